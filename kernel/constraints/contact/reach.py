"""How long a step may be, so that two shapes do not pass through each other unseen between two stages.

A witness is below zero from the touch until the centres have passed (of a vertex: until the middle of the box), which
takes at least the smallest half extents at the speed at which the shapes can close.  A step lasts no longer than that,
and than half of the way between their bounding spheres before (conservative advancement: Mirtich, thesis, Berkeley
1996, section 2.3).  Nothing passes through a plane: all below it touches.
"""

from __future__ import annotations

from typing import Any

from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, sqrt
from heavylift.kernel.description.contacts import Ball, Contact, Plane, Shape

from .frames import Side

THIN = 1e-4  # [m] what is thinner counts as that thick, so that two points do not stop the run
TINY = 1e-300  # [m^2/s^2] keeps what rests from dividing by zero


def passes(c: Contact) -> bool:
    """Whether the shapes of a contact could pass through each other."""
    return not isinstance(c.b, Plane)


def reach(c: Contact, first: Array, second: Array, A: Array, B: Array) -> Any:
    """Longest step [s] from where the bodies are, at the speed that they have."""
    (R_a, half_a), (R_b, half_b) = _extent(c.a, first), _extent(c.b, second)
    both_boxes = not isinstance(c.a, Ball) and not isinstance(c.b, Ball)
    window = minimum(half_a, half_b) if both_boxes else half_a + half_b
    a, b = Side(A), Side(B)
    p, q = a.place(first[:3]), b.place(second[:3])
    away = _length(p - q) - R_a - R_b
    speed = _length(a.velocity(p) - b.velocity(q)) + _length(a.w) * R_a + _length(b.w) * R_b
    return (maximum(window, THIN) + 0.5 * maximum(away, 0.0)) / speed


def _extent(shape: Shape, p: Array) -> tuple[Scalar, Scalar]:
    """Radius of the sphere around a shape and its smallest half extent [m]."""
    if isinstance(shape, Ball):
        return p[3], p[3]
    h = p[12:15]
    return _length(h), minimum(h[0], minimum(h[1], h[2]))


def _length(x: Array) -> Any:
    return sqrt(x @ x + TINY)
