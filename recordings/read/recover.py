"""What a cut-off or damaged file still holds, as a finished recording.

A killed run leaves `<name>.mcap.part`: all that was flushed, without summary and without end.  Records are read one
after the other (never by an index, which such a file lacks); a damaged chunk is passed over, a record that is cut off
ends the reading.  Metadata, attachments, channels and messages are copied as they are; the new `result` says that the
run was cut off, until when, and what was lost.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import msgspec
import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.mcapfile import MAGIC
from heavylift.recordings.format.samples import Field
from heavylift.recordings.format.schema import field_places, samples_template
from heavylift.recordings.write.outputs import PART, beside, file_path, output_path, unnamable
from heavylift.recordings.write.rows import Peak
from heavylift.recordings.write.sink import Sink
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Message, Metadata, Schema

from .chunks import LIMIT, RECORD, records, unpacked
from .container import BROKEN, RATIO

CHUNK = struct.Struct("<QQQ")  # how one begins: times of its first and last message [ns], size of what is packed
PEAKS = ("rope/peak", "rope/peak_time")
LONGEST_s = 1e8  # a chunk that tells of later times is damaged there, too
READERS: dict[int, Callable[[ReadDataStream], object]] = {
    Opcode.HEADER: Header.read,
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
}


@dataclass
class Recovered:
    """The new file, messages in it, simulation time of the last one [s], and what could not be read."""

    path: Path
    messages: int = 0
    sim_s: float = 0.0
    lost: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        lost = "; ".join(self.lost) or "nothing that had reached the disk"
        return f"{self.messages} messages until {self.sim_s:.3f} s; lost: {lost}"


def recover(path: str | Path, out: str | Path | None = None, force: bool = False, begun: bool = False) -> Recovered:
    """Copy what is readable into `out` (default: <name>-recovered.mcap); RecordingError if there is no run in it.

    `begun`: any run that did not come to its end will do, though nothing happened in it or its file is whole.
    """
    path = file_path(path)
    if refused := unnamable(path):
        raise RecordingError(f"{path}: cannot be opened ({refused}); check the name")
    if path.exists() and not path.is_file():
        raise RecordingError(f"{path}: is no file; give the name of a recording, such as run.mcap.part")
    name = path.name.removesuffix(PART)
    out = output_path(out or beside(path.with_name(name), "-recovered.mcap"), "a recording", (".mcap",))
    if path in (out, out.with_name(out.name + PART)):
        raise RecordingError(f"{out}: would overwrite what is to be recovered; choose another name with -o")
    try:
        stream = path.open("rb")
    except OSError as error:
        raise RecordingError(f"{path}: cannot be opened ({error.strerror}); check the name") from None
    with stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise RecordingError(f"{path}: is not a recording (not an MCAP file); there is nothing to recover")
        copy = _Copy(path, out, begun, force)
        try:
            for record in _records(stream, path.stat().st_size, copy.found.lost):
                copy.take(record)
            return copy.finish()
        finally:
            copy.abandon()


def _records(stream: BinaryIO, size: int, lost: list[str]) -> Iterator[object]:
    """The known records of the data section in order, those in chunks as well; `lost` hears what is unreadable."""
    room = LIMIT + RATIO * size
    while (place := stream.tell()) < size:
        head = stream.read(RECORD.size)
        length = RECORD.unpack(head)[1] if len(head) == RECORD.size else LIMIT + 1
        if length > min(LIMIT, size - stream.tell()):
            span = _span(head[0], stream.read(CHUNK.size)) if head else ""
            lost.append(f"what stood after byte {place}, where the file is cut off or damaged{span}")
            return
        opcode, body = head[0], stream.read(length)
        if opcode == Opcode.DATA_END:
            return
        room -= CHUNK.unpack_from(body)[2] if opcode == Opcode.CHUNK and length >= CHUNK.size else 0
        if room < 0:
            lost.append(f"what stood after byte {place} and would unpack to more than any run records")
            return
        try:
            found = list(_parsed(opcode, head + body))
        except BROKEN as error:
            lost.append(f"{length} bytes at byte {place} ({error or type(error).__name__}){_span(opcode, body)}")
        else:
            yield from found


def _span(opcode: int, body: bytes) -> str:
    """How much of the run a damaged chunk held, as far as its first bytes tell."""
    if opcode != Opcode.CHUNK or len(body) < CHUNK.size:
        return ""
    first, last, _ = (x * 1e-9 for x in CHUNK.unpack_from(body))
    return f": {last - first:.3f} s of the run, {first:.3f} to {last:.3f} s" if first <= last < LONGEST_s else ""


def _parsed(opcode: int, record: bytes) -> Iterator[object]:
    """A record, or those of a chunk; raises one of BROKEN if it is damaged."""
    stream = ReadDataStream(BytesIO(record[RECORD.size :]))
    if opcode in READERS:
        yield READERS[opcode](stream)
    elif opcode == Opcode.MESSAGE:
        yield Message.read(stream, len(record) - RECORD.size)
    elif opcode == Opcode.CHUNK:
        data = unpacked(Chunk.read(stream))
        for inner, begin, end in records(data):
            yield from _parsed(inner, data[begin - RECORD.size : end])


class _Copy:
    """Takes records one by one; the new file is opened at the first channel, when facts and attachments are known."""

    def __init__(self, path: Path, out: Path, begun: bool, force: bool) -> None:
        self._path, self._out, self._begun, self._force = path, out, begun, force
        self._metadata: dict[str, dict[str, str]] = {}
        self._attachments: dict[str, bytes] = {}
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._made = ""
        self._numbers: dict[int, int] = {}  # of a channel in the new file
        self._sink: Sink | None = None
        self._samples: list[bytes] = []
        self.found = Recovered(out)

    def take(self, record: object) -> None:
        match record:
            case Header():
                self._made = record.library
            case Metadata():
                self._metadata[record.name] = dict(record.metadata)
            case Attachment():
                self._attachments[record.name] = record.data
            case Schema():
                self._schemas[record.id] = record
            case Channel():
                self._channels[record.id] = record
            case Message():
                self._message(record)

    def _open(self) -> Sink:
        if self._sink is None:
            if "run" not in self._metadata:
                raise RecordingError(f"{self._path}: holds no run of heavylift; there is nothing to recover")
            self._sink = Sink(self._out, self._metadata["run"], self._attachments, self._force, self._made)
        return self._sink

    def _message(self, message: Message) -> None:
        sink, channel = self._open(), self._channels.get(message.channel_id)
        schema = self._schemas.get(channel.schema_id) if channel else None
        if channel is None or schema is None:
            note = "messages of a channel that is not described"
            self.found.lost += [note] if note not in self.found.lost else []
            return
        if channel.id not in self._numbers:
            self._numbers[channel.id] = sink.channel(
                channel.topic, channel.message_encoding, schema.name, schema.encoding, schema.data, channel.metadata
            )
        with sink.writing():
            sink.mcap.write(self._numbers[channel.id], message.log_time, message.publish_time, message.data)
        sink.flush()
        self.found.messages += 1
        self.found.sim_s = max(self.found.sim_s, message.log_time * 1e-9)
        if channel.topic == "/samples":
            self._samples.append(message.data)

    def _peaks(self) -> dict[str, Peak]:
        """Largest tension of each rope among the samples that are there."""
        channel = next((c for c in self._channels.values() if c.topic == "/samples"), None)
        if channel is None:
            return {}
        try:
            fields = msgspec.json.decode(channel.metadata["signals"], type=list[Field])
            names = next((f.columns for f in fields if f.signal == "rope/peak"), [])
            sent = np.array([np.frombuffer(x, np.uint8) for x in self._samples])  # ValueError if their lengths differ
            T, when = samples_template(fields).decode(sent, *(field_places(fields)[signal] for signal in PEAKS))
            found = T.argmax(axis=0)
            return {
                name: Peak(float(T[r, i]), float(when[r, i]))
                for i, (name, r) in enumerate(zip(names, found, strict=False))
            }
        except BROKEN:
            return {}  # by rules of another version, or without ropes

    def finish(self) -> Recovered:
        """Write the result and give the file its name."""
        sink = self._open()
        if not (self.found.messages or self._begun):
            raise RecordingError(f"{self._path}: holds no message that can be read; there is nothing to recover")
        ended = not self._begun or self._metadata.get("result", {}).get("status") == "finished"
        if "result" in self._metadata and not self.found.lost and ended:
            raise RecordingError(f"{self._path}: is whole; there is nothing to recover")
        facts: dict[str, object] = {
            "status": "damaged" if "result" in self._metadata else "cut off",
            "reason": f"recovered from {self._path.name}: {self.found}",
            "sim_s": self.found.sim_s,
            "peaks": {name: peak._asdict() for name, peak in self._peaks().items()},
        }
        self.found.path = sink.finish(facts)
        return self.found

    def abandon(self) -> None:
        """Leave nothing half-made behind."""
        if self._sink is not None:
            self._sink.abandon(keep=False)
