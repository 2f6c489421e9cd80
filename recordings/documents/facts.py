"""What a planner asks of a run, computed from its recording alone: samples, rope lines, stages and the resolved scene.

Use is peak tension over rated tension.  A crane's load is the sum of its hook tensions over gravity, less the hook
blocks, which belong to the crane.  The dynamic factor of a stage is the largest sum of a crane's hook tensions over the
larger one of the sums at rest before and at the end of the stage.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format import machines
from heavylift.recordings.format.samples import REEVING, reeved
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import Signal
from heavylift.recordings.read.verdict import Judged, recorded_peaks, recorded_verdict
from numpy.typing import NDArray

from .loads import Borne, Loads, SlingUse, loads_of
from .scene import block_table, scene_table

EMPTY = 1.1  # times what always hangs on its hooks: with less a crane carries nothing
SETTLED = 0.05  # last part of a stage over which its resting load is taken
Floats = NDArray[np.float64]


class RopeUse(NamedTuple):
    """Peak [N] and when [s], in which stage; rated [N] or None."""

    name: str
    peak: float
    when: float
    stage: str
    rated: float | None


class LoadUse(NamedTuple):
    """Largest load of a hook or crane [kg], when [s], and the load that it may carry [kg]."""

    name: str
    load: float
    when: float
    capacity: float


class StageUse(NamedTuple):
    """A stage from when to when [s]; the rope that is used most, its use; per crane the dynamic factor; of the block,
    if there is one, the lowest point [m], least and largest tilt [rad], and the centre of mass at the end [m]."""

    name: str
    start: float
    end: float
    rope: str
    use: float
    dynamic: dict[str, float]
    lowest: float | None = None
    tilt: tuple[float, float] | None = None
    com: tuple[float, float, float] | None = None


class Excess(NamedTuple):
    """Something that went beyond what it should: when [s], who, what."""

    when: float
    who: str
    what: str


@dataclass(frozen=True)
class Facts:
    """All tables of the document."""

    stages: list[StageUse]
    ropes: list[RopeUse]
    cranes: list[LoadUse]
    warnings: list[Excess]
    hooks: list[LoadUse]
    scene: list[tuple[str, str]]
    lifted: float  # mass of the block, else the largest load of a crane [kg]
    notes: list[tuple[float, str]]  # when [s], what the kernel had to say
    block: list[tuple[str, str]]
    slings: list[SlingUse]
    lugs: list[Borne]
    stools: list[Borne]
    portals: list[Borne]


def facts(rec: Recording, verdict: Judged | None = None) -> Facts:
    """The tables of a recording; whatever it has no samples of stays empty.  `verdict`: else the recorded one."""
    with rec.reading():
        if "model" in rec.run:
            raise RecordingError(
                f"{rec.path}: a DEVS model lifts nothing to report; `heavylift info` tells its results"
            )
        plan = machines.plan_of(rec.attachments)
        borne = loads_of(rec, plan)  # the first, for its pass through the file reads tensions, too
        tension = _tensions(rec)
        rated: dict[str, float] = rec.fact("rated", {})
        spans = _stages(rec, tension.t[-1] if len(tension.t) else 0.0)
        given = machines.cranes(plan)
        hooks = {c.name: [tension.names.index(h.rope) for h in c.hooks if h.rope in tension.names] for c in given}
        loads = {crane: tension.values[:, columns].sum(axis=1) for crane, columns in hooks.items() if columns}
        ropes = []
        for name, peak in recorded_peaks(rec).items():
            stage = next((s for s, a, b in spans if a <= peak.time <= b), "")
            ropes.append(RopeUse(name, peak.tension, peak.time, stage, rated.get(name)))
        gravity = float(plan.get("gravity", 9.80665))
        able = [crane for crane in given if crane.name in loads and len(tension.t) and crane.capacity]
        cranes = [_largest(x.name, tension.t, loads[x.name], gravity, x.hooks, x.capacity) for x in able]
        if len(cranes) > 1:
            every, total = [h for c in able for h in c.hooks], np.sum([loads[c.name] for c in cranes], axis=0)
            cranes.append(_largest("all together", tension.t, total, gravity, every, sum(c.capacity for c in cranes)))
        dead = {c.name: sum(hook.dead for hook in c.hooks) * gravity for c in given}
        stages = [_of_block(_stage(span, tension, rated, loads, dead), borne) for span in spans]
        found = _warnings(rec, ropes, cranes, verdict or recorded_verdict(rec))
        tables = stages, ropes, cranes, found, _hook_uses(plan, tension, gravity)
        lifted = machines.block(plan).get("mass") or max((c.load for c in cranes), default=0.0)
        told = scene_table(rec, plan), float(lifted), rec.notes(), block_table(plan)
        return Facts(*tables, *told, borne.slings, borne.lugs, borne.stools, borne.portals)


def _tensions(rec: Recording) -> Signal:
    """The tension of every rope; over sheaves that of its most loaded part."""
    signals = [rec.signal(name) for name in ("rope/tension", REEVING) if name in rec.signals()]
    found: dict[str, Floats] = {}
    for signal in signals:
        for i, column in enumerate(signal.names):
            name, x = reeved(column) if signal.name == REEVING else column, signal.values[:, i]
            found[name] = np.maximum(found[name], x) if name in found else x
    t = signals[0].t if signals else np.zeros(0)
    return Signal(t, np.column_stack([*found.values()]) if found else np.zeros((len(t), 0)), [*found], "N")


def _hook_uses(plan: dict[str, Any], tension: Signal, gravity: float) -> list[LoadUse]:
    """The load below each hook block."""
    found = []
    for hook in (hook for crane in machines.cranes(plan) for hook in crane.hooks if hook.capacity):
        if hook.rope in tension.names and len(tension.t):
            name, pull = hook.rope.replace(".", " ", 1), tension.values[:, tension.names.index(hook.rope)]
            found.append(_largest(name, tension.t, pull, gravity, [hook], hook.capacity))
    return found


def _largest(
    name: str, t: Floats, pull: Floats, gravity: float, hooks: list[machines.Hook], capacity: float
) -> LoadUse:
    """The largest load below some hook blocks, of what their ropes pull together (n,) [N]."""
    k = int(np.argmax(pull))
    load = float(pull[k]) / gravity - sum(hook.block_mass for hook in hooks)
    return LoadUse(name, load, float(t[k]), float(capacity))


def _of_block(stage: StageUse, borne: Loads) -> StageUse:
    """The same with what the block did in it."""
    inside = (borne.t >= stage.start) & (borne.t <= stage.end)
    if not inside.any():
        return stage
    tilt, com = borne.tilt[inside], borne.com[inside][-1]
    x, y, z = map(float, com)
    return stage._replace(
        lowest=float(borne.lowest[inside].min()), tilt=(float(tilt.min()), float(tilt.max())), com=(x, y, z)
    )


def _stages(rec: Recording, end: float) -> list[tuple[str, float, float]]:
    said = [*((name, t) for t, name in rec.stages()), ("", end)]
    return [(name, start, stop) for (name, start), (_, stop) in pairwise(said)]


def _stage(
    span: tuple[str, float, float],
    tension: Signal,
    rated: dict[str, float],
    loads: dict[str, Floats],
    dead: dict[str, float],
) -> StageUse:
    """What a stage asked for; a crane whose hooks are empty has no dynamic factor."""
    name, start, end = span
    inside = (tension.t >= start) & (tension.t <= end)
    uses = {r: float(np.max(tension.values[inside, tension.names.index(r)], initial=0.0)) / x for r, x in rated.items()}
    rope = max(uses, key=lambda r: uses[r], default="")
    late = inside & (tension.t >= end - SETTLED * (end - start))
    dynamic = {}
    for crane, load in loads.items():
        if late.any():
            rest = max(float(load[inside][0]), float(np.mean(load[late])))
            if rest > EMPTY * dead.get(crane, 0.0):
                dynamic[crane] = float(np.max(load[inside])) / rest if rest > 0.0 else 1.0
    return StageUse(name, start, end, rope, uses.get(rope, 0.0), dynamic)


def _warnings(rec: Recording, ropes: list[RopeUse], cranes: list[LoadUse], verdict: Judged | None) -> list[Excess]:
    """What went beyond its limits: as it was judged, else as peaks and samples alone tell."""
    if verdict is not None:
        return [Excess(f.t or 0.0, f.subject, f.sentence) for f in verdict.findings if f.severity != "note"]
    found = []
    for r in ropes:
        if r.rated and r.peak > r.rated:
            found.append(Excess(r.when, r.name, f"tension {100 * r.peak / r.rated:.0f} % of the rated one"))
    for c in cranes:
        if c.load > c.capacity:
            found.append(Excess(c.when, c.name, f"{100 * c.load / c.capacity:.0f} % of the load that it may carry"))
    return sorted(found)
