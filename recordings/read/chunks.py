"""Chunks of an MCAP file of unknown origin: unpacked within limits, cut into records and messages, or into tables."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk
from numpy.typing import NDArray

LIMIT = 64 << 20  # largest record, packed or unpacked [bytes]
INNER = frozenset(map(int, (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)))  # what may stand in a chunk
RECORD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")


class Raw(NamedTuple):
    """A message as it stands in the file."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class Table(NamedTuple):
    """Messages of a channel that have one length: when they were published (n,) [ns], and their bytes (n, length)."""

    channel: int
    times: NDArray[np.int64]
    data: NDArray[np.uint8]


def unpacked(chunk: Chunk) -> bytes:
    """The records of a chunk; ValueError if it is too large, damaged or packed in a way of others."""
    size = chunk.uncompressed_size
    if size > LIMIT:
        raise ValueError(f"a chunk of {size} bytes is beyond the limit")
    if chunk.compression == "zstd":
        if zstandard.get_frame_parameters(chunk.data).content_size != size:
            raise ValueError("a chunk has another size than it says")
        data = zstandard.decompress(chunk.data, size)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"compression {chunk.compression} is not used by heavylift")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("a chunk's checksum is wrong")
    return data


def records(data: bytes, place: int = 0) -> Iterator[tuple[int, int, int]]:
    """Opcode, begin and end of the content of each record of an unpacked chunk from a place on; ValueError if they are
    not whole."""
    while place < len(data):
        opcode, length = RECORD.unpack_from(data, place)
        begin, place = place + RECORD.size, place + RECORD.size + length
        if opcode not in INNER or place > len(data):
            raise ValueError("a chunk is not made of whole records")
        yield opcode, begin, place


def messages_of(data: bytes, channels: set[int]) -> Iterator[Raw]:
    """The messages of these channels in an unpacked chunk."""
    for opcode, begin, end in records(data):
        if opcode == Opcode.MESSAGE and data[begin] | data[begin + 1] << 8 in channels:
            channel, sequence, log_time, publish_time = MESSAGE.unpack_from(data, begin)
            yield Raw(channel, sequence, log_time, publish_time, data[begin + MESSAGE.size : end])


def tables_of(data: bytes, channels: set[int]) -> Iterator[Table]:
    """The same by tables: what a sampler writes repeats after a few records, and is then taken as rows of bytes."""
    flat, place = np.frombuffer(data, np.uint8), 0
    while place < len(data):
        heads: list[tuple[int, int, int]] = []  # of records until a channel recurs: it, begin and end of content
        known: set[int] = set()
        for opcode, begin, end in records(data, place):
            if opcode != Opcode.MESSAGE or end - begin < MESSAGE.size:
                if opcode == Opcode.MESSAGE:
                    raise ValueError("a message is shorter than its head")
                channel = -1
            else:
                channel = data[begin] | data[begin + 1] << 8
            if channel in known:
                break
            heads.append((channel, begin - place, end - place))
            known.add(channel)
        step = heads[-1][2]
        rows = flat[place : place + (len(data) - place) // step * step].reshape(-1, step)
        same = np.ones(len(rows), bool)
        for _, begin, _ in heads:
            at = slice(begin - RECORD.size, begin + 2)  # opcode, length, channel
            same &= (rows[:, at] == rows[0, at]).all(axis=1)
        count = len(rows) if same.all() else int(np.argmin(same))
        for channel, begin, end in heads:
            if channel in channels:
                stamp = rows[:count, begin + MESSAGE.size - 8 : begin + MESSAGE.size]
                times = np.ascontiguousarray(stamp).view("<u8").ravel().astype(np.int64)
                yield Table(channel, times, rows[:count, begin + MESSAGE.size : end])
        place += count * step
