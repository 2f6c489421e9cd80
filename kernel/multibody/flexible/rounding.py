"""Rounding of modes and constants, and rigid motions of nodes."""

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.spatial import skew

FREE = 1e-6  # of the largest stiffness, as a strain that is none
DIGITS = 12  # to which constants are rounded: beyond them they are noise


def rounded(x: np.ndarray) -> np.ndarray:
    """x to DIGITS significant digits of its largest element, so that what should be zero is zero."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0:
        return x
    digits, exponent = f"{largest:.17e}".split("e")
    scale = float(f"1e{int(exponent) + (float(digits) > 1.0)}")
    return np.asarray(np.round(x / scale, DIGITS) * scale + 0.0)  # no negative zeros


def rounded_each(x: np.ndarray) -> np.ndarray:
    """Every element to DIGITS significant digits of its own."""
    return np.array([float(f"{e:.{DIGITS - 1}e}") for e in x])


def rigid_motions(nodes: np.ndarray) -> np.ndarray:
    """(6n, 6) B_0 of equation (2) in `tracks`: velocities of the nodes (n, 3) in a rigid motion."""
    B = np.zeros((len(nodes), 6, 6))
    for j, X in enumerate(nodes):
        B[j, :3, :3] = -skew(X)
    B[:, :3, 3:] = B[:, 3:, :3] = np.eye(3)
    return B.reshape(-1, 6)


def moves_freely(u: np.ndarray, K: np.ndarray, held: list[int]) -> bool:
    """Whether a rigid motion of the nodes neither meets the frame nor strains anything."""
    if not np.any(u) or np.any(u[held]):
        return False
    return bool(np.abs(times(K, u)).max() <= FREE * np.abs(K).max() * np.abs(u).max())
