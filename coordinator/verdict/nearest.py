"""When two things come nearest: branch and bound over time, so that nothing is missed between samples.

A stretch of samples is bounded by the gap at one of them less how far the two shapes move against each other within it;
stretches that cannot hold anything nearer than what is known are dropped, the others cut, down to steps from a sample
to the next.  In a step shapes go straight, so the gap along a direction is least at an end of it; how far they may
stray from that (see `moving`) lowers the bound.  The minimum that is found is at most `SHARP` above the true one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from heavylift.nodes.limits.shapes import Solid
from numpy.typing import NDArray

from .distance import Near, Placed, bounds, bounds_along, bounds_between, exactly
from .moving import Moving, lengths

__all__ = ["SIZES", "Minimum", "Stretches", "nearest", "together", "whole"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Ends = tuple[Placed, Placed]  # at the begin and the end of steps
SHARP = 1e-3  # [m]
SIZES = (64, 16, 4, 1)  # samples in a stretch, from the first cut to the last
FINEST = 2.0**-20  # part of the time between two samples that is not cut any more


@dataclass(frozen=True)
class Minimum:
    """What two things come near to: at least `least` [m], `seen` on the way that is taken between samples, when [s];
    the direction of the nearest points in the world, in a and in b."""

    least: float
    seen: float
    t: float
    a: Moving
    b: Moving
    near: Near
    directions: tuple[Floats, Floats, Floats]


@dataclass(frozen=True)
class Stretches:
    """Pairs of shapes (indices) over the samples from `first` to `last`, both included: by how much they move against
    each other, seen from the sample in the middle, and what they are apart at least [m]."""

    a: Indices
    b: Indices
    first: Indices
    last: Indices
    moved: Floats
    least: Floats

    @property
    def middle(self) -> Indices:
        """The samples in the middle."""
        found: Indices = (self.first + self.last) // 2
        return found

    def of(self, kept: NDArray[np.bool_] | Indices) -> Stretches:
        """Some of them."""
        a, b, first, last = self.a[kept], self.b[kept], self.first[kept], self.last[kept]
        return Stretches(a, b, first, last, self.moved[kept], self.least[kept])


def together(groups: Sequence[Stretches]) -> Stretches:
    """All of some groups as one."""
    a, b, first, last = (np.concatenate([getattr(g, x) for g in groups]) for x in ("a", "b", "first", "last"))
    moved, least = (np.concatenate([getattr(g, x) for g in groups]) for x in ("moved", "least"))
    return Stretches(a, b, first, last, moved, least)


def whole(shapes: list[Moving], pairs: list[tuple[int, int]], common: Floats) -> Stretches:
    """All pairs over the whole run in its longest stretches, bounded by boxes along the world's axes; motion is taken
    against a common motion (n, 3)."""
    n = len(shapes[0].t)
    starts = np.arange(0, max(1, n - 1), SIZES[0])
    ends = np.minimum(starts + SIZES[0], n - 1)
    middles = (starts + ends) // 2
    known: dict[str, Floats] = {}  # of bodies that never turn, whose shapes move alike
    moved = np.array([_excursions(s, starts, ends, middles, common, known) for s in shapes])
    centre = np.array([s.centre[middles] for s in shapes])
    reach = np.array([_reach(s, middles) for s in shapes])
    a, b = (np.array(x, np.intp) for x in zip(*pairs, strict=True))
    apart = np.maximum(0.0, np.abs(centre[a] - centre[b]) - reach[a] - reach[b])
    way = moved[a] + moved[b]
    least = np.sqrt((apart * apart).sum(axis=2)) - way
    there = np.array([_there(s, starts, ends) for s in shapes])
    i, j = np.nonzero(there[a] & there[b])
    return Stretches(a[i], b[i], starts[j], ends[j], way[i, j], least[i, j])


def _reach(s: Moving, k: Indices) -> Floats:
    """(m, 3) half edges of the box along the world's axes around a shape."""
    R, half = s.axes(k)
    found: Floats = (np.abs(R) * half[:, None, :]).sum(axis=2) + s.radius
    return found


def _there(s: Moving, starts: Indices, ends: Indices) -> NDArray[np.bool_]:
    if s.there is None:
        return np.ones(len(starts), bool)
    return np.array([s.there[i : j + 1].any() for i, j in zip(starts, ends, strict=True)])


