"""What a planner asks of a run, computed from its recording alone: samples, rope lines, stages and the resolved scene.

Use is peak tension over rated tension.  Off-lead is the largest angle of a rope's line against the vertical while it
carries.  A crane's load is the sum of its hook tensions over gravity, less the hook blocks, which belong to the crane.
The dynamic factor of a stage is the largest sum of a crane's hook tensions over the larger one of the sums at rest
before and at the end of the stage.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..reader import Recording, guarded
from ..samples import POSE
from ..signal import Signal
from .clearances import Clearance, clearances, lowest
from .scene import scene_table

__all__ = ["CraneUse", "Excess", "Facts", "RopeUse", "StageUse", "facts"]

OFF_LEAD = np.radians(3.0)  # beyond this a rope is flagged
SETTLED = 0.05  # last part of a stage over which its resting load is taken
CARRIES = 0.02  # of the rated tension, below which a rope's direction says nothing
FAULTS = ("Overload", "Limit", "Refused")  # reports that a planner must see
Floats = NDArray[np.float64]


class RopeUse(NamedTuple):
    """Peak [N] and when [s], in which stage; rated [N] or None; largest off-lead [rad] or None and when [s]; breaking
    force over peak, or None."""

    name: str
    peak: float
    when: float
    stage: str
    rated: float | None
    off_lead: float | None
    off_lead_when: float
    safety: float | None = None


class HookUse(NamedTuple):
    """Largest load of a hook [kg], when [s], and the load that it may carry [kg]."""

    name: str
    load: float
    when: float
    capacity: float


class CraneUse(NamedTuple):
    """Largest load of a crane [kg], when [s], and the load that it may carry [kg]."""

    name: str
    load: float
    when: float
    capacity: float


class StageUse(NamedTuple):
    """A stage from when to when [s]; the rope that is used most, its use; per crane the dynamic factor; the lowest
    point of the block [m] or None."""

    name: str
    start: float
    end: float
    rope: str
    use: float
    dynamic: dict[str, float]
    lowest: float | None = None


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
    cranes: list[CraneUse]
    warnings: list[Excess]
    hooks: list[HookUse]
    clearances: list[Clearance]
    scene: list[tuple[str, str]]
    lifted: float  # mass of the block, else the largest load of a crane [kg]
    notes: list[tuple[float, str]]  # when [s], what the kernel had to say


@guarded
def facts(rec: Recording) -> Facts:
    """The tables of a recording; whatever it has no samples of stays empty."""
    plan = _plan(rec)
    empty = Signal(np.zeros(0), np.zeros((0, 0)), [], "N")
    tension = rec.signal("rope/tension") if "rope/tension" in rec.signals() else empty
    rated: dict[str, float] = rec.fact("rated", {})
    factors: dict[str, float] = rec.fact("design_factors", {})
    spans = _stages(rec, tension.t[-1] if len(tension.t) else 0.0)
    hooks = {c["name"]: _hooks(plan, c["name"], tension.names) for c in plan.get("cranes", [])}
    loads = {crane: tension.values[:, columns].sum(axis=1) for crane, columns in hooks.items() if columns}
    leads = _off_leads(rec, tension, rated)
    ropes = []
    for name, peak in rec.fact("peaks", {}).items():
        angle, when = leads.get(name, (None, 0.0))
        stage = next((s for s, a, b in spans if a <= peak["time"] <= b), "")
        breaking = rated.get(name, 0.0) * factors.get(name, 0.0)
        safety = breaking / peak["tension"] if breaking and peak["tension"] else None
        ropes.append(RopeUse(name, peak["tension"], peak["time"], stage, rated.get(name), angle, when, safety))
    gravity = float(plan.get("gravity", 9.80665))
    cranes = []
    for crane in plan.get("cranes", []):
        if crane["name"] in loads and len(tension.t):
            k = int(np.argmax(loads[crane["name"]]))
            load = float(loads[crane["name"]][k]) / gravity - sum(h["block_mass"] for h in crane["hooks"])
            cranes.append(CraneUse(crane["name"], load, float(tension.t[k]), float(crane["capacity"])))
    if len(cranes) > 1:
        cranes.append(_together(plan, loads, tension, cranes, gravity))
    heights = lowest(rec, plan)
    stages = [_stage(span, tension, rated, loads)._replace(lowest=_lowest(span, heights)) for span in spans]
    tables = stages, ropes, cranes, _warnings(rec, ropes, cranes), _hook_uses(plan, tension, gravity)
    lifted = plan["block"]["body"]["mass"] if plan.get("block") else max((c.load for c in cranes), default=0.0)
    return Facts(*tables, clearances(rec, plan), scene_table(rec, plan), float(lifted), rec.notes())


def _hook_uses(plan: dict[str, Any], tension: Signal, gravity: float) -> list[HookUse]:
    """The load below each hook block."""
    found = []
    for crane in plan.get("cranes", []):
        for hook in crane["hooks"]:
            if hook.get("rope") in tension.names and len(tension.t):
                T = tension.values[:, tension.names.index(hook["rope"])]
                k = int(np.argmax(T))
                load = float(T[k]) / gravity - hook["block_mass"]
                found.append(HookUse(f"{crane['name']} {hook['name']}", load, float(tension.t[k]), hook["capacity"]))
    return found


def _together(
    plan: dict[str, Any], loads: dict[str, Floats], tension: Signal, cranes: list[CraneUse], gravity: float
) -> CraneUse:
    """All cranes as one."""
    total = np.sum([loads[c.name] for c in cranes], axis=0)
    k = int(np.argmax(total))
    blocks = sum(h["block_mass"] for c in plan["cranes"] for h in c["hooks"])
    capacity = sum(c.capacity for c in cranes)
    return CraneUse("all together", float(total[k]) / gravity - blocks, float(tension.t[k]), capacity)


def _lowest(span: tuple[str, float, float], heights: tuple[Floats, Floats]) -> float | None:
    t, z = heights
    inside = (t >= span[1]) & (t <= span[2])
    return float(z[inside].min()) if inside.any() else None


def _plan(rec: Recording) -> dict[str, Any]:
    text = rec.attachments.get("resolved.json")
    found: dict[str, Any] = msgspec.json.decode(text) if text else {}
    return found


def _stages(rec: Recording, end: float) -> list[tuple[str, float, float]]:
    said = [*((name, t) for t, name in rec.stages()), ("", end)]
    return [(name, start, stop) for (name, start), (_, stop) in pairwise(said)]


def _hooks(plan: dict[str, Any], crane: str, names: list[str]) -> list[int]:
    ropes = plan.get("rig", {}).get("hook_ropes", [])
    return [names.index(r["name"]) for r in ropes if r["crane"] == crane and r["name"] in names]


def _stage(
    span: tuple[str, float, float], tension: Signal, rated: dict[str, float], loads: dict[str, Floats]
) -> StageUse:
    name, start, end = span
    inside = (tension.t >= start) & (tension.t <= end)
    uses = {r: float(np.max(tension.values[inside, tension.names.index(r)], initial=0.0)) / x for r, x in rated.items()}
    rope = max(uses, key=lambda r: uses[r], default="")
    late = inside & (tension.t >= end - SETTLED * (end - start))
    dynamic = {}
    for crane, load in loads.items():
        if late.any():
            rest = max(float(load[inside][0]), float(np.mean(load[late])))
            dynamic[crane] = float(np.max(load[inside])) / rest if rest > 0.0 else 1.0
    return StageUse(name, start, end, rope, uses.get(rope, 0.0), dynamic)


def _off_leads(rec: Recording, tension: Signal, rated: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Largest angle against the vertical of each rope's lines while it carries [rad], and when [s]."""
    poses = {name.removeprefix(POSE): rec.signal(name).values for name in rec.signals() if name.startswith(POSE)}
    out: dict[str, tuple[float, float]] = {}
    rigs = rec.rigs()
    for i, rig in enumerate(rigs):
        end = rigs[i + 1].t_ns * 1e-9 if i + 1 < len(rigs) else np.inf
        inside = (tension.t >= rig.t_ns * 1e-9) & (tension.t < end)
        for line in rig.lines:
            if line.rope not in tension.names or not inside.any():
                continue
            T = tension.values[inside, tension.names.index(line.rope)]
            ends = (_points(poses, line.a_body, line.a, inside), _points(poses, line.b_body, line.b, inside))
            d = ends[1] - ends[0]
            angle = np.arctan2(np.hypot(d[:, 0], d[:, 1]), np.abs(d[:, 2]))
            angle[CARRIES * rated.get(line.rope, 0.0) > T] = 0.0
            k = int(np.argmax(angle))
            if angle[k] >= out.get(line.rope, (0.0, 0.0))[0]:
                out[line.rope] = float(angle[k]), float(tension.t[inside][k])
    return out


