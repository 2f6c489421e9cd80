"""Hills of tensions between the ends of steps, as text: what is remembered of two steps, and whether they show one.

Three tensions at the ends of two accepted steps show that a rope's tension has a hill between them; before the first
step of a stretch its rate stands for the third one.  If the hill may be the highest of the run, the run stops when the
step is committed and looks for it (`simulation.peak_search`).  A parabola through three points of a sine sees at least
a third of what is missing (steps of up to two radians).
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.compiler.symbol import Value, any_of, maximum, select
from heavylift.kernel.methods.method import inside
from heavylift.kernel.methods.step_state import Rate, StepState

__all__ = ["AHEAD", "POINTS", "SLIGHT", "STATES", "begin", "higher", "remember", "watch"]

POINTS = ("Ta", "Tb", "top", "hill", "older", "skips")  # (n_ropes,) at the starts of the last two steps;
# highest so far; the last two hills that were looked for in this stretch, and how many of the next ones are skipped
STATES = ("ya", "fa")  # (ny,) state and derivative at the start of the step before the last one
SLIGHT = 1e-4  # of the highest tension: what is not looked for
SEEN = 3.0  # times what a parabola sees
AHEAD = 1e-6  # [s] to where a rate is measured


def begin(s: StepState, rate: Rate) -> None:
    """At the start of a stretch: a point before it, on the tangent."""
    ahead = rate(s.t + AHEAD, inside(s), s.y + AHEAD * s.f).T
    s.ta, s.t0, s.Tb, s.Ta = s.t - AHEAD, s.t, s.T, 2.0 * s.T - ahead
    s.ya = s.d0 = s.y
    s.fa = s.f0 = s.f
    s.peaking, s.hill, s.older, s.skips = 0.0, 0.0 * s.T, 0.0 * s.T, 0.0 * s.T


def remember(s: StepState) -> None:
    """Before an attempt: the last step, if it was taken, becomes the one before it."""
    taken = s.t > s.t0
    s.ta, s.Ta, s.Tb = select(taken, s.t0, s.ta), select(taken, s.Tb, s.Ta), select(taken, s.T, s.Tb)
    s.ya, s.fa = select(taken, s.d0, s.ya), select(taken, s.f0, s.fa)


def watch(s: StepState, ok: Value) -> None:
    """After an attempt: whether it shows a hill that may be the highest and is not skipped."""
    rising = [ok & h for h in higher(s, select(ok, s.t, s.t0 + 1.0))]
    due = [h & (n <= 0.0) for h, n in zip(rising, s.skips, strict=True)]
    s.skips = np.array([select(h, n - 1.0, n) for h, n in zip(rising, s.skips, strict=True)], dtype=object)
    s.peaking = select(any_of(due), 1.0, 0.0)


def higher(s: StepState, end: Value) -> list[Value]:
    """Of each rope, whether the last two steps, to time `end`, show a hill that may be the highest."""
    before, after, whole = 1.0 / (s.t0 - s.ta), 1.0 / (end - s.t0), 1.0 / (end - s.ta)
    hills = []
    for a, b, c, top in zip(s.Ta, s.Tb, s.T, s.top, strict=True):
        up, down = (b - a) * before, (b - c) * after
        slope = (up * (end - s.t0) - down * (s.t0 - s.ta)) * whole
        more = slope * slope / (4.0 * maximum((up + down) * whole, 1e-30))
        hill = (up >= 0.0) & (down >= 0.0)
        hills.append(hill & (b + SEEN * more > (1.0 + SLIGHT) * maximum(top, maximum(b, c))))
    return hills
