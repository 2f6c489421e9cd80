"""Rotations as quaternions, for what is shown and recorded of a run; nothing in a run follows from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["quaternions"]


def quaternions(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 4) unit quaternions x y z w, w >= 0, of (n, 3, 3) rotations of floats, or of the rotations next to them.

    Shepperd (1978): of four equal quaternions the one without cancellation.  Sums have one order, as the bits must.
    """
    sheared = ~np.isclose(R @ R.transpose(0, 2, 1), np.eye(3), atol=1e-12).all(axis=(1, 2))
    if sheared.any():
        U, _, Vt = np.linalg.svd(R[sheared])
        R = R.copy()
        R[sheared] = U @ Vt
    diagonal = R[:, range(3), range(3)]
    trace = diagonal[:, 0] + diagonal[:, 1] + diagonal[:, 2]
    K = np.empty((len(R), 4, 4))
    K[:, :3, :3] = R + R.transpose(0, 2, 1)
    K[:, range(3), range(3)] += (1.0 - trace)[:, None]
    K[:, 3, :3] = K[:, :3, 3] = R[:, (2, 0, 1), (1, 2, 0)] - R[:, (1, 2, 0), (2, 0, 1)]
    K[:, 3, 3] = 1.0 + trace
    q = K[range(len(R)), np.column_stack([diagonal, trace]).argmax(axis=1)]
    x, y, z, w = q.T
    q /= np.sqrt(x * x + y * y + z * z + w * w)[:, None]
    opposite = (w < 0) | ((w == 0) & ((x < 0) | ((x == 0) & ((y < 0) | ((y == 0) & (z < 0))))))
    return np.where(opposite[:, None], -q, q)
