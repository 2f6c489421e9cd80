"""Recovery of a cut-off or damaged file: the readable part of its contents becomes a finished recording.

A killed run leaves `NAME.mcap.part`, which contains everything written so far, but no summary and no end. Records are
read one after the other (never by an index, which such a file lacks); a damaged chunk is skipped, and after a damaged
length the next record is searched for. Metadata, attachments, channels and messages are copied unchanged; the new
`result` says that the run was cut off, at what time, and what was lost. If only the end of the file after all data is
damaged, and the digest computed again equals that of the old result, nothing was lost and the old result is kept.
"""

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.mcapfile import BROKEN, MAGIC
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.outputs import PART, beside, file_path, output_path, unnamable
from heavylift.recordings.write.sink import FORMAT, RecordingSink, library
from mcap.records import Attachment, Channel, DataEnd, Header, Message, Metadata, Schema

from .chunks import LIMIT, RECORD, salvaged
from .container import HEAD, Container, is_recording
from .contents import Contents

TORN = "rows of numbers without poses, or poses without numbers"


@dataclass
class Recovered:
    """Result of a recovery: path of the new file, number of its messages, time of its last message [s], and sentences
    about the unreadable parts."""

    path: Path
    messages: int = 0
    sim_s: float = 0.0
    lost: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        lost = "; ".join(self.lost) or "nothing that had reached the disk"
        return f"{self.messages} messages until {self.sim_s:.3f} s; lost: {lost}"


def recover(path: str | Path, out: str | Path | None = None, force: bool = False, begun: bool = False) -> Recovered:
    """Copy everything readable of a recording into `out` (default: NAME-recovered.mcap).

    Raises RecordingError if the file contains no run. `begun`: accept any run that did not reach its end, even if it
    has no messages yet or its file is undamaged.
    """
    path = file_path(path)
    if refused := unnamable(path):
        raise RecordingError(f"{path}: the file cannot be opened ({refused}); check the name")
    if path.exists() and not path.is_file():
        raise RecordingError(f"{path}: this is not a file; give the name of a recording, such as run.mcap.part")
    name = path.name.removesuffix(PART)
    out = output_path(out or beside(path.with_name(name), "-recovered.mcap"), "a recording", (".mcap",))
    if path in (out, out.with_name(out.name + PART)):
        raise RecordingError(f"{out}: this would overwrite the file to be recovered; choose another name with -o")
    try:
        stream = path.open("rb")
    except OSError as error:
        raise RecordingError(f"{path}: the file cannot be opened ({error.strerror}); check the name") from None
    with stream:
        if not is_recording(stream.read(HEAD)):
            raise RecordingError(f"{path}: this is not a recording (not an MCAP file); there is nothing to recover")
        stream.seek(max(0, path.stat().st_size - len(MAGIC)))
        copy = _Copy(path, out, begun, force, stream.read() == MAGIC)
        stream.seek(len(MAGIC))
        try:
            for record in salvaged(stream, path.stat().st_size, copy.found.lost):
                copy.take(record)
                if isinstance(record, DataEnd) and record.data_section_crc:
                    copy.whole = copy.proved = record.data_section_crc == _crc(stream, stream.tell() - RECORD.size - 4)
            return copy.finish()
        finally:
            copy.abandon()


def _crc(stream: BinaryIO, end: int) -> int:
    """Return the CRC of all bytes before the position `end`."""
    stream.seek(0)
    crc = 0
    while data := stream.read(min(LIMIT, end - stream.tell())):
        crc = zlib.crc32(data, crc)
    return crc


