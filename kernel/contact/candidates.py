"""What could touch: a fixed list of candidates for each pair of shapes, each a witness that is positive while apart.

ball - plane, ball - ball     one candidate
box - plane                   its 8 vertices
ball - box                    one: the face of the box that the ball's centre lies outside of, if its foot is on it
box - box                     16 vertices in the other box; 36 pairs of edges

A vertex has its distance from the box's surface (largest over the three axes), so that it needs no test of a foot.
Of the 12 x 12 pairs of edges only those can touch that lie on the sides turned to each other: for each pair of
directions (a_i, b_j) with n = a_i x b_j from B to A these are two edges of A by two of B, since the sign of the
direction along which n leans less is free.  Edges count only where they cross within both, and only if no other
direction separates the boxes further (Gottschalk, Lin, Manocha, SIGGRAPH 1996: 15 axes decide).  Other pairs stand at
`APART`.  Written without branches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..spatial import cross
from ..symbol import maximum, minimum, select, sqrt
from .frames import Side

__all__ = ["APART", "BOX", "VERTICES", "ball_box", "box_box", "box_plane"]

BOX = 15  # numbers: centre (3), axes as rows (9), half edges (3), in the body's frame
APART = 1.0  # [m] witness of a candidate that does not count
CROSSING = 1e-3  # sine of the angle below which two edges are parallel
NEAR = 1e-6  # [m] by which another direction may separate two boxes further
VERTICES = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
TINY = 1e-300  # keeps the length of a vanishing cross product from being zero


class Box:
    """Centre, axes (rows) and half edges in world axes."""

    def __init__(self, p: Any, body: Any) -> None:
        side = Side(body)
        self.c, self.h = side.place(p[:3]), p[12:15]
        self.axes = np.array([side.R @ e for e in np.reshape(p[3:12], (3, 3))])

    def vertices(self) -> list[Any]:
        return [self.c + sum(s * h * e for s, h, e in zip(v, self.h, self.axes, strict=True)) for v in VERTICES]

    def outside(self, x: Any) -> Any:
        """(3,) how far x lies outside of the nearer face across each axis."""
        return abs(self.axes @ (x - self.c)) - self.h


def ball_box(ball: Any, box: Any, A: Any, B: Any) -> Any:
    """Witness of a ball of A (centre, radius) against the faces of a box of B; its edges and corners do not count."""
    s = Box(box, B).outside(Side(A).place(ball[:3]))
    high, low = maximum(s[0], s[1]), minimum(s[0], s[1])
    second = maximum(low, minimum(high, s[2]))
    return select(second > 0.0, APART, maximum(high, s[2]) - ball[3])


def box_plane(box: Any, point: Any, normal: Any, A: Any, B: Any) -> list[Any]:
    """(8,) heights of a box's vertices above a plane of B."""
    b = Side(B)
    q, n = b.place(point), b.R @ normal
    return [n @ (x - q) for x in Box(box, A).vertices()]


def box_box(first: Any, second: Any, A: Any, B: Any) -> list[Any]:
    """(52,) witnesses: vertices of A in B, vertices of B in A, pairs of edges (a_i, b_j, edge of A, edge of B)."""
    a, b = Box(first, A), Box(second, B)
    depths = [b.outside(x) for x in a.vertices()] + [a.outside(x) for x in b.vertices()]
    C = a.axes @ b.axes.T
    d = a.c - b.c
    apart = [abs(a.axes[i] @ d) - a.h[i] - sum(abs(C[i, j]) * b.h[j] for j in range(3)) for i in range(3)]
    apart += [abs(b.axes[j] @ d) - b.h[j] - sum(abs(C[i, j]) * a.h[i] for i in range(3)) for j in range(3)]
    directions = [_crossing(a, b, d, i, j) for i in range(3) for j in range(3)]
    most = apart[0]
    for x in [*apart[1:], *(x.separation for x in directions)]:
        most = maximum(most, x)
    edges = [w for x in directions for w in x.witnesses(most)]
    return [maximum(s[0], maximum(s[1], s[2])) for s in depths] + edges


@dataclass(frozen=True)
class Direction:
    """n = a_i x b_j from B to A; per box the two edges that face the other one (their midpoints)."""

    n: Any
    a: Any
    b: Any
    half: tuple[Any, Any]
    edges_a: list[Any]
    edges_b: list[Any]
    sine: Any
    separation: Any

    def witnesses(self, most: Any) -> list[Any]:
        """Gap of each pair of edges, if they cross within both and no other direction separates further."""
        on_a, on_b = cross(self.b, self.n), cross(self.a, self.n)
        crossing = self.sine > CROSSING
        per_sine = 1.0 / select(crossing, self.sine, 1.0)
        out = []
        for p in self.edges_a:
            for q in self.edges_b:
                s = abs((q - p) @ on_a) * per_sine - self.half[0]
                t = abs((p - q) @ on_b) * per_sine - self.half[1]
                gap = self.n @ (p - q)
                counts = (maximum(s, t) < 0.0) & (gap > most - NEAR) & crossing
                out.append(select(counts, gap, APART))
        return out


def _crossing(a: Box, b: Box, d: Any, i: int, j: int) -> Direction:
    m = cross(a.axes[i], b.axes[j])
    size = sqrt(m @ m + TINY)
    n = m * (1.0 / size)
    n = n * select(n @ d > 0.0, 1.0, -1.0)
    edges_a, reach_a = _facing(a, i, -n)
    edges_b, reach_b = _facing(b, j, n)
    separation = select(size > CROSSING, n @ d - reach_a - reach_b, -APART)
    return Direction(n, a.axes[i], b.axes[j], (a.h[i], b.h[j]), edges_a, edges_b, size, separation)


def _facing(box: Box, i: int, n: Any) -> tuple[list[Any], Any]:
    """Midpoints of the outermost edges along axis i in direction n, both signs of the axis that n leans to less, the
    outermost first; and how far the box reaches along n."""
    k, l = (i + 1) % 3, (i + 2) % 3
    lean_k, lean_l = n @ box.axes[k], n @ box.axes[l]
    step_k = box.axes[k] * (box.h[k] * select(lean_k > 0.0, 1.0, -1.0))
    step_l = box.axes[l] * (box.h[l] * select(lean_l > 0.0, 1.0, -1.0))
    first = abs(lean_k) > abs(lean_l)
    edges = [box.c + step_k + step_l, box.c + select(first, step_k - step_l, step_l - step_k)]
    return edges, abs(lean_k) * box.h[k] + abs(lean_l) * box.h[l]
