"""What block, slings, lugs and supports bore, sample by sample, from a recording alone.

Tensions are the peaks since the sample before, where they are recorded; directions are those at the sample.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from heavylift.recordings.format import machines
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.viewer_messages import Rig, RopeLine, corners, turned
from heavylift.recordings.read.reader import Recording
from numpy.typing import NDArray

CARRIES = 0.1  # of its largest tension: with less the angle of a sling matters to nobody
Floats = NDArray[np.float64]


class Borne(NamedTuple):
    """The largest force [N] on something at a place [m], its time [s], and components [N] or None."""

    name: str
    place: tuple[float, float, float] | None
    force: float
    when: float
    parts: tuple[float, float, float] | None = None


class SlingUse(NamedTuple):
    """A sling: lugs, angle to the vertical [rad] at peak tension, and the largest angle while carrying."""

    name: str
    lugs: list[str]
    angle: float
    widest: float


class Loads(NamedTuple):
    """Loads of lugs (axes u, v, w of the block) and supports (world); slings; over time: t (n,) [s], tilt (n,) [rad],
    centre of mass (n, 3) and lowest point (n,) [m] of the block."""

    lugs: list[Borne]
    slings: list[SlingUse]
    supports: list[Borne]
    t: Floats
    tilt: Floats
    com: Floats
    lowest: Floats


class _Largest(dict[str, tuple[float, float, Floats]]):
    """Running maximum by name, with its time [s] and data at that time."""

    def see(self, name: str, t: Floats, values: Floats, beside: Floats) -> None:
        """Add values (n,) at times (n,), with data `beside` (n, k)."""
        k = int(np.argmax(values))
        if name not in self or values[k] > self[name][0]:
            self[name] = float(values[k]), float(t[k]), np.array(beside[k])


class _Stretch(NamedTuple):
    """Samples with constant rope lines: times [s], ropes, tensions and support forces by name, poses by signal."""

    t: Floats
    rig: Rig
    tension: dict[str, Floats]
    forces: dict[str, Floats]
    poses: dict[str, Floats]


def loads_of(rec: Recording, plan: dict[str, Any]) -> Loads:
    """All loads in one pass over the samples; empty for missing signals."""
    rigging, course = _Rigging(plan), _BlockMotion(rec, plan)
    pads = [s for s in rec.fact("supports", []) if POSE + s["body"] in rec.signals()]
    supports = _Largest()
    for x in _stretches(rec):
        course.see(x)
        rigging.see(x)
        for s in (s for s in pads if s["name"] in x.forces):
            supports.see(s["name"], x.t, x.forces[s["name"]], _end(s["body"], s["p"], x.poses))
        if pads and x.forces:
            supports.see("all together", x.t, np.sum([*x.forces.values()], axis=0), np.zeros((len(x.t), 0)))
    return Loads(rigging.lugs(), rigging.slings(), _placed(supports), *course.joined())


class _BlockMotion:
    """Where the block was."""

    def __init__(self, rec: Recording, plan: dict[str, Any]) -> None:
        block = machines.block(plan)
        body = str(block.get("body", ""))
        self._pose = POSE + body
        self._com = np.array(block.get("com", (0.0, 0.0, 0.0)))
        drawn = [corners(box) for box in rec.boxes() if body and box.body == body]
        self._points = np.concatenate(drawn) if drawn else self._com[None]
        self._parts = [(np.zeros(0), np.zeros(0), np.zeros((0, 3)), np.zeros(0))]

    def see(self, x: _Stretch) -> None:
        if self._pose in x.poses:
            p, q = x.poses[self._pose][:, :3], x.poses[self._pose][:, 3:]
            up = turned(q, np.broadcast_to([0.0, 0.0, 1.0], p.shape))[:, 2]
            low = (p[:, None] + turned(q[:, None], self._points))[:, :, 2].min(axis=1)
            self._parts.append((x.t, np.arccos(np.clip(up, -1.0, 1.0)), p + turned(q, self._com), low))

    def joined(self) -> tuple[Floats, Floats, Floats, Floats]:
        t, tilt, com, low = map(np.concatenate, zip(*self._parts, strict=True))
        return t, tilt, com, low


class _Rigging:
    """What slings and lugs bore."""

    def __init__(self, plan: dict[str, Any]) -> None:
        block = machines.block(plan)
        self._pose = POSE + str(block.get("body", ""))
        self._lugs = {tuple(p): name for name, p in block.get("lugs", {}).items()}
        self._hooked: dict[str, list[str]] = {tie["rope"]: [] for tie in machines.ties(plan)}
        self._angles: dict[str, list[tuple[Floats, Floats]]] = {name: [] for name in self._hooked}
        self._at_sling, self._at_lug = _Largest(), _Largest()

    def see(self, x: _Stretch) -> None:
        forces: dict[str, Floats] = {}
        for line in (line for line in x.rig.lines if line.rope in self._hooked and line.rope in x.tension):
            pull, T = _pull(line, x.poses), x.tension[line.rope]
            angle = np.arccos(np.clip(np.abs(pull[:, 2]), 0.0, 1.0))
            self._at_sling.see(line.rope, x.t, T, angle[:, None])
            self._angles[line.rope].append((T, angle))
            lug = self._lugs.get(line.b)
            if lug and self._pose in x.poses:
                known = self._hooked[line.rope]
                known += [lug] if lug not in known else []
                back = x.poses[self._pose][:, 3:] * [-1.0, -1.0, -1.0, 1.0]
                forces[lug] = forces.get(lug, 0.0) + T[:, None] * turned(back, pull)
        for lug, force in forces.items():
            self._at_lug.see(lug, x.t, np.linalg.norm(force, axis=1), force)

    def lugs(self) -> list[Borne]:
        places = {name: p for p, name in self._lugs.items()}
        return [Borne(lug, places[lug], f, t, _vector(x)) for lug, (f, t, x) in self._at_lug.items()]

    def slings(self) -> list[SlingUse]:
        carried = {name: found for name, found in self._at_sling.items() if found[0] > 0.0}
        return [
            SlingUse(name, self._hooked[name], float(x[0]), self._widest(name, f))
            for name, (f, _, x) in carried.items()
        ]

    def _widest(self, name: str, most: float) -> float:
        """Largest angle at which a sling carries."""
        return max(float(angle[CARRIES * most < T].max(initial=0.0)) for T, angle in self._angles[name])


def _placed(found: _Largest) -> list[Borne]:
    return [Borne(name, _vector(x), f, t) for name, (f, t, x) in found.items() if f > 0.0]


def _vector(x: Floats) -> tuple[float, float, float] | None:
    return (float(x[0]), float(x[1]), float(x[2])) if len(x) else None


def _stretches(rec: Recording) -> Iterator[_Stretch]:
    names = [x for x in ("rope/tension", "rope/peak", "support/force") if x in rec.signals() and rec.columns(x)]
    poses = [x for x in rec.signals() if x.startswith(POSE)]
    rigs = rec.rigs() or [Rig(0, [])]
    if not poses:
        return
    for times, values in rec.blocks([*names, *poses], keep=[x for x in names if x != "support/force"]):
        found = dict(zip([*names, *poses], values, strict=True))
        pulls = found.get("rope/tension", np.zeros((len(times), 0)))
        pulls = np.maximum(pulls, found.get("rope/peak", pulls))
        ropes = rec.columns("rope/tension") if "rope/tension" in found else []
        pads = rec.columns("support/force") if "support/force" in found else []
        cuts = np.searchsorted(times, [rig.t_ns for rig in rigs], side="left")
        cuts[0] = 0
        for rig, (i, j) in zip(rigs, pairwise([*cuts, len(times)]), strict=True):
            if j > i:
                by_rope = {name: pulls[i:j, k] for k, name in enumerate(ropes)}
                by_pad = {name: found["support/force"][i:j, k] for k, name in enumerate(pads)}
                by_body = {name: found[name][i:j] for name in poses}
                yield _Stretch(np.array(times[i:j]) / 1e9, rig, by_rope, by_pad, by_body)


def _pull(line: RopeLine, poses: Mapping[str, Floats]) -> Floats:
    """Direction (n, 3) from the lower to the upper end of a line."""
    distance = _end(line.a_body, line.a, poses) - _end(line.b_body, line.b, poses)
    out: Floats = distance / np.maximum(np.linalg.norm(distance, axis=1), 1e-12)[:, None]
    return out


def _end(body: str, p: tuple[float, float, float], poses: Mapping[str, Floats]) -> Floats:
    """(n, 3) a point of a body in the world."""
    if POSE + body not in poses:
        n = len(next(iter(poses.values())))
        return np.broadcast_to(np.array(p), (n, 3))
    pose = poses[POSE + body]
    out: Floats = pose[:, :3] + turned(pose[:, 3:], np.broadcast_to(np.array(p), pose[:, :3].shape))
    return out
