"""Safe access to an MCAP file of unknown origin: sizes are checked before anything is read or decompressed.

The summary at the end is read first and its checksum verified, then only the chunks that contain the requested
channels. A damaged, cut-off, foreign or hostile file results in an error of one sentence (RecordingError), never in a
traceback or in running out of memory. Before an error says that a file is damaged, `damage` has checked all of its
bytes, as it does for `recover`, so both always agree.
"""

import struct
import weakref
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError, printable
from heavylift.recordings.format.mcapfile import BROKEN, MAGIC, failing, refused
from heavylift.recordings.format.text import GENERATOR, shown
from heavylift.recordings.write.outputs import HEADER, file_path, unnamable
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Chunk, ChunkIndex, Metadata
from mcap.summary import Summary
from numpy.typing import NDArray

from .chunks import (
    LIMIT,
    RATIO,
    RECORD,
    MessageTable,
    RawMessage,
    attached,
    messages_of,
    numbers_of,
    tables_of,
    unpacked,
)

FOOTER = struct.Struct("<BQQQI")
HEAD = HEADER + len(GENERATOR)  # bytes from which it is known who has made a file
INDEX, ENTRY = struct.Struct("<BQHI"), 16  # of the messages of a channel in a chunk; bytes for each of them
STATED = 300  # characters of what a library says of an error


class FileChannel(NamedTuple):
    """A channel of an MCAP file: topic, name of its schema, encoding, metadata, number of messages, schema."""

    name: str
    schema: str
    encoding: str
    metadata: dict[str, str]
    messages: int
    form: bytes = b""


def is_recording(head: bytes) -> bool:
    """Return whether these are the first bytes of an MCAP file, or of a recording with a damaged beginning."""
    return head.startswith(MAGIC) or head[HEADER:].startswith(GENERATOR.encode())


