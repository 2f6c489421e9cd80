"""Chunks of an MCAP file of unknown origin: decompressed within size limits and divided into records and messages, or
into tables.

Also reading of all records one after the other without an index, for files with damaged records.
"""

import re
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from itertools import groupby
from operator import itemgetter
from typing import BinaryIO, NamedTuple

import numpy as np
import zstandard
from heavylift.recordings.format.mcapfile import BROKEN
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, Message, Metadata, Schema
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

LIMIT = 64 << 20  # largest record, packed or unpacked [bytes]
INNER = frozenset(map(int, (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)))  # what may stand in a chunk
RECORD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")
RATIO = 100  # most that a whole file may grow when it is unpacked; what runs record grows four times
CHUNK = struct.Struct("<QQQ")  # how one begins: times of its first and last message [ns], size of what is packed
NEXT = re.compile(rb"(?=[\x03-\x0f][\0-\xff]{4}\0{4})")  # how a record begins: opcode and a length below 4 GB
KNOWN = range(int(Opcode.HEADER), int(Opcode.DATA_END) + 1)
LONGEST_s = 1e8  # a chunk that tells of later times is damaged there, too
READERS: dict[int, Callable[[ReadDataStream], object]] = {
    Opcode.HEADER: Header.read,
    Opcode.METADATA: Metadata.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.DATA_END: DataEnd.read,
}


class RawMessage(NamedTuple):
    """A message as stored in an MCAP file."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class MessageTable(NamedTuple):
    """Messages of equal length in a channel: times (n,) [ns] and bytes (n, length)."""

    channel: int
    times: NDArray[np.int64]
    data: NDArray[np.uint8]


def unpacked(chunk: Chunk) -> bytes:
    """Return the uncompressed records of a chunk; raises ValueError if the chunk is too large, damaged, or compressed
    in an unknown way."""
    size = chunk.uncompressed_size
    if size > LIMIT:
        raise ValueError(f"a chunk of {size} bytes exceeds the size limit")
    if chunk.compression == "zstd":
        if zstandard.get_frame_parameters(chunk.data).content_size != size:
            raise ValueError("the size of a chunk differs from the stated size")
        data = zstandard.decompress(chunk.data, size)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"compression {chunk.compression} is not supported by heavylift")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("a chunk's checksum is wrong")
    return data


def records(data: bytes, place: int = 0) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each record in an uncompressed chunk; raises ValueError for an incomplete one."""
    while place < len(data):
        opcode, length = RECORD.unpack_from(data, place)
        begin, place = place + RECORD.size, place + RECORD.size + length
        if opcode not in INNER or place > len(data):
            raise ValueError("a chunk has an incomplete record")
        yield opcode, begin, place


def attached(body: bytes) -> Attachment:
    """Return the attachment in an attachment record; raises ValueError if its checksum is wrong."""
    if body[-4:] not in (bytes(4), struct.pack("<I", zlib.crc32(body[:-4]))):
        raise ValueError("an attachment's checksum is wrong")
    found: Attachment = Attachment.read(ReadDataStream(BytesIO(body)))
    return found


def numbers_of(data: bytes) -> Iterator[int]:
    """Yield the channel number of each message in an uncompressed chunk."""
    return (data[begin] | data[begin + 1] << 8 for opcode, begin, _ in records(data) if opcode == Opcode.MESSAGE)


def messages_of(data: bytes, channels: set[int]) -> Iterator[RawMessage]:
    """Yield the messages of these channels in an uncompressed chunk."""
    for opcode, begin, end in records(data):
        if opcode == Opcode.MESSAGE and data[begin] | data[begin + 1] << 8 in channels:
            channel, sequence, log_time, publish_time = MESSAGE.unpack_from(data, begin)
            yield RawMessage(channel, sequence, log_time, publish_time, data[begin + MESSAGE.size : end])


