"""Connections of processes on other hosts to a run, by TLS with certificates on both sides; permission to join.

    process -> coordinator   ASK at join/NAME            its name, version, code, host, and the run and scene it wants
    coordinator -> process   ANSWER                      the run, or the reason of a refusal
    process -> coordinator   ASK at RUN/enter/NAME       only a certificate of this name gets here (transport)
    coordinator -> process   ANSWER                      a ticket, or the reason of a refusal

Asking at join/NAME changes nothing, so nobody can block another process by asking under its name. The name in a
process's certificate also decides what it may publish and receive. Both sides report refusals; texts from
unauthenticated clients are escaped.
"""

import hashlib
import math
import re
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Self

import msgspec
import zenoh
from heavylift.coordinator.transport.frame import JOIN, key
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.link import JOIN_s
from heavylift.coordinator.transport.session import Ticket
from heavylift.kernel.cache import contents
from heavylift.kernel.errors import UNREADABLE, ProtocolError, printable
from heavylift.kernel.version import __version__, install
from zenoh.handlers import Callback

from .certificates import Credentials

SHOWN = 64  # characters of what a stranger says of itself
REFUSALS = 100  # that are reported


ROOMS = ("kernel", "nodes", "coordinator", "recordings")


@cache
def code() -> str:
    """Return a fingerprint of all source code of heavylift, which may change while the version stays the same."""
    rooms = Path(__file__).parent.parent.parent
    return hashlib.sha256(b"".join(contents(rooms / room, ".py", ".yaml") for room in ROOMS)).hexdigest()


class JoinRequest(msgspec.Struct, frozen=True):
    """Request of a remote process to join a run; "" for `run` or `scene` means that it accepts every one.

    Later versions only add fields with defaults.
    """

    process: str
    version: str
    host: str
    run: str = ""
    scene: str = ""
    code: str = ""


class JoinReply(msgspec.Struct, frozen=True):
    """Reply to a join request: the run id, a ticket whose password is empty, or the reason for a refusal."""

    ticket: Ticket | None
    refusal: str = ""
    run: str = ""


class JoinHandshake:
    """Answers the requests of remote processes to join a run of one scene; reports refusals through `say`."""

    def __init__(self, hub: Hub, session: zenoh.Session, scene: str, say: Callable[[str], None]) -> None:
        self.hosts: dict[str, str] = {}
        """Remote process -> the host from which it has joined."""
        self._hub, self._session, self._scene, self._report = hub, session, scene, say
        self._entered: dict[str, float] = {}
        self._message: set[str] = set()
        self._lock = Lock()
        doors = (key(JOIN, "*"), self._ask), (key(hub.run, "enter", "*"), self._enter)
        self._queryables = [session.declare_queryable(at, Callback(reply)) for at, reply in doors]

    def _ask(self, query: zenoh.Query) -> None:
        """Answer a client with a certificate of this yard that asks whether it may join; this changes no state."""
        asked = self._read(query)
        if asked is not None:
            why = self.refusal(asked) or self._impostor(asked.process)
            self._answer(query, asked, JoinReply(None, why, "" if why else self._hub.run))

    def _enter(self, query: zenoh.Query) -> None:
        """Let a process join whose certificate has this name, or refuse it."""
        asked = self._read(query)
        if asked is None:
            return
        named = str(query.key_expr).rpartition("/")[2]
        with self._lock:
            why = self.refusal(asked) if asked.process == named else f"its certificate was issued to '{named}'"
            if not why:
                self.hosts[named], self._entered[named] = printable(asked.host, SHOWN), time.monotonic()
        self._answer(query, asked, JoinReply(None, why) if why else JoinReply(self._hub.ticket(named)))

    def _read(self, query: zenoh.Query) -> JoinRequest | None:
        try:
            return msgspec.msgpack.decode(query.payload.to_bytes() if query.payload else b"", type=JoinRequest)
        except UNREADABLE:
            self._tell("somebody with a certificate of this yard asked to join in words of another program")
            message = f"it asks in words that heavylift {__version__} does not know; {install(__version__)} there"
            query.reply(query.key_expr, msgspec.msgpack.encode(JoinReply(None, message)))
            return None

    def _answer(self, query: zenoh.Query, asked: JoinRequest, answer: JoinReply) -> None:
        message = f"process {printable(asked.process, SHOWN)} on host {printable(asked.host, SHOWN)}"
        if answer.ticket is not None:
            self._report(f"{message} has joined")
        elif answer.refusal:
            self._tell(f"refused {message}: {answer.refusal}")
        query.reply(query.key_expr, msgspec.msgpack.encode(answer))

    def _tell(self, refusal: str) -> None:
        """Report each refusal once, up to a maximum number."""
        with self._lock:
            new = refusal not in self._message and len(self._message) <= REFUSALS
            if new:
                self._message.add(refusal)
                last = len(self._message) > REFUSALS
        if new:
            self._report("more refusals are not reported" if last else refusal)

    def _impostor(self, name: str) -> str:
        """Return why the client cannot be this process: no connection's certificate has its name; "" if one has."""
        if any(link.auth_identifier == name for link in self._session.info.links()):
            return ""
        return f"its certificate was not made for '{name}'"

    def refusal(self, asked: JoinRequest) -> str:
        """Return why a process may not join; "" if it may."""
        hub, name = self._hub, asked.process
        remote = hub.placement.remote
        if asked.version != __version__:
            other = printable(asked.version, SHOWN)
            return f"it runs heavylift {other}, the coordinator {__version__}; {install(__version__)} on all hosts"
        if asked.code != code():
            same = f"it runs heavylift {__version__} as the coordinator does, but files of one of them were changed"
            return f"{same}; {install(__version__)} anew on both hosts"
        if asked.run not in ("", hub.run):
            return f"it insists on run {printable(asked.run, SHOWN)}, but this is run {hub.run}"
        if asked.scene not in ("", self._scene):
            return "its scene is not the one that is run; give both hosts the same file and the same settings"
        awaited = ", ".join(sorted(remote))
        if name not in hub.placement.processes:
            return f"this run has no process '{printable(name, SHOWN)}'; it waits for {awaited}"
        if name not in remote:
            return f"process '{name}' runs on the coordinator's host; those of other hosts are {awaited}"
        if self._taken(name):
            return f"process '{name}' is there already, on host {self.hosts[name]}"
        return ""

    def free(self, process: str) -> None:
        """Make the name of a lost remote process available again, so that another process may join with this name."""
        self._entered.pop(process, None)

    def _taken(self, process: str) -> bool:
        """Return whether a process of this name has joined or holds a ticket."""
        recently = time.monotonic() - self._entered.get(process, -math.inf) < JOIN_s
        return recently or self._hub.joined(process)


