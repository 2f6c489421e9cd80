"""Rows of numbers: which columns of a kernel sample belong to which topic, and how they look in the file.

A sample is one float64 row; the layout is announced once and cuts the row into channels.  Batches travel as
msgpack `[first number, [t_ns, ...], rows]`, rows being little-endian float64 in C order.  Channels
`pose/<body>` (x y z, then quaternion x y z w of the body frame in the world) are drawn as
foxglove.FrameTransforms; every other channel becomes one `heavylift.Samples` message per row, made straight
from the row's bytes (protobuf encoding: tag 0x0a, length, doubles).
"""

from __future__ import annotations

import msgspec
import numpy as np
from heavylift.kernel.errors import RecordingError
from numpy.typing import NDArray

POSE = "pose/"
POSE_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")

_decode_batch = msgspec.msgpack.Decoder(tuple[int, list[int], bytes]).decode


class SampleChannel(msgspec.Struct, frozen=True):
    """Columns start to stop of a row: topic such as "rope/tension", one name per column, one unit for all."""

    topic: str
    names: list[str]
    unit: str
    start: int
    stop: int


class SampleLayout(msgspec.Struct, frozen=True):
    """All channels of a row."""

    channels: list[SampleChannel]

    @property
    def width(self) -> int:
        """Number of columns of a row."""
        return max((channel.stop for channel in self.channels), default=0)

    def find(self, topic: str) -> SampleChannel | None:
        """The channel of this topic, if the row has one."""
        return next((channel for channel in self.channels if channel.topic == topic), None)

    def check(self) -> SampleLayout:
        """This layout, or a RecordingError if topics repeat or names and columns do not fit."""
        topics: set[str] = set()
        for channel in self.channels:
            columns = channel.stop - channel.start
            if channel.start < 0 or columns != len(channel.names):
                raise RecordingError(
                    f"sample channel {channel.topic}: {len(channel.names)} names for the columns "
                    f"{channel.start} to {channel.stop}; give one name per column"
                )
            if channel.topic.startswith(POSE) and columns != len(POSE_COLUMNS):
                raise RecordingError(
                    f"sample channel {channel.topic}: a pose has 7 columns (x y z qx qy qz qw), not {columns}"
                )
            if channel.topic in topics:
                raise RecordingError(f"sample channel {channel.topic}: announced twice; name each topic once")
            topics.add(channel.topic)
        return self


class Batch(msgspec.Struct, frozen=True):
    """Consecutive samples: number of the first, simulation times [ns], rows (n, width)."""

    first: int
    times: list[int]
    rows: NDArray[np.float64]


def decode_batch(payload: bytes, width: int) -> Batch:
    """A batch from its wire form; RecordingError if it does not hold whole rows of `width` columns."""
    try:
        first, times, data = _decode_batch(payload)
    except msgspec.DecodeError as error:
        raise RecordingError(f"a batch of samples is not [number, times, rows]: {error}") from None
    if len(data) != 8 * width * len(times):
        raise RecordingError(
            f"samples from number {first}: {len(times)} rows of {width} values are {8 * width * len(times)} "
            f"bytes, but {len(data)} came; the sender's layout differs from the announced one"
        )
    return Batch(first, times, np.frombuffer(data, "<f8").reshape(len(times), width))


def varint(number: int) -> bytes:
    """Protobuf's base-128 encoding of a number >= 0."""
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)
    return bytes(out)


def samples_head(count: int) -> bytes:
    """What stands before the doubles of a `heavylift.Samples` message of `count` values."""
    return b"\x0a" + varint(8 * count) if count else b""
