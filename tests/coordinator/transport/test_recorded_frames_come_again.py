"""Frames are recorded on the wire and sent again, bit-equal or spoiled, by members, guests and strangers of a run.

What a member may write ends the run in a sentence, or is dropped if it is of an earlier incarnation; what nobody may
write does not arrive.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import pytest
import zenoh
from heavylift.coordinator.transport import OBSERVER, OPERATOR, Hub, NodeLink, Writer, guest_session, key
from heavylift.kernel import ProtocolError

TOPICS = ("in", "out", "samples")


@pytest.fixture
def wire(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """All frames that anybody has made."""
    frames: list[bytes] = []
    frame = Writer.frame

    def heard(self: Writer, payload: bytes) -> bytes:
        frames.append(frame(self, payload))
        return frames[-1]

    monkeypatch.setattr(Writer, "frame", heard)
    return frames


@pytest.fixture
def hub() -> Iterator[Hub]:
    with Hub(["west", "east"]) as hub:
        yield hub


def spoken(hub: Hub, link: NodeLink, words: bytes) -> None:
    """A grant, samples and the answer."""
    hub.send(next(iter(link.nodes)), words)
    assert link.receive() == (next(iter(link.nodes)), words)
    link.sample(next(iter(link.nodes)), words)
    link.send(next(iter(link.nodes)), words)
    assert hub.receive(10.0) == (next(iter(link.nodes)), words)
    assert hub.samples() == [(next(iter(link.nodes)), words)]


def said_again(session: zenoh.Session, hub: Hub, wire: list[bytes], *processes: str) -> None:
    for process in processes:
        for topic in TOPICS:
            for frame in wire:
                session.put(key(hub.run, topic, process, process), frame)


def test_a_message_frame_from_an_earlier_process_of_the_node_is_dropped(hub: Hub, wire: list[bytes]) -> None:
    with NodeLink(hub.ticket("west")) as first:
        spoken(hub, first, b"first")
        hub.renew("west")
        out = wire[1:]  # its samples and its answer
        with NodeLink(hub.ticket("west")) as second:
            for topic, frame in zip(("samples", "out"), out, strict=True):
                second._session.put(key(hub.run, topic, "west", "west"), frame)
            spoken(hub, second, b"second")


@pytest.mark.parametrize("topic", ["out", "samples"])
def test_a_repeated_frame_from_the_present_process_of_a_node_ends_the_run(
    hub: Hub, wire: list[bytes], topic: str
) -> None:
    with NodeLink(hub.ticket("west")) as west:
        spoken(hub, west, b"grant")
        west._session.put(key(hub.run, topic, "west", "west"), wire[("in", "samples", "out").index(topic)])
        west.send("west", b"next")
        with pytest.raises(ProtocolError, match=rf"^node west, message 1 on '{topic}': .*\(it had arrived before\)"):
            assert (hub.receive(10.0), hub.samples()) == (("west", b"next"), [])


def test_a_repeated_frame_of_another_node_ends_the_run(hub: Hub, wire: list[bytes]) -> None:
    with NodeLink(hub.ticket("west")) as west, NodeLink(hub.ticket("east")) as east:
        spoken(hub, west, b"grant")
        said_again(east._session, hub, wire, "west")
        spoken(hub, east, b"grant")
        spoken(hub, west, b"next")
        east._session.put(key(hub.run, "out", "east", "east"), wire[2])
        with pytest.raises(ProtocolError, match=r"^node east, message 1 on 'out': a message of node west arrived"):
            hub.receive(10.0)


def test_messages_sent_by_an_observer_do_not_disturb_a_run(hub: Hub, wire: list[bytes]) -> None:
    rng = Random(1)
    with (
        guest_session(hub.directory.path, OBSERVER) as observer,
        guest_session(hub.directory.path, OPERATOR) as operator,
        NodeLink(hub.ticket("west")) as west,
    ):
        spoken(hub, west, b"grant")
        for guest in (observer, operator):
            said_again(guest, hub, [*wire, *map(rng.randbytes, (0, 1, 30, 3000))], "west", "east", "*")
            for chunk in ("1", "2", "0", "-1", "x", "9" * 5000):
                guest.liveliness().declare_token(key(hub.run, "alive", "west", chunk))
        spoken(hub, west, b"next")
        assert hub.epoch("west") == 1


def test_an_invalid_message_from_a_node_ends_the_run_with_a_clear_message(wire: list[bytes]) -> None:
    rng = Random(2)
    for number in range(12):
        with Hub(["west"]) as hub, NodeLink(hub.ticket("west")) as west:
            spoken(hub, west, b"grant %d" % number)
            for chunk in ("2", "0", "x", "9" * 5000):  # incarnations that nobody has begun
                west._session.liveliness().declare_token(key(hub.run, "alive", "west", chunk))
            frame = bytearray(rng.choice(wire[-3:]))
            for _ in range(rng.choice((0, 1, 4, 40))):
                frame[rng.randrange(len(frame))] = rng.randrange(256)
            west._session.put(key(hub.run, "out", "west", "west"), bytes(frame[: rng.choice((len(frame), 10))]))
            with pytest.raises(ProtocolError, match=r"^node west, message 1 on 'out': "):
                hub.receive(10.0)