ALL = ("0.0.0.0", "[::]")  # all interfaces of a host


@dataclass(frozen=True)
class RemoteListener:
    """Address and TLS credentials at which a coordinator listens for remote processes; `endpoint`: tls/HOST:PORT."""

    endpoint: str
    credentials: Credentials

    @classmethod
    def at(cls, endpoint: str, credentials: Credentials) -> Self:
        """Return a listener for an endpoint tls/HOST:PORT that the user has written; raises ProtocolError if it is
        invalid."""
        protocol, slash, rest = endpoint.partition("/")
        if slash and protocol != "tls":
            raise ProtocolError(
                f"{endpoint}: hosts may connect only over TLS, with certificates on both sides, "
                f"so that nobody else can join or eavesdrop; write tls/{rest}"
            )
        found = re.fullmatch(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9.-]+):([0-9]{1,5})", rest)
        if not slash or not found or not 0 < int(found[2]) < 65536:
            raise ProtocolError(
                f"'{endpoint}' is not a valid address; write tls/HOST:PORT, such as tls/192.168.1.10:7447"
            )
        return cls(endpoint, credentials)

    @property
    def address(self) -> tuple[str, int]:
        """Host name (without brackets) and port of the endpoint."""
        host, _, port = self.endpoint.removeprefix("tls/").rpartition(":")
        return host.strip("[]"), int(port)

    @property
    def seen_from_afar(self) -> str:
        """The endpoint to which other hosts connect: that of the coordinator, with this host's name instead of a
        wildcard address."""
        host, _, port = self.endpoint.removeprefix("tls/").rpartition(":")
        return f"tls/{socket.gethostname() if host in ALL else host}:{port}"

    def gate(self, hub: Hub, session: zenoh.Session, scene: str, say: Callable[[str], None]) -> JoinHandshake:
        """Start answering the join requests of remote processes; return the object that answers these requests."""
        return JoinHandshake(hub, session, scene, say)

    def listening(self) -> dict[str, object]:
        """Return Zenoh's TLS settings for the coordinator."""
        own = self.credentials
        return {**self._both(), "listen_private_key": str(own.key), "listen_certificate": str(own.certificate)}

    def connecting(self) -> dict[str, object]:
        """Return Zenoh's TLS settings for a remote process; the coordinator's certificate must contain the host name of
        `endpoint`."""
        own = self.credentials
        shown = {"connect_private_key": str(own.key), "connect_certificate": str(own.certificate)}
        return {**self._both(), **shown, "verify_name_on_connect": True}

    def _both(self) -> dict[str, object]:
        trusted = str(self.credentials.authority)
        return {"root_ca_certificate": trusted, "enable_mtls": True, "close_link_on_expiration": True}
