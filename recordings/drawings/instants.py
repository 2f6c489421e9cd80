"""The key instants of a lift, and the world positions [m] of solids, ropes, hooks and lugs at each of them.

Key instants are the ends of stages in which something has moved (a limited number, evenly chosen), the instant of the
verdict's highest utilisation, and the instant of the smallest clearance.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np
from heavylift.recordings.format import machines
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.spellings import BEAMS
from heavylift.recordings.format.viewer_messages import DrawnBox, RopeLine, corners, turned
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import Clearance, RecordedVerdict
from numpy.typing import NDArray

MOST = 5  # ends of stages
MOVED = 0.5  # [m] a body since the last one that is drawn
ANCHOR = 0.05  # [m] marks of joints in the world are no larger
WORLD = "world"
Floats = NDArray[np.float64]


Kind = Literal["block", "deck", "hook", "frame", "crane", "world"]


class DrawnSolid(NamedTuple):
    """A solid in a drawing: its kind, its body, and its corners (8, 3) [m]."""

    kind: Kind
    body: str
    corners: Floats


class DrawnLine(NamedTuple):
    """A straight part of a rope in a drawing, with its tension [N]; `sling`: whether the rope is a sling."""

    rope: str
    a: Floats
    b: Floats
    tension: float
    sling: bool


class DrawnHook(NamedTuple):
    """A hook block in a drawing: position of its eye, and the slewing axis of its crane (None if it does not slew)."""

    rope: str
    eye: Floats
    axis: Floats | None


class DrawnInstant(NamedTuple):
    """Everything drawn of one instant of a run: time [s], solids, ropes, hooks, and the block's mass [kg].

    Also the smallest clearance of the run, if it occurs at this instant.
    """

    title: str
    t: float
    solids: list[DrawnSolid]
    lines: list[DrawnLine]
    hooks: list[DrawnHook]
    lugs: dict[str, Floats]
    com: Floats | None
    mass: float
    near: Clearance | None
    afloat: bool

    def of(self, *kinds: str) -> Floats:
        """Return the corners (n, 3) [m] of all drawn solids of the given kinds, such as "crane"."""
        return np.concatenate([np.zeros((0, 3)), *(x.corners for x in self.solids if x.kind in kinds)])


def instants_of(rec: Recording, verdict: RecordedVerdict | None) -> list[DrawnInstant]:
    """Return the key instants of a recording with the positions of all drawn objects; empty if no load is suspended."""
    plan = msgspec.json.decode(rec.attachments.get("resolved.json", b"{}"))
    if not _hooks(plan) or "/poses" not in rec.topics:
        return []
    wanted = _wanted(rec, verdict)
    if not wanted:
        return []
    total = rec.topics["/poses"].messages
    coarse = rec.picked([x for x in rec.signals() if x.startswith(POSE)][:1], np.arange(total))
    times = next(iter(coarse.values())).t
    numbers = [int(np.argmin(np.abs(times - t))) for t, _, _ in wanted]
    names = [x for x in rec.signals() if x.startswith(POSE)]
    poses = rec.picked(names, np.unique(numbers))
    frames = [
        _instant(rec, plan, title, float(times[k]), {x: poses[x].at(times[[k]]).values[0] for x in names}, at)
        for k, (_, title, at) in zip(numbers, wanted, strict=True)
    ]
    return _thinned(frames)


def _hooks(plan: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the hooks on bodies that are known."""
    return [hook for machine in plan.get("machines", []) for hook in machine.get("hooks", []) if "eye" in hook]


def _wanted(rec: Recording, verdict: RecordedVerdict | None) -> list[tuple[float, str, Clearance | None]]:
    """Return (time [s], caption, smallest clearance or None) for each key instant."""
    stages = rec.stages()
    end = rec.fact("sim_s", 0.0)
    found: list[tuple[float, str, Clearance | None]] = [
        (b, f"end of '{name}'", None) for (a, name), (b, _) in pairwise([*stages, (end, "")]) if b > a
    ]
    checks = verdict.checks if verdict else ()
    uses = [x for x in checks if x.t is not None and x.use is not None and x.quantity != "clearance" and not x.between]
    if most := max(uses, key=lambda x: (x.load, x.use or 0.0), default=None):
        found.append(
            (most.t or 0.0, f"largest use: {most.quantity} of {most.subject}, {100.0 * (most.use or 0):.0f} %", None)
        )
    if verdict and verdict.clearances:
        near = verdict.clearances[0]
        found.append((near.t, f"smallest clearance: {near.a} and {near.b}, {near.distance:.2f} m", near))
    return sorted(found, key=lambda x: x[:2])