def tables_of(data: bytes, channels: set[int]) -> Iterator[MessageTable]:
    """Yield these channels' messages in an uncompressed chunk as tables: messages of equal length, one per row."""
    begins: dict[int, list[tuple[int, int]]] = {channel: [] for channel in channels}  # length and begin of each message
    for opcode, begin, end in records(data):
        if opcode == Opcode.MESSAGE:
            if end - begin < MESSAGE.size:
                raise ValueError("a message is shorter than its header")
            if (found := begins.get(data[begin] | data[begin + 1] << 8)) is not None:
                found.append((end - begin, begin))
    flat = np.frombuffer(data, np.uint8)
    for channel, found in begins.items():
        for length, group in groupby(found, itemgetter(0)):
            rows = sliding_window_view(flat, length)[[begin for _, begin in group]]
            stamps = np.ascontiguousarray(rows[:, MESSAGE.size - 8 : MESSAGE.size]).view("<u8").ravel()
            yield MessageTable(channel, stamps.astype(np.int64), rows[:, MESSAGE.size :])


def salvaged(stream: BinaryIO, size: int, lost: list[str], beyond: bool = False) -> Iterator[object]:
    """Yield the readable records of a damaged file in order, from the position of the stream on.

    Records of the data section, including records inside chunks. `beyond`: also yield records after the data section;
    `lost`: receives sentences about unreadable parts.
    """
    room = LIMIT + RATIO * size
    while (place := stream.tell()) < size:
        head = stream.read(RECORD.size)
        opcode, length = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
        if opcode not in KNOWN or length > min(LIMIT, size - stream.tell()):
            span = _span(head[0], stream.read(CHUNK.size))
            if (after := _next(stream, place + 1, size)) is None:
                lost.append(f"what stood after byte {place}, where the file is cut off or damaged{span}")
                return
            lost.append(f"{after - place} bytes at byte {place} (no record begins there){span}")
            stream.seek(after)
            continue
        body = stream.read(length)
        unpacks = CHUNK.unpack_from(body)[2] if opcode == Opcode.CHUNK and length >= CHUNK.size else 0
        if unpacks > room:
            lost.append(f"{length} bytes at byte {place}, which would unpack to more than any run records")
            continue
        room -= unpacks
        after = place + RECORD.size + length
        if opcode != Opcode.DATA_END and not _begins(stream, after, size):  # its length may be damaged, and lead astray
            stream.seek(_next(stream, place + 1, size) or after)
        try:
            yield from list(_parsed(opcode, head + body))
        except BROKEN as error:
            lost.append(
                f"{stream.tell() - place - RECORD.size} bytes at byte {place} ({error or type(error).__name__})"
                f"{_span(opcode, body)}"
            )
        if opcode == Opcode.DATA_END and not beyond:
            return


def _begins(stream: BinaryIO, place: int, size: int, chain: int = 1) -> bool:
    """Return whether a sequence of `chain` records begins at this place; the stream is then at this place."""
    at, opcode, sound = place, 0, True
    while sound and chain and at != size and opcode != Opcode.DATA_END:
        stream.seek(at)
        head = stream.read(RECORD.size)
        opcode, length = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
        at, chain = at + RECORD.size + length, chain - 1
        sound = opcode in KNOWN and length <= LIMIT and at <= size
    stream.seek(place)
    return sound


def _next(stream: BinaryIO, place: int, size: int) -> int | None:
    """Return the place of the next record that is followed by other records; None if there is none."""
    stream.seek(place)
    rest = stream.read(2 * LIMIT)
    return next((place + x.start() for x in NEXT.finditer(rest) if _begins(stream, place + x.start(), size, 3)), None)


def _span(opcode: int, body: bytes) -> str:
    """Return, as text, the time span of a damaged chunk from its first bytes; "" if it is unknown."""
    if opcode != Opcode.CHUNK or len(body) < CHUNK.size:
        return ""
    first, last, _ = (x * 1e-9 for x in CHUNK.unpack_from(body))
    return f": {last - first:.3f} s of the run, {first:.3f} to {last:.3f} s" if first <= last < LONGEST_s else ""


def _parsed(opcode: int, record: bytes) -> Iterator[object]:
    """Yield a record, or the records in a chunk; raises one of the errors in BROKEN if it is damaged."""
    stream = ReadDataStream(BytesIO(record[RECORD.size :]))
    if opcode in READERS:
        yield READERS[opcode](stream)
    elif opcode == Opcode.ATTACHMENT:
        yield attached(record[RECORD.size :])
    elif opcode == Opcode.MESSAGE:
        yield Message.read(stream, len(record) - RECORD.size)
    elif opcode == Opcode.CHUNK:
        data = unpacked(Chunk.read(stream))
        for inner, begin, end in records(data):
            yield from _parsed(inner, data[begin - RECORD.size : end])
