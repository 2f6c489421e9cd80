"""Shapes in motion: the pose of each shape of a scene at every sample, and bounds of its deviation in between.

A shape is a rounded box: half edges `half` along the columns of R, and a radius around it; ropes are capsules whose
axis is the third column, balls have no edges. Between two samples its centre and ends are interpolated linearly; they
deviate from this by at most h^2 / 8 times their acceleration, which is taken as twice the largest second difference at
both samples. Vibration faster than the samples shows in the speeds of joints, which raise the bound.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import hypot, sqrt

import numpy as np
from heavylift.kernel.description.mechanics import WORLD, Joint, Vector
from heavylift.nodes.plan.shapes import Shapes, Solid, Strand
from numpy.typing import NDArray

from .history import History
from .rotating import Twist, axes_onto, dots, lengths, matrices, onto, product, strays, twists

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
SHORTEST = 1e-9  # [m] of a strand that has a direction
DOUBT = 2.0  # on accelerations that are known from samples alone
STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class BodyTrack:
    """Motion of a body: origin p (n, 3) [m] and quaternions (n, 4), or (1, 4) without rotation."""

    def __init__(self, t: Floats, pose: Floats) -> None:
        pose = np.asfortranarray(pose)  # each column in one piece of memory
        self._pose = pose
        self.twist: Twist | None = None
        self._places: dict[Vector, Floats] = {}
        self.t, self.p = t, pose[:, :3]
        q = pose[:, 3:]
        self.turn = q if (q != q[0]).any() else q[:1]

    @cached_property
    def R(self) -> Floats:
        """Rotation matrices of the body (n, 3, 3), or (1, 3, 3) if it does not rotate."""
        return matrices(self.turn)

    @cached_property
    def strays(self) -> Floats:
        """Upper bound (n - 1,) [m] of the deviation of the body's origin from straight lines between samples, computed
        from accelerations."""
        return _bend(self.t, self.p)

    @cached_property
    def turn_strays(self) -> tuple[Floats, Floats]:
        """Upper bounds (n - 1,) of the errors that arise between samples if the orientation of a shape is
        interpolated linearly.

        Error of the quaternion, and displacement of a point per metre of its distance from the origin.
        """
        if len(self.turn) == 1:
            return (np.zeros(max(0, len(self.t) - 1)),) * 2
        return _turn_bend(self.t, self.turn)

    @cached_property
    def shakes(self) -> tuple[Floats, Floats]:
        """Upper bounds (n - 1,) of the deviation of the body from straight motion between samples, computed from
        joint speeds.

        Displacement of its origin [m], and of a point per metre of its distance from the origin.
        """
        if self.twist is None:
            nothing = np.zeros(max(0, len(self.t) - 1))
            return nothing, nothing
        return strays(self.t, self._pose, self.twist)

    def place(self, x: Vector) -> Floats:
        """Return the world positions (n, 3) [m] of a point of the body at all samples."""
        if x not in self._places:
            self._places[x] = _place(self.p, self.R, x)
        return self._places[x]

    def place_at(self, x: Vector, k: Indices) -> Floats:
        """Return the world positions (m, 3) of a point of the body at some samples [m]."""
        return _place(self.p[k], self.R if len(self.R) == 1 else self.R[k], x)


def _place(p: Floats, R: Floats, x: Vector) -> Floats:
    for i, xi in enumerate(x):
        if xi:
            p = p + xi * R[:, :, i]
    return p


@dataclass(frozen=True)
class Moving:
    """A solid or a rope strand in motion over n samples; `there` (n,): at which samples the shape exists and can be
    checked."""

    shape: Solid | Strand
    on: tuple[tuple[BodyTrack, Vector], ...]
    there: NDArray[np.bool_] | None = None
    straight: bool = False

    @property
    def t(self) -> Floats:
        """Sample times (n,) [s]."""
        return self.on[0][0].t

    @cached_property
    def centre(self) -> Floats:
        """Centre of the shape (n, 3) [m]."""
        places = [frame.place(p) for frame, p in self.on]
        return places[0] if len(places) == 1 else (places[0] + places[1]) / 2

    @cached_property
    def turn(self) -> Floats:
        """Quaternions (n, 4) of a solid, or vectors (n, 3) from end to end of a strand; n is 1 if the shape does not
        rotate."""
        if isinstance(self.shape, Solid):
            return self.on[0][0].turn
        first, second = (frame.place(p) for frame, p in self.on)
        return second - first

    @cached_property
    def half(self) -> Floats:
        """Half edges of the shape's box (3,) [m]; the third one of a strand is half its greatest length in the run."""
        if isinstance(self.shape, Strand):
            return np.array([0.0, 0.0, float(lengths(self.turn).max()) / 2])
        return np.zeros(3) if self.shape.form == "ball" else np.array(self.shape.size) / 2

    @cached_property
    def radius(self) -> float:
        """Radius [m] by which the rounded surface of a shape lies outside its inner box or line."""
        if isinstance(self.shape, Strand):
            return self.shape.radius
        return self.shape.size[0] / 2 if self.shape.form == "ball" else 0.0

    @cached_property
    def reach(self) -> float:
        """Distance [m] of the farthest point of the inner box or line from its centre, without the rounding radius."""
        return float(lengths(self.half))

    def axes_of(self, turn: Floats) -> tuple[Floats, Floats]:
        """Return rotations R (m, 3, 3) and half edges (m, 3) of the shape for m orientations, given as in `turn`."""
        if isinstance(self.shape, Strand):
            length = lengths(turn)
            half = np.zeros((len(turn), 3))
            half[:, 2] = length / 2
            return onto(turn / np.maximum(length, SHORTEST)[:, None]), half
        R = matrices(turn)
        if self.shape.R != IDENTITY:
            R = product(R, np.array(self.shape.R))
        return R, np.broadcast_to(self.half, (len(turn), 3))

    def at(self, k: int, s: float) -> tuple[Floats, Floats, Floats]:
        """Return centre (3,), rotation matrix (3, 3) and half edges (3,) of the shape at fraction `s` between the
        samples k and k + 1."""
        p, turn = self._between(k, s)
        if isinstance(self.shape, Strand):
            x, y, z = turn.tolist()
            length = sqrt(x * x + y * y + z * z)
            far = max(length, SHORTEST)
            return p, axes_onto(x / far, y / far, z / far), np.array([0.0, 0.0, length / 2])
        x, y, z, w = turn.tolist()
        rows = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
        R = np.array(rows)
        return p, R if self.shape.R == IDENTITY else product(R, np.array(self.shape.R)), self.half

    def _between(self, k: int, s: float) -> tuple[Floats, Floats]:
        if s == 0.0:
            return self.centre[k], self.turn[min(k, len(self.turn) - 1)]
        p = (1 - s) * self.centre[k] + s * self.centre[k + 1]
        if len(self.turn) == 1:
            return p, self.turn[0]
        a, b = self.turn[k], self.turn[k + 1]
        if self.turn.shape[1] == 4:
            b = b if dots(a, b) >= 0.0 else -b
            q = (1 - s) * a + s * b
            return p, q / lengths(q)
        return p, (1 - s) * a + s * b

    @cached_property
    def stray(self) -> Floats:
        """Upper bound (n - 1,) [m] of the error of the shape's position if it is interpolated between samples."""
        if self.straight:
            return np.zeros(max(0, len(self.t) - 1))
        reach, found = self.reach if isinstance(self.shape, Solid) else 0.0, self._bent
        for frame, p in self.on:
            origin, turn = frame.shakes
            found = np.maximum(found, origin + (size(p) + reach) * turn)
        return found

    @property
    def _bent(self) -> Floats:
        """Bound (n - 1,) of the deviation from interpolated positions by accelerations of the sampled poses [m]."""
        frame, p = self.on[0]
        if isinstance(self.shape, Strand):
            return _bend(self.t, self.centre) + _bend(self.t, self.turn) / 2
        if len(self.turn) == 1:
            return frame.strays
        return (_bend(self.t, self.centre) if any(p) else frame.strays) + 2.0 * self.reach * frame.turn_strays[0]


