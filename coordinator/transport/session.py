"""The three Zenoh sessions of a run, and the private place where they meet.

The coordinator's session is the hub: it listens on one unix socket in a directory that only the user may
enter (mode 0700) and on nothing else; no scouting, no gossip, no admin space. Every process is a client of that
socket with its own password, and the hub's access control lets it write only to its own keys. `BLOCK`
publishers never drop; `wait_before_close` and the lease are long, because Zenoh's defaults lose messages
silently when a reader is slow.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import zenoh
from heavylift.kernel.errors import ProtocolError

from .access import access
from .keys import AFAR, OBSERVER, OPERATOR

if TYPE_CHECKING:
    from ..hosts.door import Door

__all__ = [
    "RunDirectory",
    "Ticket",
    "hub_session",
    "local_session",
    "node_session",
    "observer_session",
    "operator_session",
    "places",
    "remote_session",
]

TICKET = "HEAVYLIFT_TICKET"
SOCKET_PATH_LIMIT = 104  # bytes with the closing zero: the smaller of Linux (108) and macOS (104)
LEASE_ms = 60_000
CONNECT_ms = 10_000
WAIT_BEFORE_CLOSE_us = 600_000_000
# All of Zenoh's tasks on one thread: a third less time per round than its five thread pools.
RUNTIME = "(rx:(handover:app),acc:(handover:app),tx:(handover:app),net:(handover:app),app:(worker_threads:1))"


class Ticket(msgspec.Struct, frozen=True):
    """What a process needs to join a run; reaches it through its environment, never on a command line."""

    run: str
    process: str
    nodes: tuple[str, ...]
    epoch: int
    socket: str
    password: str

    def to_environment(self) -> dict[str, str]:
        """The variable that carries the ticket into a process."""
        return {TICKET: msgspec.json.encode(self).decode()}

    @classmethod
    def take(cls) -> Ticket:
        """The ticket of this process; it is removed from the environment, so no child inherits it."""
        try:
            return msgspec.json.decode(os.environ.pop(TICKET), type=cls)
        except (KeyError, msgspec.MsgspecError):
            raise ProtocolError(
                "this process has no ticket for a run, nodes are started by 'heavylift run' and not by hand"
            ) from None


class RunDirectory:
    """A directory of mode 0700 for one run: its socket, its passwords and the nodes' output."""

    def __init__(self) -> None:
        self.path = _private_directory()
        self.socket = str(self.path / "hub.sock")
        self.users = self.path / "users"

    def write_users(self, passwords: Mapping[str, str]) -> None:
        """Write the dictionary of users that the hub admits, readable by this user only."""
        with open(os.open(self.users, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
            file.writelines(f"{user}:{password}\n" for user, password in passwords.items())

    def log(self, node: str) -> Path:
        """The file that takes what the node writes to its standard output and error."""
        return self.path / f"{node}.log"

    def remove(self) -> None:
        """Delete the directory and all in it."""
        shutil.rmtree(self.path, ignore_errors=True)


def places() -> list[str]:
    """Where runs of this user have their directories, the preferred place first."""
    return list(dict.fromkeys((tempfile.gettempdir(), os.environ.get("XDG_RUNTIME_DIR", "/tmp"), "/tmp")))


def _private_directory() -> Path:
    for place in places():
        longest = Path(place) / "heavylift-12345678" / "hub.sock"
        if len(os.fsencode(longest)) < SOCKET_PATH_LIMIT and os.access(place, os.W_OK | os.X_OK):
            return Path(tempfile.mkdtemp(prefix="heavylift-", dir=place))
    raise ProtocolError(
        "no temporary directory is writable and short enough for a unix socket "
        f"({tempfile.gettempdir()} is not), set TMPDIR to a shorter path"
    )


def new_run_id() -> str:
    """A name for a run that no other run has."""
    return secrets.token_hex(8)


def new_password() -> str:
    """A password for one user of one run."""
    return secrets.token_urlsafe(24)


def hub_session(
    run: str,
    directory: RunDirectory,
    passwords: Mapping[str, str],
    door: Door | None = None,
    remote: Iterable[str] = (),
) -> zenoh.Session:
    """The coordinator's session: listens on the run's socket for the users of `passwords` and nobody else.

    At the `door`, if there is one, it lets in the `remote` processes, told by the names in their certificates.
    """
    directory.write_users({**passwords, AFAR: AFAR} if door else passwords)
    processes = [user for user in passwords if user not in ("coordinator", OBSERVER, OPERATOR)]
    config = _config("peer", listen=[f"unixsock-stream/{directory.socket}"])
    config["transport"]["unicast"]["max_sessions"] = len(passwords) + 16
    config["transport"]["auth"] = {
        "usrpwd": {
            "user": "coordinator",
            "password": passwords["coordinator"],
            "dictionary_file": str(directory.users),
        }
    }
    config["access_control"] = access(run, processes, tuple(remote))
    if door is None:
        return _open(config, "the coordinator cannot listen on " + directory.socket)
    config["listen"]["endpoints"].append(door.endpoint)
    config["transport"]["link"] |= {"protocols": ["unixsock-stream", "tls"], "tls": door.listening()}
    return _open(config, f"the coordinator cannot listen on {directory.socket} and {door.endpoint}")


def node_session(ticket: Ticket) -> zenoh.Session:
    """The session of a process of nodes: a client of the run's socket."""
    config = _config("client", connect=[f"unixsock-stream/{ticket.socket}"])
    config["transport"]["auth"] = {"usrpwd": {"user": ticket.process, "password": ticket.password}}
    return _open(config, f"process {ticket.process} cannot join run {ticket.run} at {ticket.socket}")


def remote_session(door: Door) -> zenoh.Session:
    """The session of a process on another host; who it is says its certificate."""
    config = _config("client", connect=[door.endpoint])
    config["transport"]["link"] |= {"protocols": ["tls"], "tls": door.connecting()}
    config["transport"]["auth"] = {"usrpwd": {"user": AFAR, "password": AFAR}}
    return _open(config, f"nobody lets this process in at {door.endpoint}")


def observer_session(directory: Path) -> zenoh.Session:
    """A session that may watch the committed events of the run in this directory and nothing else."""
    return _guest_session(directory, OBSERVER)


def operator_session(directory: Path) -> zenoh.Session:
    """A session that may query the control of the run in this directory and nothing else."""
    return _guest_session(directory, OPERATOR)


def _guest_session(directory: Path, user: str) -> zenoh.Session:
    config = _config("client", connect=[f"unixsock-stream/{directory / 'hub.sock'}"])
    users = dict(line.split(":", 1) for line in (directory / "users").read_text().splitlines())
    config["transport"]["auth"] = {"usrpwd": {"user": user, "password": users[user]}}
    return _open(config, f"an {user} cannot join the run in {directory}")


_idle: dict[int, list[zenoh.Session]] = {}  # local sessions by process: a fork has none of its parent's


def local_session() -> zenoh.Session:
    """A session without any end point: all nodes of a run live in this process.

    One that an earlier run of this process has given back by `rest_session`, if there is any: the bus keeps some memory
    of every session for ever.
    """
    if _idle.get(os.getpid()):
        return _idle[os.getpid()].pop()
    config = _config("peer")
    config["transport"]["link"]["protocols"] = []
    return _open(config, "the run in this process cannot start")


def rest_session(session: zenoh.Session) -> None:
    """Give back a local session on which nothing is declared any more."""
    _idle.setdefault(os.getpid(), []).append(session)


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


def _open(config: dict[str, Any], otherwise: str) -> zenoh.Session:
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError as error:
        reason = re.sub(r"[.!]? at \S+\.rs:\d+\.?", "", str(error).splitlines()[0])
        raise ProtocolError(f"{otherwise}: {reason}; start the run again") from None
