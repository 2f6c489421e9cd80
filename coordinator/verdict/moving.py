"""Shapes in motion: where each shape of a scene is at every sample, and how far it may stray from that in between.

A shape is a rounded box: half edges `half` along the columns of R, and a radius around it; ropes are capsules whose
axis is the third column, balls have no edges.  Between two samples its middle and its ends go straight, and stray from
that by at most h^2 / 8 times their acceleration, which is taken as twice the largest that second differences show at
both samples.  What shakes faster than the samples shows in the speeds of its joints, which raise the bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from heavylift.kernel.description.mechanics import Joint, Vector
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import Solid, Strand, solids, strands
from numpy.typing import NDArray

from .history import History
from .rotating import chords, dots, lengths, matrices, onto
from .speeds import Twist, strays, twists

__all__ = ["Moving", "moving"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
DOUBT = 2.0  # on accelerations that are known from samples alone
WORLD = "world"


class Frame:
    """How a body moved: its origin p (n, 3) [m] and its turn, quaternions (n, 4), or (1, 4) if it never turns."""

    def __init__(self, t: Floats, pose: Floats, twist: Twist | None = None) -> None:
        pose = np.asfortranarray(pose)  # each column in one piece of memory
        self._pose, self._twist = pose, twist
        self.t, self.p = t, pose[:, :3]
        q = pose[:, 3:]
        self.turn = q if (q != q[0]).any() else q[:1]

    @cached_property
    def R(self) -> Floats:
        """(n, 3, 3), or (1, 3, 3)."""
        return matrices(self.turn)

    @cached_property
    def strays(self) -> Floats:
        """(n - 1,) how far its origin, and of a body that never turns each point, may leave its chords [m]."""
        return _bend(self.t, self.p)

    @cached_property
    def turn_strays(self) -> Floats:
        """(n - 1,) the same of its turn."""
        return _turn_bend(self.t, self.turn)

    @cached_property
    def shakes(self) -> tuple[Floats, Floats]:
        """(n - 1,) by its speeds, how far its origin may leave its chords [m], and points more per metre from it."""
        if self._twist is None:
            nothing = np.zeros(max(0, len(self.t) - 1))
            return nothing, nothing
        return strays(self.t, self._pose, self._twist)

    def place(self, x: Vector) -> Floats:
        """(n, 3) where one of its points is in the world [m]."""
        found = self.p
        for i, xi in enumerate(x):
            if xi:
                found = found + xi * self.R[:, :, i]
        return found


@dataclass(frozen=True)
class Moving:
    """A shape over n samples: `centre` (n, 3) [m] and how it is turned about it; `half` (3,) and `radius` [m]; `there`
    (n,): whether it is there at all and can be judged."""

    shape: Solid | Strand
    t: Floats
    centre: Floats
    turn: Floats  # (n, 4) quaternions of a solid, or (n, 3) from end to end of a strand; n = 1: it never turns
    half: Floats
    radius: float
    there: NDArray[np.bool_] | None = None
    frame: Frame | None = None  # of the body that a solid is fixed on
    ends: tuple[tuple[Frame | None, Vector], ...] = ()  # of a strand, on their bodies

    @cached_property
    def reach(self) -> float:
        """Of its farthest point from its middle, but for the radius [m]."""
        return float(np.linalg.norm(self.half))

    def axes(self, k: Indices) -> tuple[Floats, Floats]:
        """R (m, 3, 3) and half edges (m, 3) at these samples."""
        if len(self.turn) == 1:
            R, half = self.axes_of(self.turn)
            return np.broadcast_to(R, (len(k), 3, 3)), np.broadcast_to(half, (len(k), 3))
        return self.axes_of(self.turn[k])

    def axes_of(self, turn: Floats) -> tuple[Floats, Floats]:
        """The same of turns (m, 3 or 4)."""
        if isinstance(self.shape, Strand):
            length = lengths(turn)
            half = np.zeros((len(turn), 3))
            half[:, 2] = length / 2
            return onto(turn / np.maximum(length, 1e-9)[:, None]), half
        R = matrices(turn)
        if self.shape.R != IDENTITY:
            R = R @ np.array(self.shape.R)
        return R, np.broadcast_to(self.half, (len(turn), 3))

    def at(self, k: int, s: float) -> tuple[Floats, Floats, Floats]:
        """Middle (3,), R (3, 3) and half edges (3,) at the part s from sample k to the next."""
        p, turn = self._between(k, s)
        if isinstance(self.shape, Strand):
            R, half = self.axes_of(turn[None])
            return p, R[0], half[0]
        x, y, z, w = turn.tolist()
        rows = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
        R = np.array(rows)
        return p, R if self.shape.R == IDENTITY else R @ np.array(self.shape.R), self.half

    def _between(self, k: int, s: float) -> tuple[Floats, Floats]:
        if s == 0.0:
            return self.centre[k], self.turn[min(k, len(self.turn) - 1)]
        p = (1 - s) * self.centre[k] + s * self.centre[k + 1]
        if len(self.turn) == 1:
            return p, self.turn[0]
        a, b = self.turn[k], self.turn[k + 1]
        if self.turn.shape[1] == 4:
            b = b if a @ b >= 0.0 else -b
            q = (1 - s) * a + s * b
            return p, q / np.linalg.norm(q)
        return p, (1 - s) * a + s * b

    def spun(self, a: Floats, b: Floats) -> Floats:
        """(m,) by how much points of the shape move about its middle between turns (m, 3 or 4), at most [m]."""
        return lengths(a - b) / 2 if isinstance(self.shape, Strand) else chords(a, b) * self.reach

    @cached_property
    def stray(self) -> Floats:
        """(n - 1,) how far a point of the shape may be between two samples from where it is taken to be [m]."""
        found = self._bent
        if self.frame is not None and isinstance(self.shape, Solid):
            found = np.maximum(found, _shaken(self.frame, _size(self.shape.centre) + self.reach))
        for frame, p in self.ends:
            if frame is not None:
                found = np.maximum(found, _shaken(frame, _size(p)))
        return found

    @property
    def _bent(self) -> Floats:
        """The same by accelerations that poses show."""
        frame = self.frame
        if len(self.turn) == 1:
            return frame.strays if frame else _bend(self.t, self.centre)
        found = _bend(self.t, self.centre)
        if self.turn.shape[1] == 4:
            return found + 2.0 * self.reach * (frame.turn_strays if frame else _turn_bend(self.t, self.turn))
        return found + _bend(self.t, self.turn) / 2


IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _size(p: Vector) -> float:
    return float(np.linalg.norm(p))


def _shaken(frame: Frame, away: float) -> Floats:
    """(n - 1,) by its speeds, how far points of a body up to so far from its origin may leave their chords [m]."""
    origin, turn = frame.shakes
    return origin + away * turn


def moving(plan: Plan, history: History, joints: Sequence[Joint] = ()) -> list[Moving]:
    """All shapes of a plan as they moved; what has no pose on record is left out.

    `joints`: those whose speeds tell how bodies shake.
    """
    found = []
    fast = twists(joints, history)
    frames = {}
    if len(history.t):
        frames = {name: Frame(history.t, pose, fast.get(name)) for name, pose in history.poses.items()}
    for solid in solids(plan):
        frame = frames.get(solid.body)
        if solid.body == WORLD:
            centre, turn = np.broadcast_to(solid.centre, (len(history.t), 3)), np.array([[0.0, 0.0, 0.0, 1.0]])
        elif frame is not None:
            centre, turn = frame.place(solid.centre), frame.turn
        else:
            continue
        half, radius = (np.zeros(3), solid.size[0] / 2) if solid.form == "ball" else (np.array(solid.size) / 2, 0.0)
        found.append(Moving(solid, history.t, centre, turn, half, radius, frame=frame))
    return found + _ropes(plan, history, frames)


def _ropes(plan: Plan, history: History, frames: dict[str, Frame]) -> list[Moving]:
    """Each straight line of a rope while it hangs and carries."""
    known = strands(plan)
    found: dict[tuple[str, str, Vector, str, Vector], NDArray[np.bool_]] = {}
    taut = {name: tension > 0.0 for name, tension in history.tensions.items()}
    for i, rig in enumerate(history.rigs):
        end = history.rigs[i + 1].t_ns * 1e-9 if i + 1 < len(history.rigs) else np.inf
        first = int(np.searchsorted(history.t, rig.t_ns * 1e-9, side="left"))
        last = int(np.searchsorted(history.t, end, side="right"))
        for line in rig.lines:
            rope = line.rope.partition("~")[0]  # of the pieces of a rope with mass
            if rope in known and rope in history.tensions:
                key = rope, line.a_body, line.a, line.b_body, line.b
                there = found.setdefault(key, np.zeros(len(history.t), bool))
                there[first:last] |= taut[line.rope][first:last] if line.rope in taut else True
    out = []
    places: dict[tuple[str, Vector], Floats | None] = {}
    for (rope, a_body, a, b_body, b), there in found.items():
        if not there.any():
            continue
        p, q = (_place(history, frames, places, key) for key in ((a_body, a), (b_body, b)))
        if p is None or q is None:
            continue
        along = q - p
        half = np.array([0.0, 0.0, float(lengths(along).max()) / 2])
        shape = known[rope]
        ends = (frames.get(a_body), a), (frames.get(b_body), b)
        out.append(Moving(shape, history.t, (p + q) / 2, along, half, shape.radius, there, ends=ends))
    return out


def _place(
    history: History, frames: dict[str, Frame], known: dict[tuple[str, Vector], Floats | None], key: tuple[str, Vector]
) -> Floats | None:
    """(n, 3) where a point of a body is in the world; None if the body is not on record."""
    if key not in known:
        body, p = key
        frame = frames.get(body)
        still = np.broadcast_to(p, (len(history.t), 3)) if body == WORLD else None
        known[key] = frame.place(p) if frame is not None else still
    return known[key]


def _turn_bend(t: Floats, turn: Floats) -> Floats:
    """(n - 1,) the same of quaternions (n, 4), of which both signs mean one turn; a small angle moves them by half."""
    q = turn.copy(order="K")
    q[1:] *= np.cumprod(np.where(dots(q[1:], q[:-1]) < 0.0, -1.0, 1.0))[:, None]
    return _bend(t, q)


def _bend(t: Floats, x: Floats) -> Floats:
    """(n - 1,) bound on how far x (n, d) leaves its chord between two samples: h^2 / 8 times its acceleration."""
    n = len(t)
    if n < 3:
        return np.zeros(max(0, n - 1))
    h = np.diff(t)
    slope = np.diff(x.T) / np.maximum(h, 1e-9)
    slope[:, h <= 0.0] = 0.0
    accel = np.empty(n)
    accel[1:-1] = 2.0 * lengths(np.diff(slope).T) / np.maximum(h[1:] + h[:-1], 1e-9)
    accel[0], accel[-1] = accel[1], accel[-2]
    found: Floats = DOUBT * h * h / 8.0 * np.maximum(accel[:-1], accel[1:])
    return found
