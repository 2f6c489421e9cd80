"""The schemas of a recording: protobuf descriptors for numbers, JSON Schema for events and messages of the protocol.

`heavylift.Samples` is one row of numbers, with a field per signal; columns and units are in the channel's metadata. It
is built here from a descriptor, so no protoc is needed, and each protobuf schema of a file has its whole
FileDescriptorSet (MCAP well-known encoding "protobuf"), so any stock reader decodes it.

Also templates of protobuf messages in which only numbers and time stamps change, encoded and decoded in batches.

The protobuf library encodes the message once with marker numbers at a marker time, the places of the markers are found,
and each further message is a copy with other numbers and another stamp. Two differences to the library, which decode to
the same message: a number that is exactly 0 is written instead of omitted, and the varints of a stamp always have five
bytes, so that all messages have one length.
"""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate, islice, pairwise
from typing import Any

import msgspec
import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool  # type: ignore[import-untyped]
from google.protobuf.descriptor import Descriptor, FileDescriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from google.protobuf.message_factory import GetMessageClass  # type: ignore[import-untyped]
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]
from numpy.typing import NDArray

from .samples import Field

MARKER = 3 * (1 << 28) * 1_000_000_000 + (1 << 28)  # a time [ns] whose varints have five bytes
WRONG = "a message is not of the form of its channel"


