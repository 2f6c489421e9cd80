"""One run of a plan in this process, on one core and without a recording: what it shows, and what it costs.

Equations are generated and compiled before the clock starts.  A run that takes longer than it may is cut; that it was,
and whatever else ends it early, is a HeavyliftError with its sentence.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import msgspec
import numpy as np
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.pause import configured
from heavylift.coordinator.protocol.core import Coordinator
from heavylift.coordinator.protocol.memory import run_in_memory
from heavylift.coordinator.protocol.messages import Grant
from heavylift.coordinator.protocol.node import Node
from heavylift.coordinator.record.energy import EnergyAudit
from heavylift.kernel.errors import KernelError, ModelError
from heavylift.nodes.devs import Event, Simulator, Tag, ns
from heavylift.nodes.models import COMMANDER, KERNEL, build, couplings
from heavylift.nodes.models.parts.messages import Finished, Stage
from heavylift.nodes.plan.actions import Lifted, Move, Wait
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.samples import decode_batch

__all__ = ["CUT", "Played", "Shown", "Span", "play", "prepared", "spans"]

LAST = Tag(4 * 3600 * 10**9)  # simulated time of a scene without an end
WHOLE = "the whole run"
CUT = "cut after"


@dataclass(frozen=True)
class Span:
    """A stage: when it begins and ends [s]; whether the load is left to itself in it, and whether it takes off."""

    name: str
    start: float
    end: float
    free: bool
    lifts: bool


@dataclass(frozen=True)
class Shown:
    """What runs are compared in: samples at `t` (n,) [s] of tensions (n, ropes) [N] and of places (n, columns), with
    the peak of each rope; places are those of the block [m], or coordinates of a mechanism's joints."""

    spans: list[Span]
    t: np.ndarray
    ropes: list[str]
    tension: np.ndarray
    peaks: np.ndarray
    places: np.ndarray
    columns: list[str]


@dataclass(frozen=True)
class Played:
    """A run: what it showed, seconds before it (of CPU time `start_s`) and in it, messages (events, GRANTs and DONEs),
    energy that has come out of nothing relative to what was turned over, the largest violation of a rigid rope [m],
    None without one, and what the kernel had to say."""

    shown: Shown
    simulated_s: float
    prepared_s: float
    start_s: float
    wall_s: float
    cpu_s: float
    messages: int
    energy: float
    drift: float | None
    notes: tuple[str, ...] = ()


class _Limited(KernelNode):
    """A kernel whose run is over at an instant of the clock."""

    deadline = 0.0
    allowed = 0.0

    def _pause(self) -> None:
        super()._pause()
        if time.perf_counter() > self.deadline:
            raise KernelError(f"{CUT} {self.allowed:.3g} s of wall time, at {self.simulation.now:.3f} s of the run")


class _Counting(Coordinator):
    """Counts grants."""

    grants = 0

    def ready(self, horizon: Tag | None = None) -> list[tuple[str, Grant]]:
        """As the coordinator's."""
        granted = super().ready() if horizon is None else super().ready(horizon)
        self.grants += len(granted)
        return granted


def prepared(plan: Plan) -> float:
    """Seconds of CPU time until a plan could run, machine code kept from before."""
    start = time.process_time()
    KernelNode(configured(plan, build(plan)), list[bytes]().append)
    return time.process_time() - start


