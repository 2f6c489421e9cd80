"""Where shapes are in long stretches of samples: boxes along the world's axes, and how far they go beyond them.

All that takes a look at each sample is done once for a body: how far its origin and its turn leave their places at the
middle of a stretch, and what both may stray between samples.  A point of the body goes no farther than the origin, and
for each metre that it is away from it as much as a point at 1 m; a point of a rope no farther than the ends of that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from heavylift.nodes.plan.shapes import Strand
from numpy.typing import NDArray

from .moving import BodyTrack, Moving, box, posed, size
from .rotating import chords, lengths

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
LONGEST = 64  # samples in a stretch


class Coarse:
    """Shapes over intervals from `starts` to `ends` (inclusive): at the middle `centre` and half edges `reach` of the
    box (shapes, m, 3), motion of points against the common horizontal motion `moved` (shapes, m), and whether it is
    `there`."""

    def __init__(self, shapes: Sequence[Moving], common: Floats, between: tuple[int, int]) -> None:
        """`common` (n, 2) [m]; `between`: the first and the last sample."""
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
        """Bounds (7, m) in each interval [m]: motion of the origin and per metre from it, the same by accelerations, of
        the quaternion, and by speeds."""
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
        """Maximum (m,) in each interval without its last sample."""
        found: Floats = np.maximum.reduceat(x, self.starts - self.starts[0])
        return found

    def _there(self, s: Moving) -> NDArray[np.bool_]:
        if s.there is None:
            return np.ones(len(self.starts), bool)
        found: NDArray[np.bool_] = np.logical_or.reduceat(s.there, self.starts) | s.there[self.ends]
        return found


def _repeated(x: Floats, counts: Indices) -> Floats:
    """Rows of x (m, k) repeated `counts` times, column-contiguous."""
    found: Floats = np.repeat(np.ascontiguousarray(x.T), counts, axis=1).T
    return found
