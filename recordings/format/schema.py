"""The schemas of a recording: protobuf descriptors for numbers, JSON Schema for events and protocol traffic.

`heavylift.Samples` is one row of numbers, a field per signal; columns and units stand in the channel's metadata.  It
is built here from a descriptor, so no protoc is needed, and each protobuf schema of a file carries its whole
FileDescriptorSet (MCAP well-known encoding "protobuf"), so any stock reader decodes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
from google.protobuf import descriptor_pb2, descriptor_pool  # type: ignore[import-untyped]

JSON_INTEGER = {"type": "integer"}
JSON_STRING = {"type": "string"}


def samples_descriptor(fields: Sequence[str], name: str = "Samples") -> Any:
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


def file_descriptor_set(descriptor: Any) -> bytes:
    """The serialised FileDescriptorSet of a protobuf message descriptor, dependencies first."""
    files: dict[str, Any] = {}

    def visit(file: Any) -> None:
        if file.name not in files:
            for dependency in file.dependencies:
                visit(dependency)
            files[file.name] = file

    visit(descriptor.file)
    out = descriptor_pb2.FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(out.file.add())
    return bytes(out.SerializeToString(deterministic=True))


def event_schema(value: Mapping[str, Any]) -> bytes:
    """JSON Schema of an event record whose `value` follows the one given; its $defs move to the root."""
    inner = {name: part for name, part in value.items() if name != "$defs"}
    properties = {
        "t_ns": JSON_INTEGER,
        "microstep": JSON_INTEGER,
        "source": JSON_STRING,
        "port": JSON_STRING,
        "index": JSON_INTEGER,
        "type": JSON_STRING,
        "value": inner,
    }
    schema = {"type": "object", "properties": properties, "required": list(properties)}
    if "$defs" in value:
        schema["$defs"] = value["$defs"]
    return msgspec.json.encode(schema)


PROTOCOL_SCHEMA = msgspec.json.encode(
    {
        "type": "object",
        "properties": {
            "kind": JSON_STRING,
            "node": JSON_STRING,
            "direction": {"type": "string", "enum": ["to node", "from node"]},
            "t_ns": JSON_INTEGER,
            "summary": {"type": "object"},
            "raw": {"type": "string", "contentEncoding": "base64"},
        },
        "required": ["kind", "node", "direction", "t_ns", "summary", "raw"],
    }
)

RIG_SCHEMA = msgspec.json.encode(
    {
        "type": "object",
        "properties": {"t_ns": JSON_INTEGER, "lines": {"type": "array", "items": {"type": "object"}}},
        "required": ["t_ns", "lines"],
    }
)
