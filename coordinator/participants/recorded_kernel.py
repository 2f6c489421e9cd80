"""A kernel with a recorded past: it repeats recorded outputs, and continues from a checkpoint.

Up to the checkpoint its events and samples are those of the recording, and its inputs are ignored; models that send
other events than recorded are found by the comparison of events. After it, the node is a `KernelNode` restored from the
checkpoint, or without one a kernel that begins at the start. Its own samples are compared with the recorded ones, as
far as these go.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import takewhile

import msgspec
import numpy as np
from heavylift.kernel.errors import KernelError, ModelError
from heavylift.nodes.devs import Event, Message, Slack, Tag
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.mcapfile import BROKEN
from heavylift.recordings.format.samples import Columns, SamplerNote, decode_batch
from numpy.typing import NDArray

from .kernel_node import KernelNode
from .parts import KernelConfig
from .rows import RowFrames

Floats = NDArray[np.float64]
Rows = Iterator[tuple[list[int], Floats]]  # times [ns], rows as they stand in the file
BATCH = 256  # samples that are said at once


@dataclass
class RecordedKernel:
    """The kernel's recorded history before a branch: events, samples, notes and checkpoints.

    The last checkpoint, `state`, is complete up to the logical time `at`; `facts` go into the new recording.

    Results: whether the checkpoint is `used`, or `why` not; how many samples were equal; the first one that was not, as
    (time [ns], column, recorded, now); whether the recorded part is `over`.
    """

    events: Sequence[Event]
    columns: dict[str, list[str]]
    rows: Callable[[Sequence[str]], Rows]
    notes: Sequence[tuple[int, str]]
    at: Tag
    state: bytes = b""
    checkpoints: Callable[[], Iterable[tuple[Tag, bytes]]] = tuple
    facts: Mapping[str, object] = field(default_factory=dict)
    why: str = ""
    samples: int = 0
    parted: tuple[int, str, float, float] | None = None
    used: bool = False
    over: bool = False


class Recalled:
    """A kernel that replays its recorded outputs up to a checkpoint and then continues computing; a `Steppable` like
    `KernelNode`."""

    def __init__(self, config: KernelConfig, publish: Callable[[bytes], None], past: RecordedKernel) -> None:
        self._publish, self._past = publish, past
        self._kernel = KernelNode(config, RowFrames(self._sampled), foretells=True)
        self._events: list[Event] = []
        self._last = self._kernel.last
        sent = noted = 0
        self._most = np.zeros(0)
        if past.state and config.lifts:
            past.why = "a scene with several lifts cannot continue from a checkpoint"
        elif past.state:
            try:
                self._kernel.start()
                self._kernel.restore(past.state)
                sent, noted, self._most = self._kernel.said
                self._events = [event for event in reversed(past.events) if event.tag < past.at]
                past.used = True
            except (KernelError, *BROKEN) as error:
                foreign = isinstance(error, KernelError)
                past.why = (
                    "the mechanics of the new scene differ" if foreign else "its checkpoint is damaged, or too old"
                )
                self._kernel = KernelNode(config, RowFrames(self._sampled), foretells=True)
        self.lookahead = self._kernel.lookahead
        self._sent, self._known = sent, _Known(past, self._announced(sent))
        self._notes = [SamplerNote(i, t, message) for i, (t, message) in enumerate(past.notes[:noted])]

    def _announced(self, recalled: int) -> SampleLayout:
        layout = msgspec.msgpack.decode(self._kernel.layout(), type=SampleLayout)
        return msgspec.structs.replace(layout, recalled=recalled, most=self._most.tolist())

    def layout(self) -> bytes:
        """Return the layout of the kernel's samples, which also states how many samples are replayed."""
        return msgspec.msgpack.encode(self._announced(self._sent))

    @property
    def pauses(self) -> int:
        """Progress counter of the kernel: while it increases, the kernel still works."""
        return self._kernel.pauses

    def start(self) -> None:
        """Start the kernel; does nothing if the kernel continues from a checkpoint."""
        if not self._past.used:
            self._kernel.start()

    @property
    def next_time(self) -> Tag:
        """Logical time of the next recorded event or, after the last one, of the kernel."""
        return self._events[-1].tag if self._events else self._kernel.next_time

    @property
    def quiet(self) -> Tag:
        """Earliest logical time at which the replayed kernel may send a message if no input arrives."""
        return self._events[-1].tag if self._events else self._kernel.quiet

    @property
    def slack(self) -> list[Slack]:
        """Observed lookaheads of the kernel: always empty."""
        return self._kernel.slack

    @property
    def last(self) -> Tag:
        """Logical time of the kernel's last transition, replayed or computed."""
        return self._last

    def results(self, end: Tag) -> dict[str, Message]:
        """Return the results that the kernel reports at the end of a run."""
        return self._kernel.results(end)

    def outputs(self) -> list[Event]:
        """Return the recorded outputs at `next_time` or, after the last recorded event, those of the kernel."""
        if not self._events:
            return self._kernel.outputs()
        tag = self.next_time
        return list(takewhile(lambda event: event.tag == tag, reversed(self._events)))

    def among(self) -> list[Event]:
        """Return the events that the kernel sends within its own node, as `KernelNode.among` does."""
        return self._kernel.among()

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        """Replay recorded outputs up to the checkpoint, then advance the kernel."""
        self._last = tag
        if self._past.used and tag < self._past.at:
            while self._events and self._events[-1].tag == tag:
                self._events.pop()
            self._recall(min(until, self.next_time).t)
        else:
            self._kernel.advance(tag, bag, until)

    def foretell(self) -> None:
        """Publish in advance the sample row of a scene at rest, unless the kernel continues from a checkpoint."""
        if not self._past.used:
            self._kernel.foretell()

    def finish(self, end: Tag) -> str:
        """Finish the kernel; does nothing in a run that ends before the checkpoint."""
        return "" if self._past.used and end < self._past.at else self._kernel.finish(end)

    def snapshot(self) -> bytes:
        """Return a snapshot of the kernel; raises KernelError in the replayed part, whose checkpoints are in the
        recording."""
        if self._past.used and self._known.number < self._sent:
            raise KernelError(
                "no checkpoint can be made while the run repeats its recorded part; use one of the recording"
            )
        return self._kernel.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Continue from a snapshot of the kernel."""
        self._kernel.restore(snapshot)

    def _recall(self, before_ns: int) -> None:
        """Publish the samples that were recorded before this time [ns]."""
        for first, times, rows in self._known.read(self._sent, before_ns):
            last = first + len(times) == self._sent
            notes = [note for note in self._notes if last or note.t_ns <= times[-1]]
            self._notes = self._notes[len(notes) :]
            more = (notes,) if notes else ()
            self._publish(msgspec.msgpack.encode((first, times, rows.astype("<f8").tobytes(), *more)))

    def _sampled(self, batch: bytes) -> None:
        """Publish own samples after all recalled ones; raises ModelError if one differs from the recording."""
        found = decode_batch(batch, self._known.layout)
        if not (found.period or found.lift):
            self._recall(found.times[0] + 1)
            if parted := self._known.compare(found.times, found.rows):
                self._past.parted = parted
                raise ModelError(f"{parted[1]} of the repeated run differs from the recording")
        self._publish(batch)


class _Known:
    """Recorded samples that are read once, in order; `number`: number of the next sample."""

    def __init__(self, past: RecordedKernel, layout: SampleLayout) -> None:
        self._past, self._columns, self.layout, self.number = past, Columns(layout), layout, 0
        names = {c.topic: c.names for c in layout.channels}
        names |= {f.signal: f.columns for f in self._columns.fields}
        self._names, here, there, at = list[str](), list[int](), list[int](), 0
        for name, place in self._columns.signals.items():
            if name not in past.columns:
                continue
            self._names += [f"{name}/{column}" for column in names[name] if column in past.columns[name]]
            here += [place.start + i for i, column in enumerate(names[name]) if column in past.columns[name]]
            there += [at + past.columns[name].index(column) for column in names[name] if column in past.columns[name]]
            at += len(past.columns[name])
        self._here, self._there = np.array(here, np.intp), np.array(there, np.intp)
        signals = [name for name in self._columns.signals if name in past.columns]
        self._blocks = past.rows(signals)
        self._times, self._rows = list[int](), np.zeros((0, 0))

    def _next(self) -> bool:
        """Return whether an unread recorded row remains."""
        while not self._times:
            block = next(self._blocks, None)
            if block is None:
                return False
            self._times, self._rows = list(block[0]), np.ascontiguousarray(block[1][:, self._there])
        return True

    def _take(self, n: int) -> tuple[list[int], Floats]:
        times, rows = self._times[:n], self._rows[:n]
        self._times, self._rows = self._times[n:], self._rows[n:]
        self.number += len(times)
        self._past.samples += len(times)
        return times, rows

    def read(self, end: int, before_ns: int) -> Iterator[tuple[int, list[int], Floats]]:
        """Yield recorded sample rows before row `end` and time `before_ns`, in batches: number of the first row,
        times, rows."""
        while self.number < end and self._next() and self._times[0] < before_ns:
            first = self.number
            n = sum(t < before_ns for t in self._times[: min(BATCH, end - first)])
            times, rows = self._take(n)
            recorded = np.zeros((n, len(self._columns)))
            recorded[:, self._here] = rows
            spread = self._columns.spread(recorded, self.layout.width)
            self._columns(spread)
            yield first, times, spread

    def compare(self, times: Sequence[int], rows: Floats) -> tuple[int, str, float, float] | None:
        """Return time [ns], column, recorded and new value of the first difference between the kernel's samples and the
        recorded ones; None if they are equal."""
        now, i = np.ascontiguousarray(self._columns(rows)[:, self._here]), 0
        while i < len(times) and self._next():
            n = min(len(times) - i, len(self._times))
            there, recorded = self._take(n)
            for k in range(n):
                other = np.flatnonzero(now[i + k].view(np.int64) != recorded[k].view(np.int64))
                if there[k] != times[i + k] or len(other):
                    column = self._names[int(other[0])] if len(other) else "the time of a sample"
                    what = (recorded[k, other[0]], now[i + k, other[0]]) if len(other) else (there[k], times[i + k])
                    return min(there[k], times[i + k]), column, float(what[0]), float(what[1])
            i += n
        return None
