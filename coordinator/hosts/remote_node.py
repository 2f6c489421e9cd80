"""A process of a run on another host: it connects, asks to join, and answers until the run ends or the coordinator is
gone."""

import contextlib
import os
import socket
import ssl
import threading
import time
from collections.abc import Callable

import msgspec
import zenoh
from heavylift.coordinator.participants.node_process import serve
from heavylift.coordinator.transport.frame import HUB, JOIN, key
from heavylift.coordinator.transport.link import JOIN_s, NodeLink
from heavylift.coordinator.transport.session import Ticket, remote_session
from heavylift.kernel.errors import UNREADABLE, ProtocolError, printable
from heavylift.kernel.version import __version__
from heavylift.nodes.models import KERNEL
from zenoh.handlers import FifoChannel

from .listener import JoinReply, JoinRequest, RemoteListener, code

LOST = 86  # exit code of a process that has lost its coordinator
KNOCK_s = 0.5  # in which a coordinator refuses a certificate


def play(name: str, listener: RemoteListener, run: str, scene: str, say: Callable[[str], None]) -> None:
    """Run process `name` on this host until its run ends; `run`: id of the run, `scene`: fingerprint of its scene (""
    for any)."""
    _knock(name, listener)
    session = remote_session(listener)
    try:
        ticket = _ask(session, JoinRequest(name, __version__, socket.gethostname(), run, scene, code()), listener)
        if KERNEL in ticket.nodes:
            from heavylift.coordinator.participants import kernel_node  # noqa: F401
        link = NodeLink(ticket, session)
        playing = _Playing(session, ticket, listener, say)
        models = ", ".join(model for some in ticket.nodes.values() for model in some)
        say(printable(f"joined run {ticket.run} at {listener.endpoint} with {models}"))
        failed = serve(link)
        playing.over = True
        link.close()
        if failed:
            raise ProtocolError(
                f"this process has failed, as reported to the coordinator at {listener.endpoint}: {failed}"
            )
        say(f"run {ticket.run} is over")
    finally:
        session.close()  # type: ignore[no-untyped-call]


class _Playing:
    """Ends this process when the coordinator disappears before the run is over."""

    def __init__(
        self, session: zenoh.Session, ticket: Ticket, listener: RemoteListener, say: Callable[[str], None]
    ) -> None:
        self.over, self._report = False, say
        self._message = f"process {ticket.process}: the coordinator of run {ticket.run} at {listener.endpoint} is gone"
        at = key(ticket.run, "alive", HUB)
        self._present = threading.Event()
        self._watch = session.liveliness().declare_subscriber(at, self._changed, history=True)
        if not self._present.wait(JOIN_s):  # the line was cut just now: of who was never seen, no end is heard
            raise ProtocolError(f"{self._message}; join again after the run has been restarted")

    def _changed(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._present.set()
        elif sample.kind == zenoh.SampleKind.DELETE and not self.over:
            self._report(f"heavylift: {self._message}; join again after the run has been restarted")
            os._exit(LOST)


def _ask(session: zenoh.Session, asked: JoinRequest, listener: RemoteListener) -> Ticket:
    """Ask to join and return the ticket; raises ProtocolError with the coordinator's reason for a refusal."""
    answer = _answer(session, key(JOIN, asked.process), asked, listener)
    entered = _answer(session, key(answer.run, "enter", asked.process), asked, listener)
    assert entered.ticket is not None, "there is one, or a refusal"
    return entered.ticket


def _answer(session: zenoh.Session, at: str, asked: JoinRequest, listener: RemoteListener) -> JoinReply:
    deadline = time.monotonic() + JOIN_s
    while time.monotonic() < deadline:
        replies = session.get(at, FifoChannel(4), payload=msgspec.msgpack.encode(asked), timeout=JOIN_s)
        for reply in replies:
            if reply.ok is not None:
                answer = _decoded(reply.ok.payload.to_bytes(), listener)
                if answer.refusal or not (answer.run or answer.ticket):
                    why = printable(answer.refusal)
                    raise ProtocolError(f"process {asked.process} may not join: {why}")
                return answer
        time.sleep(0.05)  # it listens, but does not answer yet
    raise ProtocolError(
        f"process {asked.process} cannot join: no run answers at {listener.endpoint}; start the run first"
    )


def _decoded(data: bytes, listener: RemoteListener) -> JoinReply:
    try:
        return msgspec.msgpack.decode(data, type=JoinReply)
    except UNREADABLE:
        raise ProtocolError(
            f"the program that answers at {listener.endpoint} uses the protocol of "
            "another program, or of a heavylift other than "
            f"{__version__}; install the same version on both hosts"
        ) from None


def _knock(name: str, listener: RemoteListener) -> None:
    """Explain which certificate is refused and why; Zenoh reports only a failed connection. A coordinator that does not
    answer yet is no error; Zenoh keeps trying for a while."""
    own, (host, port) = listener.credentials, listener.address
    context = ssl.create_default_context(cafile=str(own.authority))
    context.load_cert_chain(own.certificate, own.key)
    with contextlib.suppress(OSError):
        try:
            with (
                socket.create_connection((host, port), KNOCK_s) as raw,
                context.wrap_socket(raw, server_hostname=host) as wrapped,
            ):
                wrapped.settimeout(KNOCK_s)
                wrapped.recv(1)  # a refusal of our certificate comes after the handshake
        except ssl.SSLCertVerificationError as error:
            why = f"the certificate shown at {listener.endpoint} is not accepted: {error.verify_message}"
            raise ProtocolError(f"process {name} cannot join: {why}") from None
        except ssl.SSLError as error:
            reason = (error.reason or "no reason given").lower().replace("_", " ")
            why = f"the coordinator at {listener.endpoint} does not accept {own.certificate}: {reason}"
            raise ProtocolError(f"process {name} cannot join: {why}") from None
