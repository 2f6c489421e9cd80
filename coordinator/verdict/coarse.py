"""Where shapes are in long stretches of samples: boxes along the world's axes, and how far they go beyond them.

All that takes a look at each sample is done once for a body: how far its origin and its turn leave their places at the
middle of a stretch, and what both may stray between samples.  A point of the body goes no farther than the origin, and
for each metre that it is away from it as much as a point at 1 m; a point of a rope no farther than the ends of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from heavylift.nodes.plan.shapes import Strand
from numpy.typing import NDArray

from .moving import Frame, Moving, box, posed, size
from .rotating import chords, lengths

__all__ = ["LONGEST", "Coarse"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
LONGEST = 64  # samples in a stretch


class _Ways(NamedTuple):
    """Of a body in each stretch (m,), the most [m], and the most of a point for each metre that it is away from the
    origin: ways from the middle, and strays by accelerations, by them as quaternions, and by speeds."""

    way: Floats
    spun: Floats
    bend: Floats
    turning: Floats
    quaternion: Floats
    shake: Floats
    shaking: Floats


class Coarse:
    """Shapes in stretches from `starts` to `ends`, both included: of each at the middle its `centre` and half edges
    `reach` of its box (shapes, m, 3), how far points `moved` from there against a horizontal motion that all share
    (shapes, m), and whether it is `there` at any sample."""

    def __init__(self, shapes: Sequence[Moving], common: Floats, between: tuple[int, int]) -> None:
        """`common` (n, 2) [m]; `between`: the first and the last sample."""
        first, last = between
        self.starts: Indices = np.arange(first, max(first + 1, last), LONGEST)
        self.ends = np.minimum(self.starts + LONGEST, last)
        self.middles: Indices = (self.starts + self.ends) // 2
        self._common = common
        ways: dict[Frame, _Ways] = {}
        for frame in {frame: None for s in shapes for frame, _ in s.on}:
            ways[frame] = self._ways(frame)
        poses = [posed(s, self.middles) for s in shapes]
        self.centre = np.array([centre for centre, _ in poses])
        self.reach = np.array([np.broadcast_to(box(s, turn), p.shape) for s, (p, turn) in zip(shapes, poses, strict=True)])
        self.moved = np.array([_moved(s, [(ways[frame], size(p)) for frame, p in s.on]) for s in shapes])
        self.there = np.array([self._there(s) for s in shapes])

    def _ways(self, frame: Frame) -> _Ways:
        inside = slice(self.starts[0], self.ends[-1] + 1)
        counts = np.diff(self.starts, append=self.ends[-1] + 1)
        path = frame.p.copy(order="K")
        path[:, :2] -= self._common
        way = lengths(path[inside] - _repeated(path[self.middles], counts))
        way = np.maximum(self._most(way), lengths(path[self.ends] - path[self.middles]))  # the first of the next
        spun, q = np.zeros(len(way)), frame.turn
        if len(q) > 1:
            spun = self._most(chords(q[inside], _repeated(q[self.middles], counts)))
            spun = np.maximum(spun, chords(q[self.ends], q[self.middles]))
        strays = frame.strays, *reversed(frame.turn_strays), *frame.shakes
        return _Ways(way, spun, *(self._most(np.append(x, 0.0)[inside]) for x in strays))

    def _most(self, x: Floats) -> Floats:
        """(m,) in each stretch but for its last sample."""
        found: Floats = np.maximum.reduceat(x, self.starts - self.starts[0])
        return found

    def _there(self, s: Moving) -> NDArray[np.bool_]:
        if s.there is None:
            return np.ones(len(self.starts), bool)
        found: NDArray[np.bool_] = np.logical_or.reduceat(s.there, self.starts) | s.there[self.ends]
        return found


def _moved(s: Moving, on: Sequence[tuple[_Ways, float]]) -> Floats:
    """(m,) how far points of a shape leave their places; each body with the distance from its origin [m]."""
    reach = 0.0 if isinstance(s.shape, Strand) else s.reach
    way = np.max([x.way + (away + reach) * x.spun for x, away in on], axis=0)
    bend = np.sum([x.bend + away * x.turning + 2.0 * reach * x.quaternion for x, away in on], axis=0)
    shake = [x.shake + (away + reach) * x.shaking for x, away in on]
    found: Floats = way + np.max([bend, *shake], axis=0)
    return found


def _repeated(x: Floats, counts: Indices) -> Floats:
    """Rows of x (m, k), each as often as said; each column in one piece of memory."""
    found: Floats = np.repeat(np.ascontiguousarray(x.T), counts, axis=1).T
    return found
