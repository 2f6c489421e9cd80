"""Batched products of vectors and quaternions, independent of the kernel.

Arrays are small, so what counts is the number of calls, not of operations.
"""

from __future__ import annotations

import numpy as np


def rotation(q: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of quaternions x y z w."""
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    R, double = np.empty((*q.shape[:-1], 3, 3)), 2.0 * q
    xx, yy, zz = double[..., 0] * x, double[..., 1] * y, double[..., 2] * z
    xy, xz, yz = double[..., 0] * y, double[..., 0] * z, double[..., 1] * z
    xw, yw, zw = double[..., 0] * w, double[..., 1] * w, double[..., 2] * w
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = 1.0 - yy - zz, xy - zw, xz + yw
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = xy + zw, 1.0 - xx - zz, yz - xw
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = xz - yw, yz + xw, 1.0 - xx - yy
    return R


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b along the last axis; NumPy's own is slower."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    out = np.empty((*np.broadcast(ax, bx).shape, 3))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out


def turned(R: np.ndarray, a: np.ndarray) -> np.ndarray:
    """(..., m) of matrices (..., m, n) times vectors (..., n)."""
    return (R @ a[..., None])[..., 0]


def hat(a: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of the cross product with a."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    out = np.zeros((*a.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = z, -y, x
    return out


def hamilton(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of quaternions x y z w."""
    ax, ay, az, aw = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    out = aw[..., None] * b + b[..., 3:] * a
    out[..., 3] = aw * b[..., 3] - ax * b[..., 0] - ay * b[..., 1] - az * b[..., 2]
    out[..., :3] += cross(a, b)
    return out
