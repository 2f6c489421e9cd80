"""Directions and attitudes as they are written in scene files, and as the kernel wants them: unit vectors and matrices.

What is given need not have length 1; what has no length stays as it is and is a fault elsewhere.
"""

from __future__ import annotations

from typing import TypeVar, cast

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.points import Matrix, Vector
from heavylift.nodes.scene.keys.base import Quaternion

__all__ = ["across", "quaternion_matrix", "turned", "unit"]

Directed = TypeVar("Directed", Vector, Quaternion)
EXACT = 1e-15  # how far a sine may be from 0 or 1 by rounding
X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def unit(vector: Directed) -> Directed:
    """The vector with length 1."""
    length = norm(vector) or 1.0
    return cast(Directed, tuple(x / length for x in vector))


def across(axis: Vector) -> Vector:
    """The x axis as seen across an axis, or y where that is x."""
    a = unit(axis)
    e = Y if abs(a[0]) > 1.0 - 1e-9 else X
    along = sum(p * q for p, q in zip(a, e, strict=True))
    x, y, z = (p - along * q for p, q in zip(e, a, strict=True))
    return x, y, z


def turned(roll: float, pitch: float, yaw: float) -> Matrix:
    """R = Rz(yaw) Ry(pitch) Rx(roll); quarter turns are exact, so that they cost nothing in the compiled code."""
    (c, s), (d, t), (e, u) = ((_exact(cos(x)), _exact(sin(x))) for x in (roll, pitch, yaw))
    return (
        (e * d, e * t * s - u * c, e * t * c + u * s),
        (u * d, u * t * s + e * c, u * t * c - e * s),
        (0.0 - t, d * s, d * c),
    )


def quaternion_matrix(quaternion: Quaternion) -> Matrix:
    """Rotation matrix of a quaternion x y z w."""
    x, y, z, w = unit(quaternion)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def _exact(x: float) -> float:
    return float(round(x)) if abs(x - round(x)) < EXACT else x
