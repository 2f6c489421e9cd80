"""How near things come to the ground, which is the plane z = 0: their lowest points, with a bound between samples.

A block that stands, is lifted off or is set down comes near the ground on purpose: until it is carried aside of where
it stands, and while it is ordered to land, it must only not go into the ground.  A hook that carries nothing may come
as low as it likes above it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import Kind, Solid, Strand
from numpy.typing import NDArray

from .coarse import Coarse
from .history import History
from .moving import Moving, moving, posed
from .rotating import chords, turned

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]
Spans = Sequence[tuple[float, float]]
ABOVE: tuple[Kind, ...] = ("block", "loader", "sling", "trolley")
PARTS = ("girder", "cross beam")  # of a portal, which stands on the ground with the others
TOUCH = 0.01  # depth of a penetration that is only numbers, such as of a pad that yields [m]
CONTACT = 1e-3  # between a pad and its stool that is none [m]
ASIDE = 1.0  # from where a block stands: as far as it and its trolleys go, it is lifted off or set down [m]


@dataclass(frozen=True)
class Low:
    """The lowest point of a thing: its distance from the ground [m], when [s], its place (3,); the limit to keep [m],
    0 where it must only not go into the ground."""

    shape: Moving
    distance: float
    t: float
    p: Floats
    limit: float


class Ground:
    """The nearest of each thing: first all parts of a run are surveyed, then each is looked at."""

    def __init__(self, plan: Plan, limit: float) -> None:
        self._plan, self._limit = plan, limit
        self._columns: list[tuple[NDArray[Any], ...]] = []  # t, near, stands, block, trolleys
        self._meant = np.zeros(0, bool)
        self._at = 0  # of all samples, that from which the next part is looked at
        self._least: dict[tuple[str, bool], float] = {}

    def survey(self, part: History, between: tuple[int, int]) -> None:
        """When the block of a part is near the ground, or stands, and where."""
        plan, pose = self._plan, part.poses.get(self._plan.block.name) if self._plan.block else None
        if plan.block is None or pose is None or not plan.cranes:
            return
        first, last = between
        inside = slice(first, last if last < len(part.t) - 1 else last + 1)
        alone = History(part.t, {plan.block.name: pose}, {}, {}, ())
        block = next(s for s in moving(plan, alone) if s.shape.kind == "block")
        gap, after = _gaps(block, np.arange(len(part.t)))
        np.minimum(gap[1:], after, out=gap[1:])
        np.minimum(gap[:-1], after, out=gap[:-1])
        near, (stands, _) = gap < self._limit, _stands(plan, part)
        columns = part.t, near, stands, pose[:, :2], _trolleys(plan, part)
        self._columns.append(tuple(x[inside].copy() for x in columns))

    def settle(self, landing: Spans) -> None:
        """All parts were surveyed; `landing`: from when to when [s] orders to land are carried out."""
        if self._columns:
            columns = [np.concatenate(x) for x in zip(*self._columns, strict=True)]
            self._meant = _meant(landing, *columns)
            self._columns = []

    def look(self, shapes: Sequence[Moving], coarse: Coarse, part: History, bar: float) -> Iterator[tuple[Low, bool]]:
        """What is nearer than before, and than a bar [m]; and whether it went into the ground."""
        plan, n = self._plan, len(part.t)
        first, last = int(coarse.starts[0]), int(coarse.ends[-1])
        if not plan.cranes:
            return
        always, meant = np.ones(n, bool), np.zeros(n, bool)
        if len(self._meant):
            meant[first : last + 1] = self._meant[self._at : self._at + last + 1 - first]
        self._at += last - first
        least = coarse.centre[:, :, 2] - coarse.reach[:, :, 2] - coarse.moved
        things: dict[str, list[tuple[Moving, Floats]]] = {}
        for s, gaps in zip(shapes, least, strict=True):
            if s.shape.kind in ABOVE or (isinstance(s.shape, Solid) and s.shape.part in PARTS):
                things.setdefault(s.shape.thing, []).append((s, gaps))
        _, sinks = _stands(plan, part)
        for thing, some in things.items():
            kind = some[0][0].shape.kind
            free = always
            if kind in ("block", "sling"):
                free = ~meant
            elif kind == "loader":
                free = _loaded(plan, part, thing)
            for through, when, limit, most in ((True, always, 0.0, -TOUCH), (False, free, self._limit, bar)):
                known = min(most, self._least.get((thing, through), np.inf))
                x = _least(some, coarse, when, limit, known, sinks if through and kind == "block" else None)
                if x is not None:
                    self._least[thing, through] = x.distance
                    yield x, through


def _gaps(s: Moving, k: Indices) -> tuple[Floats, Floats]:
    """Of a shape the gap at samples (m,), and the least from each to the next of them (m - 1,), where that is the next
    of all [m]: it goes straight, but for what it strays and, as it turns, w^2 r / 8."""
    centre, turn = posed(s, k)
    at = centre[:, 2] - s.radius
    if isinstance(s.shape, Strand):
        at -= np.abs(turn[:, 2]) / 2
    else:
        up = _up(turn)
        for half, own in zip(s.half.tolist(), zip(*s.shape.R, strict=True), strict=True):
            along = sum((x * r for x, r in zip(own, up, strict=True) if x), np.zeros(1))
            at -= half * np.abs(along)
    after = np.minimum(at[1:], at[:-1]) - s.stray[k[:-1]]
    if len(turn) > 1 and isinstance(s.shape, Solid):
        angle = 2.0 * np.arcsin(np.minimum(1.0, chords(turn[1:], turn[:-1]) / 2))
        after -= angle * angle * s.reach / 8.0
    after[np.diff(k) > 1] = np.inf
    return at, after


def _up(turn: Floats) -> tuple[Floats, Floats, Floats]:
    """The third row of the rotations of quaternions (n, 4)."""
    x, y, z, w = turn.T
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


def _least(
    some: Sequence[tuple[Moving, Floats]],
    coarse: Coarse,
    free: Flags,
    limit: float,
    known: float,
    sinks: Floats | None = None,
) -> Low | None:
    """The least of a thing's shapes at and between samples that are free, None if it is not below what is known;
    each shape with the least that it can have in each stretch (m,); `sinks` (n,): by how much its pads yield."""
    best: Low | None = None
    for s, gaps in some:
        bar = known if best is None else best.distance
        k = _samples(coarse, gaps < bar)
        if not len(k):
            continue
        there = free[k] if s.there is None else free[k] & s.there[k]
        gap, between = _gaps(s, k)
        more = np.zeros(len(k)) if sinks is None else sinks[k]
        at = np.where(there, gap + more, np.inf)
        after = np.where(there[1:] & there[:-1], between + more[1:], np.inf)
        i, j = int(np.argmin(at)), int(np.argmin(after)) if len(after) else 0
        value = min(float(at[i]), float(after[j]) if len(after) else np.inf)
        if value < bar:
            if at[i] > value:
                i = j if gap[j] <= gap[j + 1] else j + 1
            best = Low(s, value, float(s.t[k[i]]), _lowest(s, int(k[i])), limit)
    return best


def _samples(coarse: Coarse, stretches: Flags) -> Indices:
    """All samples of some stretches."""
    inside = np.zeros(coarse.ends[-1] + 1, bool)
    for first, last in zip(coarse.starts[stretches].tolist(), coarse.ends[stretches].tolist(), strict=True):
        inside[first : last + 1] = True
    return np.flatnonzero(inside)


def _lowest(s: Moving, k: int) -> Floats:
    """(3,) the middle of what of a shape is lowest at a sample."""
    R, half = (x[0] for x in s.axes(np.array([k])))
    down = np.where(np.abs(R[2]) > 1e-6, -np.sign(R[2]), 0.0)
    point: Floats = s.centre[k] + turned(R, down * half)
    point[2] -= s.radius
    return point


def _stands(plan: Plan, history: History) -> tuple[Flags, Floats]:
    """(n,) when the block stands on a pad, and by how much its pads yield at most [m]."""
    n = len(history.t)
    depth = np.zeros(n)
    pose = history.poses.get(plan.block.name) if plan.block else None
    if plan.block is None or pose is None:
        return np.zeros(n, bool), depth
    row = _up(pose[:, 3:])
    deepest = np.full(n, -np.inf)
    for pad in (pad for pad in plan.block.pads if not pad.support.on):  # others are high above it
        height = pose[:, 2] + sum(p * r for p, r in zip(pad.support.point.p, row, strict=True))
        np.maximum(deepest, pad.support.height - height, out=deepest)
    return deepest >= -CONTACT, np.maximum(depth, deepest)


def _meant(landing: Spans, t: Floats, near: Flags, stands: Flags, block: Floats, trolleys: Floats) -> Flags:
    """(n,) when the block is near the ground on purpose: it stands, or near the ground it is about to, or just did."""
    anchors = stands.copy()
    for first, last in landing:
        anchors |= near & (t >= first) & (t <= last)
    found = anchors.copy()
    if not found.any():
        return found
    for first, last in _runs(near | stands):
        at = np.flatnonzero(anchors[first:last]) + first
        if len(at):
            k = np.arange(first, last)
            i = np.searchsorted(at, k)
            for other in (at[np.minimum(i, len(at) - 1)], at[np.maximum(i - 1, 0)]):
                carried = [np.hypot(*(x[k] - x[other]).T) > ASIDE for x in (block, trolleys)]
                found[k] |= ~(carried[0] & carried[1])
    return found


def _trolleys(plan: Plan, history: History) -> Floats:
    """(n, 2) the middle of the trolleys, which does not swing."""
    names = sorted({line.a.body for rope in plan.rig.hook_ropes for line in rope.lines} & set(history.poses))
    found = np.zeros((len(history.t), 2))
    for name in names:
        found += history.poses[name][:, :2] / len(names)
    return found


def _runs(flags: Flags) -> Iterator[tuple[int, int]]:
    """From where to where (exclusive) flags are set without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _loaded(plan: Plan, history: History, loader: str) -> Flags:
    """(n,) when a sling of a loader is taut."""
    found = np.zeros(len(history.t), bool)
    for sling in plan.rig.slings:
        if sling.loader == loader and sling.name in history.tensions:
            found |= history.tensions[sling.name] > 0.0
    return found
