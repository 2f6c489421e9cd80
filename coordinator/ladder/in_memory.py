"""One run of a plan in this process and thread: no file, no bus, no other process; the digest is that of `run`.

One node has commander and machines, another the kernel, and the protocol decides; what they say is kept in memory.
A run that takes longer than it may is cut; that it was, and whatever else ends it early, is a HeavyliftError with its
sentence.  Outputs of the models are not watched for side effects: `run` does that.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from math import inf
from random import Random

import msgspec
import numpy as np
from heavylift.coordinator.live.command_queue import TimedCommand, command
from heavylift.coordinator.participants.configuration import PATIENCE_ns, wiring
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.mechanics_at import configured
from heavylift.coordinator.participants.parts import KernelConfig
from heavylift.coordinator.protocol.core import RunEnd
from heavylift.coordinator.protocol.memory import go_on, run_in_memory
from heavylift.coordinator.protocol.messages import Bye, Grant, Stop
from heavylift.coordinator.protocol.node import Node
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.coordinator.record.drawing import RopeLines
from heavylift.coordinator.verdict.conduct import Conduct
from heavylift.coordinator.verdict.history import Collector
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError, ModelError
from heavylift.kernel.islands.dense_output import Looks
from heavylift.kernel.simulation.commands import OwnRows
from heavylift.kernel.simulation.native.samples import published
from heavylift.nodes.devs import FOREVER, Event, Simulator, Tag, seconds
from heavylift.nodes.limits.checks import Errors
from heavylift.nodes.models import COMMANDER, KERNEL, build, driving, goes_on
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import Digest, RopeLine, SampleLayout
from heavylift.recordings.format.samples import Columns
from heavylift.recordings.read.verdict import Judged
from heavylift.recordings.write.rows import Peak, note_peaks
from numpy.typing import NDArray

CUT = "cut after"


@dataclass(frozen=True)
class Played:
    """A run of a plan and its mechanics: the columns of a sample, times (n,) [ns] and rows (n, width); events in
    total order; the rope lines that hang from when on [ns]; `apart`: times and rows of one lift alone, by its name;
    what the kernel has to say, and when [ns]; its end [ns]; what the action list still waited for; rows at instants
    between samples; GRANTs; seconds before it (of CPU time `start_s`) and in it."""

    plan: Plan
    mechanics: System
    layout: SampleLayout
    times: NDArray[np.int64]
    rows: NDArray[np.float64]
    events: list[Event]
    rigs: list[tuple[int, list[RopeLine]]]
    apart: dict[str, list[tuple[int, NDArray[np.float64]]]]
    notes: list[tuple[int, str]]
    end_ns: int
    unfinished: str
    looked: NDArray[np.float64]
    grants: int
    prepared_s: float
    start_s: float
    wall_s: float
    cpu_s: float
    errors: Errors = field(default_factory=dict)  # of its figures, as far as they are known

    @cached_property
    def digest(self) -> str:
        """The line that equal runs share, recorded or not."""
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
        """What was said in it."""
        said = Conduct(
            notes=[(t * 1e-9, sentence) for t, sentence in self.notes],
            peaks={name: (p.tension, p.time) for name, p in self.peaks.items()},
            end=self.end_ns * 1e-9,
            unfinished=self.unfinished,
        )
        for event in self.events:
            said.event(event)
        return said

    @property
    def verdict(self) -> Judged:
        """The verdict."""
        return self.judged[0]

    @property
    def uses(self) -> Sequence[Use]:
        """The worst of each limit."""
        return self.judged[1]

    @cached_property
    def judged(self) -> tuple[Judged, Sequence[Use]]:
        """The verdict, and the worst of each limit."""
        return self.judging()

    def judging(self, **options: int) -> tuple[Judged, Sequence[Use]]:
        """The same, with options of `judged_with_uses`."""
        from heavylift.coordinator.verdict.judging import judged_with_uses

        return judged_with_uses(self.plan, self.past, self.conduct, self.errors, mechanics=self.mechanics, **options)

    @cached_property
    def past(self) -> Collector:
        """What it has shown, as columns."""
        past = Collector(self.layout)
        past.samples(0, self.times.tolist(), self.rows)
        for t_ns, lines in self.rigs:
            past.ropes(t_ns, lines)
        return past


class _Kernel(KernelNode):
    """A kernel whose samples stay with it, and whose run is over at an instant of the clock."""

    def __init__(self, config: KernelConfig, instants: Sequence[int]) -> None:
        super().__init__(config, lambda batch: None)
        self.looks = Looks(self.simulation, instants)
        self.kept: list[tuple[object, tuple[int, np.ndarray]]] = []  # beside the code whose row it is
        self.told: list[tuple[int, str]] = []
        self.of_lifts: dict[str, list[tuple[int, np.ndarray]]] = {}
        self.allowed = self.deadline = inf

    def _pause(self) -> None:
        super()._pause()
        if time.perf_counter() > self.deadline:
            raise KernelError(f"{CUT} {self.allowed:.3g} s of wall time, at {self.simulation.now:.3f} s of the run")

    def _batch(self, rows: list[tuple[int, np.ndarray]], notes: list[tuple[int, int, str]], period: int = 0) -> None:
        self.kept += [(self.simulation.method, row) for row in rows]
        self.told += [(t_ns, sentence) for _, t_ns, sentence in notes]

    def _batch_apart(self, lift: OwnRows, rows: list[tuple[int, np.ndarray]]) -> None:
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


class _Counting(OpenCoordinator):
    """Counts grants."""

    grants = 0

    def ready(self, horizon: Tag = FOREVER) -> list[tuple[str, Grant]]:
        """As the coordinator's."""
        granted = super().ready(horizon)
        self.grants += len(granted)
        return granted