def play(plan: Plan, limit: float) -> Played:
    """Run a plan to its end within `limit` seconds of wall time; raises HeavyliftError."""
    began, start = time.perf_counter(), time.process_time()
    models, batches = build(plan), list[bytes]()
    kernel = _Limited(configured(plan, models), batches.append)
    heard = _Heard()
    end = Tag(ns(plan.end)) if plan.end else LAST
    most = plan.microsteps
    core = _Counting([*models, KERNEL], couplings(plan), end, (COMMANDER, "finished"), heard, most)
    nodes = [*(Node(name, Simulator(m, microsteps=most)) for name, m in models.items()), Node(KERNEL, kernel)]
    ready = time.perf_counter()
    kernel.allowed, kernel.deadline = limit, ready + limit
    cpu_begins = time.process_time()
    run_in_memory(core, nodes)
    if heard.finished is None and not plan.end:
        raise ModelError(f"it has not come to its end after {LAST.t * 1e-9:g} s: an action waits for ever")
    last = heard.finished if heard.finished is not None else end.t - 1
    kernel.finish(Tag(last + 1))
    cpu, wall = time.process_time() - cpu_begins, time.perf_counter() - ready
    layout = msgspec.convert(msgspec.msgpack.decode(kernel.layout()), SampleLayout)
    t, rows = _table(layout, batches)
    audit = EnergyAudit(layout)
    audit.add(rows)
    return Played(
        _shown(plan, layout, t, rows, heard.stages, last * 1e-9),
        simulated_s=last * 1e-9,
        prepared_s=ready - began,
        start_s=cpu_begins - start,
        wall_s=wall,
        cpu_s=cpu,
        messages=heard.events + 2 * core.grants,
        energy=audit.error,
        drift=_drift(layout, rows),
        notes=tuple(note.sentence for note in kernel.simulation.notes),
    )


def _drift(layout: SampleLayout, rows: np.ndarray) -> float | None:
    """Most by which a rigid rope that pulls is longer than it is [m]."""
    slack, tension = layout.find("rigid/slack"), layout.find("rope/tension")
    if slack is None or tension is None:
        return None
    pulls = [tension.start + tension.names.index(name) for name in slack.names]
    return float(np.where(rows[:, pulls] > 0.0, -rows[:, slack.start : slack.stop], 0.0).max(initial=0.0))


class _Heard:
    """Stages as they begin, the end, the number of events."""

    def __init__(self) -> None:
        self.stages, self.events = list[tuple[int, int, str]](), 0
        self.finished: int | None = None

    def __call__(self, event: Event) -> None:
        self.events += 1
        if event.source == COMMANDER and isinstance(event.value, Stage):
            self.stages.append((event.t, event.value.action, event.value.name))
        elif event.source == COMMANDER and isinstance(event.value, Finished):
            self.finished = event.t


def _table(layout: SampleLayout, batches: list[bytes]) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and rows (n, width)."""
    decoded = [decode_batch(batch, layout.width) for batch in batches]
    times = np.array([t for batch in decoded for t in batch.times]) * 1e-9
    return times, np.concatenate([batch.rows for batch in decoded])


def _shown(
    plan: Plan, layout: SampleLayout, t: np.ndarray, rows: np.ndarray, stages: list[tuple[int, int, str]], last: float
) -> Shown:
    tension, peak = layout.find("rope/tension"), layout.find("rope/peak")
    names = list(tension.names) if tension else []
    ropes = [r.name for r in plan.rig.hook_ropes] if plan.block else names
    picks = [names.index(r) for r in ropes]
    channel = layout.find(f"pose/{plan.block.name}" if plan.block else "joint/position")
    columns = [] if channel is None else list(channel.names[:3] if plan.block else channel.names)
    at = channel.start if channel else 0
    empty = np.zeros((len(t), 0))
    return Shown(
        spans(plan, stages, last),
        t,
        ropes,
        rows[:, [tension.start + i for i in picks]] if tension else empty,
        rows[:, [peak.start + i for i in picks]].max(axis=0) if peak else np.zeros(0),
        rows[:, at : at + len(columns)],
        columns,
    )


def spans(plan: Plan, stages: list[tuple[int, int, str]], last: float) -> list[Span]:
    """One for each action; the whole run where there are none."""
    if not stages:
        return [Span(WHOLE, 0.0, last, True, False)]
    ends = [t * 1e-9 for t, _, _ in stages[1:]] + [last]
    out = []
    for (t, index, name), end in zip(stages, ends, strict=True):
        orders = plan.actions[index].orders
        free = all(isinstance(order, Wait) for order in orders)
        lifts = any(isinstance(order, Move) and isinstance(order.until, Lifted) for order in orders)
        out.append(Span(name or f"action {index + 1}", t * 1e-9, end, free, lifts))
    return out
