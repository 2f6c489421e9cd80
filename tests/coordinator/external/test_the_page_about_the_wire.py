"""Each hex dump of WIRE.md, read by the program's own codec and by one that knows nothing but the page."""

from __future__ import annotations

import json
import re
import struct
import zlib
from pathlib import Path

import msgpack
import msgspec
import pytest
from heavylift.coordinator.participants import SPEAKS, External, parts
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.transport import FrameReader, FrameTopic, Ticket, Writer
from heavylift.nodes.devs import message_type
from heavylift.nodes.zoo import ring

PAGE = (Path(__file__).parents[3] / "coordinator/protocol/WIRE.md").read_text()
DUMPS = dict(re.findall(r"^```wire (\w+)\n(.*?)^```", PAGE, re.M | re.S))
KINDS = {message.__struct_config__.tag: message for message in m.AnyMessage.__args__}


def dump(name: str) -> tuple[object, bytes]:
    """What the page says that the bytes mean, and the bytes."""
    lines = DUMPS[name].splitlines()
    text = json.loads(lines.pop(0)) if lines[0][0] in "[{" else None
    return text, bytes.fromhex("".join(lines))


def shown(x: object) -> object:
    """Plain data as the page writes it."""
    if isinstance(x, bytes):
        return f"h'{x.hex()}'"
    if isinstance(x, dict):
        return {key: shown(value) for key, value in x.items()}
    return [shown(y) for y in x] if isinstance(x, list) else x


def test_every_message_on_the_wire_format_page_is_shown_with_its_bytes() -> None:
    assert sorted(DUMPS) == sorted([*KINDS, "alive", "config", "frame"])


@pytest.mark.parametrize("name", sorted(DUMPS.keys() - {"frame"}))
def test_the_example_messages_on_the_wire_format_page_are_valid_messagepack(name: str) -> None:
    text, data = dump(name)
    assert shown(msgpack.unpackb(data)) == text


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_the_example_program_reads_and_writes_the_bytes_shown_on_the_wire_format_page(kind: str) -> None:
    data = dump(kind)[1]
    message = m.decode(data)
    assert type(message) is KINDS[kind]
    assert m.encode(message) == data
    assert m.kind(data) == kind
    rows = dict(re.findall(r"^\| `(\w+)` \| \w+ \| (.*?) \|", PAGE, re.M))
    assert tuple(rows[kind].split(", ")) == message.__struct_fields__


def test_the_example_program_creates_the_documented_liveliness_token_and_session_config() -> None:
    assert msgspec.msgpack.decode(dump("alive")[1], type=m.Alive) == m.Alive(12)
    model = ring(stations=4, tokens=2, hold=5_000_000)
    wires = [(a.owner.name, a.name, b.owner.name, b.name) for a, b in model.couplings]
    assert External("s1", [model.children["s1"]], wires, 10_000).config == dump("config")[1]
    welcome = m.decode(dump("welcome")[1])
    assert isinstance(welcome, m.Welcome)
    assert welcome.config == dump("config")[1]
    assert msgspec.msgpack.decode(welcome.config, type=parts.ExternalPart).models["s1"].out == {"out": ("Token", 0)}


def test_frames_can_be_decoded_by_the_table_on_the_wire_format_page() -> None:
    frame, done = dump("frame")[1], dump("done")[1]
    rows = re.findall(r"^\| (\d+) \| (\d+) \| (.*?) \|$", PAGE, re.M)
    assert [int(offset) + int(size) for offset, size, _ in rows[:-1]] == [int(offset) for offset, _, _ in rows[1:]]
    crc, number, magic, topic, epoch, r, n = struct.unpack_from("<IQ4sBIBB", frame)
    assert (crc, number, magic, topic, epoch) == (zlib.crc32(frame[4:]), 1, b"HLF1", 1, 1)
    assert (frame[23 : 23 + r], frame[23 + r : 23 + r + n]) == (b"9c1f0e6b2a7d4583", b"s1")
    assert frame[23 + r + n :] == done
    reader, writer = (kind("9c1f0e6b2a7d4583", "s1", FrameTopic.OUT, 1) for kind in (FrameReader, Writer))
    first = writer.frame(b"")
    assert (reader.open(first), writer.frame(done), reader.open(frame)) == (b"", frame, done)


def test_the_ticket_is_read_and_written_as_the_wire_format_page_specifies() -> None:
    text = re.search(r"^```json\n(.*?)\n```", PAGE, re.M | re.S)
    assert text is not None
    ticket = msgspec.json.decode(text[1], type=Ticket)
    assert ticket.to_text() == text[1]
    assert f"**{SPEAKS}**" in PAGE
    assert message_type("Token").__struct_fields__ == ("number",)
