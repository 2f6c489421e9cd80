"""First deviation of a new run from a recorded one: the first differing event or sample, with both values.

`single` runs one model alone: the model receives its recorded inputs at their tags and must produce its recorded
outputs; the kernel must also produce its recorded samples. The comparison ends at the first deviation, after which the
recorded inputs do not fit any more.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.kernel.errors import RecordingError, printable
from heavylift.nodes.devs import Event, Steppable, Tag
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.samples import POSE, Columns, decode_batch
from numpy.typing import NDArray

from .recorded import RecordedRun

Floats = NDArray[np.float64]


class Deviation(msgspec.Struct, frozen=True):
    """The first difference between a recorded run and its repetition: logical time, topic, recorded and new value."""

    t_ns: int
    microstep: int
    topic: str
    recorded: object  # None: no value
    now: object

    def __str__(self) -> str:
        values = [msgspec.json.encode(x).decode() if x is not None else "nothing" for x in (self.recorded, self.now)]
        return f"at {Tag(self.t_ns, self.microstep)} on {printable(self.topic)}: recorded {values[0]}, now {values[1]}"


class ReplayResult(msgspec.Struct, frozen=True):
    """Result of comparing a repeated run with the recorded one.

    Number of equal events, first deviation, digest if known, other differences, verdict if computed again, facts that
    were not computed again.
    """

    events: int
    deviation: Deviation | None = None
    digest: str = ""
    others: tuple[str, ...] = ()
    judged: str = ""
    as_recorded: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether the repeated run equals the recorded one."""
        return self.deviation is None and not self.others


class EventComparison:
    """Compares the events of a repeated run, in total order, with the recorded ones."""

    def __init__(self, recorded: list[Event]) -> None:
        self._recorded = recorded
        self.count = 0
        """Number of recorded events that the new run has repeated."""

    def hear(self, event: Event) -> Deviation | None:
        """Compare the next event of the repeated run with the recorded one; return the deviation, or None."""
        due = self._recorded[self.count] if self.count < len(self._recorded) else None
        if due == event:
            self.count += 1
            return None
        if due is None or event.order < due.order:
            return _deviation(None, event)
        return _deviation(due, event if event.order == due.order else None)

    def reach(self, tag: Tag) -> Deviation | None:
        """Return a deviation if a recorded event before this time is missing; to be called when the repeated run has
        passed it."""
        due = self._recorded[self.count] if self.count < len(self._recorded) else None
        return _deviation(due, None) if due is not None and due.tag < tag else None


def _deviation(recorded: Event | None, now: Event | None) -> Deviation:
    known = recorded or now
    assert known is not None
    return Deviation(known.t, known.k, f"/{known.source}/{known.port}", _plain(recorded), _plain(now))


def _plain(event: Event | None) -> object:
    return None if event is None else {event.type: msgspec.msgpack.decode(event.payload)}


def sample_apart(run: RecordedRun, layout: bytes, batches: list[bytes]) -> Deviation | None:
    """Compare newly computed batches of samples with the recorded samples; return the first recorded sample that
    differs or is missing."""
    rec, announced = run.recording, msgspec.msgpack.decode(layout, type=SampleLayout)
    columns = Columns(announced)
    found = [x for x in (decode_batch(batch, announced) for batch in batches) if not x.lift]
    times = np.array([t for batch in found for t in batch.times], np.int64)
    rows = np.concatenate([np.zeros((0, len(columns))), *(columns(batch.rows) for batch in found)])
    first = _unrecorded(run, [t for batch in found if not batch.period for t in batch.times])
    places = {name: x for name, x in columns.signals.items() if name in rec.signals() and not name.startswith(POSE)}
    now = np.hstack([np.zeros((len(rows), 0)), *(rows[:, x] for x in places.values())])
    labels = [f"/{name}/{column}" for name in places for column in rec.columns(name)]
    for samples, values in rec.blocks([*places]) if places else ():
        for t, row in zip(samples, np.hstack(values), strict=True):
            if not len(times) or t > times[-1] or (first is not None and t >= first.t_ns):
                return first
            at = now[slice(*np.searchsorted(times, (t, t + 1)))]  # one before and one after an event
            if not (at == row).all(axis=1).any():
                k = int(np.argmin((at == row).any(axis=0)))
                return Deviation(t, 0, labels[k], float(row[k]), float(at[-1, k]) if len(at) else None)
    return first


def _unrecorded(run: RecordedRun, now: list[int]) -> Deviation | None:
    """Return the first new sample that is not in the recording; of an incomplete recording only before its last one."""
    recorded = {raw.publish_time for raw in run.recording.messages("/samples")}
    known = (t for t in now if t not in recorded and (run.complete or t < max(recorded, default=0)))
    t_ns = min(known, default=None)
    return None if t_ns is None else Deviation(t_ns, 0, "/samples", None, "a row")


def single(run: RecordedRun, name: str) -> ReplayResult:
    """Run a single model with its recorded inputs and compare its outputs; raises RecordingError if there is no such
    model."""
    try:
        node = run.cast.node(name)
    except RecordingError as error:
        raise RecordingError(f"{run.path}: {error}") from None
    events, end, models = run.events, run.end, run.cast
    heard = {(wire.source, wire.port) for wire in models.wiring.all if wire.target == node}
    inputs = [e for e in events if (e.source, e.port) in heard]
    follower = EventComparison([e for e in events if e.source == node])
    batches: list[bytes] = []
    model = models.make(node, batches.append)
    found = _play(model, inputs, end, follower)
    if isinstance(model, KernelNode):
        if found is None:
            model.finish(end)
        both = (x for x in (found, sample_apart(run, model.layout(), batches)) if x)
        found = min(both, key=lambda x: (x.t_ns, x.microstep), default=None)
    return ReplayResult(follower.count, found)


def _play(model: Steppable, inputs: Sequence[Event], end: Tag, follower: EventComparison) -> Deviation | None:
    """Run a model before `end` with its recorded inputs; returns the first deviation of its outputs, or None."""
    model.start()
    at = 0
    while True:
        due = model.next_time
        tag = min(due, inputs[at].tag) if at < len(inputs) else due
        missing = follower.reach(min(tag, end))
        if missing or tag >= end:
            return missing
        begin = at
        while at < len(inputs) and inputs[at].tag == tag:
            at += 1
        for event in model.outputs() if tag == due else []:
            if deviation := follower.hear(event):
                return deviation
        model.advance(tag, inputs[begin:at], inputs[at].tag if at < len(inputs) else end)
