"""A process that could not be killed wakes beside its successor: nobody hears it, and it refuses what it hears."""

from __future__ import annotations

import sys
import time

import pytest
from heavylift.coordinator.transport import Hub, NodeLink
from heavylift.kernel import ProtocolError

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")

SOON_s = 5.0


def received(hub: Hub) -> list[tuple[str, bytes]]:
    """All that comes within a moment."""
    found = []
    while (got := hub.receive(0.2)) is not None:
        found.append(got)
    return found


def test_a_replaced_process_that_still_runs_refuses_new_messages_and_its_own_messages_are_ignored() -> None:
    with Hub(["west"]) as hub, NodeLink(hub.ticket("west")) as old:
        hub.send("west", b"grant 1")
        assert old.receive() == ("west", b"grant 1")
        hub.renew("west")  # it is thought to be lost, but on its own host it lives
        with NodeLink(hub.ticket("west")) as new:
            old.send("west", b"done 1, late")
            old.sample("west", b"late samples")
            new.send("west", b"hello")
            new.sample("west", b"samples")
            assert received(hub) == [("west", b"hello")]
            assert hub.samples() == [("west", b"samples")]
            hub.send("west", b"grant 1 again")
            assert new.receive() == ("west", b"grant 1 again")
            with pytest.raises(ProtocolError, match="a message of epoch 2 arrived in epoch 1"):
                old.receive()


def test_the_end_of_a_replaced_process_does_not_end_its_replacement() -> None:
    with Hub(["west"]) as hub:
        old = NodeLink(hub.ticket("west"))
        hub.send("west", b"grant 1")
        hub.renew("west")
        with NodeLink(hub.ticket("west")) as new:
            old.close()
            time.sleep(0.5)
            new.send("west", b"hello")
            assert received(hub) == [("west", b"hello")]
            new.close()
            with pytest.raises(ProtocolError, match="node west is gone: it left the run"):
                hub.receive(SOON_s)


def test_a_node_process_can_be_replaced_254_times() -> None:
    with Hub(["west"]) as hub:
        for _ in range(254):
            hub.renew("west")
        with pytest.raises(ProtocolError, match="was replaced 255 times"):
            hub.renew("west")
