"""Geometry of a rope over sheaves: straight parts between tangent points, and arcs.

A node is a point (radius 0) or a sheave around which the rope turns positively about its axis. With u the direction of
a straight part and n the axis, a rope leaves a circle at c + r w, w = u x n; so for two circles u = (l D + (r_a - r_b)
n x D) / |D|^2 with D from centre to centre and l^2 = |D|^2 - (r_a - r_b)^2. A point has r = 0. Sheaves are planar: D
lies across the axis up to a small fleet angle; neighbouring axes are parallel, or opposite where the rope turns the
other way (a crossed belt).

The arc is divided at a direction that is fixed on the sheave's body, so that the length of each part has the rate u .
(v_B - v_A) of the material tangent points, on which the tensions do work, whatever their ratio.

A sheave that the rope has left lies beside the straight part between its neighbours; the two parts at it are then
pieces of that straight part, divided at the foot of its centre, so that their lengths are continuous when the rope
leaves and returns.

Geometry of a rope over edges that stay parallel, along which it slides without friction: an unrolled helix.

Projected along the edges it is a rope over sheaves in their plane (`sheaves`), of length F.  Unrolled, it is
a straight line that rises by h along the edges: slope s = h/F, length F sqrt(1 + s^2), and a wrap theta in
the plane turns the rope by theta/sqrt(1 + s^2).  Each part pulls along itself.  Where friction makes the
tensions of two parts differ, the power of sliding along the edge is the sum of T_j (rate of the material line
- rate of the length).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select, sqrt
from heavylift.kernel.multibody.continuous_angles import on_turn

TINY = 1e-300  # [m2] keeps a root from zero
NEAR = 1e-9  # rad, and part of a radius: what lies between leaving a sheave and finding it


@dataclass(frozen=True)
class SheavePoint:
    """A sheave or end point of a rope: its position, motion and axis in world axes."""

    x: Array  # centre relative to the tree's reference point
    c: Array  # position of the centre
    v: Array  # velocity
    w: Array  # angular velocity
    axis: Any
    divide: Any  # dividing direction
    radius: Any = None  # None for a point


@dataclass(frozen=True)
class RopeSegment:
    """A straight part of a rope: its length [m], rate of length and direction."""

    straight: Scalar
    rate: Scalar  # of its length, including adjacent arcs
    u: Array
    arms: tuple[Array, Array]  # levers from the trees' reference points to both ends
    begin: Array | None = None  # the point where it begins
    flat: Any = None  # its length across the axis
    plane: Any = None  # u across the axis, for wraps
    turning: Any = None  # (3,) angular velocity of that direction [rad/s]


def _blend(on: Scalar, a: Any, b: Any) -> Any:
    """Return a where `on`, else b; for numbers, arrays, nodes and segments."""
    if a is None or b is None:
        return b if a is None else a
    if isinstance(a, SheavePoint | RopeSegment):
        return replace(a, **{k: _blend(on, x, getattr(b, k)) for k, x in vars(a).items()})
    if isinstance(a, tuple):
        return tuple(_blend(on, x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, np.ndarray | list):
        return np.array([select(on, x, y) for x, y in zip(a, b, strict=True)], dtype=object)
    return select(on, a, b)


class RopePath:
    """The path of a rope over its sheaves and end points (nodes).

    `turning`: whether the wrap angle at a node is needed; `on`: whether the rope lies on each node (None: it cannot
    leave); `counted`: integrals of the wrap angles' rates.
    """

    def __init__(
        self,
        nodes: Sequence[SheavePoint],
        turning: Sequence[bool],
        on: Sequence[Scalar | None],
        counted: Array | None = None,
    ) -> None:
        self._nodes, self._on = nodes, on
        ends = [nodes[-1]]
        # from the far end: a sheave that the rope has left is skipped, its neighbours meet directly
        for x, here in zip(reversed(nodes[1:-1]), reversed(on[1:-1]), strict=True):
            ends.append(x if here is None else _blend(here, x, _as_circle(ends[-1])))
        meets = list(reversed(ends))
        n = range(len(nodes) - 1)
        own = [_part(nodes[i], meets[i], turning[i] or turning[i + 1] or on[i + 1] is not None) for i in n]
        self.parts = own[:1]  # what runs between two nodes, wherever it begins and ends
        for i in n[1:]:
            here = on[i]
            self.parts.append(own[i] if here is None else _blend(here, own[i], self.parts[-1]))
        self.rates = [x.rate if on[i] is None else select(on[i], x.rate, 0.0) for i, x in enumerate(own)]
        self.turned: list[Scalar] = []
        self.turning: list[Scalar] = []
        self.wraps: dict[int, tuple[Scalar, Scalar]] = {}
        """For each node that turns the rope: wrap angle [rad] and its rate."""
        self.lengths = self._pieces()
        for i, turns in enumerate(turning):
            if turns:
                x, sides = nodes[i], (self.parts[i - 1], self.parts[i])
                k = len(self.turned)
                angles = [turn(x, side.plane) for side in sides]
                # the angle integral distinguishes turns that the pose cannot
                if counted is not None:
                    angles = [on_turn(a, c) for a, c in zip(angles, counted[k : k + 2], strict=True)]
                rates = [x.axis @ (side.turning - x.w) for side in sides]
                self.turned += angles
                self.turning += rates
                self.wraps[i] = angles[1] - angles[0], rates[1] - rates[0]
                # arcs on both sides of the dividing direction belong to the adjacent parts
                if x.radius is not None:
                    self.lengths[i - 1] = self.lengths[i - 1] - x.radius * angles[0]
                    self.lengths[i] = self.lengths[i] + x.radius * angles[1]

    def _pieces(self) -> list[Scalar]:
        """Return the straight lengths between nodes; the feet of nodes that the rope has left divide its parts."""
        starts: list[Scalar] = [0.0]
        for part, x, here in zip(self.parts[1:], self._nodes[1:], self._on[1:], strict=False):
            if here is None:
                starts.append(0.0)
                continue
            # foot of the sheave's centre on the straight part divides it while the rope is off
            foot = ((x.c - part.begin) @ part.plane) * part.straight * (1.0 / part.flat)
            starts.append(select(here, 0.0, minimum(maximum(foot, starts[-1]), part.straight)))
        out = []
        for i, part in enumerate(self.parts):
            here = self._on[i + 1]
            last = part.straight if here is None else select(here, part.straight, starts[i + 1])
            out.append(last - starts[i])
        return out

    def watches(self) -> list[tuple[Scalar, Scalar]]:
        """Return two guards per sheave that the rope can leave: for contact, and for the wrong side of the sheave."""
        out = []
        for i, here in enumerate(self._on):
            if here is not None:
                x, part = self._nodes[i], self.parts[i]
                # the nearest point of the straight part to the sheave's axis
                there = minimum(maximum((x.c - part.begin) @ part.plane, 0.0), part.flat)
                next_to = part.begin + there * part.plane - x.c
                next_to = next_to - (next_to @ x.axis) * x.axis
                gap = sqrt(next_to @ next_to + TINY) * (1.0 / x.radius) - (1.0 - NEAR)
                right = next_to @ cross(part.plane, x.axis) > 0.0
                finds, other = select(right, gap, 1.0), select(right, 1.0, gap)
                out.append((select(here, self.wraps[i][0] + NEAR, finds), select(here, 1.0, other)))
        return out


def _as_circle(x: SheavePoint) -> SheavePoint:
    return x if x.radius is not None else replace(x, radius=0.0)


def _part(a: SheavePoint, b: SheavePoint, turning: bool) -> RopeSegment:
    D, dD = b.c - a.c, b.v - a.v
    if not turning and a.radius is None and b.radius is None:
        length = sqrt(D @ D)
        u = D * (1.0 / length)
        return RopeSegment(length, u @ dD, u, (a.x, b.x))
    n = b.axis if a.axis is None else a.axis
    # opposite axes (a crossed belt) count negatively
    r_a, r_b = (0.0 if x.radius is None else x.radius * (x.axis @ n) for x in (a, b))  # < 0: turns the other way
    h = D @ n
    across = D - h * n
    square = across @ across
    bias = r_a - r_b
    # tangent length between two circles: l^2 = D^2 - (r_a - r_b)^2
    flat = sqrt(square - bias * bias)
    plane = (flat * across + bias * cross(n, across)) * (1.0 / square)
    w = cross(plane, n)
    straight = sqrt(flat * flat + h * h)
    u = (flat * plane + h * n) * (1.0 / straight)
    rate = u @ dD
    arms = []
    for x, arm, sign in ((a, r_a * w, 1.0), (b, r_b * w, -1.0)):
        if x.radius is None:
            arms.append(x.x)
            continue
        # the tangent point moves with the sheave's surface
        rate = rate - sign * (u @ cross(x.w, arm))
        arms.append(x.x + arm)
    # rotation of the straight part in its plane
    about = ((cross(n, plane) @ dD) * (1.0 / flat)) * n
    return RopeSegment(straight, rate, u, (arms[0], arms[1]), a.c + r_a * w, flat, plane, about)


def turn(x: SheavePoint, plane: Array) -> Any:
    """Return the angle [rad], about a sheave's axis, of the point where a rope part touches the sheave.

    Measured from the direction at which the arc is divided (see the module), within half a turn; `plane`: direction of
    the rope part in the plane of the sheave.
    """
    w = cross(plane, x.axis)
    return atan2(x.axis @ cross(x.divide, w), x.divide @ w)


class Unrolled:
    """The path of a rope over edges from end to end; arguments and attributes as in `RopePath`."""

    def __init__(
        self,
        nodes: Sequence[SheavePoint],
        turning: Sequence[bool],
        on: Sequence[Scalar | None],
        counted: Array | None = None,
        apart: bool = False,
    ) -> None:
        """Compute the path; if `apart`, the edges are on several bodies that slide along one another."""
        self._on, edge = on, nodes[1]
        n = edge.axis
        dn = cross(edge.w, n)
        heights, rates, flat = [], [], []
        for x in nodes:
            r = x.c - edge.c
            h, dh = r @ n, (x.v - edge.v) @ n + r @ dn
            heights.append(h)
            rates.append(dh)
            flat.append(replace(x, x=x.x - h * n, c=x.c - h * n, v=x.v - dh * n - h * dn))
        self._plane = RopePath(flat, turning, on, counted)
        plane = self._plane
        # slope of the unrolled helix
        F, dF = sum(plane.lengths), sum(plane.rates)
        slope = (heights[-1] - heights[0]) * (1.0 / F)
        dslope = ((rates[-1] - rates[0]) - slope * dF) * (1.0 / F)
        # lengths grow by sqrt(1 + s^2), wraps in space shrink by it
        longer = sqrt(1.0 + slope * slope)
        shorter = 1.0 / longer
        dlonger = slope * dslope * shorter
        self.turned, self.turning = plane.turned, plane.turning
        self.lengths = [longer * x for x in plane.lengths]
        self.rates = [longer * dx + dlonger * x for x, dx in zip(plane.lengths, plane.rates, strict=True)]
        self.wraps = {
            i: (shorter * a, shorter * (da - a * dlonger * shorter)) for i, (a, da) in plane.wraps.items()
        }  # by how much the rope turns [rad], and the rate of that
        self.slides = [
            shorter * (dx + slope * rise) - rate
            for dx, rise, rate in zip(plane.rates, _rises(rates, apart), self.rates, strict=True)
        ]
        """For each part: rate of its material line minus rate of its length [m/s]."""
        self.spans: list[tuple[Scalar, Scalar]] = []
        """For each edge: positions along its axis, from its point, at which the rope arrives and leaves [m]."""
        self.parts: list[RopeSegment] = []
        begin, end = heights[0], heights[0]
        for i, part in enumerate(plane.parts):
            here = on[i]
            if here is not None:
                goes = end + slope * nodes[i].radius * plane.wraps[i][0]
                self.spans.append((end - heights[i], goes - heights[i]))
                begin = select(here, goes, begin)
            end = begin + slope * part.straight
            arms = part.arms[0] + begin * n, part.arms[1] + end * n
            u = shorter * (part.plane + slope * n)
            self.parts.append(replace(part, straight=longer * part.straight, u=u, arms=arms))

    def watches(self) -> list[tuple[Scalar, Scalar]]:
        """Return two guards per edge: for the rope leaving or touching the edge, and for the rope on its wrong side."""
        return self._plane.watches()

    def within(self, ends: Sequence[Array]) -> list[Scalar]:
        """Return the guard against the rope running off each edge: its distance [m] from the nearer end."""
        out = []
        for here, (comes, goes), (lower, upper) in zip(self._on[1:-1], self.spans, ends, strict=True):
            inside = minimum(minimum(comes, goes) - lower, upper - maximum(comes, goes))
            out.append(select(here, inside, 1.0))
        return out


def _rises(rates: list[Scalar], apart: bool) -> list[Scalar]:
    """Return the speed of each part's material along the edges [m/s], zero unless the edges are on several bodies."""
    if apart:
        return [b - a for a, b in pairwise(rates)]
    # on one body nothing but the ends moves along the edges
    return [-rates[0], *(0.0 for _ in rates[3:]), rates[-1]]
