"""Stretches of samples of two shapes with bounds of what they are apart in them; and the steps between samples: what
the two are apart at least in each, and exactly where that is in doubt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from .coarse import LONGEST, Coarse
from .distance import Placed, bounds, bounds_along, bounds_between, exactly
from .moving import Moving
from .rotating import turned
from .shape_batch import ShapeBatch

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
SIZES = (LONGEST, 8, 1)  # samples in a stretch, from the first cut to the last
PIECE = 1 << 10  # stretches that are looked at together: so few that their numbers stay in the cache
Some = TypeVar("Some")
Ends = tuple[Placed, Placed]  # at the begin and the end of steps
SHARP = 1e-3  # [m]
FINEST = 2.0**-20  # part of the time between two samples that is not cut any more


@dataclass(frozen=True)
class Stretches:
    """Pairs of shapes (indices) from sample `first` to `last` (inclusive): bound of their relative motion about the
    middle sample, lower bound of their distance [m], number of their things."""

    a: Indices
    b: Indices
    first: Indices
    last: Indices
    moved: Floats
    least: Floats
    group: Indices

    @property
    def middle(self) -> Indices:
        """The samples in the middle."""
        found: Indices = (self.first + self.last) // 2
        return found

    def of(self, kept: NDArray[np.bool_] | Indices) -> Stretches:
        """A selection of them."""
        a, b, first, last = self.a[kept], self.b[kept], self.first[kept], self.last[kept]
        return Stretches(a, b, first, last, self.moved[kept], self.least[kept], self.group[kept])


def whole(coarse: Coarse, pairs: Sequence[tuple[int, int]], groups: Sequence[int] | None = None) -> Stretches:
    """All pairs in the longest intervals, bounded by their boxes."""
    centre, reach, moved = coarse.centre.transpose(2, 0, 1), coarse.reach.transpose(2, 0, 1), coarse.moved
    a, b = (np.array(x, np.intp) for x in zip(*pairs, strict=True))
    group = np.zeros(len(a), np.intp) if groups is None else np.array(groups, np.intp)
    square = np.zeros((len(a), len(coarse.starts)))
    deep = np.full(square.shape, -np.inf)  # of boxes that overlap, along the axis where they do least
    for x, half in zip(centre, reach, strict=True):
        apart = np.abs(x[a] - x[b]) - (half[a] + half[b])
        np.maximum(deep, apart, out=deep)
        np.maximum(0.0, apart, out=apart)
        square += apart * apart
    distance = moved[a] + moved[b]
    least = np.sqrt(square) + np.minimum(deep, 0.0) - distance
    i, j = np.nonzero(coarse.there[a] & coarse.there[b])
    return Stretches(a[i], b[i], coarse.starts[j], coarse.ends[j], distance[i, j], least[i, j], group[i])


def in_pieces(now: Stretches, look: Callable[[Stretches], Some]) -> Some:
    """Apply `look` to parts of the intervals, to limit memory."""
    found = [look(now.of(np.arange(i, min(i + PIECE, len(now.a))))) for i in range(0, max(1, len(now.a)), PIECE)]
    return found[0] if len(found) == 1 else joined(found)


def joined(parts: Sequence[Some]) -> Some:
    """Concatenate arrays, and tuples and classes of arrays."""
    one, all_ = cast("Any", parts[0]), cast("Any", parts)
    found: Any
    if isinstance(one, np.ndarray):
        found = np.concatenate([x.T for x in all_], axis=-1).T
    elif isinstance(one, tuple):
        columns = [joined(x) for x in zip(*all_, strict=True)]
        found = type(one)(*columns) if hasattr(one, "_fields") else tuple(columns)
    else:
        found = type(one)(*(joined([getattr(x, f.name) for x in all_]) for f in fields(one)))
    return cast("Some", found)


def bounded(all_: ShapeBatch, now: Stretches) -> Stretches:
    """Stretches with the bound of the gap at their middles."""
    if not len(now.a):
        return now
    gap = bounds(all_.placed(now.a, now.middle), all_.placed(now.b, now.middle))
    return replace(now, least=np.maximum(now.least, gap - now.moved))


def cut(all_: ShapeBatch, now: Stretches, size: int) -> Stretches:
    """The stretches in pieces of so many samples, each bounded by itself."""
    pieces = np.maximum(-(-(now.last - now.first) // size), 1)
    of = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(of)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = now.first[of] + number * size
    last = np.minimum(first + size, now.last[of])
    a, b = now.a[of], now.b[of]
    kept = all_.there(a, first, last) & all_.there(b, first, last)
    first, last, a, b, of = first[kept], last[kept], a[kept], b[kept], of[kept]
    k = np.minimum(first[:, None] + np.arange(size + 1), last[:, None])
    one, two, middle = a[:, None], b[:, None], ((first + last) // 2)[:, None]
    distance = all_.moved(one, two, k, middle) + all_.stray(one, two, k)
    return Stretches(a, b, first, last, distance.max(axis=1, initial=0.0), np.full(len(a), -np.inf), now.group[of])


@dataclass(frozen=True)
class Minimum:
    """Smallest distance of two things: lower bound `least` [m], value `seen` on the interpolated path, time [s],
    nearest points (3,), direction from a to b in the world, in a and in b."""

    least: float
    seen: float
    t: float
    a: Moving
    b: Moving
    near: tuple[Floats, Floats]
    directions: tuple[Floats, Floats, Floats]


@dataclass(frozen=True)
class Steps:
    """Pairs of shapes between samples k and k + 1, with bounds of their deviation from straight motion by rotation and
    by sampling, and of their distance [m]."""

    a: Indices
    b: Indices
    k: Indices
    ends_a: Ends
    ends_b: Ends
    turning: Floats
    stray: Floats
    least: Floats
    group: Indices

    def sharpen(self, found: Minimum | None) -> None:
        """Raise bounds by the direction in which things were nearest."""
        if found is not None and len(self.least):
            raised = bounds_along(self.ends_a, self.ends_b, *found.directions) - self.turning - self.stray
            np.maximum(self.least, raised, out=self.least)

    def of(self, kept: NDArray[np.bool_] | Indices) -> Steps:
        """A selection of them."""
        ends_a, ends_b = ((_some(x, kept), _some(y, kept)) for x, y in (self.ends_a, self.ends_b))
        a, b, k, group = self.a[kept], self.b[kept], self.k[kept], self.group[kept]
        return Steps(a, b, k, ends_a, ends_b, self.turning[kept], self.stray[kept], self.least[kept], group)


def _some(x: Placed, kept: NDArray[np.bool_] | Indices) -> Placed:
    """Some of the poses; a component stays in one piece of memory."""
    return Placed(*(np.asarray(y).T[..., kept].T for y in x))


def steps_of(all_: ShapeBatch, now: Stretches, n: int) -> Steps:
    """Intervals of one step; for shapes that appear or vanish those at whose begin they exist."""
    now = now.of(all_.there(now.a, now.first, now.first) & all_.there(now.b, now.first, now.first))
    k, after = now.first, np.minimum(now.first + 1, n - 1)
    ends_a, ends_b = ((all_.placed(x, k), all_.placed(x, after)) for x in (now.a, now.b))
    turning, stray = all_.turning(now.a, now.b, k, after), all_.stray(now.a, now.b, k)
    least = bounds_between(ends_a, ends_b) - turning - stray
    return Steps(now.a, now.b, k, ends_a, ends_b, turning, stray, least, now.group)


def between(a: Moving, b: Moving, k: int, turning: float, stray: float, bar: float) -> Minimum:
    """The minimum between samples k and k + 1 as far as it is below a bound [m], by bisection in time with a lower
    bound along the direction of the nearest points."""
    if k + 1 >= len(a.t):
        return seen([(a, b, k)])[0]
    best: Minimum | None = None
    pieces = [(0.0, 1.0)]
    while pieces:
        low, high = pieces.pop()
        (found,) = seen([(a, b, k)], (low + high) / 2, stray)
        best = found if best is None or found.least < best.least else best
        (a0, b0), (a1, b1) = ([_posed([(x, k)], s) for x in (a, b)] for s in (low, high))
        gap = float(bounds_along((a0, a1), (b0, b1), *found.directions)[0])
        if gap - turning * (high - low) ** 2 - stray < min(bar, best.least - SHARP) and high - low > FINEST:
            pieces += [((low + high) / 2, high), (low, (low + high) / 2)]
    assert best is not None
    return best


def seen(pairs: Sequence[tuple[Moving, Moving, int]], s: float = 0.0, stray: float = 0.0) -> list[Minimum]:
    """What is seen of pairs of shapes at the part s from a sample of each to the next."""
    x, y = _posed([(a, k) for a, _, k in pairs], s), _posed([(b, k) for _, b, k in pairs], s)
    near = exactly(x, y)
    n = near.normal
    directions = zip(n, turned(x.R.transpose(0, 2, 1), n), turned(y.R.transpose(0, 2, 1), n), strict=True)
    found = zip(pairs, near.distance.tolist(), near.a, near.b, directions, strict=True)
    return [Minimum(gap - stray, gap, _time(a.t, k, s), a, b, (p, q), along) for (a, b, k), gap, p, q, along in found]


def _time(t: Floats, k: int, s: float) -> float:
    return float(t[k] if s == 0.0 else (1 - s) * t[k] + s * t[k + 1])


def _posed(shapes: Sequence[tuple[Moving, int]], s: float) -> Placed:
    """Each shape interpolated at fraction s of its step."""
    p, R, half = (np.array(column) for column in zip(*(x.at(k, s) for x, k in shapes), strict=True))
    return Placed(p, R, half, np.array([x.radius for x, _ in shapes]))