class Container:
    """Reader of a finished MCAP file whose content is not trusted."""

    def __init__(self, path: str | Path) -> None:
        self.path = file_path(path)
        self._opened = False
        with self.reading():
            self._open()
        self._opened = True

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Return a context that converts read errors into a RecordingError with a sentence about this file."""
        try:
            yield
        except RecordingError:
            raise
        except (*BROKEN, ImportError) as error:
            raise self._sentence(error) from None

    def _sentence(self, error: Exception) -> RecordingError:
        message = printable(str(error), STATED) or type(error).__name__
        if why := refused(error):
            return self.error(f"cannot be read: {why}")
        if library := failing(error):
            return self.error(
                f"cannot be read, as the library {library} fails ({message}); install another version of it"
            )
        if why := self.damage() if self._opened else message:
            message = message if why == message else f"{message}; {why}"
            return self.error(f"is damaged ({message}); `heavylift recover {self.path}` saves what can be read")
        return self.error(
            f"has contents that no run writes ({message}), though no byte is damaged: another program has changed it; "
            "run the scene again"
        )

    def error(self, what: str) -> RecordingError:
        """Return a RecordingError with a sentence about this file."""
        return RecordingError(shown(f"{self.path}: {what}"))

    def _open(self) -> None:
        path = self.path
        if refused := unnamable(path):
            raise self.error(f"the file cannot be opened ({refused}); check the name")
        if path.is_dir():
            raise self.error("this is a folder; give the name of a recording, such as run.mcap")
        if path.exists() and not path.is_file():
            raise self.error("this is a pipe or device; save the recording to a file first")
        part = path.with_name(path.name + ".part")
        try:
            self._stream = path.open("rb")
            weakref.finalize(self, self._stream.close)  # which Python would warn of
        except FileNotFoundError:
            if part.exists():
                raise self.error(
                    f"the file does not exist, but {part} does: its run is still going or was cut off; "
                    f"`heavylift recover {part}`"
                ) from None
            raise self.error("the file does not exist; check the name or make it with `heavylift run`") from None
        except OSError as error:
            raise self.error(f"the file cannot be opened ({error.strerror}); check its permissions") from None
        self.size = path.stat().st_size
        if self.size == 0:
            raise self.error("the file is empty; run the scene again")
        if not is_recording(head := self._stream.read(HEAD)):
            raise self.error("this is not a recording (not an MCAP file); give a file made by `heavylift run`")
        if not head.startswith(MAGIC):
            raise ValueError("its first bytes are not those of an MCAP file")
        self._stream.seek(max(0, self.size - len(MAGIC)))
        if self.size < 2 * len(MAGIC) + FOOTER.size or self._stream.read() != MAGIC:
            raise self.error(
                "the file is cut off: its end is missing, as in the .part file of a run that was killed; "
                f"`heavylift recover {path}` saves what can be read"
            )
        self._check_summary()
        self._stream.seek(0)
        reader = SeekingReader(self._stream, record_size_limit=LIMIT)
        self.library = reader.get_header().library
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise ValueError("it has no summary")
        lengths = [x.length for x in summary.attachment_indexes] + [x.length for x in summary.metadata_indexes]
        if sum(lengths) + sum(x.chunk_length for x in summary.chunk_indexes) > self.size:
            raise ValueError("its indexes point beyond the end of the file")
        size = sum(index.uncompressed_size for index in summary.chunk_indexes)
        if size > LIMIT + RATIO * self.size:
            raise ValueError(f"it would have {size} bytes when unpacked, more than any run records")
        self.summary: Summary = summary
        self._counts: dict[int, int] = dict(summary.statistics.channel_message_counts)

    def _check_summary(self) -> None:
        self._stream.seek(-FOOTER.size - len(MAGIC), 2)
        footer = self._stream.read(FOOTER.size)
        opcode, length, start, _, crc = FOOTER.unpack(footer)
        end = self.size - FOOTER.size - len(MAGIC)
        if opcode != Opcode.FOOTER or length != 20 or not 0 <= end - start <= LIMIT:
            raise ValueError("its footer is corrupt")
        self._stream.seek(start)
        if crc and start and zlib.crc32(self._stream.read(end - start) + footer[:-4]) != crc:
            raise ValueError("the summary's checksum is wrong")

    def damage(self) -> str:
        """Return a sentence about the first damage that checksums or indexes show; "" if the file is undamaged."""
        try:
            self._check_data()
            found: Counter[int] = Counter()
            for index in self.summary.chunk_indexes:
                counts = Counter(numbers_of(self._unpack(index)))
                offsets = index.message_index_offsets
                if offsets and counts != {c: n for c, x in offsets.items() if (n := self._count(x, c))}:
                    raise ValueError("a message index is corrupt")
                found += counts
            if found != Counter({c: n for c, n in self._counts.items() if n}):
                raise ValueError("the message counts in its summary are wrong")
            for at in self.summary.metadata_indexes:
                Metadata.read(ReadDataStream(BytesIO(self._at(at.offset, at.length, Opcode.METADATA))))
            for it in self.summary.attachment_indexes:
                attached(self._at(it.offset, it.length, Opcode.ATTACHMENT))
            return ""
        except BROKEN as error:
            return str(error) or type(error).__name__

    def _check_data(self) -> None:
        """Raise ValueError if data records and summary disagree, or if a checksum is wrong."""
        indexed = {
            Opcode.CHUNK: {x.chunk_start_offset for x in self.summary.chunk_indexes},
            Opcode.METADATA: {x.offset for x in self.summary.metadata_indexes},
            Opcode.ATTACHMENT: {x.offset for x in self.summary.attachment_indexes},
        }
        found: dict[int, set[int]] = {opcode: set() for opcode in indexed}
        place, crc = len(MAGIC), zlib.crc32(MAGIC)
        while True:
            self._stream.seek(place)
            head = self._stream.read(RECORD.size)
            opcode, length = RECORD.unpack(head)
            if opcode == Opcode.DATA_END or length > LIMIT:
                break
            found.get(opcode, set()).add(place)
            crc = zlib.crc32(self._stream.read(length), zlib.crc32(head, crc))
            place += RECORD.size + length
        message = self._stream.read(4)
        if length != len(message) or message not in (bytes(4), struct.pack("<I", crc)):
            raise ValueError("the checksum of its data is wrong")
        if found != indexed:
            raise ValueError("its summary does not list all records")

    def _at(self, offset: int, length: int, opcode: Opcode) -> bytes:
        """Return the body of the record at this place; raises ValueError if it is of another kind."""
        if not 9 <= length <= LIMIT or not 0 <= offset <= self.size - length:
            raise ValueError(f"a {opcode.name.lower()} of {length} bytes exceeds the size limit or the end of the file")
        self._stream.seek(offset)
        found, body = RECORD.unpack(self._stream.read(RECORD.size))
        if found != opcode or body != length - RECORD.size:
            raise ValueError(f"no {opcode.name.lower()} is at the position that the index gives")
        return self._stream.read(body)

    def topics(self) -> dict[str, FileChannel]:
        """Return all channels of the file by topic."""
        with self.reading():
            return {
                shown(x.topic): FileChannel(
                    shown(x.topic),
                    shown(self.summary.schemas[x.schema_id].name),
                    shown(x.message_encoding),
                    shown(dict(x.metadata)),
                    self._counts.get(x.id, 0),
                    self.summary.schemas[x.schema_id].data,
                )
                for x in self.summary.channels.values()
            }

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return all metadata records of the file by name."""
        with self.reading():
            found = (
                Metadata.read(ReadDataStream(BytesIO(self._at(index.offset, index.length, Opcode.METADATA))))
                for index in self.summary.metadata_indexes
            )
            return {record.name: dict(record.metadata) for record in found}

    def attachments(self, wanted: Callable[[str], bool] = lambda name: True) -> dict[str, bytes]:
        """Return the attached files by name; only those whose names satisfy `wanted`."""
        with self.reading():
            found = (
                attached(self._at(index.offset, index.length, Opcode.ATTACHMENT))
                for index in self.summary.attachment_indexes
                if wanted(index.name)
            )
            return {record.name: record.data for record in found}

    def messages(self, channels: set[int]) -> Iterator[RawMessage]:
        """Yield the messages of these channels in the order of the file."""
        for index in self._chunks(channels):
            with self.reading():
                found = list(messages_of(self._unpack(index), channels))
            yield from found

    def tables(self, channels: set[int], only: Sequence[int] | None = None) -> Iterator[MessageTable]:
        """Yield the messages of these channels as tables of messages with equal length.

        `only`: numbers, in ascending order, of the wanted messages of each channel (None: all); chunks without wanted
        messages are not unpacked.
        """
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
                yield MessageTable(channel, times[kept], data[kept])
                before[channel] += len(times)

    def _chunks(self, channels: set[int]) -> Iterator[ChunkIndex]:
        """Yield the indexes of the chunks that may contain messages of these channels, in file order."""
        for index in sorted(self.summary.chunk_indexes, key=lambda index: index.chunk_start_offset):
            if not index.message_index_offsets or not channels.isdisjoint(index.message_index_offsets):
                yield index

    def _count(self, offset: int, channel: int) -> int:
        """Return the number of messages of a channel in a chunk, from the chunk's message index."""
        self._stream.seek(offset)
        opcode, _, found, size = INDEX.unpack(self._stream.read(INDEX.size))
        if opcode != Opcode.MESSAGE_INDEX or found != channel:
            raise ValueError("no message index is at the position that the summary gives")
        return int(size // ENTRY)

    def _unpack(self, index: ChunkIndex) -> bytes:
        chunk = Chunk.read(
            ReadDataStream(BytesIO(self._at(index.chunk_start_offset, index.chunk_length, Opcode.CHUNK)))
        )
        data = unpacked(chunk)
        if len(data) != index.uncompressed_size:
            raise ValueError("the size of a chunk differs from its index")
        return data


def _between(numbers: NDArray[np.int64], first: int, count: int) -> NDArray[np.int64]:
    """Return those of the ascending `numbers` that are at least `first` and below `first` + `count`, minus `first`."""
    found: NDArray[np.int64] = numbers[slice(*np.searchsorted(numbers, (first, first + count)))] - first
    return found
