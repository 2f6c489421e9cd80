"""Geometry of a rope over edges that stay parallel, along which it slides without friction: an unrolled helix.

Projected along the edges it is a rope over sheaves in their plane (`sheaves`), of length F.  Unrolled, it is a straight
line that rises by h along the edges: slope s = h/F, length F sqrt(1 + s^2), and a wrap theta in the plane turns the
rope by theta/sqrt(1 + s^2).  Each part pulls along itself.  What the sliding does on the edge, where friction makes the
tensions of two parts differ, is the sum of T_j (rate of the material line - rate of the length).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select, sqrt

from .sheaves import RopeSegment, SheavePoint, Way


class Unrolled:
    """A rope from end to end over edges; the arguments and what it shows are those of a `Way`."""

    def __init__(
        self,
        nodes: Sequence[SheavePoint],
        turning: Sequence[bool],
        on: Sequence[Scalar | None],
        counted: Array | None = None,
        apart: bool = False,
    ) -> None:
        """`apart`: the edges are on several bodies, which slide along one another."""
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
        self._plane = Way(flat, turning, on, counted)
        plane = self._plane
        F, dF = sum(plane.lengths), sum(plane.rates)
        slope = (heights[-1] - heights[0]) * (1.0 / F)
        dslope = ((rates[-1] - rates[0]) - slope * dF) * (1.0 / F)
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
        """Of each part the rate of its material line less that of its length [m/s]."""
        self.spans: list[tuple[Scalar, Scalar]] = []
        """Of each edge, from its point, where along its axis the rope comes and where it goes [m]."""
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
        """As of a `Way`."""
        return self._plane.watches()

    def within(self, ends: Sequence[Array]) -> list[Scalar]:
        """Guards of each edge: that the rope lies between its ends (lower, upper) [m]."""
        out = []
        for here, (comes, goes), (lower, upper) in zip(self._on[1:-1], self.spans, ends, strict=True):
            inside = minimum(minimum(comes, goes) - lower, upper - maximum(comes, goes))
            out.append(select(here, inside, 1.0))
        return out


def _rises(rates: list[Scalar], apart: bool) -> list[Scalar]:
    """By how much each part's material rises along the edges [m/s], which stand still there unless they are `apart`."""
    if apart:
        return [b - a for a, b in pairwise(rates)]
    return [-rates[0], *(0.0 for _ in rates[3:]), rates[-1]]
