"""A run of a plan in this process from its start to its end, kept in memory; the digest is that of `run`.

A run that takes longer than it may is cut; that it was, and whatever else ends it early, is a HeavyliftError with its
sentence.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from math import inf

import msgspec
import numpy as np
from heavylift.coordinator.live.command_queue import TimedCommand, command
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.parts import KernelConfig
from heavylift.coordinator.participants.session import Session
from heavylift.coordinator.protocol.core import RunEnd
from heavylift.coordinator.record.drawing import RopeLines
from heavylift.coordinator.verdict.conduct import Conduct
from heavylift.coordinator.verdict.history import Collector
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.islands.dense_output import DenseRows
from heavylift.kernel.simulation.commands import LiftRowsView
from heavylift.kernel.simulation.native.samples import published
from heavylift.nodes.devs import Event, Tag
from heavylift.nodes.limits.checks import Errors
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import Digest, RopeLine, SampleLayout
from heavylift.recordings.format.samples import Columns
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.write.sink import Peak, note_peaks
from numpy.typing import NDArray

CUT = "cut after"


@dataclass(frozen=True)
class Played:
    """A run of a plan and its mechanics: the columns of a sample, times (n,) [ns] and rows (n, width); events in
    total order; the rope lines that hang from when on [ns]; `apart`: times and rows of one lift alone, by its name;
    what the kernel has to say, and when [ns]; whether a hook rope `slackens`; its end [ns]; what the action list still
    waited for; rows at instants between samples; GRANTs; seconds before it (of CPU time `start_s`) and in it."""

    plan: Plan
    mechanics: System
    layout: SampleLayout
    times: NDArray[np.int64]
    rows: NDArray[np.float64]
    events: list[Event]
    rigs: list[tuple[int, list[RopeLine]]]
    apart: dict[str, list[tuple[int, NDArray[np.float64]]]]
    notes: list[tuple[int, str]]
    slackens: bool
    end_ns: int
    unfinished: str
    dense: NDArray[np.float64]
    grants: int
    prepared_s: float
    start_s: float
    wall_s: float
    cpu_s: float
    errors: Errors = field(default_factory=dict)  # of its figures, as far as they are known

    @cached_property
    def digest(self) -> str:
        """The digest, equal for equal runs whether recorded or not."""
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
        """Times (n,) [s]."""
        return np.asarray(self.times / 1e9, np.float64)

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """The largest tension of each rope."""
        found: dict[str, Peak] = {}
        note_peaks(found, self.layout, self.times.tolist(), self.rows)
        return found

    @cached_property
    def conduct(self) -> Conduct:
        """Stages, orders and incidents of the run."""
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
        """The verdict."""
        return self.judged[0]

    @property
    def uses(self) -> Sequence[Use]:
        """The worst of each limit."""
        return self.judged[1]

    @cached_property
    def judged(self) -> tuple[RecordedVerdict, Sequence[Use]]:
        """The verdict, and the worst of each limit."""
        return self.judging()

    @cached_property
    def judged_coarsely(self) -> tuple[RecordedVerdict, Sequence[Use]]:
        """The same of every second sample."""
        return self.judging(2)

    def judging(self, every: int = 1, **options: int) -> tuple[RecordedVerdict, Sequence[Use]]:
        """The same of every so many-th sample, with options of `verdict_with_uses`."""
        from heavylift.coordinator.verdict.judging import verdict_with_uses

        past, known = self.past(every), self.mechanics
        return verdict_with_uses(self.plan, past, self.conduct, self.errors, mechanics=known, **options)

    def past(self, every: int = 1) -> Collector:
        """What every so many-th sample has shown, as columns."""
        past = Collector(self.layout)
        past.samples(0, self.times[::every].tolist(), self.rows[::every])
        for t_ns, lines in self.rigs:
            past.ropes(t_ns, lines)
        return past


class _Kernel(KernelNode):
    """A kernel whose samples stay in this process and whose run can be ended by the clock."""

    def __init__(self, config: KernelConfig, instants: Sequence[int], allowed: float) -> None:
        super().__init__(config, lambda batch: None)
        self.looks = DenseRows(self.simulation, instants)
        self.kept: list[tuple[object, tuple[int, np.ndarray]]] = []  # beside the code whose row it is
        self.sentences: list[tuple[int, str]] = []
        self.of_lifts: dict[str, list[tuple[int, np.ndarray]]] = {}
        self._allowed, self._deadline = allowed, time.perf_counter() + allowed

    def _pause(self) -> None:
        super()._pause()
        if time.perf_counter() > self._deadline:
            raise KernelError(f"{CUT} {self._allowed:.3g} s of wall time, at {self.simulation.now:.3f} s of the run")

    def _batch(self, rows: list[tuple[int, np.ndarray]], notes: list[tuple[int, int, str]], period: int = 0) -> None:
        self.kept += [(self.simulation.method, row) for row in rows]
        self.sentences += [(t_ns, sentence) for _, t_ns, sentence in notes]

    def _batch_apart(self, lift: LiftRowsView, rows: list[tuple[int, np.ndarray]]) -> None:
        shown = published(lift.method, np.array([row for _, row in rows]))
        self.of_lifts.setdefault(lift.name, []).extend(zip([t for t, _ in rows], shown, strict=True))

    def table(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Times (n,) [ns] and rows (n, width) of all samples."""
        parts = []
        for _, group in groupby(self.kept, key=lambda x: id(x[0])):
            some = list(group)
            method: object = some[0][0]
            parts.append(published(method, np.array([row for _, (_, row) in some])))  # type: ignore[arg-type]
        return np.array([t for _, (t, _) in self.kept], np.int64), np.concatenate(parts)