def size(p: Vector) -> float:
    """Return the distance of a point from the origin [m]."""
    return hypot(*p)


def posed(s: Moving, k: Indices) -> tuple[Floats, Floats]:
    """Return centre (m, 3) and orientation of a shape at m samples: quaternions (m or 1, 4) or, for a strand, vectors
    (m, 3)."""
    places = [frame.place_at(p, k) for frame, p in s.on]
    if len(places) == 2:
        return (places[0] + places[1]) / 2, places[1] - places[0]
    turn = s.on[0][0].turn
    return places[0], turn if len(turn) == 1 else turn[k]


def box(s: Moving, turn: Floats) -> Floats:
    """Return half edges (m, 3) [m] of the box along the world's axes that encloses a shape."""
    if isinstance(s.shape, Strand):
        return np.abs(turn) / 2 + s.radius
    R, half = s.axes_of(turn)
    found: Floats = (np.abs(R) * half[:, None, :]).sum(axis=2) + s.radius
    return found


def moving(shapes: Shapes, history: History, joints: Sequence[Joint] = ()) -> list[Moving]:
    """Return all solids and taut ropes with their motions over a history, except solids whose pose is not recorded.

    `joints`: joints whose speeds show vibration of bodies between samples.
    """
    n = len(history.t)
    if not n:
        return []
    frames = {name: BodyTrack(history.t, pose) for name, pose in history.poses.items()}
    frames[WORLD] = BodyTrack(history.t, np.tile(STILL, (n, 1)))
    for body, twist in twists(joints, frames, history.speeds).items():
        frames[body].twist = twist
    straight = history.straight
    found = [Moving(s, ((frames[s.body], s.centre),), None, straight) for s in shapes.solids if s.body in frames]
    return found + _ropes(shapes, history, frames)


