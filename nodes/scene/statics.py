"""What each of several plumb elastic hangers carries of a rigid load, none of them ever pushing.

The elongations of the hangers are those of a plane (the load is rigid), so T_i = k_i (a + b x_i + c y_i)
with sum T = W and no moment about the centre of mass; a hanger that would push is taken away and the rest
solved again. Three hangers give the barycentric shares whatever their stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ARM = 0.05  # what a line of hangers may miss the centre of mass by [m]; the load then leans a little


@dataclass(frozen=True)
class Hang:
    """A hanger at (x, y) from the centre of mass [m] with its stiffness [N/m]."""

    name: str
    x: float
    y: float
    k: float


def shares(hangs: list[Hang], mass: float) -> tuple[dict[str, float] | None, float]:
    """Load of each hanger in units of `mass` (None: they cannot hold it) and the arm that is missing [m]."""
    left = list(hangs)
    lean = 0.0
    while left:
        A = np.array([(1.0, h.x, h.y) for h in left])
        K = np.array([h.k for h in left])
        c = np.linalg.lstsq((A.T * K) @ A, np.array([mass, 0.0, 0.0]), rcond=1e-12)[0]
        T = K * (A @ c)
        if T.min() < -1e-9 * mass:
            left.pop(int(T.argmin()))
            continue
        error = A.T @ T - np.array([mass, 0.0, 0.0])
        lean = float(np.hypot(error[1], error[2]) / mass) + abs(float(error[0])) / mass
        if lean > ARM:
            break
        found = {h.name: 0.0 for h in hangs}
        return found | {h.name: max(0.0, float(t)) for h, t in zip(left, T, strict=True)}, lean
    if not hangs:
        return None, 0.0
    return None, lean or min(float(np.hypot(h.x, h.y)) for h in hangs)
