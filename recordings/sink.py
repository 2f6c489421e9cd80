"""The MCAP file of a run as the recorder sees it: channels, messages, a flush per wall second, an end.

The first record is the metadata `run`, on disk at once, then the attachments.  Chunks of 256 KiB, zstd,
checksums of chunks, attachments, summary and of the whole data section.  A kill loses what was not flushed,
at most a second.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mcap.writer
import msgspec
from heavylift.kernel.errors import RecordingError
from mcap.well_known import MessageEncoding, SchemaEncoding

from .partfile import PartFile
from .schema import file_descriptor_set

__all__ = ["Sink", "texts"]

CHUNK = 256 * 1024  # [bytes]
FLUSH = 1.0  # [s] of wall time
MEDIA = {".yaml": "application/yaml", ".json": "application/json"}


def library() -> str:
    """The name of the writer in the file's header: `heavylift X mcap-python/Y`."""
    return f"heavylift {version('heavylift')} {mcap.writer.LIBRARY_IDENTIFIER}"


def texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Metadata values: text as it is, everything else as JSON."""
    return {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode() for name, value in facts.items()
    }


class Sink:
    """Opens `<path>.part` and writes the facts and attachments; `finish` gives it its name."""

    def __init__(self, path: str | Path, run: Mapping[str, object], attachments: Mapping[str, bytes]) -> None:
        self._file = PartFile(path)
        self.path = self._file.path
        self.topics: dict[str, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._sequence = [0]  # by channel
        self._flushed = time.monotonic()
        with self._file.writing():
            self._writer = mcap.writer.Writer(self._file.stream, chunk_size=CHUNK, enable_data_crcs=True)
            self._writer.start(library=library())
            self._writer.add_metadata("run", texts(run))
            self._file.stream.flush()
            for name, data in attachments.items():
                media = MEDIA.get(Path(name).suffix, "application/octet-stream")
                self._writer.add_attachment(time.time_ns(), 0, name, media, data)
            self._file.stream.flush()

    def protobuf(self, topic: str, message: Any, facts: Mapping[str, object] | None = None) -> int:
        """A new channel of this protobuf message class."""
        schema = file_descriptor_set(message)
        name = message.DESCRIPTOR.full_name
        return self.channel(topic, MessageEncoding.Protobuf, name, SchemaEncoding.Protobuf, schema, facts or {})

    def json(self, topic: str, name: str, schema: bytes, facts: Mapping[str, object]) -> int:
        """A new channel of JSON objects with this JSON Schema."""
        return self.channel(topic, MessageEncoding.JSON, name, SchemaEncoding.JSONSchema, schema, facts)

    def channel(
        self, topic: str, encoding: str, name: str, language: str, schema: bytes, facts: Mapping[str, object]
    ) -> int:
        """A new channel with this message encoding, schema name, schema language and schema."""
        if topic in self.topics:
            raise RecordingError(f"topic {topic}: announced twice; name models, ports and samples apart")
        with self._file.writing():
            number = self._schemas.get((name, schema))
            if number is None:
                number = self._schemas[name, schema] = self._writer.register_schema(name, language, schema)
            self.topics[topic] = self._writer.register_channel(topic, encoding, number, texts(facts))
        self._sequence.append(0)
        return self.topics[topic]

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Append a message; to be called within `writing`."""
        self._writer.add_message(channel, log_ns, data, publish_ns, self._sequence[channel])
        self._sequence[channel] += 1

    def writing(self) -> Any:
        """Context that turns the system's refusals into a RecordingError."""
        return self._file.writing()

    def flush(self) -> None:
        """Put what was written on disk, at most once per second of wall time."""
        if time.monotonic() - self._flushed > FLUSH:
            with self._file.writing():
                self._writer.flush()  # type: ignore[no-untyped-call]
            self._flushed = time.monotonic()

    def finish(self, result: Mapping[str, object]) -> Path:
        """Write the metadata `result` and the summary, give the file its name."""
        with self._file.writing():
            self._writer.flush()  # type: ignore[no-untyped-call]  # the last chunk stands before the metadata
            self._writer.add_metadata("result", texts(result))
            self._writer.finish()  # type: ignore[no-untyped-call]
        return self._file.finish()

    def abandon(self) -> None:
        """Close a file that cannot be finished; without effect on a finished one."""
        self._file.abandon()
