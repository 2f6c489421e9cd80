"""Vectors and rotations of all samples at once, several times as fast as NumPy's functions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cross(a: Floats, b: Floats) -> Floats:
    """Return cross products (n, 3), column-contiguous; four times as fast as NumPy's."""
    (x, y, z), (u, v, w) = a.T, b.T
    found: Floats = np.array([y * w - z * v, z * u - x * w, x * v - y * u]).T
    return found


def lengths(x: Floats) -> Floats:
    """Return the norms (...,) of vectors (..., 3 or 4); three times as fast as NumPy's."""
    found: Floats = np.sqrt(dots(x, x))
    return found


def dots(a: Floats, b: Floats) -> Floats:
    """Return the scalar products (...,) of vectors (..., k), summed in a fixed order."""
    found: Floats = a[..., 0] * b[..., 0]
    for i in range(1, a.shape[-1]):
        found += a[..., i] * b[..., i]
    return found


def turned(R: Floats, x: Floats) -> Floats:
    """Return the vectors R x (..., 3) for rotations (..., 3, 3), summed in a fixed order."""
    found: Floats = R[..., 0] * x[..., :1] + R[..., 1] * x[..., 1:2] + R[..., 2] * x[..., 2:]
    return found


def product(R: Floats, S: Floats) -> Floats:
    """Return the products R S (..., 3, 3) of rotations, summed in a fixed order."""
    return np.stack([turned(R, S[..., i]) for i in range(3)], axis=-1)


def chords(a: Floats, b: Floats) -> Floats:
    """Return an upper bound (...,) of the motion of a point 1 m from the axis between rotations (..., 4)."""
    w = dots(a, b)
    found: Floats = 2.0 * np.sqrt(np.maximum(0.0, 1.0 - w * w))
    return found


def matrices(q: Floats) -> Floats:
    """Return the rotation matrices (n, 3, 3) of unit quaternions x y z w, each element contiguous in memory."""
    x, y, z, w = q.T
    R = np.empty((3, 3, len(q)))
    R[0, 0], R[1, 1], R[2, 2] = 1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z), 1 - 2 * (x * x + y * y)
    R[0, 1], R[1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    R[0, 2], R[2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    R[1, 2], R[2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    found: Floats = R.transpose(2, 0, 1)
    return found


def onto(n: Floats) -> Floats:
    """Return rotations (m, 3, 3) whose third column is a unit vector (Duff et al. 2017, JCGT 6(1))."""
    x, y, z = n.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    R = np.empty((3, 3, len(n))).transpose(2, 0, 1)
    R[:, :, 0] = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    R[:, :, 1] = np.stack([b, sign + y * y * a, -y], axis=1)
    R[:, :, 2] = n
    return R


def axes_onto(x: float, y: float, z: float) -> Floats:
    """Return the rotation (3, 3) of `onto` for one unit vector, bit-identical and ten times as fast."""
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array(((1.0 + sign * x * x * a, b, x), (sign * b, sign + y * y * a, y), (-sign * x, -y, z)))