def _excursions(
    s: Moving, starts: Indices, ends: Indices, middles: Indices, common: Floats, known: dict[str, Floats]
) -> Floats:
    """(m,) by how much points of a shape leave their places at the middle of each stretch, against a common motion."""
    straight = s.shape.body if isinstance(s.shape, Solid) and len(s.turn) == 1 else ""
    if straight in known:
        return known[straight]
    path = s.centre - common
    k = np.arange(len(path))
    r = middles[np.minimum(k // SIZES[0], len(starts) - 1)]
    moved = lengths(path - path[r]) + s.spun(k, r)
    if len(s.stray):
        moved += np.maximum(np.append(s.stray, 0.0), np.append(0.0, s.stray))
    last = lengths(path[ends] - path[middles]) + s.spun(ends, middles)  # the first of the next
    found: Floats = np.maximum(np.maximum.reduceat(moved, starts), last)
    if straight:
        known[straight] = found
    return found


def nearest(shapes: list[Moving], start: Stretches, most: float = np.inf) -> Minimum | None:
    """The minimum over some stretches; None if they stay farther apart than `most` [m]."""
    best: Minimum | None = None
    now = start
    for size in (*SIZES[1:], 0):
        now = now.of(now.least < _bar(best, most))
        now = _bounded(shapes, now)
        best = _known(shapes, now, best, most)
        now = now.of(now.least < _bar(best, most))
        if size and len(now.a):
            now = _cut(shapes, now, size)
    steps = _steps(shapes, now)
    steps.sharpen(best)
    while len(steps.least):
        i = int(np.argmin(steps.least))
        if steps.least[i] >= _bar(best, most):
            break
        found = _between(shapes[steps.a[i]], shapes[steps.b[i]], int(steps.k[i]), _bar(best, most))
        best = found if found is not None and (best is None or found.least < best.least) else best
        steps.least[i] = np.inf
        steps.sharpen(found)
        steps = steps.of(steps.least < _bar(best, most))
    return best if best is not None and best.least < most else None


def _bar(best: Minimum | None, most: float) -> float:
    """What a stretch must be able to come below to be looked at."""
    return min(most, best.least - SHARP if best else np.inf)


def _bounded(shapes: list[Moving], now: Stretches) -> Stretches:
    """Stretches with the bound of the gap at their middles."""
    if not len(now.a):
        return now
    gap = bounds(_placed(shapes, now.a, now.middle), _placed(shapes, now.b, now.middle))
    return replace(now, least=np.maximum(now.least, gap - now.moved))


def _known(shapes: list[Moving], now: Stretches, best: Minimum | None, most: float) -> Minimum | None:
    """Look exactly at the samples in the middle of the most promising stretches."""
    gap = now.least + now.moved
    for i in np.argsort(gap, kind="stable")[:3]:
        a, b, k = shapes[now.a[i]], shapes[now.b[i]], int(now.middle[i])
        if gap[i] < _bar(best, most) and _judged(a, b, k):
            found = _seen(a, b, k, 0.0, 0.0)
            best = found if best is None or found.least < best.least else best
    return best


def _judged(a: Moving, b: Moving, k: int) -> bool:
    """Whether both are there at a sample."""
    return all(s.there is None or bool(s.there[k]) for s in (a, b))


def _cut(shapes: list[Moving], now: Stretches, size: int) -> Stretches:
    """The stretches in pieces of so many samples, each bounded by itself."""
    pieces = np.maximum(-(-(now.last - now.first) // size), 1)
    of = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(of)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = now.first[of] + number * size
    last = np.minimum(first + size, now.last[of])
    a, b, middle = now.a[of], now.b[of], (first + last) // 2
    there, moved = np.ones(len(a), bool), np.zeros(len(a))
    for one, two, here in _by_pair(shapes, a, b):
        span = np.minimum(first[here, None] + np.arange(size + 1), last[here, None])
        k, r = span.ravel(), np.repeat(middle[here], size + 1)
        apart = one.centre[k] - two.centre[k] - (one.centre[r] - two.centre[r])
        way = lengths(apart) + one.spun(k, r) + two.spun(k, r)
        if len(one.stray):
            j = np.minimum(k, len(one.stray) - 1)
            way += one.stray[j] + two.stray[j]
        moved[here] = way.reshape(len(here), -1).max(axis=1)
        for s in (one, two):
            if s.there is not None:
                there[here] &= s.there[span].any(axis=1)
    return Stretches(a, b, first, last, moved, np.full(len(a), -np.inf)).of(there)


def _by_pair(shapes: list[Moving], a: Indices, b: Indices) -> list[tuple[Moving, Moving, Indices]]:
    """Each pair of shapes, and where it stands among many."""
    pairs = sorted({(int(x), int(y)) for x, y in zip(a, b, strict=True)})
    return [(shapes[x], shapes[y], np.nonzero((a == x) & (b == y))[0]) for x, y in pairs]


def _placed(shapes: list[Moving], which: Indices, k: Indices) -> Placed:
    """Many shapes, each at its sample."""
    m = len(which)
    if m and (which == which[0]).all():
        s = shapes[which[0]]
        turns, edges = s.axes(k)
        return Placed(s.centre[k], turns, edges, np.full(m, s.radius))
    centre, R, half, radius = np.empty((m, 3)), np.empty((m, 3, 3)), np.empty((m, 3)), np.empty(m)
    for i in np.unique(which):
        here, s = which == i, shapes[i]
        centre[here], radius[here] = s.centre[k[here]], s.radius
        R[here], half[here] = s.axes(k[here])
    return Placed(centre, R, half, radius)


@dataclass(frozen=True)
class _Steps:
    """Pairs of shapes from samples k to the next: where they are at both, how far they may leave straight ways in
    between, and what they are apart at least [m]."""

    a: Indices
    b: Indices
    k: Indices
    ends_a: Ends
    ends_b: Ends
    astray: Floats
    least: Floats

    def sharpen(self, found: Minimum | None) -> None:
        """Raise bounds by the direction in which things were nearest."""
        if found is not None and len(self.least):
            raised = bounds_along(self.ends_a, self.ends_b, *found.directions) - self.astray
            np.maximum(self.least, raised, out=self.least)

    def of(self, kept: NDArray[np.bool_]) -> _Steps:
        """Some of them."""
        ends_a, ends_b = ((_some(x, kept), _some(y, kept)) for x, y in (self.ends_a, self.ends_b))
        return _Steps(self.a[kept], self.b[kept], self.k[kept], ends_a, ends_b, self.astray[kept], self.least[kept])


def _some(x: Placed, kept: NDArray[np.bool_]) -> Placed:
    return Placed(x.centre[kept], x.R[kept], x.half[kept], np.asarray(x.radius)[kept])


def _steps(shapes: list[Moving], now: Stretches) -> _Steps:
    """Stretches of one step each; of shapes that come and go those at whose begin they are there."""
    kept = [bool(_judged(shapes[x], shapes[y], k)) for x, y, k in zip(now.a, now.b, now.first, strict=True)]
    now = now.of(np.array(kept, bool))
    k = now.first
    after = np.minimum(k + 1, len(shapes[0].t) - 1)
    ends_a, ends_b = ((_placed(shapes, x, k), _placed(shapes, x, after)) for x in (now.a, now.b))
    astray = np.zeros(len(k))
    for one, two, here in _by_pair(shapes, now.a, now.b):
        astray[here] = _astray(one, two, k[here], after[here])
    least = bounds_between(ends_a, ends_b) - astray
    return _Steps(now.a, now.b, k, ends_a, ends_b, astray, least)


def _astray(a: Moving, b: Moving, k: Indices, r: Indices) -> Floats:
    """(m,) how far points of one shape leave, seen from the other, the straight way from samples k to samples r [m], at
    most: h^2 / 8 times the accelerations w^2 y and 2 w v of a frame that turns, and what samples do not show."""
    d = b.centre[k] - a.centre[k]
    v = lengths(b.centre[r] - a.centre[r] - d) + a.spun(r, k) + b.spun(r, k)
    w = a.turned_by(r, k) + b.turned_by(r, k)
    y = lengths(d) + a.reach + b.reach
    found: Floats = w * w * y / 8.0 + w * v / 4.0
    return found + _stray(a, b, k)


def _stray(a: Moving, b: Moving, k: Indices) -> Floats:
    """(m,) how far both may be between samples from where they are taken to be [m]."""
    if not len(a.stray):
        return np.zeros(len(k))
    j = np.minimum(k, len(a.stray) - 1)
    found: Floats = a.stray[j] + b.stray[j]
    return found


def _between(a: Moving, b: Moving, k: int, bar: float) -> Minimum | None:
    """The minimum from sample k to the next as far as it is below a bar [m]: halved in time until the gap along the
    direction of the nearest points, least at one end of a piece, says that nothing nearer is in it."""
    if k + 1 >= len(a.t):
        return _seen(a, b, k, 0.0, 0.0)
    i, j = np.array([k]), np.array([k + 1])
    stray = float(_stray(a, b, i)[0])
    turning = float(_astray(a, b, i, j)[0]) - stray
    best: Minimum | None = None
    pieces = [(0.0, 1.0)]
    while pieces:
        low, high = pieces.pop()
        found = _seen(a, b, k, (low + high) / 2, stray)
        best = found if best is None or found.least < best.least else best
        (a0, b0), (a1, b1) = ([_posed(x, k, s) for x in (a, b)] for s in (low, high))
        gap = float(bounds_along((a0, a1), (b0, b1), *found.directions)[0])
        if gap - turning * (high - low) ** 2 - stray < min(bar, best.least - SHARP) and high - low > FINEST:
            pieces += [((low + high) / 2, high), (low, (low + high) / 2)]
    return best


def _seen(a: Moving, b: Moving, k: int, s: float, stray: float) -> Minimum:
    """What is seen at the part s from sample k to the next."""
    x, y = _posed(a, k, s), _posed(b, k, s)
    near = exactly(x, y)
    t = float(a.t[k] if s == 0.0 else (1 - s) * a.t[k] + s * a.t[k + 1])
    directions = near.normal, x.R[0].T @ near.normal, y.R[0].T @ near.normal
    return Minimum(near.distance - stray, near.distance, t, a, b, near, directions)


def _posed(x: Moving, k: int, s: float) -> Placed:
    """A shape at the part s from sample k to the next."""
    p, turn = (x.centre[k], x.turn[min(k, len(x.turn) - 1)]) if s == 0.0 else x.between(k, s)
    R, half = x.axes_of(turn[None])
    return Placed(p[None], R, half, x.radius)
