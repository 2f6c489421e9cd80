"""Safe access to an MCAP file of unknown origin: sizes are checked before anything is read or unpacked.

The summary at the end is read first and its CRC checked, then only the chunks that hold the wanted
channels; a damaged, cut-off, foreign or hostile file ends in one sentence (RecordingError), never in a
traceback or without memory.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import wraps
from pathlib import Path
from typing import Concatenate, NamedTuple, ParamSpec, Protocol, TypeVar

import msgspec
import numpy as np
import zstandard
from google.protobuf.message import DecodeError  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.mcapfile import MAGIC
from heavylift.recordings.format.text import shown
from heavylift.recordings.write.outputs import file_path, unnamable
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Attachment, Chunk, ChunkIndex, Metadata
from mcap.summary import Summary
from numpy.typing import NDArray

from .chunks import LIMIT, RECORD, Raw, Table, messages_of, tables_of, unpacked

FOOTER = struct.Struct("<BQQQI")
RATIO = 100  # most that a whole file may grow when it is unpacked; what runs record grows four times
P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S", bound="Read")
INDEX, ENTRY = struct.Struct("<BQHI"), 16  # of the messages of a channel in a chunk; bytes for each of them
BROKEN = (
    McapError,
    struct.error,
    zstandard.ZstdError,
    msgspec.MsgspecError,
    DecodeError,
    OSError,
    EOFError,
    ArithmeticError,
    ValueError,
    LookupError,
    AttributeError,
    TypeError,
    MemoryError,
    RecursionError,
)


class Topic(NamedTuple):
    """A channel of the file: topic, schema name, message encoding, its metadata, number of messages."""

    name: str
    schema: str
    encoding: str
    metadata: dict[str, str]
    messages: int


class Container:
    """A finished MCAP file."""

    def __init__(self, path: str | Path) -> None:
        self.path = file_path(path)
        with self.reading():
            self._open()

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Turns whatever goes wrong inside into a sentence about this file."""
        try:
            yield
        except RecordingError:
            raise
        except BROKEN as error:
            raise self.error(f"is damaged ({error or type(error).__name__}); run the scene again") from None

    def error(self, what: str) -> RecordingError:
        """A sentence about this file."""
        return RecordingError(shown(f"{self.path}: {what}"))

    def _open(self) -> None:
        path = self.path
        if refused := unnamable(path):
            raise self.error(f"cannot be opened ({refused}); check the name")
        if path.is_dir():
            raise self.error("is a folder; give the name of a recording, such as run.mcap")
        if path.exists() and not path.is_file():
            raise self.error("is no file but a pipe or device; save the recording in a file first")
        part = path.with_name(path.name + ".part")
        try:
            self._stream = path.open("rb")
        except FileNotFoundError:
            if part.exists():
                raise self.error(
                    f"does not exist, but {part} does: its run is still going or was cut off; "
                    f"`heavylift recover {part}`"
                ) from None
            raise self.error("does not exist; check the name or make it with `heavylift run`") from None
        except OSError as error:
            raise self.error(f"cannot be opened ({error.strerror}); check its permissions") from None
        self.size = path.stat().st_size
        if self.size == 0:
            raise self.error("is empty; run the scene again")
        if self._stream.read(len(MAGIC)) != MAGIC:
            raise self.error("is not a recording (not an MCAP file); give a file made by `heavylift run`")
        self._stream.seek(max(0, self.size - len(MAGIC)))
        if self.size < 2 * len(MAGIC) + FOOTER.size or self._stream.read() != MAGIC:
            raise self.error(
                "is cut off: its end is missing, as in the .part file of a run that was killed; `heavylift recover` it"
            )
        self._check_summary()
        self._stream.seek(0)
        reader = SeekingReader(self._stream, record_size_limit=LIMIT)
        self.library = reader.get_header().library
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise self.error("has no summary; it was not made by `heavylift run`")
        lengths = [x.length for x in summary.attachment_indexes] + [x.length for x in summary.metadata_indexes]
        if sum(lengths) + sum(x.chunk_length for x in summary.chunk_indexes) > self.size:
            raise ValueError("its indexes point to more than there is")
        size = sum(index.uncompressed_size for index in summary.chunk_indexes)
        if size > LIMIT + RATIO * self.size:
            raise ValueError(f"it would unpack to {size} bytes, which no run records")
        self.summary: Summary = summary
        self._counts: dict[int, int] = dict(summary.statistics.channel_message_counts)

    def _check_summary(self) -> None:
        self._stream.seek(-FOOTER.size - len(MAGIC), 2)
        footer = self._stream.read(FOOTER.size)
        opcode, length, start, _, crc = FOOTER.unpack(footer)
        end = self.size - FOOTER.size - len(MAGIC)
        if opcode != Opcode.FOOTER or length != 20 or not 0 <= end - start <= LIMIT:
            raise ValueError("the footer is wrong")
        self._stream.seek(start)
        if crc and start and zlib.crc32(self._stream.read(end - start) + footer[:-4]) != crc:
            raise ValueError("the summary's checksum is wrong")

    def _at(self, offset: int, length: int, opcode: Opcode) -> ReadDataStream:
        """The body of the record of this kind at this place."""
        if not 9 <= length <= LIMIT or not 0 <= offset <= self.size - length:
            raise ValueError(f"a {opcode.name.lower()} of {length} bytes is beyond the limit or the end")
        self._stream.seek(offset)
        found, body = RECORD.unpack(self._stream.read(RECORD.size))
        if found != opcode or body != length - RECORD.size:
            raise ValueError(f"no {opcode.name.lower()} stands where the index says")
        return ReadDataStream(self._stream)

    def topics(self) -> dict[str, Topic]:
        """All channels by topic."""
        with self.reading():
            return {
                shown(x.topic): Topic(
                    shown(x.topic),
                    shown(self.summary.schemas[x.schema_id].name),
                    shown(x.message_encoding),
                    shown(dict(x.metadata)),
                    self._counts.get(x.id, 0),
                )
                for x in self.summary.channels.values()
            }

    def metadata(self) -> dict[str, dict[str, str]]:
        """All metadata records by name."""
        with self.reading():
            found = (
                Metadata.read(self._at(index.offset, index.length, Opcode.METADATA))
                for index in self.summary.metadata_indexes
            )
            return {record.name: dict(record.metadata) for record in found}

    def attachments(self, wanted: Callable[[str], bool] = lambda name: True) -> dict[str, bytes]:
        """The attached files by name, all or those of the names that are wanted."""
        with self.reading():
            found = (
                Attachment.read(self._at(index.offset, index.length, Opcode.ATTACHMENT))
                for index in self.summary.attachment_indexes
                if wanted(index.name)
            )
            return {record.name: record.data for record in found}

    def messages(self, channels: set[int]) -> Iterator[Raw]:
        """The messages of these channels in the order of the file."""
        for index in self._chunks(channels):
            with self.reading():
                found = list(messages_of(self._unpack(index), channels))
            yield from found

    def tables(self, channels: set[int], only: Sequence[int] | None = None) -> Iterator[Table]:
        """The same, those of a channel that have one length together; `only`: of each channel those of these numbers,
        rising.  Chunks without any of them are not unpacked."""
        before, wanted = dict.fromkeys(channels, 0), np.array([] if only is None else only, np.int64)
        for index in self._chunks(channels):
            with self.reading():
                if only is not None and (offsets := index.message_index_offsets):
                    counts = {c: self._count(offsets[c], c) for c in channels & offsets.keys()}
                    if not any(len(_between(wanted, before[c], n)) for c, n in counts.items()):
                        before |= {c: before[c] + n for c, n in counts.items()}
                        continue
                found = list(tables_of(self._unpack(index), channels))
            for channel, times, data in found:
                kept = slice(None) if only is None else _between(wanted, before[channel], len(times))
                yield Table(channel, times[kept], data[kept])
                before[channel] += len(times)

    def _chunks(self, channels: set[int]) -> Iterator[ChunkIndex]:
        """Those that may hold messages of these channels, in the order of the file."""
        for index in sorted(self.summary.chunk_indexes, key=lambda index: index.chunk_start_offset):
            if not index.message_index_offsets or not channels.isdisjoint(index.message_index_offsets):
                yield index

    def _count(self, offset: int, channel: int) -> int:
        """How many messages of a channel the index of a chunk at this place tells of."""
        self._stream.seek(offset)
        opcode, _, found, size = INDEX.unpack(self._stream.read(INDEX.size))
        if opcode != Opcode.MESSAGE_INDEX or found != channel:
            raise ValueError("no index of messages stands where the summary says")
        return int(size // ENTRY)

    def _unpack(self, index: ChunkIndex) -> bytes:
        chunk = Chunk.read(self._at(index.chunk_start_offset, index.chunk_length, Opcode.CHUNK))
        data = unpacked(chunk)
        if len(data) != index.uncompressed_size:
            raise ValueError("a chunk has another size than its index says")
        return data


def _between(numbers: NDArray[np.int64], first: int, count: int) -> NDArray[np.int64]:
    """Those of rising numbers that are among so many from `first` on, counted from there."""
    found: NDArray[np.int64] = numbers[slice(*np.searchsorted(numbers, (first, first + count)))] - first
    return found


class Read(Protocol):
    """What is read of such a file."""

    def reading(self) -> AbstractContextManager[None]: ...


def guarded(tell: Callable[Concatenate[S, P], R]) -> Callable[Concatenate[S, P], R]:
    """Makes of a function of a recording one that ends in a sentence where facts in the file are not what they are."""

    @wraps(tell)
    def told(rec: S, /, *args: P.args, **kwargs: P.kwargs) -> R:
        with rec.reading():
            return tell(rec, *args, **kwargs)

    return told
