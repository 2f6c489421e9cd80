"""Intervals of samples for pairs of shapes, with lower bounds of their distance; and steps between two samples, with
lower bounds, and the exact distance where it is needed.

Bounds of shapes over long intervals of samples: boxes along the world's axes, and how far the shapes leave them.

All work per sample is done once for a body: the deviation of its origin and its rotation from the pose at the middle of
an interval, and of both between samples. A point of the body moves no farther than the origin, plus per metre of its
distance as much as a point at 1 m; a point of a rope no farther than the rope's ends.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, cast

import numpy as np
from heavylift.nodes.plan.shapes import Strand
from numpy.typing import NDArray

from .distance import Placed, bounds, bounds_along, bounds_between, exactly
from .moving import BodyTrack, Moving, box, posed, size
from .rotating import chords, lengths, turned
from .shape_batch import ShapeBatch

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
LONGEST = 64  # samples in a stretch


class Coarse:
    """Bounding boxes of moving shapes over long intervals of samples, from `starts` to `ends`, inclusive.

    `centre` and half edges `reach` of the box at the middle sample (shapes, m, 3) [m]; `moved`: largest motion of
    points relative to the common horizontal motion (shapes, m) [m]; `there`: whether the shape exists.
    """

    def __init__(self, shapes: Sequence[Moving], common: Floats, between: tuple[int, int]) -> None:
        """`common`: common horizontal motion (n, 2) [m]; `between`: the first and the last sample."""
        first, last = between
        self.starts: Indices = np.arange(first, max(first + 1, last), LONGEST)
        self.ends = np.minimum(self.starts + LONGEST, last)
        self.middles: Indices = (self.starts + self.ends) // 2
        poses = [posed(s, self.middles) for s in shapes]
        self.centre = np.array([centre for centre, _ in poses])
        boxes = (box(s, turn) for s, (_, turn) in zip(shapes, poses, strict=True))
        self.reach = np.array([np.broadcast_to(x, self.centre.shape[1:]) for x in boxes])
        self.moved = self._moved(shapes, common)
        self.there = np.array([self._there(s) for s in shapes])

    def _moved(self, shapes: Sequence[Moving], common: Floats) -> Floats:
        frames = {frame: None for s in shapes for frame, _ in s.on}
        distances = np.array([self._ways(frame, common) for frame in frames])
        number = {frame: i for i, frame in enumerate(frames)}
        rows = [
            (number[frame], size(p), 0.0 if isinstance(s.shape, Strand) else s.reach)
            for s in shapes
            for frame, p in s.on
        ]
        begin = np.cumsum([0, *(len(s.on) for s in shapes)])[:-1]
        of, away, reach = (np.array(x)[:, None] for x in zip(*rows, strict=True))
        distance, spun, bend, turning, quaternion, shake, shaking = distances[of[:, 0]].transpose(1, 0, 2)
        distance = np.maximum.reduceat(distance + (away + reach) * spun, begin)
        bend = np.add.reduceat(bend + away * turning + 2.0 * reach * quaternion, begin)
        shake = np.maximum.reduceat(shake + (away + reach) * shaking, begin)
        found: Floats = distance + np.maximum(bend, shake)
        return found

    def _ways(self, frame: BodyTrack, common: Floats) -> Floats:
        """Return seven bounds (7, m) of the motion of a body in each interval: displacement of its origin [m], and of
        other points per metre of their distance from the origin; from accelerations, deviation between samples of the
        origin [m], per metre from the origin, and of the quaternion; from joint speeds, deviation of the origin [m],
        and per metre."""
        inside = slice(self.starts[0], self.ends[-1] + 1)
        counts = np.diff(self.starts, append=self.ends[-1] + 1)
        path = frame.p.copy(order="K")
        path[:, :2] -= common
        distance = lengths(path[inside] - _repeated(path[self.middles], counts))
        distance = np.maximum(
            self._most(distance), lengths(path[self.ends] - path[self.middles])
        )  # the first of the next
        spun, q = np.zeros(len(distance)), frame.turn
        if len(q) > 1:
            spun = self._most(chords(q[inside], _repeated(q[self.middles], counts)))
            spun = np.maximum(spun, chords(q[self.ends], q[self.middles]))
        strays = frame.strays, *reversed(frame.turn_strays), *frame.shakes
        return np.array([distance, spun, *(self._most(np.append(x, 0.0)[inside]) for x in strays)])

    def _most(self, x: Floats) -> Floats:
        """Return the maximum (m,) in each interval without its last sample."""
        found: Floats = np.maximum.reduceat(x, self.starts - self.starts[0])
        return found

    def _there(self, s: Moving) -> NDArray[np.bool_]:
        if s.there is None:
            return np.ones(len(self.starts), bool)
        found: NDArray[np.bool_] = np.logical_or.reduceat(s.there, self.starts) | s.there[self.ends]
        return found


def _repeated(x: Floats, counts: Indices) -> Floats:
    """Return rows of x (m, k) repeated `counts` times, column-contiguous."""
    found: Floats = np.repeat(np.ascontiguousarray(x.T), counts, axis=1).T
    return found


SIZES = (LONGEST, 8, 1)  # samples in a stretch, from the first cut to the last
PIECE = 1 << 10  # stretches that are looked at together: so few that their numbers stay in the cache
Some = TypeVar("Some")
Ends = tuple[Placed, Placed]  # at the begin and the end of steps
SHARP = 1e-3  # [m]
FINEST = 2.0**-20  # part of the time between two samples that is not cut any more


@dataclass(frozen=True)
class Stretches:
    """Pairs of shapes over intervals of samples, with bounds of their motion and distance.

    Indices `a`, `b` of the shapes; `first` to `last` sample, inclusive; `moved`: bound of the relative motion about the
    middle sample [m]; `least`: lower bound of the distance [m]; `group`: number of the pair of parts to which the
    shapes belong.
    """

    a: Indices
    b: Indices
    first: Indices
    last: Indices
    moved: Floats
    least: Floats
    group: Indices

    @property
    def middle(self) -> Indices:
        """Index of the middle sample of each interval."""
        found: Indices = (self.first + self.last) // 2
        return found

    def of(self, kept: NDArray[np.bool_] | Indices) -> "Stretches":
        """Return those intervals that a mask or an array of indices selects."""
        a, b, first, last = self.a[kept], self.b[kept], self.first[kept], self.last[kept]
        return Stretches(a, b, first, last, self.moved[kept], self.least[kept], self.group[kept])


def whole(coarse: Coarse, pairs: Sequence[tuple[int, int]], groups: Sequence[int] | None = None) -> Stretches:
    """Return all pairs of shapes over the longest intervals of samples, with lower bounds of their distances."""
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
    """Apply the function `look` to a limited number of intervals at a time, to save memory, and join the results."""
    found = [look(now.of(np.arange(i, min(i + PIECE, len(now.a))))) for i in range(0, max(1, len(now.a)), PIECE)]
    return found[0] if len(found) == 1 else joined(found)


def joined(parts: Sequence[Some]) -> Some:
    """Concatenate several arrays; for tuples or objects of arrays, concatenate each component."""
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
    """Return intervals with tighter lower bounds of the distances, computed from the gaps at their middle samples."""
    if not len(now.a):
        return now
    gap = bounds(all_.placed(now.a, now.middle), all_.placed(now.b, now.middle))
    return replace(now, least=np.maximum(now.least, gap - now.moved))


def cut(all_: ShapeBatch, now: Stretches, size: int) -> Stretches:
    """Divide the intervals into shorter ones of `size` samples, and compute a bound of the motion in each."""
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
    """Smallest distance of two shapes in a time step [m], with its lower bound, time [s], nearest points (3,) and
    direction."""

    least: float
    seen: float
    t: float
    a: Moving
    b: Moving
    near: tuple[Floats, Floats]
    directions: tuple[Floats, Floats, Floats]


@dataclass(frozen=True)
class Steps:
    """Pairs of shapes between two consecutive samples, with bounds of their motion and distance [m]."""

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
        """Raise the lower bounds of the distances, by gaps along the separating directions of an earlier minimum."""
        if found is not None and len(self.least):
            raised = bounds_along(self.ends_a, self.ends_b, *found.directions) - self.turning - self.stray
            np.maximum(self.least, raised, out=self.least)

    def of(self, kept: NDArray[np.bool_] | Indices) -> "Steps":
        """Return the steps that a mask or an array of indices selects."""
        ends_a, ends_b = ((_some(x, kept), _some(y, kept)) for x, y in (self.ends_a, self.ends_b))
        a, b, k, group = self.a[kept], self.b[kept], self.k[kept], self.group[kept]
        return Steps(a, b, k, ends_a, ends_b, self.turning[kept], self.stray[kept], self.least[kept], group)


def _some(x: Placed, kept: NDArray[np.bool_] | Indices) -> Placed:
    """Return some of the poses; each component stays contiguous in memory."""
    return Placed(*(np.asarray(y).T[..., kept].T for y in x))


def steps_of(all_: ShapeBatch, now: Stretches, n: int) -> Steps:
    """Return the first time step of each interval, for the pairs of shapes that exist when the interval begins."""
    now = now.of(all_.there(now.a, now.first, now.first) & all_.there(now.b, now.first, now.first))
    k, after = now.first, np.minimum(now.first + 1, n - 1)
    ends_a, ends_b = ((all_.placed(x, k), all_.placed(x, after)) for x in (now.a, now.b))
    turning, stray = all_.turning(now.a, now.b, k, after), all_.stray(now.a, now.b, k)
    least = bounds_between(ends_a, ends_b) - turning - stray
    return Steps(now.a, now.b, k, ends_a, ends_b, turning, stray, least, now.group)


def between(a: Moving, b: Moving, k: int, turning: float, stray: float, bar: float) -> Minimum:
    """Return the smallest distance of two shapes between consecutive samples; it is exact only if it is below `bar`
    [m]."""
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
    """Return the distances [m] of pairs of shapes at a fraction `s` of a time step, reduced by the interpolation error
    `stray`."""
    x, y = _posed([(a, k) for a, _, k in pairs], s), _posed([(b, k) for _, b, k in pairs], s)
    near = exactly(x, y)
    n = near.normal
    directions = zip(n, turned(x.R.transpose(0, 2, 1), n), turned(y.R.transpose(0, 2, 1), n), strict=True)
    found = zip(pairs, near.distance.tolist(), near.a, near.b, directions, strict=True)
    return [Minimum(gap - stray, gap, _time(a.t, k, s), a, b, (p, q), along) for (a, b, k), gap, p, q, along in found]


def _time(t: Floats, k: int, s: float) -> float:
    return float(t[k] if s == 0.0 else (1 - s) * t[k] + s * t[k + 1])


def _posed(shapes: Sequence[tuple[Moving, int]], s: float) -> Placed:
    """Return each shape interpolated at fraction `s` of its step."""
    p, R, half = (np.array(column) for column in zip(*(x.at(k, s) for x, k in shapes), strict=True))
    return Placed(p, R, half, np.array([x.radius for x, _ in shapes]))
