"""The Zenoh sessions of a run, and the access control of the coordinator's.

The coordinator's session is the hub: it listens on one unix socket in a directory that only the user may enter (mode
0700) and on nothing else; no scouting, no gossip, no admin space. Every process is a client of that socket with its own
password, and may write only to its own keys: everything that is not explicitly allowed is denied, without notice to the
sender; directions (ingress, egress) are seen from the coordinator. `BLOCK` publishers never drop; `wait_before_close`
and the lease are long, because Zenoh's defaults lose messages silently when a reader is slow.
"""

import json
import os
import re
import resource
import secrets
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Protocol

import msgspec
import zenoh
from heavylift.kernel.errors import ProtocolError

from .frame import AFAR, HUB, JOIN, OBSERVER, OPERATOR, WIRE, RunDirectory, key


def access(run: str, processes: list[str], remote: tuple[str, ...]) -> dict[str, object]:
    """Return Zenoh's access rules for a run: processes use only the keys of their nodes, observers only read events.

    A process on this host is identified by its password, one on another host by the name in its certificate; the holder
    of any certificate of the yard may ask whether it may join, and may join under the name in the certificate.
    """

    def rule(name: str, flow: str, messages: list[str], *keys: str) -> dict[str, Any]:
        return {"id": name, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": list(keys)}

    rules = [
        rule(
            "egress",
            "egress",
            ["put", "declare_subscriber", "declare_queryable", "liveliness_token", "reply", "query"],
            key(run, "**"),
            key(JOIN, "*"),
        ),
        rule("join", "ingress", ["query"], key(JOIN, "*")),
        rule("hub", "ingress", ["declare_liveliness_subscriber"], key(run, "alive", HUB)),
        rule("observe", "ingress", ["declare_subscriber"], key(run, "event", "**"), key(run, "sample", "**")),
    ]
    rules.append(rule("operate", "ingress", ["query"], key(run, "control")))
    policies = [
        {"rules": ["observe", "egress"], "subjects": [OBSERVER]},
        {"rules": ["operate", "egress"], "subjects": [OPERATOR]},
    ]
    for process in (*processes, *remote):
        out, into = [key(run, topic, process, "*") for topic in ("out", "samples")], key(run, "in", process, "*")
        own = [
            rule(f"{process}/out", "ingress", ["put"], *out),
            rule(f"{process}/alive", "ingress", ["liveliness_token"], key(run, "alive", process, "*")),
            rule(f"{process}/ask", "ingress", ["declare_queryable", "reply"], key(run, "ask", process, "*")),
            rule(f"{process}/in", "ingress", ["declare_subscriber"], into),
            rule(f"{process}/leave", "ingress", ["query"], key(run, "leave", process), key(run, "enter", process)),
        ]
        rules += own
        policies.append({"rules": [*(each["id"] for each in own), "hub", "egress"], "subjects": [process]})
    here, afar = {"link_protocols": ["unixsock-stream"]}, {"link_protocols": ["tls"]}
    users = (*processes, OBSERVER, OPERATOR)
    subjects: list[dict[str, object]] = [{"id": user, "usernames": [user], **here} for user in users]
    subjects += [{"id": process, "cert_common_names": [process], **afar} for process in remote]
    if remote:
        subjects.append({"id": AFAR, **afar})
        policies.append({"rules": ["join", "egress"], "subjects": [AFAR]})
    return {"enabled": True, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies}


SESSIONS = 100_000  # no process shuts others out by sessions; their number ends with the descriptors of the coordinator
LEASE_ms = 60_000
CONNECT_ms = 10_000
WAIT_BEFORE_CLOSE_us = 600_000_000
# All of Zenoh's tasks on one thread: a third less time per round than its five thread pools.
RUNTIME = "(rx:(handover:app),acc:(handover:app),tx:(handover:app),net:(handover:app),app:(worker_threads:1))"


class ListenAddress(Protocol):
    """Interface of a listener for other hosts (`hosts.listener`): its address, and Zenoh's settings for both sides."""

    @property
    def endpoint(self) -> str: ...
    def listening(self) -> dict[str, object]: ...
    def connecting(self) -> dict[str, object]: ...


class Ticket(msgspec.Struct, frozen=True):
    """The data that a process needs to join a run; passed on standard input, or as a file to an external program."""

    run: str
    process: str
    nodes: dict[str, tuple[str, ...]]  # each with its models
    epoch: int
    socket: str
    password: str
    wire: int = WIRE

    def to_text(self) -> str:
        """Return the ticket as text, which `Ticket.take` of the new process reads from standard input."""
        return msgspec.json.encode(self).decode()

    @classmethod
    def take(cls) -> "Ticket":
        """Read the ticket of this process from standard input, then replace standard input by /dev/null; raises
        ProtocolError."""
        try:
            with open(0, "rb", closefd=False) as given:
                ticket = msgspec.json.decode(b"" if given.isatty() else given.read(), type=cls)
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            return ticket
        except (OSError, msgspec.MsgspecError):
            raise ProtocolError(
                "this process has no ticket for a run; nodes are started by 'heavylift run' and not by hand"
            ) from None


def new_run_id() -> str:
    """Return a unique name for a run."""
    return secrets.token_hex(8)


def new_password() -> str:
    """Return a new random password for one user of one run."""
    return secrets.token_urlsafe(24)


def hub_session(
    run: str,
    directory: RunDirectory,
    passwords: Mapping[str, str],
    listener: ListenAddress | None = None,
    remote: Iterable[str] = (),
) -> zenoh.Session:
    """Open the coordinator's session, which listens on the run's socket for the users of `passwords` only.

    A `listener` also admits the `remote` processes, identified by the names in their certificates.
    """
    known = {**passwords, AFAR: AFAR} if listener else passwords
    users = directory.write("users", "".join(f"{user}:{password}\n" for user, password in known.items()))
    for guest in passwords.keys() & {OBSERVER, OPERATOR}:
        directory.write(guest, passwords[guest])
    processes = [user for user in passwords if user not in ("coordinator", OBSERVER, OPERATOR)]
    config = _config("peer", listen=[f"unixsock-stream/{directory.socket}"])
    config["transport"]["unicast"]["max_sessions"] = SESSIONS
    config["transport"]["auth"] = {
        "usrpwd": {"user": "coordinator", "password": passwords["coordinator"], "dictionary_file": str(users)}
    }
    config["access_control"] = access(run, processes, tuple(remote))
    where = directory.socket
    if listener is not None:
        where += f" and {listener.endpoint}"
        most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
        config["listen"]["endpoints"].append(listener.endpoint)
        config["transport"]["link"] |= {"protocols": ["unixsock-stream", "tls"], "tls": listener.listening()}
    try:
        return _open(config, f"the coordinator cannot listen on {where}")
    finally:
        users.unlink()  # it is read once


def node_session(ticket: Ticket) -> zenoh.Session:
    """Open the session of a process with nodes, as a client of the run's socket."""
    config = _config("client", connect=[f"unixsock-stream/{ticket.socket}"])
    config["transport"]["auth"] = {"usrpwd": {"user": ticket.process, "password": ticket.password}}
    return _open(config, f"process {ticket.process} cannot join run {ticket.run} at {ticket.socket}")


def remote_session(listener: ListenAddress) -> zenoh.Session:
    """Open the session of a remote process, identified by its certificate."""
    config = _config("client", connect=[listener.endpoint])
    config["transport"]["link"] |= {"protocols": ["tls"], "tls": listener.connecting()}
    config["transport"]["auth"] = {"usrpwd": {"user": AFAR, "password": AFAR}}
    return _open(config, f"this process is not admitted at {listener.endpoint}")


def observer_config(directory: Path, run: str) -> dict[str, object]:
    """Return Zenoh's settings with which an observer connects to the run in this directory, and the keys to subscribe
    to."""
    keys = [key(run, topic, "**") for topic in ("event", "sample")]
    return {
        "metadata": {"heavylift": {"run": run, "wire": WIRE, "keys": keys}},
        "mode": "client",
        "connect": {"endpoints": [f"unixsock-stream/{directory / 'hub.sock'}"]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {
            "auth": {"usrpwd": {"user": OBSERVER, "password": (directory / OBSERVER).read_text(encoding="utf-8")}}
        },
    }


def guest_session(directory: Path, user: str) -> zenoh.Session:
    """Open the session of an observer (`OBSERVER`) or operator (`OPERATOR`) of the run in this directory."""
    config = _config("client", connect=[f"unixsock-stream/{directory / 'hub.sock'}"])
    config["transport"]["auth"] = {"usrpwd": {"user": user, "password": (directory / user).read_text(encoding="utf-8")}}
    return _open(config, f"an {user} cannot join the run in {directory}")


def local_session() -> zenoh.Session:
    """Open a session without any network end point, for a run with all nodes in this process."""
    config = _config("peer")
    config["transport"]["link"]["protocols"] = []
    return _open(config, "the run in this process cannot start")


def _config(mode: str, listen: list[str] | None = None, connect: list[str] | None = None) -> dict[str, Any]:
    return {
        "mode": mode,
        "listen": {"endpoints": listen or [], "exit_on_failure": True},
        "connect": {
            "endpoints": connect or [],
            "timeout_ms": CONNECT_ms,
            "exit_on_failure": True,
            "retry": {"period_init_ms": 5, "period_max_ms": 200, "period_increase_factor": 2},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "adminspace": {"enabled": False},
        "transport": {
            "unicast": {"lowlatency": False, "qos": {"enabled": True}},
            "shared_memory": {"enabled": False},
            "link": {
                "protocols": ["unixsock-stream"],
                "tx": {
                    "lease": LEASE_ms,
                    "keep_alive": 4,
                    "queue": {
                        "congestion_control": {
                            "block": {"wait_before_close": WAIT_BEFORE_CLOSE_us},
                            "drop": {"wait_before_drop": 0},  # a frozen observer costs no time
                        },
                        "batching": {"enabled": True, "time_limit": 1},
                    },
                },
            },
        },
    }


_begun: list[int] = []  # the process in which Zenoh has begun its threads, which no fork of it has


def _open(config: dict[str, object], otherwise: str) -> zenoh.Session:
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)
    if _begun and _begun != [os.getpid()]:
        raise ProtocolError(
            "this process was forked from one that has run models, and cannot "
            "run models itself; use spawned processes, "
            "such as those of ProcessPoolExecutor(mp_context=multiprocessing.get_context('spawn'))"
        )
    _begun[:] = [os.getpid()]
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError as error:
        reason = re.sub(r"[.!]? at \S+\.rs:\d+\.?", "", str(error).splitlines()[0])
        raise ProtocolError(f"{otherwise}: {reason}; start the run again") from None
