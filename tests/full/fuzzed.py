"""Kinds of fuzzed data: for each a corpus, a way to draw cases, and the command that reads them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from random import Random
from typing import Any

import msgspec
from heavylift.coordinator.hosts import JoinReply, JoinRequest
from heavylift.coordinator.live import Notice, Reply, RunOrder, journaled
from heavylift.coordinator.participants import Participant, built, couplings, participant, parts
from heavylift.coordinator.protocol import Coordinator, Node, messages as m
from heavylift.coordinator.record import MERGED, RESOLVED
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import Beginning, run
from heavylift.coordinator.supervision import Journal
from heavylift.coordinator.transport import FrameReader, FrameTopic, Writer
from heavylift.kernel import UNREADABLE, HeavyliftError
from heavylift.nodes.devs import Simulator, Tag
from heavylift.nodes.scene import load, parse, spoken
from heavylift.nodes.scenes import bundled
from heavylift.recordings import Recording
from heavylift.recordings.format import SampleChannel, SampleLayout, decode_batch
from heavylift.recordings.write import RecordingSink
from in_memory import run_in_memory
from mutations import JSON, MSGPACK, bytes_of, spoiled
from spoiled_recordings import read_in_all_ways, spoiled as spoiled_recording

Kind = Callable[[Path], tuple[Callable[[Random], bytes], Callable[[bytes], None]]]

RING = "heavylift.nodes.zoo.token_ring:ring(3, 1, 5)"


def scenes(folder: Path) -> Any:
    """Texts of scenes, bundled ones and those that they extend."""
    texts = [path.read_bytes() for path in bundled().values()]
    own = b"heavylift: 1\nname: x\nextends: pendulum\nend: 1 s\n"
    settings = [b"end=2 s", b"mechanism.bodies.bob.mass=3 t", b"actions.0.crane=stop", b"seed=7"]

    def draw(rng: Random) -> bytes:
        if rng.random() < 0.1:
            return b"\x00" + bytes_of(rng.choice(settings), rng)
        first = bytes_of(rng.choice([*texts, own, own]), rng)
        return first + bytes_of(rng.choice(texts), rng) if rng.random() < 0.05 else first

    def play(case: bytes) -> None:
        if case.startswith(b"\x00"):
            parse(own.decode(), overrides=[case[1:].decode(errors="replace")])
        path = folder / "scene.yaml"
        path.write_bytes(case)
        load(path)

    return draw, play


def recordings(folder: Path) -> Any:
    """Recordings, with checksums that hold and with others."""
    whole = _recorded(folder)
    data = whole.read_bytes()

    def play(case: bytes) -> None:
        path = folder / "spoiled.mcap"
        path.write_bytes(case)
        for sentence in read_in_all_ways(path, whole, folder, pictures=False):
            assert "\n" not in sentence
        left = RecordedRun(path)
        assert left.cast.nodes
        assert left.events is not None

    return lambda rng: spoiled_recording(data, rng), play


def commands(folder: Path) -> Any:
    """What an operator says to a run, in words and as orders."""
    scene, order = load("lift"), RunOrder("command", text="crane: travel 1 m/min by 1 m")
    text = b"""crane: travel 2 m/min by 1 m