def stamp(t_ns: int) -> Timestamp:
    """Return a simulation time [ns] as a protobuf Timestamp."""
    return Timestamp(seconds=t_ns // 1_000_000_000, nanos=t_ns % 1_000_000_000)


def stamp_bytes(times: Sequence[int]) -> NDArray[np.uint8]:
    """Return times [ns] as protobuf Timestamps of 12 bytes (n, 12): tag and seconds (6), tag and nanoseconds (6)."""
    parts = np.stack(np.divmod(np.array(times, np.uint64), np.uint64(1_000_000_000)), axis=1)[:, :, None]
    out = np.empty((len(times), 2, 6), np.uint8)
    out[:, :, 0] = 0x08, 0x10
    out[:, :, 1:] = parts >> np.arange(0, 35, 7, dtype=np.uint64) & np.uint64(0x7F)
    out[:, :, 1:5] |= 0x80
    return out.reshape(-1, 12)


class Template:
    """Template of protobuf messages that differ only in numbers and time, for fast encoding.

    `build(timestamp, numbers)`: function that makes one message with the protobuf library; `stamps`: number of places
    in the message that hold the time.
    """

    def __init__(self, build: Callable[[Timestamp, list[float]], Message], numbers: int, stamps: int) -> None:
        markers = b"".join(struct.pack("<HIH", 0xA7F5, i, 0x7E5A) for i in range(numbers))  # finite doubles
        values = np.frombuffer(markers, "<f8").tolist()
        image = build(stamp(MARKER), values).SerializeToString()
        time = stamp_bytes([MARKER]).tobytes()
        stamped = [found.start() for found in re.finditer(re.escape(time), image)]
        assert len(stamped) == stamps, "a name looks like a time stamp"
        places = {found[1]: found.start() for found in re.finditer(b"\xf5\xa7(.{4})\x5a\x7e", image, re.DOTALL)}
        starts = [places[struct.pack("<I", i)] for i in range(numbers)]
        self._image, self._starts = np.frombuffer(image, np.uint8), np.array(starts, np.intp)
        self._runs: list[slice] = []  # bytes of numbers that stand side by side
        for at in starts:
            begin = self._runs.pop().start if self._runs and self._runs[-1].stop == at else at
            self._runs.append(slice(begin, at + 8))
        self._stamps = (np.array(stamped, np.intp)[:, None] + np.arange(12)).ravel()
        self._fixed = np.ones(len(image), bool)
        for place in (*self._runs, *(slice(at, at + 12) for at in stamped)):
            self._fixed[place] = False

    def encode(self, times: Sequence[int], numbers: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return messages of this template (n, bytes), with these simulation times [ns] and numbers (n, numbers)."""
        out = np.tile(self._image, (len(times), 1))
        data, at = np.ascontiguousarray(numbers, "<f8").view(np.uint8).reshape(len(times), -1), 0
        for run in self._runs:
            out[:, run] = data[:, at : (at := at + run.stop - run.start)]
        out[:, self._stamps] = np.tile(stamp_bytes(times), (1, len(self._stamps) // 12))
        return out

    def decode(self, data: NDArray[np.uint8], *wanted: slice) -> list[NDArray[np.float64]]:
        """Return the numbers (n, numbers) in messages of this template (n, bytes); raises ValueError for others."""
        if data.shape[1] != len(self._image) or ((data != self._image) & self._fixed).any():
            raise ValueError(WRONG)
        starts = (self._starts[x] for x in wanted)
        return [np.take(data, (at[:, None] + np.arange(8)).ravel(), axis=1).view("<f8") for at in starts]


INTEGER = {"type": "integer"}
STRING = {"type": "string"}


def samples_descriptor(fields: Sequence[str], name: str = "Samples") -> Descriptor:
    """Return the descriptor of `heavylift.Samples` with these fields: `repeated double <field> = <number> [packed]`."""
    file = descriptor_pb2.FileDescriptorProto(name=f"heavylift/{name}.proto", package="heavylift", syntax="proto3")
    message = file.message_type.add(name=name)
    for i, field_name in enumerate(fields):
        field = message.field.add(
            name=field_name,
            number=i + 1,
            label=descriptor_pb2.FieldDescriptorProto.LABEL_REPEATED,
            type=descriptor_pb2.FieldDescriptorProto.TYPE_DOUBLE,
        )
        field.options.packed = True
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return pool.FindMessageTypeByName(f"heavylift.{name}")


def samples_template(fields: Sequence[Field]) -> Template:
    """Return the template of a run's `heavylift.Samples` messages, whose numbers are the columns of these fields."""
    message = GetMessageClass(samples_descriptor([field.field for field in fields]))

    def build(_: Timestamp, numbers: list[float]) -> Message:
        rest = iter(numbers)
        return message(**{field.field: [*islice(rest, len(field.columns))] for field in fields})

    return Template(build, sum(len(field.columns) for field in fields), 0)


def field_places(fields: Sequence[Field]) -> dict[str, slice]:
    """Return the position of each signal among the numbers of a `heavylift.Samples` message."""
    ends = [*accumulate((len(field.columns) for field in fields), initial=0)]
    return {field.signal: slice(*place) for field, place in zip(fields, pairwise(ends), strict=True)}


def file_descriptor_set(descriptor: Descriptor) -> bytes:
    """Return the serialised FileDescriptorSet of a protobuf message descriptor, with its dependencies first."""
    files: dict[str, FileDescriptor] = {}

    def visit(file: FileDescriptor) -> None:
        if file.name not in files:
            for dependency in file.dependencies:
                visit(dependency)
            files[file.name] = file

    visit(descriptor.file)
    out = descriptor_pb2.FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(out.file.add())
    return bytes(out.SerializeToString(deterministic=True))


class RecordedEvent(msgspec.Struct, frozen=True):
    """An event on a port of a coupled model, or a state change in a simulated System; `value`: the message of the event
    as plain data."""

    t_ns: int
    microstep: int
    source: str
    port: str
    index: int
    type: str
    value: Any

    @property
    def t(self) -> float:
        """Simulation time of the event [s]."""
        return self.t_ns / 1e9


def event_schema(value: Mapping[str, object]) -> bytes:
    """Return the JSON Schema of an event record; `value`: schema of its value, whose $defs move to the root."""
    inner = {name: part for name, part in value.items() if name != "$defs"}
    schema = _record(
        t_ns=INTEGER, microstep=INTEGER, source=STRING, port=STRING, index=INTEGER, type=STRING, value=inner
    )
    if "$defs" in value:
        schema["$defs"] = value["$defs"]
    return msgspec.json.encode(schema)


def _record(**properties: object) -> dict[str, object]:
    """Return the JSON Schema of an object with all of these properties, each required."""
    return {"type": "object", "properties": properties, "required": list(properties)}


PROTOCOL_SCHEMA = msgspec.json.encode(
    _record(
        kind=STRING,
        node=STRING,
        direction={"type": "string", "enum": ["to node", "from node"]},
        t_ns=INTEGER,
        summary={"type": "object"},
        raw={"type": "string", "contentEncoding": "base64"},
    )
)
RIG_SCHEMA = msgspec.json.encode(_record(t_ns=INTEGER, lines={"type": "array", "items": {"type": "object"}}))
