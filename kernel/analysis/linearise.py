"""Derivatives of the accelerations at a pose, by fourth-order central differences of the native rate.

Discrete states are frozen; a step in which a guard falls is made smaller, so that no clamp of a law enters.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .poses import Poses

__all__ = ["damping", "stiffness"]

STEP, SMALLEST = 1e-4, 1e-7  # [m, rad] between poses
SPEED_STEP = 1e-3  # [m/s, rad/s]


def stiffness(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """(n, n) da/dq [1/s2] of the motions `basis` (n_free, n) at pose q, at rest."""
    poses.accelerations(q)
    holds = poses.guards() >= 0.0

    def column(e: np.ndarray) -> np.ndarray:
        h = STEP
        while True:
            fallen = False

            def at(x: float) -> np.ndarray:
                nonlocal fallen
                a = poses.accelerations(poses.moved(q, x * e))
                fallen = fallen or bool(np.any(poses.guards()[holds] < 0.0))
                return a

            derivative = _difference(at, h)
            if not fallen or h <= SMALLEST:
                return derivative
            h *= 0.1

    return _columns(column, basis)


def damping(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """(n, n) da/dv [1/s] of the motions `basis` at pose q, at rest."""
    return _columns(lambda e: _difference(lambda x: poses.accelerations(q, x * e), SPEED_STEP), basis)


def _difference(f: Callable[[float], np.ndarray], h: float) -> np.ndarray:
    """f'(0) to fourth order."""
    derivative: np.ndarray = (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
    return derivative


def _columns(f: Callable[[np.ndarray], np.ndarray], basis: np.ndarray) -> np.ndarray:
    n = basis.shape[1]
    matrix: np.ndarray = basis.T @ np.array([f(e) for e in basis.T]).reshape(n, len(basis)).T
    return matrix