def play(
    plan: Plan,
    limit: float = inf,
    commands: Sequence[TimedCommand] = (),
    instants: Sequence[int] = (),
    errors: Errors | None = None,
) -> Played:
    """Run a plan to its end within `limit` seconds of wall time, and look at `instants` [ns]; raises HeavyliftError."""
    began, start = time.perf_counter(), time.thread_time()
    models, events, rigs = build(plan), list[Event](), list[tuple[int, list[RopeLine]]]()
    config = configured(plan, models)
    ropes, kernel = RopeLines(config.systems), _Kernel(config, instants)
    rigs.append((0, ropes.drawn()))

    def hear(event: Event) -> None:
        events.append(event)
        if plan.end is None and goes_on(event):
            core.extend(Tag(event.t + PATIENCE_ns))
        if ropes.change(event):
            rigs.append((event.t, ropes.drawn()))

    end = Tag(PATIENCE_ns if plan.end is None else seconds(plan.end))
    wires, most = wiring(plan), plan.microsteps
    shared = dict.fromkeys(driving(plan))  # one node: what they say to each other needs no grants
    alone = [n for n in models if n not in shared]
    homes = {COMMANDER: [*shared], **{n: [n] for n in (*alone, KERNEL)}}
    core = _Counting(homes, wires.couplings, end, wires.finish, hear, wires.outside, most, homes)
    for given in commands:
        core.inject(command(given))
    simulators = {
        n: Simulator([models[m] for m in own], microsteps=most, watched=False, wires=wires.all)
        for n, own in homes.items()
        if n != KERNEL
    }
    nodes = {n: Node(n, simulator) for n, simulator in simulators.items()}
    nodes[KERNEL] = Node(KERNEL, kernel, kernel.finish)
    prepared, started = time.perf_counter(), time.thread_time()
    kernel.allowed, kernel.deadline = limit, prepared + limit
    outcome = run_in_memory(core, nodes.values(), wired=False)
    while outcome is RunEnd.BOUND and plan.end is None and (due := core.scheduled(driving(plan))) < FOREVER:
        core.extend(Tag(due.t + PATIENCE_ns))
        outcome = go_on(core, nodes, Random(0), wired=False)
    reached = max(events[-1].t if events else 0, kernel.kept[-1][1][0] if kernel.kept else 0)
    ended = outcome is RunEnd.QUIET and plan.end is None
    bye = nodes[KERNEL].handle(Stop(Tag(reached + 1) if ended else core.end))
    if not isinstance(bye, Bye):
        raise ModelError(getattr(bye, "sentence", f"{KERNEL} answered STOP with {bye!r}"))
    waiting = [said for model in models.values() if (said := str(getattr(model, "waiting_for", str)()))]
    if waiting and plan.end is None and outcome is not RunEnd.FINISHED:
        raise ModelError(waiting[0])
    cpu, wall = time.thread_time() - started, time.perf_counter() - prepared
    times, rows = kernel.table()
    return Played(
        plan,
        kernel.mechanics,
        msgspec.convert(msgspec.msgpack.decode(kernel.layout()), SampleLayout),
        times,
        rows,
        events,
        rigs,
        kernel.of_lifts,
        kernel.told,
        max(times[-1].item(), events[-1].t if events else 0),
        "; ".join(waiting),
        kernel.looks.finish(),
        core.grants,
        prepared - began,
        started - start,
        wall,
        cpu,
        errors or {},
    )
