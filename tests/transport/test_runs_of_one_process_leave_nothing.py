"""Runs in this process, one after the other or one within another: sessions, files and threads do not add up."""

from __future__ import annotations

import os

from heavylift.coordinator.transport import session as session_module
from heavylift.coordinator.transport.hub import LocalHub


def idle() -> int:
    return len(session_module._idle.get(os.getpid(), []))


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


def talk(hub: LocalHub) -> bytes:
    link = hub.link("a")
    link.serve(lambda data: link.send(data + b" heard"))
    hub.send("a", b"word")
    got = hub.receive()
    assert got is not None
    return got[1]


def test_a_session_serves_one_run_after_the_other() -> None:
    with LocalHub(["a"]) as hub:
        first = hub._session
        assert talk(hub) == b"word heard"
    before = idle(), open_files()
    for _ in range(10):
        with LocalHub(["a"]) as hub:
            assert hub._session is first
            assert talk(hub) == b"word heard"
    hub.close()  # a second time
    assert (idle(), open_files()) == before


def test_two_runs_at_once_have_a_session_each() -> None:
    with LocalHub(["a"]) as one, LocalHub(["a"]) as other:
        assert one._session is not other._session
        assert [talk(hub) for hub in (one, other)] == [b"word heard"] * 2
