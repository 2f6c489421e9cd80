"""The recorder: one MCAP file per run, written while it runs, complete once it has its final name.

First come the metadata `run` and the attachments; then messages in the order of simulation time; last the metadata
`result`, whose absence means "cut off". log_time is the recorder's own simulation time [ns] and never decreases;
publish_time is the sender's. Events arrive in total order and samples in theirs, but not together: both wait until
nothing earlier can arrive, that is below `settle(t)` or below both the last event and the last sample.
"""

import heapq
import math
import time
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import NamedTuple

import msgspec
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.digest import Digest
from heavylift.recordings.format.samples import SAMPLER, Batch, SampleLayout, SamplerNote, decode_batch
from heavylift.recordings.format.schema import PROTOCOL_SCHEMA, RIG_SCHEMA, RecordedEvent, event_schema
from heavylift.recordings.format.viewer_messages import (
    DrawnBox,
    Log,
    Rig,
    RopeLine,
    SceneUpdate,
    boxes_message,
    log_message,
)

from .sink import Peak, RecordingSink, RowBlock, RowWriter, note_peaks

EVENT, SAMPLE = 0, 1  # at one instant events stand before the sample taken after them


class PendingRows(NamedTuple):
    """Encoded sample rows that wait to be written: those of a block from its row `first` on."""

    rows: RowWriter
    block: RowBlock
    first: int = 0


@dataclass
class _Apart:
    """Writer of the rows of a single lift, and the number of its next row."""

    rows: RowWriter
    next: int = 0


