"""Clearances from the ground, the plane z = 0: lowest points of things, with a bound between samples.

A block that stands, is lifted off or is set down comes near the ground on purpose: until it is carried aside of where
it stands, and while it is ordered to land, it must only not penetrate the ground. An unloaded hook has no clearance
limit, either.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.description.units import WORLD
from heavylift.nodes.plan.shapes import Kind, Shapes, Solid, Strand
from numpy.typing import NDArray

from .conduct import Meant
from .history import History
from .intervals import Coarse
from .moving import Moving, moving, posed
from .rotating import chords, turned

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]
Spans = Sequence[tuple[float, float]]
ABOVE: tuple[Kind, ...] = ("block", "hanging", "sling")
TOUCH = 0.01  # depth of a penetration that is only numbers, such as of a pad that yields [m]
CONTACT = 1e-3  # between a pad and its support that is none [m]
SHAKES = 0.05  # more than its places alone tell of how near a block comes that has just left its supports [m]
ASIDE = 1.0  # from where a block stands: as far as it and its trolleys go, it is lifted off or set down [m]


@dataclass(frozen=True)
class GroundClearance:
    """The smallest distance [m] of the lowest point of a part from the ground, with time [s] and position (3,)."""

    shape: Moving
    distance: float
    t: float
    p: Floats
    limit: float  # [m]; 0 if only penetration is checked


class GroundSurvey:
    """Finds the ground clearances of a run that is read in parts.

    Call `survey` for all parts, then `settle` once, then `look` for each part.
    """

    def __init__(self, shapes: Shapes, keep: Callable[[str], float]) -> None:
        self._shapes, self._keep = shapes, keep
        self._looks = shapes.lifts and not shapes.afloat  # the ground of what floats is elsewhere
        self._columns: dict[str, list[tuple[NDArray[Any], ...]]] = {}  # block -> t, near, stands, block, trolleys
        self._meant: dict[str, Flags] = {}
        self._at = 0  # of all samples, that from which the next part is looked at
        self._least: dict[tuple[str, bool], float] = {}
        self._high: dict[object, bool] = {}  # shapes of machines: whether they begin above the ground

    def survey(self, part: History, between: tuple[int, int]) -> None:
        """Record at which samples of one part of a run blocks are near the ground or on supports."""
        first, last = between
        inside = slice(first, last if last < len(part.t) - 1 else last + 1)
        for name in sorted({*self._shapes.cargo} & {*part.poses}) if self._looks else ():
            pose = part.poses[name]
            alone = moving(self._shapes, History(part.t, {name: pose}, {}, {}, ()))
            gap = np.full(len(part.t), np.inf)
            for block in (s for s in alone if s.shape.kind == "block"):
                at, after = _gaps(block, np.arange(len(part.t)))
                np.minimum(at[1:], after, out=at[1:])
                np.minimum(at[:-1], after, out=at[:-1])
                np.minimum(gap, at, out=gap)
            stands, _ = _stands(self._shapes, name, part)
            columns = part.t, gap < self._keep(name) + SHAKES, stands, pose[:, :2], _trolleys(self._shapes, part)
            self._columns.setdefault(name, []).append(tuple(x[inside].copy() for x in columns))

    def settle(self, landing: Spans, meant: Meant = ()) -> None:
        """Find the times at which blocks are meant to be near the ground, once `survey` has read the whole run.

        `landing`: intervals [s] of orders to land; `meant`: allowed contacts.
        """
        for name, columns in self._columns.items():
            t, *others = (np.concatenate(x) for x in zip(*columns, strict=True))
            self._meant[name] = _meant(landing, t, *others)
            for _, first, last in (x for x in meant if x[0] == {name, WORLD}):
                self._meant[name] |= (t >= first) & (t <= last)
        self._columns = {}

    def look(
        self, shapes: Sequence[Moving], coarse: Coarse, part: History, bar: float
    ) -> Iterator[tuple[GroundClearance, bool]]:
        """Yield the ground clearances in one part of a run; a flag states for each whether only penetration counts.

        Each is smaller than `bar` [m] and all earlier ones.
        """
        first, last = int(coarse.starts[0]), int(coarse.ends[-1])
        if not self._looks:
            return
        always = np.ones(len(part.t), bool)
        meant = {name: ~always for name in self._meant}
        for name, flags in self._meant.items():
            meant[name][first : last + 1] = flags[self._at : self._at + last + 1 - first]
        self._at += last - first
        least = coarse.centre[:, :, 2] - coarse.reach[:, :, 2] - coarse.moved
        things: dict[str, list[tuple[Moving, Floats]]] = {}
        for s, gaps in zip(shapes, least, strict=True):
            if s.shape.kind in ABOVE or (s.shape.kind == "machine" and self._begins_high(s)):
                things.setdefault(s.shape.thing, []).append((s, gaps))
        sinks = {name: _stands(self._shapes, name, part)[1] for name in meant}
        for thing, some in things.items():
            shape, free = some[0][0].shape, always
            if shape.kind == "hanging" and isinstance(shape, Solid):
                free = _loaded(self._shapes, part, shape.body)
            for name in (shape.body,) if isinstance(shape, Solid) else shape.ends:
                free = free & ~meant[name] if name in meant else free
            yields = sinks.get(shape.body) if isinstance(shape, Solid) else None
            for through, when, limit, most in ((True, always, 0.0, -TOUCH), (False, free, self._keep(thing), bar)):
                known = min(most, self._least.get((thing, through), np.inf))
                x = _least(some, coarse, when, limit, known, yields if through else None)
                if x is not None:
                    self._least[thing, through] = x.distance
                    yield x, through

    def _begins_high(self, s: Moving) -> bool:
        """Return whether a part of a machine begins above the ground."""
        if s.shape not in self._high:
            self._high[s.shape] = bool(_gaps(s, np.arange(1))[0][0] >= self._keep(s.shape.thing))
        return self._high[s.shape]


def _gaps(s: Moving, k: Indices) -> tuple[Floats, Floats]:
    """Return the gap of a shape at samples (m,), and its lower bound to the next sample (m - 1,), including deviation
    from the chord and w^2 r / 8 for rotation."""
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
    """Return the third row of the rotations of quaternions (n, 4)."""
    x, y, z, w = turn.T
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


def _least(
    some: Sequence[tuple[Moving, Floats]],
    coarse: Coarse,
    free: Flags,
    limit: float,
    known: float,
    sinks: Floats | None = None,
) -> GroundClearance | None:
    """Return the least clearance of a thing at and between the samples `free`, None if it is not below `known` [m];
    `sinks` (n,): yield of its pads [m]."""
    best: GroundClearance | None = None
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
            best = GroundClearance(s, value, float(s.t[k[i]]), _lowest(s, int(k[i])), limit)
    return best


def _samples(coarse: Coarse, stretches: Flags) -> Indices:
    """Return all samples of some intervals."""
    inside = np.zeros(coarse.ends[-1] + 1, bool)
    for first, last in zip(coarse.starts[stretches].tolist(), coarse.ends[stretches].tolist(), strict=True):
        inside[first : last + 1] = True
    return np.flatnonzero(inside)


def _lowest(s: Moving, k: int) -> Floats:
    """Return the centre (3,) of the lowest part of a shape at a sample."""
    _, R, half = s.at(k, 0.0)
    down = np.where(np.abs(R[2]) > 1e-6, -np.sign(R[2]), 0.0)
    point: Floats = s.centre[k] + turned(R, down * half)
    point[2] -= s.radius
    return point


def _stands(shapes: Shapes, block: str, history: History) -> tuple[Flags, Floats]:
    """Return whether a block is on a support (n,), and the largest yield of its supports [m]."""
    pose = history.poses[block]
    row = _up(pose[:, 3:])
    deepest = np.full(len(pose), -np.inf)
    for support in shapes.supports(block):
        height = pose[:, 2] + sum(p * r for p, r in zip(support.point.p, row, strict=True))
        np.maximum(deepest, support.height - height, out=deepest)
    return deepest >= -CONTACT, np.maximum(0.0, deepest)


def _meant(landing: Spans, t: Floats, near: Flags, stands: Flags, block: Floats, trolleys: Floats) -> Flags:
    """Return when ground contact is intended (n,): on supports, or near the ground around a landing, and above it until
    the block is carried aside."""
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
                found[k] |= _above(block, trolleys, k, other)
            before, after = (np.flatnonzero(~_above(block, trolleys, slice(None), i)) for i in (at[0], at[-1]))
            found[(before[before < at[0]] + 1).max(initial=0) : at[0]] = True
            found[at[-1] : after[after > at[-1]].min(initial=len(t))] = True
    return found


def _above(block: Floats, trolleys: Floats, k: Indices | slice, there: Indices) -> Flags:
    """Return whether a block or its trolleys are near where they were at other samples (n,)."""
    aside: Flags = np.hypot(*(block[k] - block[there]).T) > ASIDE
    away: Flags = np.hypot(*(trolleys[k] - trolleys[there]).T) > ASIDE
    return ~(aside & away)


def _trolleys(shapes: Shapes, history: History) -> Floats:
    """Return the centre (n, 2) of the suspension points of hooks, which do not swing."""
    names = sorted({hook.on for hook in shapes.hooks.values()} & set(history.poses))
    found = np.zeros((len(history.t), 2))
    for name in names:
        found += history.poses[name][:, :2] / len(names)
    return found


def _runs(flags: Flags) -> Iterator[tuple[int, int]]:
    """Yield the intervals (begin, end exclusive) of consecutive flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _loaded(shapes: Shapes, history: History, body: str) -> Flags:
    """Return (n,) whether a sling from a hanging body is taut."""
    found = np.zeros(len(history.t), bool)
    for tie in (tie for machine in shapes.machines for tie in machine.ties):
        if tie.rope in history.tensions and shapes.root(tie.upper.body) == shapes.root(body):
            found |= history.tensions[tie.rope] > 0.0
    return found
