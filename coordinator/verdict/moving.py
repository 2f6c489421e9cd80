"""Shapes in motion: where each shape of a scene is at every sample, and how far it may stray from that in between.

A shape is a rounded box: half edges `half` along the columns of R, and a radius around it; ropes are capsules whose
axis is the third column, balls have no edges.  Between two samples its middle and its ends go straight, and stray from
that by at most h^2 / 8 times their acceleration, which is taken as twice the largest that second differences show at
both samples; the speeds that samples hold are those of joints, so poses alone are used.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from heavylift.kernel.describe import Vector
from heavylift.nodes.limits.shapes import Solid, Strand, solids, strands
from heavylift.nodes.scene.plan import Plan
from numpy.typing import NDArray

from .history import History

__all__ = ["Moving", "moving"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
DOUBT = 2.0  # on accelerations that are known from samples alone
WORLD = "world"


@dataclass(frozen=True)
class Moving:
    """A shape over n samples: `centre` (n, 3), `spin` (n, 3, k) half edges as vectors in the world, which turn and
    stretch about it [m]; `half` (3,) and `radius` [m]; `there` (n,): whether it is there at all and can be judged."""

    shape: Solid | Strand
    t: Floats
    centre: Floats
    turn: Floats  # (n, 4) quaternions of a solid, or (n, 3) from end to end of a strand; n = 1: it never turns
    half: Floats
    radius: float
    there: NDArray[np.bool_] | None = None

    @property
    def reach(self) -> float:
        """Of its farthest point from its middle, but for the radius [m]."""
        return float(np.linalg.norm(self.half))

    def axes(self, k: Indices) -> tuple[Floats, Floats]:
        """R (m, 3, 3) and half edges (m, 3) at these samples."""
        turn = self.turn[np.minimum(k, len(self.turn) - 1)]
        return self.axes_of(turn)

    def axes_of(self, turn: Floats) -> tuple[Floats, Floats]:
        """The same of turns (m, 3 or 4)."""
        if isinstance(self.shape, Strand):
            length = np.linalg.norm(turn, axis=1)
            half = np.zeros((len(turn), 3))
            half[:, 2] = length / 2
            return _onto(turn / np.maximum(length, 1e-9)[:, None]), half
        R = matrices(turn)
        if self.shape.R != IDENTITY:
            R = R @ np.array(self.shape.R)
        return R, np.broadcast_to(self.half, (len(turn), 3))

    def between(self, k: int, s: float) -> tuple[Floats, Floats]:
        """Middle (3,) and turn at the part s from sample k to the next."""
        p = (1 - s) * self.centre[k] + s * self.centre[k + 1]
        if len(self.turn) == 1:
            return p, self.turn[0]
        a, b = self.turn[k], self.turn[k + 1]
        if self.turn.shape[1] == 4:
            b = b if a @ b >= 0.0 else -b
            q = (1 - s) * a + s * b
            return p, q / np.linalg.norm(q)
        return p, (1 - s) * a + s * b

    def spun(self, k: Indices, r: Indices) -> Floats:
        """(m,) by how much points of the shape are moved about its middle from samples r to samples k, at most [m]."""
        if len(self.turn) == 1:
            return np.zeros(len(k))
        a, b = self.turn[k], self.turn[r]
        if self.turn.shape[1] == 4:  # a chord of the turn
            w = np.minimum(1.0, np.abs((a * b).sum(axis=1)))
            chord: Floats = 2.0 * np.sqrt(1.0 - w * w) * self.reach
            return chord
        half: Floats = lengths(a - b) / 2
        return half

    def turned_by(self, k: Indices, r: Indices) -> Floats:
        """(m,) angles by which the shape turns from samples r to samples k [rad], at most; a strand's are small."""
        if len(self.turn) == 1 or self.turn.shape[1] != 4:
            return np.zeros(len(k))
        w = np.abs((self.turn[k] * self.turn[r]).sum(axis=1))
        angle: Floats = 2.0 * np.arccos(np.minimum(1.0, w))
        return angle

    @cached_property
    def stray(self) -> Floats:
        """(n - 1,) how far a point of the shape may be between two samples from where it is taken to be [m]."""
        found = _bend(self.t, self.centre)
        if len(self.turn) > 1:
            if self.turn.shape[1] == 4:
                q = self.turn.copy()
                q[1:] *= np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))[:, None]
                found = found + 2.0 * self.reach * _bend(self.t, q)  # a turn by a small angle moves q by half of it
            else:
                found = found + _bend(self.t, self.turn) / 2
        return found


IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def moving(plan: Plan, history: History) -> list[Moving]:
    """All shapes of a plan as they moved; what has no pose on record is left out."""
    found = []
    for solid in solids(plan):
        if solid.body == WORLD:
            centre, turn = np.tile(solid.centre, (len(history.t), 1)), np.array([[0.0, 0.0, 0.0, 1.0]])
        elif solid.body in history.poses:
            pose = history.poses[solid.body]
            turn = _turn(pose)
            centre = pose[:, :3] + turned(turn, solid.centre)
        else:
            continue
        half, radius = (np.zeros(3), solid.size[0] / 2) if solid.form == "ball" else (np.array(solid.size) / 2, 0.0)
        found.append(Moving(solid, history.t, centre, turn, half, radius))
    return found + _ropes(plan, history)


