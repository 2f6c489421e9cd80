"""Products of vectors and quaternions in batches, for equations that owe nothing to the kernel."""

from __future__ import annotations

import numpy as np


def rotation(q: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of quaternions x y z w."""
    x, y, z, w = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(r, -1) for r in rows], -2)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b along the last axis; NumPy's own is slower."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    out = np.empty(a.shape if a.shape == b.shape else np.broadcast_shapes(a.shape, b.shape))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out


def hat(a: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of the cross product with a."""
    x, y, z = np.moveaxis(a, -1, 0)
    o = 0 * x
    return np.stack([np.stack(r, -1) for r in ([o, -z, y], [z, o, -x], [-y, x, o])], -2)


def hamilton(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of quaternions x y z w."""
    ax, ay, az, aw = np.moveaxis(a, -1, 0)
    bx, by, bz, bw = np.moveaxis(b, -1, 0)
    return np.stack([
        aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
    ], -1)  # fmt: skip
