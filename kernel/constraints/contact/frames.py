"""Contact frames: the contact point x, the normal n along which A is pushed away from B, two tangents, and their rates.

Five kinds cover points, balls and boxes: a ball of A on a face, an edge or a corner of B; two balls; two edges that
cross. With F = (n, t1, t2), the rows' velocities are F (v_A(x) - v_B(x)). Since x is the same moving point of the world
for both bodies, their derivatives contain, besides the accelerations of the bodies, only F ((w_A - w_B) x dx/dt) +
dF/dt (v_A(x) - v_B(x)): each kind needs no more than x, dx/dt, F and dF/dt.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.function import Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, minimum, sqrt

FACE = 16  # numbers: centre and radius of the ball on A; a point of the face and its normal, first, second on B
BALLS = 11  # centre and radius on A, centre and radius on B, a direction of B that is not the normal
EDGE = 13  # centre and radius on A; a point of the edge, its direction, difference of its faces' normals on B
CORNER = 16  # centre and radius on A; the corner and the normals of its faces on B
EDGES = 12  # a point and the unit direction of the edge on A (turned so that a x b pushes A away), the same on B
TINY = 1e-300  # keeps what is computed of an empty slot finite


@dataclass(frozen=True)
class ContactFrame:
    """Contact frame of bodies A and B: gap [m], contact point, and normal and tangents, with their rates."""

    gap: Scalar
    x: Array  # (3,) contact point in world axes [m]
    dx: Array
    F: Array  # (3, 3) rows: normal n, tangents t1 and t2
    dF: Array
    along: Array  # coordinates of x within the face, or along the edges of A and B [m]


class Side:
    """A body in a contact: its pose and velocity in world axes, from the 21 numbers that `attachment` describes."""

    def __init__(self, body: Array) -> None:
        self.R, self.o, self.r = np.reshape(body[:9], (3, 3)), body[9:12], body[12:15]
        self.w, self.v = body[15:18], body[18:21]

    def place(self, p: Array) -> Any:
        return self.o + self.r + self.R @ p

    def velocity(self, x: Array) -> Array:
        return self.v + cross(self.w, x - self.o)


def face(p: Array, A: Array, B: Array) -> ContactFrame:
    """Return the contact frame of a ball of A on a plane fixed in B."""
    a, b = Side(A), Side(B)
    c, r, q = a.place(p[:3]), p[3], b.place(p[4:7])
    F = np.array([b.R @ e for e in np.reshape(p[7:16], (3, 3))])
    dF = np.array([cross(b.w, e) for e in F])
    # the contact point on the surface of the ball
    x = c - r * F[0]
    return ContactFrame(F[0] @ (c - q) - r, x, a.velocity(c) - r * dF[0], F, dF, F[1:] @ (x - q))


def balls(p: Array, A: Array, B: Array) -> ContactFrame:
    """Return the contact frame of two balls; both tangents are perpendicular to the normal.

    The first tangent is also perpendicular to a fixed direction of B, the second to the first.
    """
    a, b = Side(A), Side(B)
    c_a, c_b, e = a.place(p[:3]), b.place(p[4:7]), b.R @ p[8:11]
    n, dn, distance = _unit(c_a - c_b, a.velocity(c_a) - b.velocity(c_b))
    # perpendicular to a direction fixed on B, so that the tangents turn with it and have rates
    t, dt, _ = _unit(cross(n, e), cross(dn, e) + cross(n, cross(b.w, e)))
    F = np.array([n, t, cross(n, t)])
    dF = np.array([dn, dt, cross(dn, t) + cross(n, dt)])
    return ContactFrame(distance - p[3] - p[7], c_b + p[7] * n, b.velocity(c_b) + p[7] * dn, F, dF, np.zeros(2))


def edges(p: Array, A: Array, B: Array) -> ContactFrame:
    """Return the contact frame of two crossing edges; its first tangent is along the edge of A."""
    a, b = Side(A), Side(B)
    p_a, p_b, d, e = a.place(p[:3]), b.place(p[6:9]), a.R @ p[3:6], b.R @ p[9:12]
    dd, de = cross(a.w, d), cross(b.w, e)
    n, dn, _ = _unit(cross(d, e), cross(dd, e) + cross(d, de))
    F = np.array([n, d, cross(n, d)])
    dF = np.array([dn, dd, cross(dn, d) + cross(n, dd)])
    # along A up to the plane of n and the edge of B, along B likewise
    # where each edge crosses the plane through the other one and n
    on_a, on_b = cross(e, n), cross(d, n)
    per_a, per_b = 1.0 / (d @ on_a + TINY), 1.0 / (e @ on_b - TINY)
    s, t = ((p_b - p_a) @ on_a) * per_a, ((p_a - p_b) @ on_b) * per_b
    x = p_a + s * d
    v_a, v_b = a.velocity(x), b.velocity(x)
    ds = ((v_b - v_a) @ on_a) * per_a
    return ContactFrame(n @ (p_a - p_b), x, v_a + ds * d, F, dF, np.array([s, t]))


def edge(p: Array, A: Array, B: Array) -> ContactFrame:
    """Return the contact frame of a ball of A on an edge of B.

    Its `along`: the place on the edge [m], and a number that becomes 1 where an adjacent face begins.
    """
    a, b = Side(A), Side(B)
    c, q, e, across = a.place(p[:3]), b.place(p[4:7]), b.R @ p[7:10], b.R @ p[10:13]
    d, dd, de = c - q, a.velocity(c) - b.velocity(q), cross(b.w, e)
    s, ds = d @ e, dd @ e + d @ de
    # radial direction from the edge
    n, dn, distance = _unit(d - s * e, dd - ds * e - s * de)
    F = np.array([n, e, cross(n, e)])
    dF = np.array([dn, de, cross(dn, e) + cross(n, de)])
    return ContactFrame(distance - p[3], c - p[3] * n, a.velocity(c) - p[3] * dn, F, dF, np.array([s, n @ across]))


def corner(p: Array, A: Array, B: Array) -> ContactFrame:
    """Return the contact frame of a ball of A on a corner of a box of B.

    Its field `along` exceeds 1 once the ball has moved on to an edge or a face.
    """
    axes = np.reshape(p[7:16], (3, 3))
    f = balls(np.concatenate([p[:7], [0.0], p[7:10]]), A, B)
    outward = [f.F[0] @ (Side(B).R @ e) for e in axes]
    least = minimum(minimum(outward[0], outward[1]), outward[2])
    # 1 minus the least component: above 1 as soon as the ball has left the octant of the corner
    return ContactFrame(f.gap, f.x, f.dx, f.F, f.dF, np.array([1.0 - least, 0.0]))


def _unit(m: Array, dm: Array) -> tuple[Array, Array, Scalar]:
    """Return the unit vector of m, its rate, and the length of m."""
    size = sqrt(m @ m + TINY)
    u, du = m * (1.0 / size), dm * (1.0 / size)
    # derivative of a unit vector: the part of the rate across it
    return u, du - u * (u @ du), size


def rows(f: ContactFrame, A: Array, B: Array) -> Outputs:
    """Return the constraint rows of a contact frame: rate and bias (3,), and wrenches on bodies A and B.

    wa, wb (3, 6) about the reference points of their trees, with rate = wa V_A - wb V_B.
    """
    a, b = Side(A), Side(B)
    v = a.velocity(f.x) - b.velocity(f.x)
    return {
        "rate": f.F @ v,
        # x is the same moving point of the world for both bodies: see the module
        "bias": f.F @ cross(a.w - b.w, f.dx) + f.dF @ v,
        "wa": np.array([join(cross(f.x - a.o, e), e) for e in f.F]),
        "wb": np.array([join(cross(f.x - b.o, e), e) for e in f.F]),
    }