def _ropes(plan: Plan, history: History) -> list[Moving]:
    """Each straight line of a rope while it hangs and carries."""
    known = strands(plan)
    found: dict[tuple[str, str, Vector, str, Vector], NDArray[np.bool_]] = {}
    for i, rig in enumerate(history.rigs):
        end = history.rigs[i + 1].t_ns * 1e-9 if i + 1 < len(history.rigs) else np.inf
        inside = (history.t >= rig.t_ns * 1e-9) & (history.t <= end)
        for line in rig.lines:
            rope = line.rope.partition("~")[0]  # of the pieces of a rope with mass
            if rope in known and rope in history.tensions:
                key = rope, line.a_body, line.a, line.b_body, line.b
                taut = inside & (history.tensions[line.rope] > 0.0) if line.rope in history.tensions else inside
                found[key] = found.get(key, np.zeros(len(inside), bool)) | taut
    out = []
    for (rope, a_body, a, b_body, b), there in found.items():
        if not there.any():
            continue
        ends = [_places(history, body, p) for body, p in ((a_body, a), (b_body, b))]
        if any(end is None for end in ends):
            continue
        p, q = ends
        assert p is not None
        assert q is not None
        along = q - p
        half = np.array([0.0, 0.0, float(np.linalg.norm(along, axis=1).max()) / 2])
        shape = known[rope]
        out.append(Moving(shape, history.t, (p + q) / 2, along, half, shape.radius, there))
    return out


def _places(history: History, body: str, p: tuple[float, float, float]) -> Floats | None:
    """(n, 3) where a point of a body is in the world; None if the body is not on record."""
    if body == WORLD:
        return np.tile(p, (len(history.t), 1))
    if body not in history.poses:
        return None
    pose = history.poses[body]
    return pose[:, :3] + turned(_turn(pose), p)


def _turn(pose: Floats) -> Floats:
    """(n, 4) quaternions of a body, (1, 4) of one that never turns."""
    q = pose[:, 3:]
    return q if (q != q[0]).any() else q[:1]


def turned(q: Floats, p: tuple[float, float, float]) -> Floats:
    """(n, 3) a point turned by each of n quaternions x y z w."""
    u, w, x = q[:, :3], q[:, 3:], np.array(p)
    if not x.any():
        return np.zeros((len(q), 3))
    return x + 2.0 * cross(u, cross(u, np.broadcast_to(x, u.shape)) + w * x)


def cross(a: Floats, b: Floats) -> Floats:
    """(n, 3) cross products; NumPy's own takes four times as long."""
    (x, y, z), (u, v, w) = a.T, b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def lengths(x: Floats) -> Floats:
    """(n,) norms of n vectors; NumPy's own takes three times as long."""
    found: Floats = np.sqrt(np.einsum("ij,ij->i", x, x))
    return found


def matrices(q: Floats) -> Floats:
    """(n, 3, 3) of unit quaternions x y z w."""
    x, y, z, w = q.T
    R = np.empty((len(q), 3, 3))
    R[:, 0, 0], R[:, 1, 1], R[:, 2, 2] = 1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z), 1 - 2 * (x * x + y * y)
    R[:, 0, 1], R[:, 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    R[:, 0, 2], R[:, 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    R[:, 1, 2], R[:, 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return R


def _onto(n: Floats) -> Floats:
    """(m, 3, 3) rotations whose third column is a unit vector (Duff et al. 2017, JCGT 6(1), Building an orthonormal
    basis, revisited)."""
    x, y, z = n.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    R = np.empty((len(n), 3, 3))
    R[:, :, 0] = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    R[:, :, 1] = np.stack([b, sign + y * y * a, -y], axis=1)
    R[:, :, 2] = n
    return R


def _bend(t: Floats, x: Floats) -> Floats:
    """(n - 1,) bound on how far x (n, d) leaves its chord between two samples: h^2 / 8 times its acceleration."""
    n = len(t)
    if n < 3:
        return np.zeros(max(0, n - 1))
    h = np.diff(t)
    step = np.maximum(h, 1e-9)[:, None]
    slope = np.where(h[:, None] > 0.0, np.diff(x, axis=0) / step, 0.0)
    jump = lengths(np.diff(slope, axis=0))
    accel = np.zeros(n)
    accel[1:-1] = 2.0 * jump / np.maximum(h[1:] + h[:-1], 1e-9)
    accel[0], accel[-1] = accel[1], accel[-2]
    found: Floats = DOUBT * h * h / 8.0 * np.maximum(accel[:-1], accel[1:])
    return found
