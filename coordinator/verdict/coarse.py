"""Bounds of shapes over long intervals of samples: boxes along the world's axes, and how far the shapes leave them.

All work per sample is done once for a body: the deviation of its origin and its rotation from the pose at the middle of
an interval, and of both between samples. A point of the body moves no farther than the origin, plus per metre of its
distance as much as a point at 1 m; a point of a rope no farther than the rope's ends.
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
    """Bounds of shapes over intervals from `starts` to `ends` (inclusive): `centre` and half edges `reach` of the box
    at the middle (shapes, m, 3), largest motion of points relative to the common horizontal motion `moved` (shapes, m),
    and whether the shape is `there`."""

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
        """Return bounds (7, m) in each interval [m]: motion of the origin, and per metre from it; deviation between
        samples by accelerations, per metre from the origin, and of the quaternion; by speeds, and per metre from the
        origin."""
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
