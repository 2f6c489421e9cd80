"""Contact candidates: for each pair of shapes a fixed list of places that could touch, each with a gap
function: the signed distance, positive while the shapes are apart there.

ball - plane, ball - ball     one candidate
box - plane                   its 8 vertices
ball - box                    one: the nearest point of the box, on a face, an edge or a corner
box - box                     16 vertices in the other box; 144 pairs of edges

A ball is (centre, radius), a box (centre, axes as rows, half edges), a plane (point, normal), in its body's frame.

The gap of a vertex is its signed distance from the other box (the largest over the three axes), so no test of a foot
point is needed. The border of a face belongs to the face: above the face that separates two overlapping boxes
most, the gap is the height above that face; otherwise boxes of equal width, whose vertices meet border on border,
would pass through each other. Of the 12 x 12 pairs of edges only those count that cross within both edges and whose gap
equals the separation of the boxes along their direction of largest separation (Gottschalk, Lin, Manocha, SIGGRAPH 1996:
15 directions decide): convex bodies touch nowhere else. The others have the value `APART`. The code has no branches.

Each gap comes with its rate: a candidate that has just been left is zero within round-off, and touches again only
when it is negative and falling.

Bound of a step, so that two shapes do not pass through each other unseen between two stages: a gap is negative from
the touch until the centres have passed (of a vertex: until the middle of the box), which takes at least the smallest
half extents at the largest possible closing speed. A step is no longer than that, plus half of the time in which the
bounding spheres can meet (conservative advancement: Mirtich, thesis, Berkeley 1996, section 2.3). Nothing passes
through a plane: whatever is below it touches.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select, sqrt
from heavylift.kernel.description.contacts import Ball, Contact, Plane, Shape

from .frames import Side

Gap = tuple[Scalar, Scalar]  # gap [m], its rate [m/s]

APART = 1.0  # [m] gap of a candidate that does not count
CROSSING = 1e-3  # sine of the angle below which two edges are parallel
BORDER = 5e-10  # [m] beyond a face up to which its border reaches; within this, a place is not yet left
NEAR = 1e-6  # [m] to which a gap is that of the direction that separates two boxes most
VERTICES = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
SIGNS = [(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
TINY = 1e-300  # keeps the length of a vanishing cross product from being zero


class OrientedBox:
    """A box in world axes: centre, axes (rows) and half edges."""

    def __init__(self, p: Array, body: Array) -> None:
        self.side = Side(body)
        self.c, self.h = self.side.place(p[:3]), p[12:15]
        self.axes = np.array([self.side.R @ e for e in np.reshape(p[3:12], (3, 3))])

    def vertices(self) -> list[Array]:
        return [self.c + sum(s * h * e for s, h, e in zip(v, self.h, self.axes, strict=True)) for v in VERTICES]

    def outside(self, x: Array, body: Side) -> tuple[Array, Array]:
        """Return how far a point x of `body` lies beyond the nearer box face along each axis (3,) [m], and its rate."""
        d = self.axes @ (x - self.c)
        v = self.axes @ (body.velocity(x) - self.side.velocity(x))
        return abs(d) - self.h, np.array([select(e > 0.0, u, -u) for e, u in zip(d, v, strict=True)], dtype=object)

    def depth(self, x: Array, body: Side) -> Gap:
        """Return the largest distance [m] over the axes by which a point of `body` is outside the box, and its rate."""
        s, v = self.outside(x, body)
        # the largest over three axes: negative inside; the maximum is the nearer face's distance
        first = s[0] > s[1]
        gap, rate = select(first, s[0], s[1]), select(first, v[0], v[1])
        return select(gap > s[2], gap, s[2]), select(gap > s[2], rate, v[2])

    def height(self, x: Array, body: Side, faces: list[Scalar]) -> Gap:
        """Return the gap [m] between a point of `body` and a face of the box, and its rate.

        Beside the face, the result of `depth`. `faces`: one flag per axis of the box, true for that of the face.
        """
        s, v = self.outside(x, body)
        gap, rate = self.depth(x, body)
        for k, face in enumerate(faces):
            # only over the face itself, or its plane would act beyond its edges
            over = face & (s[k - 2] < BORDER) & (s[k - 1] < BORDER)
            gap, rate = select(over, s[k], gap), select(over, v[k], rate)
        return gap, rate


def ball_plane(ball: Array, plane: Array, A: Array, B: Array) -> list[Gap]:
    """Return the gap function (signed distance, rate) of a ball of body A and a plane (point, normal) of body B."""
    a, b = Side(A), Side(B)
    c, n = a.place(ball[:3]), b.R @ plane[3:6]
    return [(n @ (c - b.place(plane[:3])) - ball[3], n @ (a.velocity(c) - b.velocity(c)))]


def ball_ball(first: Array, second: Array, A: Array, B: Array) -> list[Gap]:
    """Return the gap function (signed distance, rate) of two balls."""
    a, b = Side(A), Side(B)
    p, q = a.place(first[:3]), b.place(second[:3])
    d = p - q
    size = sqrt(d @ d)
    return [(size - first[3] - second[3], d @ (a.velocity(p) - b.velocity(q)) * (1.0 / size))]


def ball_box(ball: Array, box: Array, A: Array, B: Array) -> list[Gap]:
    """Return the gap function (signed distance, rate) of a ball of body A and the nearest point of a box of body B.

    That point is on a face, an edge or a corner.
    """
    a, b = Side(A), OrientedBox(box, B)
    c = a.place(ball[:3])
    d = b.axes @ (c - b.c)
    # distance beyond the box along each axis; zero alongside a face
    beyond = [select(e > h, e - h, select(-e > h, e + h, 0.0)) for e, h in zip(d, b.h, strict=True)]
    off = np.array(beyond, dtype=object)
    size = sqrt(off @ off + TINY)
    v = off @ (b.axes @ (a.velocity(c) - b.side.velocity(c))) * (1.0 / size)
    gap, rate = b.depth(c, a)
    # outside the nearest point counts, inside the nearest face
    return [(select(gap > 0.0, size, gap) - ball[3], select(gap > 0.0, v, rate))]


def box_plane(box: Array, plane: Array, A: Array, B: Array) -> list[Gap]:
    """Return the gap functions of the vertices of a box of body A above a plane of body B."""
    return [w for x in OrientedBox(box, A).vertices() for w in _above(x, plane, Side(A), Side(B))]


def _above(x: Array, plane: Array, a: Side, b: Side) -> list[Gap]:
    n = b.R @ plane[3:6]
    return [(n @ (x - b.place(plane[:3])), n @ (a.velocity(x) - b.velocity(x)))]


def box_box(first: Array, second: Array, A: Array, B: Array) -> list[Gap]:
    """Return the gap functions of two boxes: vertices of A in B, vertices of B in A, then pairs of edges.

    Edges a_i of A and b_j of B.
    """
    a, b = OrientedBox(first, A), OrientedBox(second, B)
    C = a.axes @ b.axes.T
    d = a.c - b.c
    # separating axes of two oriented boxes: three of A, three of B, nine cross products (Gottschalk et al.)
    apart = [abs(a.axes[i] @ d) - a.h[i] - sum(abs(C[i, j]) * b.h[j] for j in range(3)) for i in range(3)]
    apart += [abs(b.axes[j] @ d) - b.h[j] - sum(abs(C[i, j]) * a.h[i] for i in range(3)) for j in range(3)]
    of_a, of_b = _faces(apart[:3]), _faces(apart[3:])
    heights = [b.height(x, a.side, of_b) for x in a.vertices()] + [a.height(x, b.side, of_a) for x in b.vertices()]
    directions = crossings(a, b)
    most = apart[0]
    # the largest separation: positive exactly where the boxes are apart
    for x in [*apart[1:], *(x.separation for x in directions)]:
        most = maximum(most, x)
    return heights + [w for x in directions for w in _edges(a, b, x, most)]


def _faces(apart: list[Scalar]) -> list[Scalar]:
    """Return 3 flags, one per axis: whether two boxes overlap along both other axes and are separated most along this
    one. The flags prevent flush boxes from catching on each other."""
    over = [x < -NEAR for x in apart]
    return [(apart[k] >= maximum(apart[k - 2], apart[k - 1])) & over[k - 2] & over[k - 1] for k in range(3)]


@dataclass(frozen=True)
class Direction:
    """A direction perpendicular to one edge of box A and to one edge of box B, pointing from B to A.

    n = a_i x b_j; `separation`: distance of the boxes along it [m].
    """

    i: int
    j: int
    n: Array
    sine: Scalar
    separation: Scalar


def crossings(a: OrientedBox, b: OrientedBox) -> list[Direction]:
    """Return the nine directions that are perpendicular to an edge of each of two boxes."""
    return [_crossing(a, b, i, j) for i in range(3) for j in range(3)]


def _crossing(a: OrientedBox, b: OrientedBox, i: int, j: int) -> Direction:
    m, d = cross(a.axes[i], b.axes[j]), a.c - b.c
    size = sqrt(m @ m + TINY)
    n = m * (1.0 / size)
    # n from B to A, whatever the order of the edges
    n = n * select(n @ d > 0.0, 1.0, -1.0)
    reach = sum(abs(n @ e) * h for box in (a, b) for e, h in zip(box.axes, box.h, strict=True))
    # parallel edges define no direction
    return Direction(i, j, n, size, select(size > CROSSING, n @ d - reach, -APART))


def edge(box: OrientedBox, i: int, signs: tuple[float, float]) -> Any:
    """Return the midpoint, in world axes, of an edge of a box along its axis i; `signs` selects one of the four."""
    k, l = (i + 1) % 3, (i + 2) % 3
    return box.c + signs[0] * box.h[k] * box.axes[k] + signs[1] * box.h[l] * box.axes[l]


def _edges(a: OrientedBox, b: OrientedBox, x: Direction, most: Scalar) -> list[Gap]:
    """Return the witnesses of the pairs of crossing edges along whose common normal the boxes are separated most. All
    is linear in the midpoints p, q of the edges: their crossing lies at p + s a_i = q + t b_j + gap n."""
    along, across = a.axes[x.i], b.axes[x.j]
    crossing = x.sine > CROSSING
    # parameters of the crossing along both edges, from two linear equations
    per = select(x.n @ cross(along, across) > 0.0, 1.0, -1.0) / select(crossing, x.sine, 1.0)
    on_a, on_b = cross(across, x.n) * per, cross(along, x.n) * per
    A, B = a.side, b.side
    turn = cross(x.n, A.w - B.w)
    drift = x.n @ (A.v - B.v) - cross(x.n, A.w) @ A.o + cross(x.n, B.w) @ B.o
    ahead = turn @ along
    of_a, of_b = (
        [tuple(f @ e for f in (x.n, on_a, on_b, turn)) for e in [edge(box, i, s) for s in SIGNS]]
        for box, i in ((a, x.i), (b, x.j))
    )
    out = []
    for n_p, a_p, b_p, m_p in of_a:
        for n_q, a_q, b_q, _ in of_b:
            gap, s, t = n_p - n_q, a_q - a_p, b_p - b_q
            within = (a.h[x.i] > abs(s)) & (b.h[x.j] > abs(t))
            # only a pair in the separating direction can touch
            counts = within & (abs(gap - most) < NEAR) & crossing
            out.append((select(counts, gap, APART), drift + m_p + s * ahead))
    return out


THIN = 1e-4  # [m] what is thinner counts as that thick, so that two points do not stop the run


def passes(c: Contact) -> bool:
    """Return whether two contact shapes could pass through each other within a long step."""
    return not isinstance(c.b, Plane)


def reach(c: Contact, first: Array, second: Array, A: Array, B: Array) -> Any:
    """Return the longest step [s] in which the two shapes of a contact cannot pass through each other."""
    (R_a, half_a), (R_b, half_b) = _extent(c.a, first), _extent(c.b, second)
    both_boxes = not isinstance(c.a, Ball) and not isinstance(c.b, Ball)
    # two boxes can pass once the smaller half extent has been crossed
    window = minimum(half_a, half_b) if both_boxes else half_a + half_b
    a, b = Side(A), Side(B)
    p, q = a.place(first[:3]), b.place(second[:3])
    away = _length(p - q) - R_a - R_b
    # fastest approach: relative speed of centres and rotation of the bounding spheres
    speed = _length(a.velocity(p) - b.velocity(q)) + _length(a.w) * R_a + _length(b.w) * R_b
    # distance counts half, since the speed may grow meanwhile
    return (maximum(window, THIN) + 0.5 * maximum(away, 0.0)) / speed


def _extent(shape: Shape, p: Array) -> tuple[Scalar, Scalar]:
    """Return the radius of the bounding sphere and the smallest half extent of a shape [m]."""
    if isinstance(shape, Ball):
        return p[3], p[3]
    h = p[12:15]
    return _length(h), minimum(h[0], minimum(h[1], h[2]))


def _length(x: Array) -> Any:
    return sqrt(x @ x + TINY)
