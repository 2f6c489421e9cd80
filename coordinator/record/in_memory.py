"""A run of a plan from start to end in this process, kept in memory; its digest is that of `run`.

A run that takes longer than its limit is stopped; like any other early end, this raises a HeavyliftError.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf

import msgspec
import numpy as np
from heavylift.coordinator.live.command_queue import TimedCommand, command
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.verdict.conduct import Conduct
from heavylift.coordinator.verdict.history import Collector, Every
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.devs import Event, Tag
from heavylift.nodes.limits.checks import Errors
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import Digest, RopeLine, SampleLayout
from heavylift.recordings.format.samples import Columns
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.write.sink import Peak, note_peaks
from numpy.typing import NDArray

from .drawing import RopeLines

CUT = "cut after"
Judged = tuple[RecordedVerdict, Sequence[Use]]  # a verdict, and the maximum utilisation of each limit


@dataclass(frozen=True)
class Played:
    """A finished run of a plan, whose results are kept in memory.

    Samples: layout, times (n,) [ns] and rows (n, width); `apart`: samples of single lifts, by name; `dense`: rows at
    the requested instants. Also the events in total order, rope lines with the time [ns] from which they are valid,
    notes of the kernel with times [ns], ropes that went slack, end [ns], conditions for which the action list still
    waited, wall and CPU time before and during the run [s].
    """

    plan: Plan
    mechanics: System
    layout: SampleLayout
    times: NDArray[np.int64]
    rows: NDArray[np.float64]
    events: list[Event]
    rigs: list[tuple[int, list[RopeLine]]]
    apart: dict[str, list[tuple[int, NDArray[np.float64]]]]
    notes: list[tuple[int, str]]
    slack: frozenset[str]
    end_ns: int
    unfinished: str
    dense: NDArray[np.float64]
    prepared_s: float
    start_s: float
    wall_s: float
    cpu_s: float
    errors: Errors = field(default_factory=dict)  # of its figures, as far as they are known

    @cached_property
    def digest(self) -> str:
        """Digest of the run; a recorded run with the same events and samples has the same digest."""
        digest, columns = Digest(), Columns(self.layout)
        for e in self.events:
            digest.event(e.t, e.k, e.source, e.port, e.index, e.type, e.payload)
        for number, (t_ns, row) in enumerate(zip(self.times.tolist(), columns(self.rows), strict=True)):
            digest.samples(number, t_ns, row.tobytes())
        for lift, rows in self.apart.items():
            columns = Columns(self.layout.lifts[lift])
            for number, (t_ns, row) in enumerate(rows):
                digest.samples(number, t_ns, columns(row[None])[0].tobytes(), lift)
        for number, note in enumerate(self.notes):
            digest.note(number, *note)
        return digest.hexdigest()

    @property
    def t(self) -> NDArray[np.float64]:
        """Times of the samples (n,) [s]."""
        return np.asarray(self.times / 1e9, np.float64)

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """The largest tension [N] of each rope, with its time [s]."""
        found: dict[str, Peak] = {}
        note_peaks(found, self.layout, self.times.tolist(), self.rows)
        return found

    @cached_property
    def conduct(self) -> Conduct:
        """The course of the run: stages, orders and incidents such as warnings."""
        text = Conduct(
            notes=[(t * 1e-9, sentence) for t, sentence in self.notes],
            peaks={name: (p.tension, p.time) for name, p in self.peaks.items()},
            end=self.end_ns * 1e-9,
            unfinished=self.unfinished,
        )
        for event in self.events:
            text.event(event)
        return text

    @property
    def verdict(self) -> RecordedVerdict:
        """The verdict on the run: its checks with their states and the resulting overall state."""
        return self.judge.full[0]

    @property
    def uses(self) -> Sequence[Use]:
        """The maximum utilisation of each limit during the run."""
        return self.judge.full[1]

    @cached_property
    def judge(self) -> "Judge":
        """The data from which the verdict of the run is computed."""
        return Judge(self.plan, self.mechanics, self.past, self.conduct, self.errors)

    @cached_property
    def past(self) -> Collector:
        """The recorded history of the run: the columns of all samples, and the lines of the ropes."""
        past = Collector(self.layout)
        past.samples(0, self.times.tolist(), self.rows)
        for t_ns, lines in self.rigs:
            past.ropes(t_ns, lines)
        return past


@dataclass(frozen=True)
class Judge:
    """The data from which the verdict of a run is computed, such as plan and recorded columns."""

    plan: Plan
    mechanics: System
    past: Collector
    conduct: Conduct
    errors: Errors

    def _judged(self, whole: bool, every: int = 1) -> Judged:
        """Compute the verdict from every `every`-th sample. Unless `whole`, tables and all but the smallest clearance
        are omitted."""
        from heavylift.coordinator.verdict.clearances import SMALLEST
        from heavylift.coordinator.verdict.judging import verdict_with_uses

        past, smallest = Every(self.past, every) if every > 1 else self.past, SMALLEST if whole else 1
        return verdict_with_uses(self.plan, past, self.conduct, self.errors, smallest, self.mechanics, whole)

    @cached_property
    def full(self) -> Judged:
        """The verdict with all tables of a report, and the largest utilisation of each limit."""
        return self._judged(whole=True)

    @cached_property
    def fine(self) -> Judged:
        """The verdict from all samples, without the tables of a report and with the smallest clearance only."""
        return self._judged(whole=False)

    @cached_property
    def coarse(self) -> Judged:
        """The verdict computed from every second sample, without tables; its difference shows the error due to
        sampling."""
        return self._judged(whole=False, every=2)


def play(
    plan: Plan,
    limit: float = inf,
    commands: Sequence[TimedCommand] = (),
    instants: Sequence[int] = (),
    errors: Errors | None = None,
) -> Played:
    """Run a plan to its end in this process and keep the result in memory; raises HeavyliftError.

    `limit`: wall time [s]; `instants`: times [ns] at which dense output is read.
    """
    # with the compiler, which nobody needs who only reads what is remembered
    from heavylift.coordinator.participants.kernel_node import KernelNode
    from heavylift.coordinator.participants.session import Session
    from heavylift.kernel.islands.dense_output import DenseRows

    from .kept_rows import KeptRows

    began, start = time.perf_counter(), time.thread_time()
    events, kept = list[Event](), KeptRows()

    def hear(event: Event) -> None:
        events.append(event)
        if ropes.change(event):
            rigs.append((event.t, ropes.drawn()))

    session = Session(plan, lambda config: KernelNode(config, kept), hear)
    kernel, ropes = session.kernel, RopeLines(session.config.systems)
    looks, rigs = DenseRows(kernel.simulation, instants), [(0, ropes.drawn())]
    kept.limit(limit, CUT)
    for given in commands:
        session.core.inject(command(given))
    prepared, started = time.perf_counter(), time.thread_time()
    outcome = session.advance()
    reached = max(events[-1].t if events else 0, kept.kept[-1][1][0] if kept.kept else 0)
    ended = outcome is RunEnd.QUIET and plan.end is None
    unfinished = session.finish(Tag(reached + 1) if ended else session.core.end)
    cpu, wall = time.thread_time() - started, time.perf_counter() - prepared
    times, rows = kept.table()
    slack = frozenset(e.name.partition("~")[0] for _, e in kernel.simulation.log if e.what == "slack")
    return Played(
        plan, kernel.mechanics, msgspec.convert(msgspec.msgpack.decode(kernel.layout()), SampleLayout), times, rows,
        events, rigs, kept.of_lifts, kept.sentences, slack,
        max(times[-1].item(), events[-1].t if events else 0), unfinished,
        looks.finish(), prepared - began, started - start, wall, cpu, errors or {},
    )  # fmt: skip
