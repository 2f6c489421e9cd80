"""A small MCAP writer: chunks are built from byte strings, rare records by the mcap library.

The library's Writer takes some twenty microseconds for each message, this one takes one and a half: a message is one
header packed into the growing chunk and one entry in the index of its channel. The file follows the specification: zstd
chunks with message indexes, a summary with statistics and indexes, checksums of chunks, data section, attachments and
summary.

Also the classification of errors in reading a file: damaged bytes, failing libraries, and errors of the operating
system.
"""

import errno
import struct
import sys
import zlib
from collections.abc import Mapping, Sequence
from traceback import walk_tb
from types import ModuleType
from typing import BinaryIO

import msgspec
import zstandard
from google.protobuf.message import DecodeError  # type: ignore[import-untyped]
from mcap import records as r
from mcap.data_stream import RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
CHUNK = 256 * 1024  # [bytes] before packing
RECENT = 64  # chunk indexes that are kept as they are
LEVEL = 3  # of zstd: higher ones gain 2 % in thrice the time
MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log and publish time
BODY = MESSAGE.size - 9
ENTRY = struct.Struct("<QQ")  # of a message index: log time, offset in the chunk
INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of entries
FOOTER = struct.Struct("<BQQQ")


class McapFile:
    """Writer of a new MCAP file to `stream`; `finish` writes the summary but does not close the stream."""

    def __init__(self, stream: BinaryIO, library: str) -> None:
        self._stream, self._place, self._crc = stream, 0, 0
        self._pack = zstandard.ZstdCompressor(level=LEVEL).compress
        self._schemas: list[r.Schema] = []
        self._channels: list[r.Channel] = []
        self._counts = [0]  # messages by channel
        self._attachments: list[r.AttachmentIndex] = []
        self._metadata: list[r.MetadataIndex] = []
        self._chunks: list[r.ChunkIndex] = []  # the last ones; a long run has many
        self._indexes = bytearray()  # those before, encoded
        self._chunk_count, self._began, self._ended = 0, 0, 0  # of all chunks; least and largest log time
        self._chunk = bytearray()
        self._entries: dict[int, bytearray] = {}
        self._first = self._last = 0  # log times in the chunk
        self._write(MAGIC)
        self._record(r.Header(profile="", library=library))

    def metadata(self, name: str, facts: Mapping[str, str]) -> None:
        """Write a metadata record with a name and texts to the MCAP file."""
        self._close_chunk()
        offset, length = self._record(r.Metadata(name=name, metadata=dict(facts)))
        self._metadata.append(r.MetadataIndex(offset=offset, length=length, name=name))

    def attachment(self, create_ns: int, name: str, media: str, data: bytes) -> None:
        """Write a file as an attachment of the recording."""
        self._close_chunk()
        record = r.Attachment(create_time=create_ns, log_time=0, name=name, media_type=media, data=data)
        offset, length = self._record(record)
        self._attachments.append(
            r.AttachmentIndex(
                offset=offset,
                length=length,
                log_time=0,
                create_time=create_ns,
                data_size=len(data),
                name=name,
                media_type=media,
            )
        )

    def schema(self, name: str, language: str, data: bytes) -> int:
        """Write a message schema to the MCAP file and return its number."""
        self._schemas.append(r.Schema(id=len(self._schemas) + 1, data=data, encoding=language, name=name))
        self._chunk += _bytes(self._schemas[-1])
        return len(self._schemas)

    def channel(self, topic: str, encoding: str, schema: int, facts: Mapping[str, str]) -> int:
        """Add a channel whose messages have the schema with the given number; return the number of the channel."""
        number = len(self._channels) + 1
        record = r.Channel(id=number, topic=topic, message_encoding=encoding, metadata=dict(facts), schema_id=schema)
        self._channels.append(record)
        self._chunk += _bytes(record)
        self._counts.append(0)
        return number

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Append a message to a channel of the MCAP file."""
        chunk = self._chunk
        if not self._entries:
            self._first = self._last = log_ns
        entries = self._entries.get(channel)
        if entries is None:
            entries = self._entries[channel] = bytearray()
        entries += ENTRY.pack(log_ns, len(chunk))
        chunk += MESSAGE.pack(Opcode.MESSAGE, BODY + len(data), channel, self._counts[channel], log_ns, publish_ns)
        chunk += data
        if log_ns > self._last:
            self._last = log_ns
        elif log_ns < self._first:  # only in what is recovered
            self._first = log_ns
        self._counts[channel] += 1
        if len(chunk) >= CHUNK:
            self._close_chunk()

    def flush(self) -> None:
        """Write all data to disk."""
        self._close_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """Write the end of the data section, the summary and the footer."""
        self._close_chunk()
        self._record(r.DataEnd(data_section_crc=self._crc))
        start = self._place
        groups: list[tuple[Opcode, bytes]] = [
            (Opcode.SCHEMA, _all(self._schemas)),
            (Opcode.CHANNEL, _all(self._channels)),
            (Opcode.STATISTICS, _bytes(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._indexes) + _all(self._chunks)),
            (Opcode.ATTACHMENT_INDEX, _all(self._attachments)),
            (Opcode.METADATA_INDEX, _all(self._metadata)),
        ]
        summary, offsets = b"", []
        for opcode, group in groups:
            if group:
                offsets.append(
                    r.SummaryOffset(group_opcode=opcode, group_length=len(group), group_start=start + len(summary))
                )
                summary += group
        end = start + len(summary)
        summary += b"".join(_bytes(offset) for offset in offsets)
        self._write(summary)
        crc = zlib.crc32(FOOTER.pack(Opcode.FOOTER, 20, start, end), zlib.crc32(summary))
        self._record(r.Footer(summary_start=start, summary_offset_start=end, summary_crc=crc))
        self._write(MAGIC)

    def _close_chunk(self) -> None:
        """Write the chunk with its message indexes; a chunk without messages is kept until it has some."""
        if not self._entries:
            return
        data = bytes(self._chunk)
        packed = self._pack(data)
        offset, length = self._record(
            r.Chunk(
                compression="zstd",
                data=packed,
                message_end_time=self._last,
                message_start_time=self._first,
                uncompressed_crc=zlib.crc32(data),
                uncompressed_size=len(data),
            )
        )
        places, start = {}, self._place
        for channel, entries in self._entries.items():
            places[channel] = self._place
            self._write(INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries)
        if len(self._chunks) == RECENT:
            self._indexes += _all(self._chunks)
            self._chunks.clear()
        self._chunks.append(
            r.ChunkIndex(
                chunk_length=length,
                chunk_start_offset=offset,
                compression="zstd",
                compressed_size=len(packed),
                message_end_time=self._last,
                message_index_length=self._place - start,
                message_index_offsets=places,
                message_start_time=self._first,
                uncompressed_size=len(data),
            )
        )
        self._began = min(self._began, self._first) if self._chunk_count else self._first
        self._ended, self._chunk_count = max(self._ended, self._last), self._chunk_count + 1
        self._chunk.clear()
        self._entries.clear()

    def _statistics(self) -> r.Statistics:
        counts = {channel: n for channel, n in enumerate(self._counts) if n}
        return r.Statistics(
            attachment_count=len(self._attachments), channel_count=len(self._channels), channel_message_counts=counts,
            chunk_count=self._chunk_count, message_count=sum(counts.values()), message_end_time=self._ended,
            message_start_time=self._began, metadata_count=len(self._metadata), schema_count=len(self._schemas),
        )  # fmt: skip

    def _record(self, record: r.McapRecord) -> tuple[int, int]:
        """Write a record; return its position in the file and its length."""
        place, data = self._place, _bytes(record)
        self._write(data)
        return place, len(data)

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._place += len(data)


def _all(records: Sequence[r.McapRecord]) -> bytes:
    return b"".join(map(_bytes, records))


def _bytes(record: r.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


BROKEN = (
    McapError, struct.error, zstandard.ZstdError, msgspec.MsgspecError, DecodeError, OSError, EOFError, ArithmeticError,
    ValueError, LookupError, AttributeError, TypeError, MemoryError, RecursionError,
)  # fmt: skip
"""Exceptions that reading damaged or foreign bytes may raise."""
READERS = {"heavylift", "__main__", "mcap", "msgspec", "zstandard", "google", "numpy"} | sys.stdlib_module_names


def failing(error: BaseException) -> str:
    """Return the library that caused an error by a failed import or a defect; "" if damaged data caused the error."""
    if isinstance(error, ImportError):
        return (error.name or str(error)).partition(".")[0]
    if isinstance(error, AttributeError) and isinstance(error.obj, ModuleType):
        return error.obj.__name__.partition(".")[0]
    for frame, _ in walk_tb(error.__traceback__):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        importing = frame.f_code.co_name == "<module>" and package not in ("heavylift", "__main__")
        if importing or (package not in READERS and "-packages" in frame.f_code.co_filename):  # site-, dist-
            return package
    return ""


def refused(error: BaseException) -> str:
    """Return a sentence about an error of the disk or for lack of memory; "" for any other error."""
    if isinstance(error, MemoryError):
        return "there is too little memory; end other programs and try again"
    if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL, errno.EOVERFLOW):
        return f"{error.strerror}; look after the disk and try again"
    return ""
