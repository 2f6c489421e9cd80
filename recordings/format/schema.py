"""The schemas of a recording: protobuf descriptors for numbers, JSON Schema for events and protocol traffic.

`heavylift.Samples` is one row of numbers, a field per signal; columns and units stand in the channel's metadata.  It
is built here from a descriptor, so no protoc is needed, and each protobuf schema of a file carries its whole
FileDescriptorSet (MCAP well-known encoding "protobuf"), so any stock reader decodes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate, islice, pairwise
from typing import Any

import msgspec
from google.protobuf import descriptor_pb2, descriptor_pool  # type: ignore[import-untyped]
from google.protobuf.descriptor import Descriptor, FileDescriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from google.protobuf.message_factory import GetMessageClass  # type: ignore[import-untyped]
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]

from .samples import Field
from .template import Template

INTEGER = {"type": "integer"}
STRING = {"type": "string"}


def samples_descriptor(fields: Sequence[str], name: str = "Samples") -> Descriptor:
    """The descriptor of `heavylift.Samples` with these fields: `repeated double <field> = <number> [packed]`."""
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
    """The form of all `heavylift.Samples` messages of a run; numbers are the columns of its fields, side by side."""
    message = GetMessageClass(samples_descriptor([field.field for field in fields]))

    def build(_: Timestamp, numbers: list[float]) -> Message:
        rest = iter(numbers)
        return message(**{field.field: [*islice(rest, len(field.columns))] for field in fields})

    return Template(build, sum(len(field.columns) for field in fields), 0)


def field_places(fields: Sequence[Field]) -> dict[str, slice]:
    """Where the columns of each signal stand among the numbers of such a message."""
    ends = [*accumulate((len(field.columns) for field in fields), initial=0)]
    return {field.signal: slice(*place) for field, place in zip(fields, pairwise(ends), strict=True)}


def file_descriptor_set(descriptor: Descriptor) -> bytes:
    """The serialised FileDescriptorSet of a protobuf message descriptor, dependencies first."""
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
    """An event on a port of a coupled model, or of a System what happened to whom; `value`: its message as plain
    data."""

    t_ns: int
    microstep: int
    source: str
    port: str
    index: int
    type: str
    value: Any

    @property
    def t(self) -> float:
        """When [s]."""
        return self.t_ns / 1e9


def event_schema(value: Mapping[str, object]) -> bytes:
    """JSON Schema of an event record whose `value` follows the one given; its $defs move to the root."""
    inner = {name: part for name, part in value.items() if name != "$defs"}
    schema = _record(
        t_ns=INTEGER, microstep=INTEGER, source=STRING, port=STRING, index=INTEGER, type=STRING, value=inner
    )
    if "$defs" in value:
        schema["$defs"] = value["$defs"]
    return msgspec.json.encode(schema)


def _record(**properties: object) -> dict[str, object]:
    """An object that has all of these properties."""
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