def _points(poses: dict[str, Floats], body: str, p: tuple[float, float, float], inside: NDArray[np.bool_]) -> Floats:
    """(n, 3) places of a point of a body in the world."""
    if body not in poses:
        return np.tile(np.array(p), (int(inside.sum()), 1))
    pose = poses[body][inside]
    u, w, x = pose[:, 3:6], pose[:, 6:], np.array(p)
    place: Floats = pose[:, :3] + x + 2.0 * np.cross(u, np.cross(u, x) + w * x)
    return place


def _warnings(rec: Recording, ropes: list[RopeUse], cranes: list[CraneUse]) -> list[Excess]:
    found = [
        Excess(e.t_ns * 1e-9, e.source, f"{e.type} {msgspec.json.encode(e.value).decode()}")
        for e in rec.events(port="report")
        if e.type in FAULTS
    ]
    for r in ropes:
        if r.rated and r.peak > r.rated:
            found.append(Excess(r.when, r.name, f"tension {100 * r.peak / r.rated:.0f} % of the rated one"))
        if r.off_lead is not None and r.off_lead > OFF_LEAD:
            angle = np.degrees(r.off_lead)
            found.append(Excess(r.off_lead_when, r.name, f"off-lead {angle:.1f} degrees, more than 3"))
    for c in cranes:
        if c.load > c.capacity:
            found.append(Excess(c.when, c.name, f"{100 * c.load / c.capacity:.0f} % of the load that it may carry"))
    return sorted(found)
