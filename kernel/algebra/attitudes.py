"""Rotations as unit quaternions for display and recordings; no simulation result depends on them."""

import numpy as np
from numpy.typing import NDArray

SKEW, ROUNDED = 1e-12, 1e-5  # by which rows of a rotation that was rounded may be off orthogonal, and off one
ONE = np.eye(3)[:, :, None]
OFF = np.where(ONE > 0.0, ROUNDED, SKEW)


def quaternions(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert rotation matrices (n, 3, 3) to unit quaternions (n, 4): x y z w with w >= 0.

    Matrices that are not orthogonal are first replaced by the nearest rotations. Shepperd (1978): of four equal
    quaternions the one without cancellation. Sums have a fixed order, for the same bits.
    """
    a, b, c, d, e, f, g, h, i = columns = np.array(R.reshape(-1, 9).T, order="C")
    x, y, z = columns.reshape(3, 3, -1).swapaxes(0, 1)  # of the rows
    off = abs(x[:, None] * x + y[:, None] * y + z[:, None] * z - ONE)
    sheared = ~(off <= OFF).all(axis=(0, 1))
    if sheared.any():
        U, _, Vt = np.linalg.svd(R[sheared])
        columns[:, sheared] = (U @ Vt).reshape(-1, 9).T
    trace = a + e + i
    rest = 1.0 - trace
    K = [
        [a + a + rest, b + d, c + g, h - f],
        [b + d, e + e + rest, f + h, c - g],
        [c + g, f + h, i + i + rest, d - b],
        [h - f, c - g, d - b, 1.0 + trace],
    ]
    largest = np.array([a, e, i, trace]).argmax(axis=0)
    q = np.array(K)[largest, :, np.arange(len(R))]
    x, y, z, w = q.T
    q /= np.sqrt(x * x + y * y + z * z + w * w)[:, None]
    opposite = w < 0
    if not w.all():
        opposite |= (w == 0) & ((x < 0) | ((x == 0) & ((y < 0) | ((y == 0) & (z < 0)))))
    q[opposite] = -q[opposite]
    return q
