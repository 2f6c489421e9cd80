"""Step control: whether an attempted step is accepted and how long the next one is, with error control or fixed steps.

Error control: the estimate is divided by tol scale (1 + |y|), scale <= 1 for small motions (see below), in the root
mean square over coordinates and velocities (Hairer, Norsett, Wanner I, II.4) and the next step is Gustafsson's PI
choice (Hairer, Wanner II, IV.2). Drift of constraint rows within a step counts as a coordinate that should be zero: its
correction must not move the bodies by more than the tolerance, since stiff laws react to it at once, however far from
the origin. Fixed steps: accepted unless the state is no longer finite; the last one before a boundary is as short as it
must be.

Scale of the tolerance for slow motions, and the speed below which a scene is at rest.

The scale is 1 once anything has moved at SWIFT; before that it is the largest speed so far relative to SWIFT, at least
FINEST. The largest speed is part of the state and never falls, so that a scene coming to rest is not resolved down to
its rounding errors. Motions that rounding alone could cause under stiff laws are never resolved.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.compiler.symbol import Value, maximum, minimum, select, sqrt
from heavylift.kernel.methods.method import StepState

from .method import Attempt, Exponents

SWIFT = 1e-2  # [m/s, rad/s] from which the tolerance is that of a metre
FINEST = 1e-5  # least scale of the tolerance: that of a motion at 1e-7 m/s
STILL = 1e-7  # |v| [SI] and |dv/dt| [SI] of a scene at rest after it has moved at SWIFT
FAINT = 1e-3  # part of STILL at which a scene is at rest that has only crept
ULPS = 16.0 * 2.0**-52  # relative displacement that shows what rounding does to accelerations


def scale_of(before: Value, v: Value) -> Value:
    """Return the scale of the error tolerance of step control, which grows with the largest speed so far, up to 1.

    `before`: the previous scale; v (nv,): velocities.
    """
    for u in v:
        # the largest speed so far: a scene that comes to rest keeps the scale of its motion
        before = maximum(before, abs(u) * (1.0 / SWIFT))
    return minimum(before, 1.0)


def allowed(s: StepState, size: Value) -> Value:
    """Return the allowed error (ny,) of a step for a state of the given size (Hairer, Norsett, Wanner I, II.4)."""
    return s.tol * maximum(s.scale, s.grain) * (1.0 + size)


def still_below(scale: Value, faint: Value) -> Value:
    """Return the threshold of |v|^2 and |dv/dt|^2 [SI] below which a scene counts as at rest; lower in slow scenes."""
    part = maximum(scale, faint)
    return STILL * STILL * (part * part)


def rounded(acceleration: Callable[[np.ndarray], np.ndarray], q: np.ndarray, tol: float) -> dict[str, float]:
    """Return two limits of step control below which it would resolve only the round-off of coordinates q (nq,).

    `grain`: smallest useful scale of the tolerance; `faint`: factor on the threshold STILL of rest. `acceleration`:
    function from coordinates to accelerations (nv,). A law that turns a displacement d into an acceleration a
    oscillates at sqrt(a / d); round-off in the displacement then becomes a speed of sqrt(a d).
    """
    here, d = acceleration(q), ULPS * (1.0 + np.abs(q))
    # two patterns of displacements, since equal signs can cancel in a stiff law between two coordinates
    alternating = d.copy()
    alternating[1::2] *= -1.0
    with np.errstate(invalid="ignore"):  # what is not finite is reported where it acts
        moved = [acceleration(q + x) - here for x in (d, alternating)]
    most = max(math.sqrt(float((x * x).sum())) for x in moved)
    if not math.isfinite(most):
        return {"grain": 1.0, "faint": 1.0}
    # a displacement d of rounding under stiffness a/d oscillates with speed sqrt(a d)
    speed = math.sqrt(most * float(d.max(initial=0.0)))
    # below this speed the tolerance would resolve round-off, below this acceleration nothing ever comes to rest
    return {"grain": min(1.0, speed / tol), "faint": min(1.0, max(FAINT, most / STILL))}


TINY = 1e-200  # keeps the quotient of two vanishing errors at zero
UNSOLVED = 16.0  # error of a step whose equations were not solved: the next one is half as long
FINITE = 1e300  # a squared state beyond it, or one that is not a number, is not finite


@dataclass
class StepDecision:
    """Decision on an attempted step: whether it is accepted or has failed, and the length of the next step."""

    ok: Value
    h: Value
    error: Value
    failed: Value


class ErrorControl:
    """Step control by error estimate: steps are as long as the tolerance allows; a `forced` step is always accepted."""

    def __init__(self, exponents: Exponents, n: int) -> None:
        self._exponents, self._n = exponents, float(n)

    def judge(self, s: StepState, a: Attempt, h: Value, last: Value) -> StepDecision:
        x = self._exponents
        error = self._weighed(a.error, 1.0 / allowed(s, maximum(abs(s.y), abs(a.y))))
        # drift of the rows is in metres or radians, so it is compared with the bare tolerance
        if hasattr(a.r, "drift"):
            error = maximum(a.r.drift[0] * (1.0 / s.tol), error)
        if a.sound is not None:
            # Newton iterations that did not converge are an error without size: halve the step (UNSOLVED^down = 1/2 for
            # order 3)
            error = select(a.sound, error, UNSOLVED)
        good = error <= 1.0
        ok = good | (s.forced > 0.0)
        # the factors 0.2, 0.9 and 5 are those of DOPRI5 and RADAU5
        down = select(error > 1.0, maximum(0.2, 0.9 * power(maximum(error, 1.0), x.down)), 0.1)  # 0.1: not a number
        up = minimum(5.0, maximum(0.2, 0.9 * power(maximum(error, 1e-10), x.up) * power(s.error, x.memory)))
        # an implicit method saves a factorisation if the step stays as long
        if x.held > 1.0:
            up = select((up >= 1.0) & (up < x.held), 1.0, up)
        # a step shortened by a boundary says nothing about the next one: at least as long as proposed before
        following = minimum(s.h_max, select(good, select(last, maximum(s.h, h * up), h * up), h * down))
        # errors below 1e-4 are remembered as 1e-4, or the PI controller would overreact to one very good step
        return StepDecision(ok, following, select(good, maximum(error, 1e-4), s.error), following < s.h_min)

    def _weighed(self, error: Value, weight: Value) -> Value:
        """Return the error relative to the tolerance; for two estimates by Hairer, Norsett, Wanner I, (II.10.17)."""
        if not isinstance(error, tuple):
            e = error * weight
            return sqrt(e @ e * (1.0 / self._n))
        high, low = (e * weight for e in error)
        square = high @ high
        # the estimate of order 3 corrects that of order 5 where the latter happens to vanish
        return square / sqrt((square + 0.01 * (low @ low) + TINY) * self._n)


class FixedStep:
    """Step control with fixed steps of length s.h, shortened only at boundaries, events and commands."""

    def judge(self, s: StepState, a: Attempt, h: Value, last: Value) -> StepDecision:
        finite = a.y @ a.y < FINITE
        if a.sound is not None:
            # a state beyond FINITE squared overflows soon; NaN fails the comparison, too
            finite = finite & a.sound
        ok = finite | (s.forced > 0.0)
        again = 0.0 if a.fresh is None else select(a.fresh, 0.0, 1.0)  # once more with a new Jacobian
        return StepDecision(ok, s.h, s.error, select(ok, 1.0, again) < 0.5)


Control = ErrorControl | FixedStep