def _ropes(shapes: Shapes, history: History, frames: dict[str, BodyTrack]) -> list[Moving]:
    """Return straight rope lines while they hang and are taut, without those along their own crane."""
    known = shapes.strands
    found: dict[tuple[str, str, Vector, str, Vector], NDArray[np.bool_]] = {}
    taut = {name: tension > 0.0 for name, tension in history.tensions.items()}
    for i, rig in enumerate(history.rigs):
        end = history.rigs[i + 1].t_ns * 1e-9 if i + 1 < len(history.rigs) else np.inf
        first = int(np.searchsorted(history.t, rig.t_ns * 1e-9, side="left"))
        last = int(np.searchsorted(history.t, end, side="right"))
        for line in rig.lines:
            rope = line.rope.partition("~")[0]  # of the pieces of a rope with mass
            along = line.a_body != WORLD and shapes.root(line.a_body) == shapes.root(line.b_body)
            if rope in known and rope in history.tensions and not along:
                key = rope, line.a_body, line.a, line.b_body, line.b
                there = found.setdefault(key, np.zeros(len(history.t), bool))
                there[first:last] |= taut[line.rope][first:last] if line.rope in taut else True
    return [
        Moving(known[rope], ((frames[a_body], a), (frames[b_body], b)), there, history.straight)
        for (rope, a_body, a, b_body, b), there in found.items()
        if there.any() and a_body in frames and b_body in frames
    ]


def _turn_bend(t: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """Return bounds (n - 1,) for rotations q (n, 4): of the quaternion, and of points 1 m from the axis, where R'' is
    at most 2 |q''| + 2 |q'|^2."""
    q = turn.copy(order="K")
    q[1:] *= np.cumprod(np.where(dots(q[1:], q[:-1]) < 0.0, -1.0, 1.0))[:, None]
    h, found = np.diff(t), _bend(t, q)
    if len(t) < 3:
        return found, found
    distance = q[1:] - q[:-1]
    square = dots(distance, distance) / np.maximum(h, 1e-9)
    accel = np.zeros(len(t))
    accel[1:-1] = 2.0 * (square[1:] + square[:-1]) / np.maximum(h[1:] + h[:-1], 1e-9)
    return found, 2.0 * found + _between(h, accel)


def _bend(t: Floats, x: Floats) -> Floats:
    """Return the bound (n - 1,) of the deviation of x (n, d) from its chord: h^2 / 8 times its acceleration."""
    n = len(t)
    if n < 3:
        return np.zeros(max(0, n - 1))
    h = np.diff(t)
    slope = np.diff(x.T) / np.maximum(h, 1e-9)
    slope[:, h <= 0.0] = 0.0
    accel = np.empty(n)
    accel[1:-1] = 2.0 * lengths(np.diff(slope).T) / np.maximum(h[1:] + h[:-1], 1e-9)
    return _between(h, accel)


def _between(h: Floats, accel: Floats) -> Floats:
    """Return the deviation from a chord (n - 1,) by accelerations at the samples, those at both ends extrapolated."""
    accel[0], accel[-1] = accel[1], accel[-2]
    found: Floats = DOUBT * h * h / 8.0 * np.maximum(accel[:-1], accel[1:])
    return found
