"""Recordings written again by the mcap library, with something altered: every checksum holds, no byte is damaged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.writer import Writer


class Said(NamedTuple):
    """A message."""

    topic: str
    log_time: int
    publish_time: int
    data: bytes


@dataclass
class Parts:
    """All that stands in a recording."""

    library: str
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, bytes]
    channels: dict[str, tuple[Schema, Channel]]
    messages: list[Said]

    def rows(self) -> list[int]:
        """Where the numbers of a row stand among the messages; its poses stand behind it."""
        return [i for i, x in enumerate(self.messages) if x.topic == "/samples"]


def parts_of(path: Path) -> Parts:
    """What a file holds, as the mcap library reads it."""
    with path.open("rb") as stream:
        reader = make_reader(stream)
        found = list(reader.iter_messages(log_time_order=False))
        summary = reader.get_summary()
        assert summary is not None
        return Parts(
            reader.get_header().library,
            {x.name: dict(x.metadata) for x in reader.iter_metadata()},
            {x.name: x.data for x in reader.iter_attachments()},
            {c.topic: (summary.schemas[c.schema_id], c) for c in summary.channels.values()},
            [Said(c.topic, x.log_time, x.publish_time, x.data) for _, c, x in found],
        )


def altered(path: Path, out: Path, alter: Callable[[Parts], Any]) -> Path:
    """The recording `path` as `out`, once something is altered."""
    parts = parts_of(path)
    alter(parts)
    with out.open("wb") as stream:
        writer = Writer(stream, enable_data_crcs=True)
        writer.start(library=parts.library)
        writer.add_metadata("run", parts.metadata["run"])
        for name, data in parts.attachments.items():
            writer.add_attachment(0, 0, name, "application/octet-stream", data)
        numbers = {}
        for topic, (schema, channel) in parts.channels.items():
            form = writer.register_schema(schema.name, schema.encoding, schema.data)
            numbers[topic] = writer.register_channel(topic, channel.message_encoding, form, channel.metadata)
        for text in parts.messages:
            writer.add_message(numbers[text.topic], text.log_time, text.data, text.publish_time)
        if "result" in parts.metadata:
            writer.add_metadata("result", parts.metadata["result"])
        writer.finish()
    return out
