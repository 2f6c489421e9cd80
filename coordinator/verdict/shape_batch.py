"""Many moving shapes concatenated in a few arrays, so that any number of them can be evaluated at any samples in one
call; each component is contiguous in memory."""

import numpy as np
from heavylift.nodes.plan.shapes import Strand
from numpy.typing import NDArray

from .distance import Placed
from .moving import IDENTITY, Moving
from .rotating import chords, dots, lengths, matrices, onto, product

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def _rows(columns: Floats, i: Indices) -> Floats:
    """Return columns `i` of an array (d, n) as rows (..., d)."""
    found: Floats = columns.take(i, axis=1).transpose(*range(1, i.ndim + 1), 0)
    return found


class ShapeBatch:
    """Many moving shapes with n samples each in common arrays.

    In all methods the indices `which` of shapes and `k` of samples are broadcast.
    """

    def __init__(self, shapes: list[Moving], used: Indices) -> None:
        """`used`: indices of the shapes in use."""
        some = [shapes[i] for i in used]
        self.shapes = shapes
        self._of = np.zeros(len(shapes), np.intp)  # number of a shape among those that are used
        self._of[used] = np.arange(len(used))
        self._n = n = len(shapes[0].t)
        self._centre = np.concatenate([s.centre.T for s in some], axis=1)
        strays = [s.stray if len(s.stray) else np.zeros(1) for s in some]
        self._steps = len(strays[0])
        self._stray = np.concatenate(strays)
        self._turn = np.zeros((4, sum(len(s.turn) for s in some)))
        self._begin = np.cumsum([0, *(len(s.turn) for s in some)])[:-1]  # of each shape's turns
        self._last = np.array([len(s.turn) - 1 for s in some])
        for s, i in zip(some, self._begin, strict=True):
            self._turn[: s.turn.shape[1], i : i + len(s.turn)] = s.turn.T
        self._strand = np.array([isinstance(s.shape, Strand) for s in some])
        self._reach = np.array([s.reach for s in some])
        self._half = np.array([s.half for s in some]).T
        self._radius = np.array([float(s.radius) for s in some])
        own = [IDENTITY if isinstance(s.shape, Strand) else s.shape.R for s in some]
        self._own = np.array(own) if any(R != IDENTITY for R in own) else None
        ropes = [s.there for s in some if s.there is not None]  # the others are always there
        self._count = np.zeros((1 + len(ropes), n + 1), np.int32)  # of samples before each at which one is there
        self._count[0] = np.arange(n + 1)
        for count, there in zip(self._count[1:], ropes, strict=True):
            np.cumsum(there, out=count[1:])
        comes = np.array([s.there is not None for s in some])
        self._row = np.where(comes, np.cumsum(comes), 0)

    def there(self, which: Indices, first: Indices, last: Indices) -> NDArray[np.bool_]:
        """Return whether shapes exist at any sample from `first` to `last`."""
        i = self._row[self._of[which]]
        found: NDArray[np.bool_] = self._count[i, last + 1] > self._count[i, first]
        return found

    def centre(self, which: Indices, k: Indices) -> Floats:
        """Return the centres (..., 3) [m] of shapes at samples."""
        return _rows(self._centre, self._of[which] * self._n + k)

    def placed(self, which: Indices, k: Indices) -> Placed:
        """Return the poses of m shapes, each shape at the sample with its number in `k`."""
        i = self._of[which]
        turn = self._turns(i, k)
        R, half = np.empty((3, 3, len(i))).transpose(2, 0, 1), _rows(self._half, i)
        strand = self._strand[i]
        if strand.any():
            along = turn[strand, :3]
            length = lengths(along)
            R[strand] = onto(along / np.maximum(length, 1e-9)[:, None])
            half[strand, 2] = length / 2
        if not strand.all():
            solid = ~strand
            R[solid] = (
                matrices(turn[solid]) if self._own is None else product(matrices(turn[solid]), self._own[i[solid]])
            )
        return Placed(self.centre(which, k), R, half, self._radius[i])

    def moved(self, a: Indices, b: Indices, k: Indices, r: Indices) -> Floats:
        """Return upper bounds (m,) [m] of the motion of shapes `a` relative to shapes `b` from samples r to samples
        k."""
        apart = self.centre(a, k) - self.centre(b, k) - (self.centre(a, r) - self.centre(b, r))
        distance = lengths(apart)
        for which in (a, b):
            self._spin(which, k, r, distance)
        return distance

    def stray(self, a: Indices, b: Indices, k: Indices) -> Floats:
        """Return the sum of the upper bounds [m] of the interpolation errors of two shapes after sample k."""
        j = np.minimum(k, self._steps - 1)
        found: Floats = self._stray[self._of[a] * self._steps + j] + self._stray[self._of[b] * self._steps + j]
        return found

    def turning(self, a: Indices, b: Indices, k: Indices, r: Indices) -> Floats:
        """Return upper bounds (m,) [m] of the deviation of relative motion from a straight line, due to rotation
        between samples.

        It is h^2 / 8 times the accelerations w^2 y and 2 w v.
        """
        y = lengths(self.centre(b, k) - self.centre(a, k)) + self._reach[self._of[a]] + self._reach[self._of[b]]
        v, w = self.moved(a, b, k, r), self._angles(a, k, r) + self._angles(b, k, r)
        found: Floats = w * w * y / 8.0 + w * v / 4.0
        return found

    def _turns(self, i: Indices, k: Indices) -> Floats:
        return _rows(self._turn, self._begin[i] + np.minimum(k, self._last[i]))

    def _spin(self, which: Indices, k: Indices, r: Indices, way: Floats) -> None:
        """Add the motion by rotation and stretch of shapes about their centres to `way`; `which` (m,) or (m, 1), k and
        r of the same or a wider shape."""
        i = self._of[which]
        flat = i.reshape(-1)
        for some, strand in ((self._strand, True), (~self._strand, False)):
            here = np.flatnonzero(some[flat] & (self._last[flat] > 0))
            if not len(here):
                continue
            one, two = self._turns(i[here], k[here]), self._turns(i[here], r[here])
            way[here] += lengths((one - two)[..., :3]) / 2 if strand else chords(one, two) * self._reach[i[here]]

    def _angles(self, which: Indices, k: Indices, r: Indices) -> Floats:
        """Return an upper bound (m,) of the rotations of solids [rad]; strands count as 0."""
        i = self._of[which]
        w = np.minimum(1.0, np.abs(dots(self._turns(i, k), self._turns(i, r))))
        found: Floats = np.where(self._strand[i] | (self._last[i] == 0), 0.0, 2.0 * np.arccos(w))
        return found