all hooks: hoist 1 m/min until taut
crane H1: lower 0.5 m/min to 3 m within 2 s
cranes: stop
block: turn 1 deg/s by 5 deg, when: all slings taut after 3 s"""
    lines = text.split(b"\n")

    def draw(rng: Random) -> bytes:
        if rng.random() < 0.3:
            return b"\x00" + spoiled(msgspec.msgpack.encode(order), MSGPACK, rng)
        return bytes_of(rng.choice(lines), rng)

    def play(case: bytes) -> None:
        if case.startswith(b"\x00"):
            _decoded(case[1:], RunOrder)
        else:
            spoken(scene, case.decode(errors="replace"))

    return draw, play


def resume(folder: Path) -> Any:
    """Recordings that were cut off, with spoiled attachments, facts, events and journals."""
    whole = Recording(_recorded(folder))
    files = {**whole.attachments}
    name = MERGED if MERGED in files else next(x for x in files if x != RESOLVED)  # of the text that is read
    topics = {x.name: x.metadata for x in whole.topics.values() if "port" in x.metadata}
    answer = [(topic, raw.log_time, raw.data) for topic, raw in whole.stream(*topics)]

    def draw(rng: Random) -> bytes:
        part = rng.choice(("plan", "text", "facts", "journal", "event", "event"))
        plan, text = files[RESOLVED], files[name]
        facts = msgspec.json.encode({k: str(v) for k, v in whole.run.items()})
        one = rng.randrange(len(answer))
        return msgspec.msgpack.encode(
            (
                spoiled(plan, JSON, rng) if part == "plan" else plan,
                bytes_of(text, rng) if part == "text" else text,
                spoiled(facts, JSON, rng) if part == "facts" else facts,
                spoiled(msgspec.msgpack.encode((Tag(5), b"\x80")), MSGPACK, rng) if part == "journal" else b"",
                [
                    (x, t, spoiled(y, JSON, rng) if part == "event" and i == one else y)
                    for i, (x, t, y) in enumerate(answer)
                ],
            )
        )

    def play(case: bytes) -> None:
        plan, text, facts, journal, events = msgspec.msgpack.decode(case, type=tuple[bytes, bytes, bytes, bytes, list])
        message: Any = {}
        with suppress(msgspec.DecodeError, UnicodeDecodeError):
            message = msgspec.json.decode(facts)
        message = message if isinstance(message, dict) and all(isinstance(x, str) for x in message.values()) else {}
        out = folder / "left.mcap"
        sink = RecordingSink(out, message, {**files, name: text, RESOLVED: plan})
        made = {x: sink.channel(x, "json", "Event", "jsonschema", b"{}", facts) for x, facts in topics.items()}
        with sink.writing():
            for topic, t, data in events:
                sink.mcap.write(made[topic], t, t, data)
        whole = sink.finish({}).read_bytes()
        left = out.with_name("left.mcap.part")
        left.write_bytes(whole[: whole.index(b"\x06\0\0\0result")])
        if journal:
            with closing(Journal(out.with_name("left.mcap.commands"))) as kept:
                kept.append(journal)
        try:
            Beginning.of(left)
            journaled(out)
        finally:
            out.with_name("left.mcap.commands").unlink(missing_ok=True)

    return draw, play


def frames(folder: Path) -> Any:
    """Frames and messages of every type, to those who decode them, to a node and to the coordinator."""
    plan = load("pendulum").plan
    from heavylift.nodes.plan import encode

    model = m.encode(m.Welcome(1, parts.encode(parts.ModelPart(RING))))
    wire = _conversation()
    corpus = [
        *wire,
        model,
        m.encode(m.Welcome(1, parts.encode(parts.ScenePart(encode(plan))))),
        m.encode(m.Fail(Tag(1), "a.b", "cannot", "Traceback")),
        m.encode(m.StopRun(Tag(9))),
        m.encode(m.Checkpoint(3, b"\x95\x01\x02", "")),
        msgspec.msgpack.encode(RunOrder("pause")),
        msgspec.msgpack.encode(Reply(True, "paused")),
        msgspec.msgpack.encode([0, [1, 2], b"\0" * 32]),
        msgspec.msgpack.encode(parts.ScenePart(encode(plan))),
    ]

    def draw(rng: Random) -> bytes:
        return bytes([rng.randrange(256)]) + spoiled(rng.choice(corpus), MSGPACK, rng)

    two = SampleLayout([SampleChannel("x", ["a", "b"], "m", 0, 2)])

    def play(case: bytes) -> None:
        where, data = case[0], case[1:]
        for decode in (m.decode, parts.decode, participant.read, lambda x: decode_batch(x, two)):
            with suppress(HeavyliftError, *UNREADABLE):
                decode(data)
        for kind in (JoinRequest, JoinReply, RunOrder, Reply, Notice, m.Alive):
            _decoded(data, kind)
        m.kind(data)
        topic = list(FrameTopic)[where % len(FrameTopic)]
        frame = Writer("run", "node", topic, 0).frame(data)
        for framed in (data, frame, bytes_of(frame, Random(where))):
            with suppress(HeavyliftError):
                FrameReader("run", "node", topic, 0).open(framed)
        with suppress(HeavyliftError):
            _participant(model, data, where)
        with suppress(HeavyliftError):
            _coordinated(data, where)

    return draw, play


KINDS: dict[str, Kind] = {f.__name__: f for f in (scenes, recordings, commands, resume, frames)}


def _decoded(data: bytes, kind: Any) -> None:
    with suppress(*UNREADABLE):
        msgspec.msgpack.decode(data, type=kind)


def _recorded(folder: Path) -> Path:
    path = folder / "whole.mcap"
    run(parse("heavylift: 1\nname: swing\nextends: trolley\n"), path, in_process=True)
    return path


def _nodes() -> tuple[Coordinator, list[Node]]:
    model = built(RING)
    wires = couplings(model)
    return Coordinator(list(model.children), wires, Tag(100)), [
        Node(name, Simulator(child, wires=wires)) for name, child in model.children.items()
    ]


def _conversation() -> list[bytes]:
    """All messages of a run of the ring."""
    text: list[bytes] = []
    core, nodes = _nodes()
    for node in nodes:
        node.hello, node.handle = _heard(node.hello, text), _heard(node.handle, text)  # type: ignore[method-assign]
    run_in_memory(core, nodes)
    return list(dict.fromkeys(text))


def _heard(function: Any, text: list[bytes]) -> Any:
    def hear(*asked: Any) -> Any:
        answer = function(*asked)
        text.extend(m.encode(x) for x in (*asked, answer) if isinstance(x, msgspec.Struct))
        return answer

    return hear


def _participant(welcome: bytes, data: bytes, where: int) -> None:
    """A node hears a spoiled message, first or after a good beginning."""
    node = Participant(["station-1"], lambda _: None, lambda _: None)
    for message in ([welcome] if where % 4 else []) + [data, data]:
        if not node.over:
            node.handle(message)


def _coordinated(data: bytes, where: int) -> None:
    """The coordinator hears a spoiled answer in the middle of a run."""
    core, nodes = _nodes()
    answer = m.decode(data)
    calls = 0

    def instead(function: Any, *kinds: type) -> Any:
        def text(*asked: Any) -> Any:
            nonlocal calls
            calls += 1
            return answer if calls == 1 + where % 12 and type(answer) in kinds else function(*asked)

        return text

    nodes[0].hello = instead(nodes[0].hello, m.Hello, m.Fail)  # type: ignore[method-assign]
    nodes[0].handle = instead(nodes[0].handle, m.GrantDone, m.Fail)  # type: ignore[method-assign]
    run_in_memory(core, nodes)