def _thinned(frames: Sequence[DrawnInstant]) -> list[DrawnInstant]:
    """Return a limited number of instants, without ends of stages in which nothing has moved."""
    ends = list[DrawnInstant]()
    for x in (x for x in frames if x.title.startswith("end of")):
        if not ends or _moved(ends[-1], x) > MOVED:
            ends.append(x)
    kept = {round(k) for k in np.linspace(0, len(ends) - 1, min(MOST, len(ends)))} if ends else set()
    chosen = [x for k, x in enumerate(ends) if k in kept]
    return sorted([*chosen, *(x for x in frames if not x.title.startswith("end of"))], key=lambda x: x.t)


def _moved(a: DrawnInstant, b: DrawnInstant) -> float:
    return max((float(np.abs(x.corners - y.corners).max()) for x, y in zip(a.solids, b.solids, strict=True)), default=0)


def _instant(
    rec: Recording, plan: dict[str, Any], title: str, t: float, poses: dict[str, Floats], near: Clearance | None
) -> DrawnInstant:
    rig = next((rig for rig in reversed(rec.rigs()) if rig.t_ns * 1e-9 <= t + 1e-9), None)
    tension = rec.signal("rope/tension").at(np.array([t])) if "rope/tension" in rec.signals() else None
    lines = rig.lines if rig else []
    tensions = {x.rope: _value(tension, x.rope) for x in lines}
    places = {name.removeprefix(POSE): x for name, x in poses.items()}
    return instant(plan, title, t, rec.boxes(), places, lines, tensions, rec.fact(BEAMS, {}), near)


def instant(
    plan: dict[str, Any],
    title: str,
    t: float,
    boxes: Sequence[DrawnBox],
    poses: Mapping[str, Floats],
    rig: Sequence[RopeLine],
    tensions: Mapping[str, float],
    hanging: Collection[str],
    near: Clearance | None = None,
) -> DrawnInstant:
    """Return everything drawn of one instant, from the plan as plain data and the poses (7,) of its bodies.

    `hanging`: machines that hang on the hooks of other machines.
    """

    def world(body: str, p: object) -> Floats:
        pose, point = poses.get(body), np.asarray(p, np.float64)
        return point if pose is None else turned(pose[3:], point) + pose[:3]

    every = plan.get("machines", [])
    cargo = {x["body"]: x for machine in every for x in machine.get("cargo", [])}
    hooks = _hooks(plan)
    slings = {tie["rope"] for tie in machines.ties(plan)}
    eyes = {hook["eye"]["body"] for hook in hooks}
    hung = {x["name"] for machine in every if machine["name"] in hanging for x in machine["system"]["bodies"]}
    frames = (hung | {tie["upper"]["body"] for tie in machines.ties(plan)}) - eyes

    def kind(box: DrawnBox) -> Kind:
        body = box.body
        if body in cargo:
            size = cargo[body].get("size", box.size)
            return "deck" if box.size[0] > size[0] and box.size[2] < size[2] else "block"
        return "world" if body == WORLD else "hook" if body in eyes else "frame" if body in frames else "crane"

    drawn = (box for box in boxes if box.body != WORLD or max(box.size) > ANCHOR)
    solids = [DrawnSolid(kind(box), box.body, world(box.body, corners(box))) for box in drawn]
    lines = [
        DrawnLine(x.rope, world(x.a_body, x.a), world(x.b_body, x.b), tensions.get(x.rope, 0.0), x.rope in slings)
        for x in rig
    ]
    found = [
        DrawnHook(hook["rope"], world(hook["eye"]["body"], hook["eye"].get("p", (0, 0, 0))),
             world(hook["axis"]["body"], hook["axis"].get("p", (0, 0, 0))) if hook.get("axis") else None)
        for hook in hooks
    ]  # fmt: skip
    lugs = {name: world(body, p) for body, x in cargo.items() for name, p in x.get("lugs", {}).items()}
    com = next((world(body, x.get("com", (0, 0, 0))) for body, x in cargo.items()), None)
    afloat = any(shape.get("part") == "hull" for machine in every for shape in machine.get("shapes", []))
    mass = sum(float(x.get("mass", 0.0)) for x in cargo.values())
    return DrawnInstant(title, t, solids, lines, found, lugs, com, mass, near, afloat)


def _value(signal: Any, name: str) -> float:
    return float(signal.values[0, signal.names.index(name)]) if signal is not None and name in signal.names else 0.0