def play(
    plan: Plan,
    limit: float = inf,
    commands: Sequence[TimedCommand] = (),
    instants: Sequence[int] = (),
    errors: Errors | None = None,
) -> Played:
    """Run a plan to its end within `limit` seconds of wall time, and look at `instants` [ns]; raises HeavyliftError."""
    began, start = time.perf_counter(), time.thread_time()
    events, rigs, ropes = list[Event](), list[tuple[int, list[RopeLine]]](), list[RopeLines]()

    def make(config: KernelConfig) -> _Kernel:
        ropes.append(RopeLines(config.systems))
        rigs.append((0, ropes[0].drawn()))
        return _Kernel(config, instants, limit)

    def hear(event: Event) -> None:
        events.append(event)
        if ropes[0].change(event):
            rigs.append((event.t, ropes[0].drawn()))

    session = Session(plan, make, hear)
    kernel = session.kernel
    for given in commands:
        session.core.inject(command(given))
    prepared, started = time.perf_counter(), time.thread_time()
    outcome = session.advance()
    reached = max(events[-1].t if events else 0, kernel.kept[-1][1][0] if kernel.kept else 0)
    ended = outcome is RunEnd.QUIET and plan.end is None
    unfinished = session.finish(Tag(reached + 1) if ended else session.core.end)
    cpu, wall = time.thread_time() - started, time.perf_counter() - prepared
    times, rows = kernel.table()
    hooks = {hook.rope for machine in plan.machines for hook in machine.hooks}
    slackens = any(e.what == "slack" and e.name.partition("~")[0] in hooks for _, e in kernel.simulation.log)
    return Played(
        plan, kernel.mechanics, msgspec.convert(msgspec.msgpack.decode(kernel.layout()), SampleLayout), times, rows,
        events, rigs, kernel.of_lifts, kernel.sentences, slackens,
        max(times[-1].item(), events[-1].t if events else 0), unfinished,
        kernel.looks.finish(), session.grants, prepared - began, started - start, wall, cpu, errors or {},
    )  # fmt: skip
