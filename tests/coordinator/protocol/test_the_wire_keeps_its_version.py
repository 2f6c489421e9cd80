"""Frames of each version of the wire, as they were written first: today's program reads and writes those of its own.

Whoever changes a message raises `WIRE` and runs this file as a program, which adds the frames of the new version.
"""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.transport import MAGIC, WIRE, FrameReader, FrameTopic, Writer
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import AtomicResult, Event, Slack, Tag

FILE = Path(__file__).parents[2] / "data" / "wire.json"
EVENTS = [Event(5, 1, "crane", "report", 0, "Report", b"\x91\x07"), Event(9, 0, "crane", "done", 2, "Done", b"")]
SAID: dict[str, m.AnyMessage] = {
    "hello": m.Hello(Tag(5, 1), EVENTS, Tag(9), {"crane.report": 3}, b"declared", f"wire {WIRE}", "of a scene"),
    "welcome": m.Welcome(2, b"config"),
    "grant": m.Grant(4, Tag(10**12, 3), (7, 0), True, EVENTS),
    "done": m.GrantDone(4, Tag(10), EVENTS, Tag(11), EVENTS[:1], Tag(12, 1), bytes(range(32)), Tag(9)),
    "checkpoint": m.Checkpoint(4, b"state", "why"),
    "fail": m.Fail(Tag(3), "yard.crane", "cannot", "Traceback", EVENTS),
    "stop": m.StopRun(Tag(2**63 - 1), "the end"),
    "bye": m.Bye("nothing", 0.25, [Slack("crane.report", 3, 5, 2)], [AtomicResult("crane", "Report", b"\x91\x07")]),
}
FRAMES: dict[str, dict[str, str]] = json.loads(FILE.read_text()) if FILE.exists() else {}


def framed() -> dict[str, str]:
    """In hexadecimal; all in one run, as the first messages of one node."""
    writer = Writer("9c1f0e6b2a7d4583", "crane", FrameTopic.OUT, 1)
    return {name: writer.frame(m.encode(message)).hex() for name, message in SAID.items()}


def test_every_message_type_of_the_protocol_has_a_stored_example_frame() -> None:
    assert list(FRAMES) == [str(version) for version in range(1, WIRE + 1)]
    tags = {msgspec.inspect.type_info(kind).tag for kind in m.AnyMessage.__args__}  # type: ignore[attr-defined]
    assert tags == SAID.keys() == FRAMES[str(WIRE)].keys()


def test_protocol_messages_are_encoded_to_the_same_bytes_as_in_the_stored_example_file() -> None:
    assert framed() == FRAMES[str(WIRE)]


def test_stored_frames_of_earlier_versions_are_decoded() -> None:
    reader = FrameReader("9c1f0e6b2a7d4583", "crane", FrameTopic.OUT, 1)
    assert {name: m.decode(reader.open(bytes.fromhex(x))) for name, x in FRAMES[str(WIRE)].items()} == SAID


def test_message_frames_of_another_protocol_version_are_refused_with_both_versions() -> None:
    others = {version: bytes.fromhex(FRAMES[version]["hello"]) for version in FRAMES if version != str(WIRE)}
    tomorrow = bytes.fromhex(FRAMES[str(WIRE)]["hello"]).replace(MAGIC, b"HLF%d" % (WIRE + 1))
    for version, frame in (others | {str(WIRE + 1): tomorrow}).items():
        with pytest.raises(ProtocolError, match=f"a frame of wire version {version} arrived, .* speaks version {WIRE}"):
            FrameReader("9c1f0e6b2a7d4583", "crane", FrameTopic.OUT, 1).open(frame)


if __name__ == "__main__":
    FILE.write_text(json.dumps(FRAMES | {str(WIRE): framed()}, indent=1) + "\n")
