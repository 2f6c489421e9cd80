"""Rotations as unit quaternions for display and recordings; no simulation result depends on them."""

import numpy as np
from numpy.typing import NDArray

SKEW, ROUNDED = 1e-12, 1e-5  # by which rows of a rotation that was rounded may be off orthogonal, and off one


def quaternions(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert rotation matrices (n, 3, 3) to unit quaternions (n, 4): x y z w with w >= 0.

    Matrices that are not orthogonal are first replaced by the nearest rotations. Shepperd (1978): of four equal
    quaternions the one without cancellation. Sums have a fixed order, for the same bits.
    """
    a, b, c, d, e, f, g, h, i = columns = np.array(R.reshape(-1, 9).T, order="C")
    squares = ((a, b, c), (d, e, f), (g, h, i))
    sheared = np.zeros(len(R), dtype=bool)
    for j, u in enumerate(squares):
        for k, v in enumerate(squares[: j + 1]):
            off = abs(u[0] * v[0] + u[1] * v[1] + u[2] * v[2] - (j == k))
            sheared |= ~(off <= (ROUNDED if j == k else SKEW))
    if sheared.any():
        U, _, Vt = np.linalg.svd(R[sheared])
        columns[:, sheared] = (U @ Vt).reshape(-1, 9).T
    trace = a + e + i
    rest = 1.0 - trace
    K = (
        (a + a + rest, b + d, c + g, h - f),
        (b + d, e + e + rest, f + h, c - g),
        (c + g, f + h, i + i + rest, d - b),
        (h - f, c - g, d - b, 1.0 + trace),
    )
    largest = np.stack([a, e, i, trace]).argmax(axis=0)
    x, y, z, w = (np.choose(largest, column) for column in zip(*K, strict=True))
    size = np.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / size, y / size, z / size, w / size
    opposite = (w < 0) | ((w == 0) & ((x < 0) | ((x == 0) & ((y < 0) | ((y == 0) & (z < 0))))))
    q = np.stack([x, y, z, w], axis=1)
    q[opposite] = -q[opposite]
    return q
