"""What a foreign node may not do: each broken rule ends the run with the node's name, whatever its language is."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from heavylift import run_models
from heavylift.coordinator.participants import External
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.transport import FIFO, NodeLink, Ticket
from heavylift.kernel import HeavyliftError, ProtocolError
from heavylift.nodes.devs import FOREVER, AtomicResult, Event, Tag, ms
from heavylift.nodes.zoo import Job, ring

RING = "heavylift.nodes.zoo.token_ring:ring(2, 1, 5_000_000)"
TOKEN = b"\x81\xa6number\x00"
HELLO = m.Hello(FOREVER, [], FOREVER, {"s1.out": 0}, version="wire 1")


def event(t: int, port: str = "out", type_: str = "Token", payload: bytes = TOKEN) -> Event:
    return Event(t, 0, "s1", port, 0, type_, payload)


def done(spoken: list[Event], reached: int = ms(5), next_: Tag = FOREVER) -> m.GrantDone:
    return m.GrantDone(1, Tag(reached, 1), spoken, next_, [], next_, b"")


def bye(path: str, type_: str = "Token") -> m.Bye:
    return m.Bye(results=[AtomicResult(path, type_, TOKEN)])


REFUSED = {  # what it says, and the sentence
    "wrong version": (
        m.Hello(FOREVER, [], FOREVER, {"s1.out": 0}, version="wire 2"),
        "node s1 uses protocol 'wire 2', this",
    ),
    "an older program": (m.Hello(FOREVER, [], FOREVER, {"s1.out": 0}, version="0.1.0"), "uses protocol '0.1.0', this"),
    "no lookahead": (
        m.Hello(FOREVER, [], FOREVER, {}, version="wire 1"),
        "node s1 does not declare a lookahead of s1.out",
    ),
    "a port too many": (
        m.Hello(FOREVER, [], FOREVER, {"s1.out": 0, "s1.in\n": 0}, version="wire 1"),
        r"node s1 declares a lookahead of s1.in\\n; its out ports are s1.out",
    ),
    "wrong port": (
        done([event(ms(5), "exit")]),
        r"s1 at \(0.005 s, 0\) sent an event on port exit: its out ports are out",
    ),
    "wrong type": (done([event(ms(5), type_=Job.__name__)]), "out carries Token, not Job"),
    "unknown type": (done([event(ms(5), type_="Ufo")]), "port out: unknown message type 'Ufo'"),
    "not the message": (done([event(ms(5), payload=b"\x01")]), "port out: message Token cannot be decoded"),
    "a long number": (
        done([event(ms(5), payload=b"\x81\xa6number\xcc\x00")]),
        "bytes of its Token are not the canonical",
    ),
    "of another type in its failure": (
        m.Fail(Tag(ms(5)), "s1", "", "", [event(ms(5), type_="Job")]),
        "s1 at .* out carries Token, not Job",
    ),
    "a result of others": (
        bye("ring.s10"),
        "node s1 sent a result for ring.s10: a node may send results only for its own models",
    ),
    "a result of no type": (bye("ring.s1", "Ufo"), "node s1, its result of ring.s1: unknown message type 'Ufo'"),
    "an unknown field": (done([event(ms(5), payload=b"\x82\xa6number\x00\xa1x\x00")]), "not the canonical ones"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_messages_that_no_correct_node_could_send_are_refused(name: str) -> None:
    message, sentence = REFUSED[name]
    model = ring(stations=2, tokens=1, hold=ms(5))
    with pytest.raises(ProtocolError, match=sentence):
        External("s1", [model.children["s1"]], [], 10_000).checked(message)


def test_valid_messages_of_external_nodes_are_accepted() -> None:
    model = ring(stations=2, tokens=1, hold=ms(5))
    external = External("s1", [model.children["s1"]], [], 10_000)
    for message in (HELLO, done([event(ms(5))]), m.Bye(), bye("ring.s1"), bye("ring.s1.part"), m.Checkpoint(1)):
        assert external.checked(message) is message


def test_the_failure_of_an_external_node_is_reported_in_one_line_with_the_name_of_the_node() -> None:
    external = External("s1", [ring(stations=2, tokens=1, hold=ms(5)).children["s1"]], [], 10_000)
    text = external.checked(m.Fail(Tag(0), "s1", "no\n\x1b[31mline" + "x" * 1000, ""))
    assert isinstance(text, m.Fail)
    assert text.sentence == "node s1 has failed: " + ("no\\n\\x1b[31mline" + "x" * 1000)[:500] + "..."


def speak(*answers: m.AnyMessage | bytes) -> Callable[[Path], None]:
    """A guest that answers WELCOME and each GRANT with these."""

    def play(path: Path) -> None:
        link = NodeLink(msgspec.json.decode(path.read_bytes(), type=Ticket))
        for answer in answers:
            link.receive()
            link.send("s1", answer if isinstance(answer, bytes) else m.encode(answer))
        link.receive()
        link.close()

    return play


def unframed(path: Path) -> None:
    link = NodeLink(msgspec.json.decode(path.read_bytes(), type=Ticket))
    link._senders["s1"]._out.put(b"good morning, everybody, how do you do?")
    link.receive()
    link.close()


def flooding(path: Path) -> None:
    """More than any inbox holds."""
    link = NodeLink(msgspec.json.decode(path.read_bytes(), type=Ticket))
    for _ in range(5 * FIFO):
        link._senders["s1"]._out.put(b"x" * 100)
    link.receive()
    link.close()


def of_tomorrow(path: Path) -> None:
    link = NodeLink(msgspec.json.decode(path.read_bytes(), type=Ticket))
    sender = link._senders["s1"]
    frame = sender._out_writer.frame(m.encode(HELLO))[4:].replace(b"HLF1", b"HLF2")
    sender._out.put(zlib.crc32(frame).to_bytes(4, "little") + frame)
    link.receive()
    link.close()


CASES = {
    "garbage": (speak(b"\x93\xa5hello\xc1"), "node s1 sent invalid data: not a message of the time protocol"),
    "no frame": (unframed, "node s1, message 0 on 'out': 39 bytes arrived that are no heavylift message"),
    "a flood": (flooding, "node s1, message 0 on 'out': 100 bytes arrived that are no heavylift message"),
    "a frame of tomorrow": (of_tomorrow, "node s1, message 0 on 'out': a frame of wire version 2 arrived, and this"),
    "a late answer": (
        speak(HELLO, done([], ms(7))),
        r"s1 has done all before \(0.007 s, 1\) and goes on at \(forever\)",
    ),
    "before its lookahead": (
        speak(msgspec.structs.replace(HELLO, lookahead={"s1.out": ms(2)}), done([event(ms(5))])),
        r"s1 sent an event on port out at \(0.005 s, 0\), earlier than the \(0.007 s, 0\) that it had declared",
    ),
}


@pytest.mark.parametrize("name", [next(iter(CASES)), *(pytest.param(x, marks=pytest.mark.large) for x in [*CASES][1:])])
def test_a_protocol_violation_ends_the_run_with_the_name_of_the_node(guest, name: str) -> None:
    play, sentence = CASES[name]
    with guest(play), pytest.raises(HeavyliftError, match=sentence):
        run_models(RING, until=0.101, external=["s1"])


def test_the_ticket_of_a_process_states_the_version_of_the_wire_format(tmp_path: Path) -> None:
    assert "wire" in json.loads(Ticket("r", "p", {}, 1, "", "").to_text())
