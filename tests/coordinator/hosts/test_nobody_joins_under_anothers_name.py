"""A process of the yard may be reported to lie: it takes nobody's place, shuts nobody out, and writes on no
terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import msgspec
import pytest
import zenoh
from heavylift.coordinator.hosts import REFUSALS, Credentials, JoinReply, JoinRequest, RemoteListener, code
from heavylift.coordinator.hosts.remote_node import _ask
from heavylift.coordinator.transport import JOIN, Hub, NodeLink, Placement, key, remote_session
from heavylift.kernel import ProtocolError
from heavylift.kernel.version import __version__
from of_a_yard import free_port

BOTH = Placement({"block": ("block",), "crane": ("crane",)}, frozenset({"block", "crane"}))
CRANE = JoinRequest("crane", __version__, "quay", code=code())
Run = tuple[Hub, list[str], RemoteListener, RemoteListener]  # with the doors of block and crane


@pytest.fixture
def run(keys: Path) -> Iterator[Run]:
    """A run that waits for block and crane, and what it has said."""
    endpoint, text = f"tls/127.0.0.1:{free_port()}", list[str]()
    with Hub(BOTH, RemoteListener.at(endpoint, Credentials.load(keys, "coordinator"))) as hub:
        hub.admit("", text.append)
        text.clear()
        yield hub, text, *(RemoteListener.at(endpoint, Credentials.load(keys, name)) for name in ("block", "crane"))


def asked(session: zenoh.Session, at: str, name: str, host: str = "here") -> JoinReply | None:
    """What the coordinator answers; None if the question does not reach it."""
    replies = session.get(
        at, payload=msgspec.msgpack.encode(JoinRequest(name, __version__, host, code=code())), timeout=5
    )
    found = [msgspec.msgpack.decode(reply.ok.payload.to_bytes(), type=JoinReply) for reply in replies if reply.ok]
    return found[0] if found else None


def test_a_remote_process_may_join_only_under_the_name_in_its_certificate(run: Run) -> None:
    hub, text, block, crane = run
    with remote_session(block) as liar:
        for _ in range(3):
            message = asked(liar, key(JOIN, "crane"), "crane")
            assert message == JoinReply(None, "its certificate was not made for 'crane'")
        assert asked(liar, key(hub.run, "enter", "crane"), "crane") is None
        message = asked(liar, key(hub.run, "enter", "block"), "crane")
        assert message == JoinReply(None, "its certificate was issued to 'block'")
        assert text == [
            "refused process crane on host here: its certificate was not made for 'crane'",
            "refused process crane on host here: its certificate was issued to 'block'",
        ]
        with (
            remote_session(crane) as honest,
            NodeLink(_ask(honest, CRANE, crane), honest),
        ):
            assert text[-1] == "process crane on host quay has joined"
            assert asked(liar, key(JOIN, "crane"), "crane") == JoinReply(
                None, "process 'crane' is there already, on host quay"
            )


def test_a_client_that_requests_a_process_name_does_not_prevent_its_owner_from_joining(run: Run) -> None:
    hub, _, block, crane = run
    with remote_session(block) as liar, remote_session(crane) as honest:
        for _ in range(3):
            assert asked(liar, key(JOIN, "crane"), "crane") == JoinReply(
                None, "", hub.run
            )  # crane is there to be let in
        assert _ask(honest, CRANE, crane) == hub.ticket("crane")


def test_many_sessions_with_one_certificate_do_not_prevent_another_process_from_joining(run: Run) -> None:
    hub, _, block, crane = run
    with ExitStack() as crowd:
        for _ in range(60):
            crowd.enter_context(remote_session(block))
        honest = crowd.enter_context(remote_session(crane))
        assert _ask(honest, CRANE, crane) == hub.ticket("crane")


def test_text_from_a_client_without_a_password_is_escaped_before_printing(run: Run) -> None:
    _, text, block, _ = run
    nasty = "\x1b]0;owned\x07\nall is well\u202e" + "x" * 1000
    with remote_session(block) as liar:
        asked(liar, key(JOIN, "block"), nasty, nasty)
        with pytest.raises(ProtocolError, match="may not join: its certificate was not made for 'crane'"):
            _ask(liar, JoinRequest("crane", __version__, nasty, code=code()), block)
    assert len(text) == 2
    assert all(line.isprintable() and len(line) < 400 for line in text)
    assert r"on host \x1b]0;owned\x07\nall is well\u202exxx" in text[0]


def test_repeated_refusals_to_clients_that_want_to_join_are_summarised(run: Run) -> None:
    _, text, block, _ = run
    with remote_session(block) as liar:
        for number in range(2 * REFUSALS):
            asked(liar, key(JOIN, "crane"), f"crane{number}")
        liar.get(key(JOIN, "crane"), payload=b"\xc1")
    assert len(text) == REFUSALS + 1
    assert text[-1] == "more refusals are not reported"


def test_a_client_of_another_version_is_refused_with_the_version_to_install(run: Run) -> None:
    """Whatever it asks in: words of before or after, or bytes of no meaning."""
    hub, text, block, _ = run
    mine = msgspec.to_builtins(JoinRequest("block", __version__, "quay", code=code()))
    others = {
        "of before": {"process": "block", "version": "0.1.0", "host": "quay", "run": "", "scene": ""},
        "of after": mine | {"version": "9.9", "wish": [1, 2]},
        "a file was changed": mine | {"code": "of an edited file"},
        "other types": mine | {"host": 3},
        "no map": [1, 2],
    }
    with remote_session(block) as session:
        for name, asked in others.items():
            for at in (key(JOIN, "block"), key(hub.run, "enter", "block")):
                (reply,) = session.get(at, payload=msgspec.msgpack.encode(asked), timeout=5)
                answer = msgspec.msgpack.decode(reply.ok.payload.to_bytes(), type=JoinReply)
                assert f"install heavylift {__version__}" in answer.refusal, name
                assert not answer.run, name
                assert answer.ticket is None, name
    assert not any("has joined" in line for line in text)
