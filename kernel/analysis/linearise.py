"""Derivatives of the accelerations at a pose of rest: along motions that loops allow, and along velocities."""

from __future__ import annotations

import numpy as np

from .poses import Poses

SPEED_STEP = 1e-3  # [m/s, rad/s]


def stiffness(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """(n, n) da/dq [1/s2] of the motions `basis` (n_free, n) at pose q, at rest."""
    matrix: np.ndarray = basis.T @ poses.stiffness(q) @ basis
    return matrix


def damping(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """(n, n) da/dv [1/s] of the motions `basis` at pose q, at rest, to fourth order."""
    h = SPEED_STEP

    def along(e: np.ndarray) -> np.ndarray:
        a = [poses.accelerations(q, x * h * e) for x in (1.0, -1.0, 2.0, -2.0)]
        difference: np.ndarray = 8.0 * (a[0] - a[1]) - (a[2] - a[3])
        return difference / (12.0 * h)

    n = basis.shape[1]
    matrix: np.ndarray = basis.T @ np.array([along(e) for e in basis.T]).reshape(n, len(basis)).T
    return matrix
