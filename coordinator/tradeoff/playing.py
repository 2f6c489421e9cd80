"""One run of a plan in this process, on one core and without a recording: what it shows, and what it costs.

Equations are generated and compiled before the clock starts.  A run that takes longer than it may is cut; that it was,
and whatever else ends it early, is a HeavyliftError with its sentence.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.pause import configured
from heavylift.coordinator.record.energy import EnergyAudit
from heavylift.coordinator.run import in_memory
from heavylift.nodes.fidelity.lifts import lift_of
from heavylift.nodes.models import build
from heavylift.nodes.plan.actions import Lifted, Move, Wait
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import SampleLayout

WHOLE = "the whole run"


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
    """A run: what it showed, seconds before it (of CPU time `start_s`) and in it, messages (events, GRANTs and DONEs)
    between its models and the kernel, energy that has come out of nothing relative to what was turned over, the largest
    violation of a rigid rope [m], None without one, and what the kernel had to say."""

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


def prepared(plan: Plan) -> float:
    """Seconds of CPU time until a plan could run, machine code kept from before."""
    start = time.thread_time()
    KernelNode(configured(plan, build(plan)), lambda batch: None)
    return time.thread_time() - start


def play(plan: Plan, limit: float) -> Played:
    """Run a plan to its end within `limit` seconds of wall time; raises HeavyliftError."""
    run = in_memory.play(plan, limit)
    audit = EnergyAudit(run.layout)
    audit.add(run.rows)
    return Played(
        _shown(plan, run.layout, run.t, run.rows, run.conduct.stages, run.end_ns * 1e-9),
        simulated_s=run.end_ns * 1e-9,
        prepared_s=run.prepared_s,
        start_s=run.start_s,
        wall_s=run.wall_s,
        cpu_s=run.cpu_s,
        messages=len(run.events) + 2 * run.grants,
        energy=audit.error,
        drift=_drift(run.layout, run.rows),
        notes=tuple(sentence for _, sentence in run.notes),
    )


def _drift(layout: SampleLayout, rows: np.ndarray) -> float | None:
    """Most by which a rigid rope that pulls is longer than it is [m]."""
    slack, tension = layout.find("rigid/slack"), layout.find("rope/tension")
    if slack is None or tension is None:
        return None
    pulls = [tension.start + tension.names.index(name) for name in slack.names]
    return float(np.where(rows[:, pulls] > 0.0, -rows[:, slack.start : slack.stop], 0.0).max(initial=0.0))


def _shown(
    plan: Plan, layout: SampleLayout, t: np.ndarray, rows: np.ndarray, stages: list[tuple[float, int, str]], last: float
) -> Shown:
    tension, peak = layout.find("rope/tension"), layout.find("rope/peak")
    names = list(tension.names) if tension else []
    ropes = [r.name for r in lift_of(plan).rig.hook_ropes] if lift_of(plan).lift else names
    picks = [names.index(r) for r in ropes]
    channel = layout.find(f"pose/{lift_of(plan).block.name}" if lift_of(plan).block else "joint/position")
    columns = [] if channel is None else list(channel.names[:3] if lift_of(plan).block else channel.names)
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


def spans(plan: Plan, stages: list[tuple[float, int, str]], last: float) -> list[Span]:
    """One for each action; the whole run where there are none."""
    if not stages:
        return [Span(WHOLE, 0.0, last, True, False)]
    ends = [t for t, _, _ in stages[1:]] + [last]
    out = []
    for (t, index, name), end in zip(stages, ends, strict=True):
        orders = plan.actions[index].orders
        free = all(isinstance(order, Wait) for order in orders)
        lifts = any(isinstance(order, Move) and isinstance(order.until, Lifted) for order in orders)
        out.append(Span(name or f"action {index + 1}", t, end, free, lifts))
    return out