class Recorder:
    """Writer of the recording `path`; `run`: facts known at the start, `attachments`: files by name.

    An earlier recording with this name is kept and the new one becomes run-2.mcap, unless `force` replaces it. Ropes
    are drawn at most every `lines_every` [s] of simulation time. As a context manager it closes the file as failed if
    the body raises.
    """

    def __init__(
        self,
        path: str | Path,
        run: Mapping[str, object],
        attachments: Mapping[str, bytes] | None = None,
        lines_every: float = 1.0,
        force: bool = False,
    ) -> None:
        self.digest = Digest()
        self._began = time.monotonic()
        self._sink = RecordingSink(path, run, attachments or {}, force)
        self._log = self._sink.protobuf("/log", Log)
        self._ports: dict[tuple[str, str], int] = {}
        self._rows: RowWriter | None = None
        self._lifts: dict[str, _Apart] = {}
        self._lines_every = lines_every
        self._next_sample = 0
        self.notes: list[SamplerNote] = []
        """Notes for the user that the sampling node has sent so far."""
        self._queue: list[tuple[int, int, int, Callable[[int], None] | PendingRows]] = []  # time, rank, ticket, what
        self._ticket = count()
        self._last_event = self._last_sample = self._settled = self._now = 0
        self._closed = False

    @property
    def path(self) -> Path:
        """Path of the recording: the given name, or the next free one."""
        return self._sink.path

    @property
    def peaks(self) -> dict[str, Peak]:
        """Peak tension of each rope so far."""
        return self._rows.peaks if self._rows else {}

    # what will be recorded

    def add_port(
        self, model: str, port: str, schema: Mapping[str, object], key: str = "", units: Mapping[str, str] | None = None
    ) -> None:
        """Add an output port, with the JSON Schema of its values, its Zenoh key, and units by field."""
        name = str(schema.get("title", schema.get("$ref", port))).rpartition("/")[2]
        facts = {"model": model, "port": port, "key": key, "units": dict(units or {})}
        self._ports[model, port] = self._sink.json(
            f"/{model}/{port}", f"heavylift.event.{name}", event_schema(schema), facts
        )

    def layout(self, layout: SampleLayout) -> None:
        """Set the layout of the sample rows; must be called only once."""
        self._rows = RowWriter(self._sink, layout, self._lines_every)
        self._lifts = {name: _Apart(RowWriter(self._sink, own, 0.0, name)) for name, own in layout.lifts.items()}

    def boxes(self, boxes: Sequence[DrawnBox]) -> None:
        """Draw these boxes on their bodies from time 0 on; must be called only once, before the first message."""
        channel = self._sink.protobuf("/scene", SceneUpdate)
        self._message(channel, 0, boxes_message(boxes))

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """Draw these ropes with the samples from this simulation time [ns] on, replacing earlier ones."""
        rows = self._announced()
        ropes = rows.ropes(lines)
        self._put(t_ns, lambda _: rows.hang(ropes))
        rig = self._sink.topics.get("/rig") or self._sink.json("/rig", "heavylift.rig", RIG_SCHEMA, {})
        self._message(rig, t_ns, msgspec.json.encode(Rig(t_ns, list(lines))))

    # what happens

    def event(self, t_ns: int, k: int, source: str, port: str, index: int, type: str, payload: bytes) -> None:
        """Record an event on a port of a coupled model, in total order; `payload`: msgpack bytes of its message."""
        channel = self._ports.get((source, port))
        if channel is None:
            raise RecordingError(f"event of {source}.{port}: this port was not announced; call add_port first")
        self.digest.event(t_ns, k, source, port, index, type, payload)
        record = RecordedEvent(t_ns, k, source, port, index, type, msgspec.msgpack.decode(payload))
        self._message(channel, t_ns, msgspec.json.encode(record))
        self._last_event = max(self._last_event, t_ns)
        self._drain()

    def samples(self, payload: bytes) -> None:
        """Record an encoded batch of samples from the kernel; rows that are already recorded are skipped."""
        rows = self._announced()
        batch = decode_batch(payload, rows.layout)
        if batch.lift:
            self._samples_apart(batch)
            return
        for note in batch.notes[max(0, len(self.notes) - batch.notes[0].number) :] if batch.notes else ():
            self.notes.append(note)
            self.digest.note(note.number, note.t_ns, note.sentence)
            self._message(self._log, note.t_ns, log_message(note.t_ns, "warning", SAMPLER, note.sentence, note.number))
        skip = self._next_sample - batch.first
        if skip < 0:
            raise RecordingError(
                f"samples {self._next_sample} to {batch.first - 1} are missing; "
                "the sender lost them or sent out of order"
            )
        if skip >= len(batch.times):
            return
        times, values = batch.times[skip:], batch.rows[skip:]
        log_ns = [max(t, self._now) for t in times]
        block = rows.encode(times, log_ns, values)
        for number, t_ns, row in zip(count(self._next_sample), times, block.columns, strict=False):
            self.digest.samples(number, t_ns, row.tobytes())
        heapq.heappush(self._queue, (log_ns[0], SAMPLE, next(self._ticket), PendingRows(rows, block)))
        note_peaks(rows.peaks, rows.layout, times, values)
        self._next_sample = batch.first + len(batch.times)
        self._last_sample = max(self._last_sample, batch.times[-1])
        self._drain()

    def _samples_apart(self, batch: Batch) -> None:
        """Record rows of a single lift."""
        lift = self._lifts[batch.lift]
        if batch.first > lift.next:
            raise RecordingError(
                f"samples {lift.next} to {batch.first - 1} of lift {batch.lift} are missing; the sender lost them"
            )
        times, values = batch.times[lift.next - batch.first :], batch.rows[lift.next - batch.first :]
        if times:
            log_ns = [max(t, self._now) for t in times]
            block = lift.rows.encode(times, log_ns, values)
            for number, t_ns, row in zip(count(lift.next), times, block.columns, strict=False):
                self.digest.samples(number, t_ns, row.tobytes(), batch.lift)
            heapq.heappush(self._queue, (log_ns[0], SAMPLE, next(self._ticket), PendingRows(lift.rows, block)))
            lift.next += len(times)
            self._drain()

    def protocol(
        self, t_ns: int, node: str, direction: str, kind: str, summary: Mapping[str, object], raw: bytes
    ) -> None:
        """Record a message of the time protocol; direction is "to node" or "from node"."""
        topic = f"/protocol/{node}"
        channel = self._sink.topics.get(topic)
        if channel is None:
            channel = self._sink.json(topic, "heavylift.protocol", PROTOCOL_SCHEMA, {"node": node})
        record = {"kind": kind, "node": node, "direction": direction, "t_ns": t_ns, "summary": summary, "raw": raw}
        self._put(self._now, self._writes(channel, t_ns, msgspec.json.encode(record)))
        self._drain()

    def checkpoint(self, at: tuple[int, int], state: bytes) -> None:
        """Attach the state of the mechanics at a logical time, before its events; it is not part of the digest."""
        self._sink.checkpoint(at, state)

    def log(self, t_ns: int, level: str, name: str, message: str) -> None:
        """Record a line of the log. `level`: debug, info, warning, error or fatal; `name`: source of the line."""
        self._message(self._log, t_ns, log_message(t_ns, level, name, message))

    def settle(self, t_ns: int) -> None:
        """Write all data before a simulation time [ns]; no further data of these times may follow."""
        self._settled = max(self._settled, t_ns)
        self._drain()

    def close(self, status: str = "finished", reason: str = "", result: Mapping[str, object] | None = None) -> Path:
        """Write all pending data and the metadata `result`, and give the finished file its name; return its path."""
        if self._closed:
            return self._sink.path
        self._closed = True
        try:
            self._write_below(math.inf)
            own: dict[str, object] = {
                "status": status,
                "reason": reason,
                "sim_s": self._now / 1e9,
                "wall_s": time.monotonic() - self._began,
                "samples": self._next_sample,
                "peaks": {name: peak._asdict() for name, peak in self.peaks.items()},
                "digest": self.digest.hexdigest(),
            }
            return self._sink.finish({**own, **(result or {})})
        finally:
            self._sink.abandon()

    def discard(self) -> None:
        """Close and delete the incomplete recording."""
        self._closed = True
        self._sink.abandon(keep=False)

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, _: object, error: object, *__: object) -> None:
        if error is None:
            self.close()
        else:
            self.close("failed", str(error) or type(error).__name__)

    # in which order it is written

    def _announced(self) -> RowWriter:
        if self._rows is None:
            raise RecordingError("samples arrived before their layout; announce the layout first")
        return self._rows

    def _writes(self, channel: int, publish_ns: int, data: bytes) -> Callable[[int], None]:
        return lambda log_ns: self._sink.mcap.write(channel, log_ns, publish_ns, data)

    def _message(self, channel: int, t_ns: int, data: bytes) -> None:
        self._put(t_ns, self._writes(channel, t_ns, data))

    def _put(self, t_ns: int, write: Callable[[int], None]) -> None:
        heapq.heappush(self._queue, (max(t_ns, self._now), EVENT, next(self._ticket), write))

    def _drain(self) -> None:
        last_sample = self._last_sample if self._rows else self._last_event
        self._write_below(max(self._settled, min(self._last_event, last_sample)))
        self._sink.flush()

    def _write_below(self, horizon: float) -> None:
        queue = self._queue
        if not queue or queue[0][0] >= horizon:
            return
        with self._sink.writing():
            while queue and queue[0][0] < horizon:
                self._now, _, ticket, what = heapq.heappop(queue)
                if isinstance(what, PendingRows):
                    self._write_rows(what, ticket, horizon)
                else:
                    what(self._now)

    def _write_rows(self, waiting: PendingRows, ticket: int, horizon: float) -> None:
        """Write pending rows below the horizon and before other pending data."""
        queue, (rows, block, first) = self._queue, waiting
        if queue:
            horizon = min(horizon, queue[0][0] + queue[0][1])  # an event stands before the sample of its instant
        end = bisect_left(block.log_ns, horizon, first)
        rows.write(block, first, end)
        self._now = block.log_ns[end - 1]
        if end < len(block.log_ns):
            heapq.heappush(queue, (block.log_ns[end], SAMPLE, ticket, PendingRows(rows, block, end)))
