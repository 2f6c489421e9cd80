"""The MCAP file of a run as the recorder sees it: channels, messages, a flush twice a wall second, an end.

The first record is the metadata `run`, then the attachments; both are in the file before anybody sees it. `format`
among these facts is the number of the rules by which topics, schemas and facts are to be read. A kill loses at most the
last second of data, since a separate thread flushes the file whatever the run is doing.

Sample rows on their way into the file: a message of numbers and one of all poses per row, ropes where they moved.
"""

import time
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from threading import Event, RLock, Thread
from typing import NamedTuple, Protocol

import msgspec
import numpy as np
import zstandard
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError
from heavylift.kernel.version import __version__
from heavylift.recordings.format import viewer_messages as viewers
from heavylift.recordings.format.mcapfile import McapFile
from heavylift.recordings.format.samples import POSE_UNIT, REEVING, Columns, SampleLayout, reeved
from heavylift.recordings.format.schema import file_descriptor_set, samples_descriptor, samples_template
from mcap.well_known import MessageEncoding, SchemaEncoding
from numpy.typing import NDArray

from .partfile import PartFile

OLDEST, FORMAT = 2, 2  # that are read; the last is written. tests/data has a recording of each, and of those before
FLUSH = 0.5  # [s] of wall time: less than a second is lost, even if messages come half a second apart
CHECKPOINT = "checkpoint/"  # before the tag in the names of such attachments
CHECK_s = 0.2  # [s] between two looks of the thread
MEDIA = {".yaml": "application/yaml", ".json": "application/json"}


def library() -> str:
    """Return the name of the writing library for the header of the file: `heavylift X mcap-python/Y`."""
    return f"heavylift {__version__} mcap-python/{version('mcap')}"


def texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Return facts as texts for a metadata record: texts unchanged, all other values as JSON."""
    return {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode() for name, value in facts.items()
    }


class RecordingSink:
    """Writes the facts and attachments of a recording to `<path>.part`; `finish` gives the file its final name.

    Messages are written to `mcap`, within the context `writing`.
    """

    def __init__(
        self,
        path: str | Path,
        run: Mapping[str, object],
        attachments: Mapping[str, bytes],
        force: bool = False,
        made: str = "",
    ) -> None:
        """`made`: for a copy, the library that wrote the original."""
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
        """Path of the recording; `finish` changes the path if another file has appeared there."""
        return self._file.path

    def protobuf(
        self, topic: str, message: type[Message] | Descriptor, facts: Mapping[str, object] | None = None
    ) -> int:
        """Add a channel for this protobuf message class (or its descriptor), and return the channel's number."""
        descriptor = getattr(message, "DESCRIPTOR", message)
        schema, name = file_descriptor_set(descriptor), descriptor.full_name
        return self.channel(topic, MessageEncoding.Protobuf, name, SchemaEncoding.Protobuf, schema, facts or {})

    def json(self, topic: str, name: str, schema: bytes, facts: Mapping[str, object]) -> int:
        """Add a channel of JSON objects with this JSON Schema, and return the channel's number."""
        return self.channel(topic, MessageEncoding.JSON, name, SchemaEncoding.JSONSchema, schema, facts)

    def channel(
        self, topic: str, encoding: str, name: str, language: str, schema: bytes, facts: Mapping[str, object]
    ) -> int:
        """Add a channel with this message encoding and schema (name, language, text); return the channel's number."""
        if topic in self.topics:
            raise RecordingError(f"topic {topic}: announced twice; models, ports and samples must have different names")
        with self.writing():
            number = self._schemas.get((name, schema))
            if number is None:
                number = self._schemas[name, schema] = self.mcap.schema(name, language, schema)
            self.topics[topic] = self.mcap.channel(topic, encoding, number, texts(facts))
        return self.topics[topic]

    def checkpoint(self, at: tuple[int, int], state: bytes) -> None:
        """Attach a compressed checkpoint, named after its logical time."""
        with self.writing():
            media = "application/zstd"
            packed = zstandard.ZstdCompressor(write_checksum=True).compress(state)
            self.mcap.attachment(time.time_ns(), "{}{}.{}".format(CHECKPOINT, *at), media, packed)

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Return a context that locks out the flushing thread and converts errors of the operating system into a
        RecordingError."""
        with self._lock, self._file.writing():
            if self._refused is not None:
                raise self._refused
            yield

    def flush(self) -> None:
        """Write pending data to disk and check the file, at most twice per second."""
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
        """Stop the flushing thread."""
        self._over.set()
        self._thread.join()

    def finish(self, result: Mapping[str, object]) -> Path:
        """Write the metadata `result` and the summary, and give the file its final name; return its path."""
        self._rest()
        with self.writing():
            self.mcap.metadata("result", texts(result))
            self.mcap.finish()
        return self._file.finish()

    def abandon(self, keep: bool = True) -> None:
        """Close an incomplete file and, unless `keep`, delete it; has no effect on a finished file."""
        self._rest()
        self._file.abandon(keep)


class Peak(NamedTuple):
    """Largest tension of a rope [N] and its time [s]."""

    tension: float
    time: float


class RowBlock(NamedTuple):
    """Encoded sample rows: simulation and log times [ns], numbers and poses, messages (n, bytes)."""

    times: list[int]
    log_ns: list[int]
    columns: NDArray[np.float64]
    samples: NDArray[np.uint8]
    frames: NDArray[np.uint8]


class Messages(Protocol):
    """Interface of a receiver of messages on numbered channels, usually a recording."""

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None: ...


class Channels(Protocol):
    """Interface of a recording to which channels can be added; `mcap` receives their messages."""

    @property
    def mcap(self) -> Messages: ...
    def protobuf(
        self, topic: str, message: type[Message] | Descriptor, facts: Mapping[str, object] | None = None
    ) -> int: ...


class RowWriter:
    """Writer of sample rows with one layout, which also records the peak tension of each rope."""

    def __init__(self, sink: Channels, layout: SampleLayout, lines_every: float, lift: str = "") -> None:
        """Create the channels of all rows, or of the rows of a single lift in topics with its name."""
        own = f"/{lift}" if lift else ""
        self.layout = layout.check()
        self.peaks: dict[str, Peak] = {}
        self._sink = sink
        self._columns = Columns(layout)
        self.bodies = self._columns.bodies
        self._ropes: viewers.Ropes | None = None
        self._lines_ns, self._lines_due = round(lines_every * 1e9), 0
        fields = self._columns.fields
        descriptor = samples_descriptor([field.field for field in fields])
        self._numbers = sink.protobuf(f"/samples{own}", descriptor, {"signals": fields})
        self._form = samples_template(fields)
        if self.bodies:
            facts = {"names": self.bodies, "unit": POSE_UNIT}
            self._poses = sink.protobuf(f"/poses{own}", viewers.FrameTransforms, facts)
            self._frames = viewers.frames_template(self.bodies)
            self._lines = 0 if lift else sink.protobuf("/ropes", viewers.SceneUpdate)

    def ropes(self, lines: Sequence[viewers.RopeLine]) -> viewers.Ropes:
        """Return rope lines prepared for `hang`; raises RecordingError for a line on a body without sampled poses."""
        for line in lines:
            for body in (line.a_body, line.b_body):
                if body != viewers.WORLD and body not in self.bodies:
                    raise RecordingError(f"rope line on {body}: the samples have no pose of this body; check the name")
        return viewers.Ropes(lines, self.bodies)

    def hang(self, ropes: viewers.Ropes) -> None:
        """Draw these rope lines together with all sample rows that are written from now on."""
        self._ropes, self._lines_due = ropes, 0

    def encode(self, times: list[int], log_ns: list[int], rows: NDArray[np.float64]) -> RowBlock:
        """Encode sample rows (n, width) with their simulation and log times [ns]; `write` accepts the result."""
        columns = self._columns(rows)
        numbers, poses = np.split(columns, [self._columns.numbers], axis=1)
        samples = self._form.encode(times, numbers)
        frames = self._frames.encode(times, poses) if self.bodies else samples[:, :0]
        return RowBlock(times, log_ns, columns, samples, frames)

    def write(self, block: RowBlock, first: int, end: int) -> None:
        """Write the messages of these rows of a block, one row after the other."""
        drawn, write = self._drawn(block, first, end), self._sink.mcap.write
        for i in range(first, end):
            log_ns, t_ns = block.log_ns[i], block.times[i]
            write(self._numbers, log_ns, t_ns, block.samples[i].tobytes())
            if self.bodies:
                write(self._poses, log_ns, t_ns, block.frames[i].tobytes())
            if i in drawn:
                write(self._lines, log_ns, t_ns, drawn[i])

    def _drawn(self, block: RowBlock, first: int, end: int) -> dict[int, bytes]:
        """Return the messages of ropes by number of the row at which they are redrawn."""
        if self._ropes is None:
            return {}
        times, poses = block.times, block.columns[:, self._columns.numbers :].reshape(len(block.times), -1, 7)
        drawn, i = [], first
        while (i := bisect_left(times, self._lines_due, i, end)) < end:
            if self._ropes.moved(poses[i]):
                drawn.append(i)
                self._lines_due = times[i] + self._lines_ns
            i += 1
        if not drawn:
            return {}
        messages = self._ropes.messages([times[i] for i in drawn], poses[drawn])
        return {i: message.tobytes() for i, message in zip(drawn, messages, strict=True)}


def note_peaks(peaks: dict[str, Peak], layout: SampleLayout, times: Sequence[int], rows: NDArray[np.float64]) -> None:
    """Update the peak tension of each rope from new sample rows.

    From the peaks of all accepted steps if the rows contain them, else from the samples; for ropes over sheaves, from
    samples of the most loaded part.
    """
    found = [x for x in (layout.find("rope/peak") or layout.find("rope/tension"), layout.find(REEVING)) if x]
    when = layout.find("rope/peak_time")
    for tension in found:
        over = tension.topic == REEVING
        values = rows[:, tension.start : tension.stop]
        for i, k in enumerate(values.argmax(axis=0).tolist()):
            name = reeved(tension.names[i]) if over else tension.names[i]
            if name not in peaks or values[k, i] > peaks[name].tension:
                at = rows[k, when.start + i] if when and not over else times[k] / 1e9
                peaks[name] = Peak(float(values[k, i]), float(at))