class _Copy:
    """Copy of the readable records; the new file is opened when facts and attachments are known, at the first
    channel."""

    def __init__(self, path: Path, out: Path, begun: bool, force: bool, ended: bool) -> None:
        self._path, self._out, self._begun, self._force = path, out, begun, force
        self._metadata: dict[str, dict[str, str]] = {}
        self._attachments: dict[str, bytes] = {}
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._numbers: dict[int, int] = {}  # of a channel in the new file
        self._sink: RecordingSink | None = None
        self._contents, self._readable = Contents(), True
        self._library, self._ended, self._described = "", ended, True
        self._held: dict[str, Message] = {}  # numbers of the last row of each lift, and times of those that are copied
        self._alone: dict[str, int] = {}
        self.whole, self.proved = True, False
        """Whether all data bytes agree with their checksum as far as it exists; whether the checksum exists."""
        self._late = 0  # what was lost before the last facts; behind those of the result nothing stands, as a rule
        self.found = Recovered(out)

    def take(self, record: object) -> None:
        match record:
            case Header():
                self._library = record.library
            case DataEnd():
                self._ended = True
            case Metadata():
                self._metadata[record.name] = dict(record.metadata)
                self._late = len(self.found.lost)
            case Attachment():
                self._attachment(record)
            case Schema():
                self._schemas[record.id] = record
            case Channel():
                self._channels[record.id] = record
            case Message():
                self._message(record)

    def _open(self) -> RecordingSink:
        if self._sink is None:
            if "run" not in self._metadata and not self._library.startswith(GENERATOR):
                raise RecordingError(
                    f"{self._path}: the file contains no run of heavylift; there is nothing to recover"
                )
            run = self._metadata.get("run", {})
            run = {**run, "format": str(FORMAT)} if self._library == library() else run
            made = self._library if self._library.startswith(GENERATOR) else ""
            self._sink = RecordingSink(self._out, run, self._attachments, self._force, made)
        return self._sink

    def _attachment(self, record: Attachment) -> None:
        if self._sink is None:
            self._attachments[record.name] = record.data
        else:  # a checkpoint
            with self._sink.writing():
                self._sink.mcap.attachment(record.create_time, record.name, record.media_type, record.data)

    def _message(self, message: Message) -> None:
        """Copy a message; the numbers of a row wait until its poses arrive, since a row needs both."""
        self._open()
        if not self._known(message) and self._described:
            self._described = False
            self._describe()
        if not self._known(message):
            self._lose("messages of a channel that is not described")
            return
        topic = self._channels[message.channel_id].topic
        kind, _, lift = topic[1:].partition("/")
        if kind == "samples" and any(x.topic == f"/poses{topic[len('/samples') :]}" for x in self._channels.values()):
            if lift in self._held:
                self._lose(TORN)
            self._held[lift] = message
            return
        if kind == "poses":
            held = self._held.pop(lift, None)
            if self._alone.pop(lift, held.publish_time if held else None) != message.publish_time:
                self._lose(TORN)
                return
            if held is not None:
                self._write(held)
        if kind == "samples":  # before poses are announced
            self._alone[lift] = message.publish_time
        self._write(message)

    def _lose(self, what: str) -> None:
        self.found.lost += [what] if what not in self.found.lost else []

    def _known(self, message: Message) -> bool:
        """Return whether the channel of a message and its schema are known."""
        channel = self._channels.get(message.channel_id)
        return channel is not None and channel.schema_id in self._schemas

    def _describe(self) -> None:
        """Search the whole file, including its summary, for descriptions of channels and schemas."""
        with self._path.open("rb") as stream:
            stream.seek(len(MAGIC))
            for record in salvaged(stream, self._path.stat().st_size, [], beyond=True):
                if isinstance(record, Schema | Channel):
                    self.take(record)

    def _write(self, message: Message) -> None:
        sink, channel = self._open(), self._channels[message.channel_id]
        schema = self._schemas[channel.schema_id]
        with sink.writing():
            sink.mcap.write(self._number(channel), message.log_time, message.publish_time, message.data)
        sink.flush()
        self.found.messages += 1
        self.found.sim_s = max(self.found.sim_s, message.log_time * 1e-9)
        self._understood(
            self._contents.take, channel.topic, channel.metadata, schema.data, message.publish_time, message.data
        )

    def _number(self, channel: Channel) -> int:
        """Return the number of a channel in the new file."""
        if channel.id not in self._numbers:
            schema = self._schemas[channel.schema_id]
            self._numbers[channel.id] = self._open().channel(
                channel.topic, channel.message_encoding, schema.name, schema.encoding, schema.data, channel.metadata
            )
        return self._numbers[channel.id]

    def _understood(self, take: Callable[..., None], *what: object) -> None:
        """Evaluate a copied record with `take`, until a record does not follow the format of this version."""
        try:
            if self._readable:
                take(*what)
        except BROKEN:
            self._readable = False

    def finish(self) -> Recovered:
        """Write the result of the recovery, and give the new file its final name."""
        sink = self._open()
        if self._held:
            self._lose(TORN)
        if not (self.found.messages or self._begun):
            raise RecordingError(f"{self._path}: the file contains no readable message; there is nothing to recover")
        if self._ended:
            self._describe()
        for channel in self._channels.values():  # those without messages, too, which may stand in the summary alone
            if channel.schema_id in self._schemas and channel.topic not in sink.topics:
                self._number(channel)
        stored = self._metadata.get("result", {})
        self._understood(self._contents.end)
        lost, status = self.found.lost, stored.get("status")
        missing = self._contents.unknown or "digest" not in stored
        agrees = self._readable and (self._contents.agrees(stored) or (self.proved and bool(stored and missing)))
        if stored and (not self._begun or status == "finished") and _undamaged(self._path):
            raise RecordingError(f"{self._path}: the file is complete and undamaged; there is nothing to recover")
        if agrees and self.whole and not lost[: self._late]:
            lost.clear()
            if self._begun and status == "finished":
                raise RecordingError(
                    f"{self._path}: the run in this file is complete; `heavylift recover {self._path}` "
                    "completes the file"
                )
            self.found.path = sink.finish(stored)
            return self.found
        why = "a byte outside of the messages was changed"
        why = f"; the old result is not kept: {why if not self.whole else 'its digest differs'}"
        facts: dict[str, object] = {
            "status": "damaged" if stored or self._ended else "cut off",
            "reason": f"recovered from {self._path.name}: {self.found}{why if stored and not lost else ''}",
            "sim_s": self.found.sim_s,
            "peaks": {name: peak._asdict() for name, peak in self._contents.peaks.items()},
        }
        self.found.path = sink.finish(facts)
        return self.found

    def abandon(self) -> None:
        """Delete the incomplete copy."""
        if self._sink is not None:
            self._sink.abandon(keep=False)


def _undamaged(path: Path) -> bool:
    """Return whether all parts of a recording are readable."""
    try:
        return not Container(path).damage()
    except RecordingError:
        return False
