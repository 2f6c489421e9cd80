"""Smallest distances over time: branch and bound, so that no minimum between samples is missed.

An interval of samples is bounded by the gap at one of them less the relative motion of the two shapes within it;
intervals that cannot hold a smaller distance than the known one are dropped, the others cut, down to steps from a
sample to the next. In a step shapes move straight, so the gap along a direction is least at an end of it; their
possible deviation (see `moving`) lowers the bound. The minimum that is found is at most `SHARP` above the true one.

All pairs of things are searched together, level by level: known distances of some also bound the search for others.
"""

import numpy as np
from numpy.typing import NDArray

from .intervals import SHARP, SIZES, Minimum, Steps, Stretches, between, bounded, cut, in_pieces, seen, steps_of
from .moving import Moving
from .shape_batch import ShapeBatch

Floats = NDArray[np.float64]
PROMISING = 3  # stretches of two things that are looked at exactly on each level


class NearestSoFar:
    """The smallest distance found so far for each group of shape pairs, and the bounds for the further search.

    For groups without a bound of their own (`most` infinite), all distances below `limit` and the `smallest` ones are
    searched.
    """

    def __init__(self, smallest: int, limit: float) -> None:
        self.found: list[Minimum | None] = []
        self.smallest, self._limit = smallest, limit
        self._least = np.zeros(0)

    def groups(self, most: Floats) -> None:
        """Set, for each group of shape pairs, the bound `most` (groups,) [m] above which distances are ignored."""
        self._most, self.free = most, np.flatnonzero(np.isinf(most))
        self.found += [None] * (len(most) - len(self.found))
        self._least = np.append(self._least, np.full(len(most) - len(self._least), np.inf))
        self.message = self._tell()

    @property
    def seen(self) -> int:
        """Number of groups of shape pairs for which a distance was found."""
        return int(np.isfinite(self._least).sum())

    def take(self) -> list[Minimum | None]:
        """Return the smallest distance found for each group since the last call; None for a group without a new one."""
        found, self.found = self.found, [None] * len(self.found)
        return found

    def add(self, group: int, found: Minimum) -> None:
        """Record a distance of a group if it is smaller than all known distances of the group."""
        if found.least < self._least[group]:
            self._least[group], self.found[group] = found.least, found
            self.message = self._tell()

    def bars(self) -> Floats:
        """Return for each group (groups,) the bound [m] below which an interval can still contain a distance of
        interest."""
        found: Floats = np.minimum(np.minimum(self._most, self.message), self._least - SHARP)
        return found

    def _tell(self) -> float:
        if not 0 < self.smallest <= len(self.free):
            return np.inf
        last = np.partition(self._least[self.free], self.smallest - 1)[self.smallest - 1]
        return max(float(last), self._limit)

    def open(self, now: Stretches) -> Stretches:
        """Return the intervals in which a distance smaller than the smallest known one is still possible."""
        return now.of(now.least < self.bars()[now.group])

    def bar(self, group: int) -> float:
        """Return the distance [m] of this group above which the search can skip an interval."""
        return min(float(self._most[group]), self.message, float(self._least[group]) - SHARP)


def search(shapes: list[Moving], start: Stretches, known: NearestSoFar) -> None:
    """Search intervals of pairs of moving shapes for distances below the `known` ones; record them in `known`."""
    if known.smallest and len(start.a):
        _begin(shapes, start, known)
    now = known.open(start)
    if len(now.a):
        all_ = ShapeBatch(shapes, np.flatnonzero(np.bincount(np.concatenate([now.a, now.b]))))
        for size in (*SIZES[1:], 0):
            now = known.open(in_pieces(now, lambda some: bounded(all_, some)))
            _look(shapes, now, known)
            now = known.open(now)
            if size:
                now = in_pieces(now, lambda some, size=size: cut(all_, some, size))  # type: ignore[misc]
        _step(all_, now, known)


def _begin(shapes: list[Moving], start: Stretches, known: NearestSoFar) -> None:
    """Evaluate promising samples of the nearest groups until enough distances are known."""
    least = np.full(len(known.found), np.inf)
    np.minimum.at(least, start.group, start.least)
    order = known.free[np.argsort(least[known.free], kind="stable")]
    order = order[np.isfinite(least[order])]
    while len(order) and known.seen < known.smallest:
        chosen = np.zeros(len(least), bool)
        chosen[order[: 2 * known.smallest]] = True
        some = start.of(chosen[start.group])
        _look(shapes, some, known, 1)
        order = order[2 * known.smallest :]


def _look(shapes: list[Moving], now: Stretches, known: NearestSoFar, each: int = PROMISING) -> None:
    """Evaluate the middle samples of the most promising intervals of each group exactly."""
    gap, middle = now.least + now.moved, now.middle
    order = np.lexsort((gap, now.group))
    group = now.group[order]
    rank = np.arange(len(group)) - np.searchsorted(group, group)
    order = order[(rank < each) & (gap[order] < known.bars()[group])]
    pairs = [(shapes[now.a[i]], shapes[now.b[i]], int(middle[i])) for i in order.tolist()]
    there = [all(s.there is None or s.there[k] for s in (a, b)) for a, b, k in pairs]
    order, pairs = order[there], [pair for pair, here in zip(pairs, there, strict=True) if here]
    for i, found in zip(order.tolist(), seen(pairs) if pairs else (), strict=True):
        g = int(now.group[i])
        if gap[i] < known.bar(g):
            known.add(g, found)


def _step(all_: ShapeBatch, now: Stretches, known: NearestSoFar) -> None:
    """Search steps from a sample to the next, those with the smallest bounds first."""
    n, bars = len(all_.shapes[0].t), known.bars()

    def near(some: Stretches) -> Steps:
        found = steps_of(all_, some, n)
        return found.of(found.least < bars[found.group])

    everything = in_pieces(now, near)
    groups = np.flatnonzero(np.bincount(everything.group))
    least = [float(everything.least[everything.group == g].min()) for g in groups]
    for g in groups[np.argsort(least, kind="stable")].tolist():
        steps = everything.of(everything.group == g)
        steps.sharpen(known.found[g])
        while len(steps.least):
            i = int(np.argmin(steps.least))
            bar = known.bar(g)
            if steps.least[i] >= bar:
                break
            a, b = all_.shapes[steps.a[i]], all_.shapes[steps.b[i]]
            found = between(a, b, int(steps.k[i]), float(steps.turning[i]), float(steps.stray[i]), bar)
            known.add(g, found)
            steps.least[i] = np.inf
            steps = steps.of(steps.least < known.bar(g))
            steps.sharpen(found)
