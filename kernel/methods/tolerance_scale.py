"""What the tolerance is relative to where nothing moves fast, and how slow a scene must be to be at rest.

The tolerance is that of a metre once anything has moved at SWIFT; before that it shrinks with the fastest speed so
far, down to FINEST.  That speed only grows, so that what comes to rest is not followed into its rounding; it is part of
the state.  What rounding alone could do under stiff laws is never resolved.
"""

from collections.abc import Callable
from math import isfinite, sqrt

import numpy as np
from heavylift.kernel.compiler.symbol import Value, maximum, minimum
from heavylift.kernel.methods.method import StepState

SWIFT = 1e-2  # [m/s, rad/s] from which the tolerance is that of a metre
FINEST = 1e-5  # least scale of the tolerance: that of a motion at 1e-7 m/s
STILL = 1e-7  # |v| [SI] and |dv/dt| [SI] of a scene at rest after it has moved at SWIFT
FAINT = 1e-3  # part of STILL at which a scene is at rest that has only crept
ULPS = 16.0 * 2.0**-52  # relative displacement that shows what rounding does to accelerations


def scale_of(before: Value, v: Value) -> Value:
    """Scale of the tolerance with velocities v (nv,), when it was `before` until now."""
    for u in v:
        before = maximum(before, abs(u) * (1.0 / SWIFT))
    return minimum(before, 1.0)


def allowed(s: StepState, size: Value) -> Value:
    """(ny,) error that a step may make in a state of this size (Hairer, Norsett, Wanner I, II.4)."""
    return s.tol * maximum(s.scale, s.grain) * (1.0 + size)


def still_below(scale: Value, faint: Value) -> Value:
    """|v|^2 and |dv/dt|^2 [SI] of a scene at rest: what has only crept must be slower than what has moved."""
    part = maximum(scale, faint)
    return STILL * STILL * (part * part)


def rounded(acceleration: Callable[[np.ndarray], np.ndarray], q: np.ndarray, tol: float) -> dict[str, float]:
    """What rounding does at coordinates q (nq,): `grain`, the scale of a tolerance that does not follow it, at most 1,
    and `faint`, the part of STILL that a scene at rest stays below in spite of it, FAINT to 1.

    `acceleration`: (nv,) of coordinates.  A law that makes a displacement d an acceleration a swings at sqrt(a / d), so
    that a displacement by rounding becomes a speed of sqrt(a d).
    """
    here, d = acceleration(q), ULPS * (1.0 + np.abs(q))
    alternating = d.copy()
    alternating[1::2] *= -1.0
    with np.errstate(invalid="ignore"):  # what is not finite is told where it acts
        moved = [acceleration(q + x) - here for x in (d, alternating)]
    most = max(sqrt(float((x * x).sum())) for x in moved)
    if not isfinite(most):
        return {"grain": 1.0, "faint": 1.0}
    speed = sqrt(most * float(d.max(initial=0.0)))
    return {"grain": min(1.0, speed / tol), "faint": min(1.0, max(FAINT, most / STILL))}
