"""Spatial algebra in world axes about a common point (Featherstone 2008, chapter 2), on floats and on symbols.

Twists are [angular; linear], wrenches [moment; force].  Because every quantity of a tree is expressed in world axes
about the same point, sums along a path need no transformations.
"""

from collections.abc import Sequence

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars

from .elementary import cos, sin


def exact(x: "Scalars | Sequence[Sequence[float]]") -> Array:
    """Return an array with its numbers as Python floats, so that products and sums are equal on all processors."""
    # products of NumPy floats use BLAS, which differs between processors
    return np.asarray(x, dtype=float).astype(object)


def join(*parts: Scalars) -> Array:
    return np.concatenate([np.asarray(p) for p in parts]) if parts else np.zeros(0)


def skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]], dtype=np.asarray(a).dtype)


def cross(a: Array, b: Array) -> Array:
    return skew(a) @ b


def mirror(A: Array) -> Array:
    """Return a square matrix with its upper triangle copied to the lower one, so that it is exactly symmetric."""
    n = len(A)
    return np.array([[A[min(i, j), max(i, j)] for j in range(n)] for i in range(n)])


def motion_cross(V: Array) -> Array:
    """Return the matrix (6, 6) of the spatial cross product V x for motion vectors (Featherstone's crm)."""
    return np.block([[skew(V[:3]), np.zeros((3, 3))], [skew(V[3:]), skew(V[:3])]])


def force_cross(V: Array) -> Array:
    """Return the matrix (6, 6) of the spatial cross product V x* for force vectors, crf(V) = -crm(V)^T."""
    return -motion_cross(V).T


def axis_rotation(a: Array, q: Scalar) -> Array:
    """Return the rotation matrix (3, 3) by q [rad] about the unit axis a.

    For a coordinate axis, its entries reduce to sin q, cos q, 0 and 1.
    """
    c, s, K = cos(q), sin(q), skew(a)
    return np.array([[a[i] * a[j] + c * ((i == j) - a[i] * a[j]) + s * K[i, j] for j in range(3)] for i in range(3)])


def quaternion_matrix(x: Scalar, y: Scalar, z: Scalar, w: Scalar) -> Array:
    """Return the rotation matrix (3, 3) of a quaternion of any length; orthogonal even if round-off changes |q|."""
    s = 2.0 / (x * x + y * y + z * z + w * w)
    return np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    )


def quaternion_rate(quaternion: Array, o: Array) -> Array:
    """Return the rate (4,) of a body's quaternion (x y z w); o: angular velocity in body axes [rad/s]."""
    x, y, z, w = quaternion
    return 0.5 * np.array(
        [
            w * o[0] + y * o[2] - z * o[1],
            w * o[1] + z * o[0] - x * o[2],
            w * o[2] + x * o[1] - y * o[0],
            -x * o[0] - y * o[1] - z * o[2],
        ]
    )


def spatial_inertia(mass: Scalar, c: Array, I_C: Array) -> Array:
    """Return the spatial inertia (6, 6) of a body about a point, from its centre of mass c [m] relative to this point,
    and its inertia I_C about c."""
    h = skew(mass * c)
    return np.block([[mirror(I_C - h @ skew(c)), h], [-h, mass * np.eye(3)]])
