"""The MCAP file of a run as the recorder sees it: channels, messages, a flush twice a wall second, an end.

The first record is the metadata `run`, then the attachments; both are in the file before anybody sees it.  `format`
among these facts is the number of the rules by which topics, schemas and facts are to be read.  A kill loses what was
not flushed, at most a second: a thread of its own sees to that, whatever the run is busy with.
"""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from threading import Event, RLock, Thread

import msgspec
import zstandard
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError
from heavylift.kernel.version import __version__
from heavylift.recordings.format.mcapfile import McapFile
from heavylift.recordings.format.schema import file_descriptor_set
from mcap.well_known import MessageEncoding, SchemaEncoding

from .partfile import PartFile

OLDEST, FORMAT = 2, 2  # that are read; the last is written. tests/data has a recording of each, and of those before
FLUSH = 0.5  # [s] of wall time: less than a second is lost, even if messages come half a second apart
CHECKPOINT = "checkpoint/"  # before the tag in the names of such attachments
CHECK_s = 0.2  # [s] between two looks of the thread
MEDIA = {".yaml": "application/yaml", ".json": "application/json"}


def library() -> str:
    """The name of the writer in the file's header: `heavylift X mcap-python/Y`."""
    return f"heavylift {__version__} mcap-python/{version('mcap')}"


def texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Metadata values: text unchanged, everything else as JSON."""
    return {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode() for name, value in facts.items()
    }


class Sink:
    """Writes facts and attachments as `<path>.part`; `finish` renames it.

    Messages are written to `mcap`, within `writing`.
    """

    def __init__(
        self,
        path: str | Path,
        run: Mapping[str, object],
        attachments: Mapping[str, bytes],
        force: bool = False,
        made: str = "",
    ) -> None:
        """`made`: of a copy, the library of the original."""
        self._file = PartFile(path, force=force)
        self.topics: dict[str, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._lock, self._over = RLock(), Event()
        self._refused: RecordingError | None = None  # what the thread has met
        self._flushed = time.monotonic()
        try:
            with self.writing():
                self.mcap = McapFile(self._file.stream, made or library())
                self.mcap.metadata("run", texts({"format": FORMAT, **run}))
                for name, data in attachments.items():
                    media = MEDIA.get(Path(name).suffix, "application/octet-stream")
                    self.mcap.attachment(time.time_ns(), name, media, data)
            self._file.show()
        except BaseException:
            self._file.abandon(keep=False)
            raise
        self._thread = Thread(target=self._watch, name="heavylift-recording", daemon=True)
        self._thread.start()

    @property
    def path(self) -> Path:
        """Path of the recording, which `finish` may change if a file has appeared there."""
        return self._file.path

    def protobuf(
        self, topic: str, message: type[Message] | Descriptor, facts: Mapping[str, object] | None = None
    ) -> int:
        """A new channel of this protobuf message class (or its descriptor)."""
        descriptor = getattr(message, "DESCRIPTOR", message)
        schema, name = file_descriptor_set(descriptor), descriptor.full_name
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
        with self.writing():
            number = self._schemas.get((name, schema))
            if number is None:
                number = self._schemas[name, schema] = self.mcap.schema(name, language, schema)
            self.topics[topic] = self.mcap.channel(topic, encoding, number, texts(facts))
        return self.topics[topic]

    def checkpoint(self, at: tuple[int, int], state: bytes) -> None:
        """Attach a compressed state under its tag."""
        with self.writing():
            media = "application/zstd"
            packed = zstandard.ZstdCompressor(write_checksum=True).compress(state)
            self.mcap.attachment(time.time_ns(), "{}{}.{}".format(CHECKPOINT, *at), media, packed)

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Keeps the thread off the file and turns the system's refusals into a RecordingError."""
        with self._lock, self._file.writing():
            if self._refused is not None:
                raise self._refused
            yield

    def flush(self) -> None:
        """Write to disk and check the file, at most twice per second."""
        if time.monotonic() - self._flushed > FLUSH:
            with self.writing():
                self.mcap.flush()
                self._file.check()
            self._flushed = time.monotonic()

    def _watch(self) -> None:
        while not self._over.wait(CHECK_s):
            try:
                self.flush()
            except RecordingError as error:
                self._refused = error  # for who writes next
                return

    def _rest(self) -> None:
        """End the thread."""
        self._over.set()
        self._thread.join()

    def finish(self, result: Mapping[str, object]) -> Path:
        """Write the metadata `result` and the summary, give the file its name."""
        self._rest()
        with self.writing():
            self.mcap.metadata("result", texts(result))
            self.mcap.finish()
        return self._file.finish()

    def abandon(self, keep: bool = True) -> None:
        """Close a file that cannot be finished, and `keep` what there is of it; without effect on a finished one."""
        self._rest()
        self._file.abandon(keep)
