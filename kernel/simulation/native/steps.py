"""Steps, located events, commits and samples of any method, as branch-free code over one state block.

The method gives stages and dense output, the control decides whether a step is accepted (Hairer, Norsett, Wanner 1993,
section II.4; dense output: II.6). The last accepted step stays *tentative*: its samples and peaks count only when the
next call commits it, so that an input inside it can discard it. A guard that becomes negative in a step is located in
the dense output to a quarter of a nanosecond; the consequences are decided elsewhere (`events`).
"""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.symbol import Value, any_of, maximum, minimum, select, sqrt
from heavylift.kernel.methods.control import Control, scale_of, still_below
from heavylift.kernel.methods.method import Evaluated, Method, Rate, StepState, fallen_in, inside, length

from . import dips
from .peaks import NEAR, begin, remember, watch
from .sample_row import kept

RUNNING, BREAK, EVENT, STILL, FAILED = 0.0, 1.0, 2.0, 3.0, 4.0  # why a native call returned
LOCATED = 2.5e-10  # [s] width to which a guard's root is bracketed

Project = Callable[[Value, Value], SimpleNamespace]  # (t, y) -> place, gap, slip, pivot
Row = Callable[[Value, Value], list[Value]]  # (t, y) -> columns of a sample


def step(s: StepState, rate: Rate, method: Method, control: Control) -> None:
    """Attempt a step from (t, y) with derivative f; a `forced` step is always accepted.

    Guards are evaluated in every stage, so a guard that falls and recovers within the step is not missed.
    """
    h, last = length(s)
    if hasattr(s, "top"):
        remember(s)
    if hasattr(s, "dip"):
        dips.remember(s)
    a = method.attempt(s, rate, h, inside(s))
    below, earliest = False, 1.0
    # stages in the order of time: the earliest one with a negative guard bounds the search
    for c, fell in sorted(a.seen, key=lambda x: x[0]):
        below, earliest = any_of([below, fell]), select(below, earliest, select(fell, c, earliest))
    verdict = control.judge(s, a, h, last)
    ok = verdict.ok
    # the state at the start stays available, so that the step can be undone
    s.t0, s.h0, s.f0, s.d0 = s.t, h, s.f, s.y
    method.keep(s, h, a)
    if method.completes:
        # the extra stages of the dense output are missing until they are needed
        s.coarse = 1.0
    # t_stop itself, not t + h, or round-off would leave a remainder before the boundary
    s.t = select(ok, select(last, s.t_stop, s.t + h), s.t)
    s.y, s.f = select(ok, a.y, s.y), select(ok, a.f, s.f)
    s.error, s.h = verdict.error, select(ok, bounded(verdict.h, a.r), verdict.h)
    s.accepted, s.rejected = s.accepted + select(ok, 1.0, 0.0), s.rejected + select(ok, 0.0, 1.0)
    s.tentative = select(ok, 1.0, 0.0)
    s.T = select(ok, a.r.T, s.T)
    ended = fallen_in(a.r)
    fallen = below if below is False else ok & below
    s.locate = select(fallen, 1.0, 0.0)
    s.doubt = select(ended, 0.0, 1.0)
    # if the end is beyond the guard, the root lies in the whole step, else before the first stage that saw it
    s.lo, s.hi = 0.0, select(ended, 1.0, earliest)
    s.G = a.r.G
    if hasattr(s, "dip"):
        dips.watch(s, ok & (s.forced < 0.5) & (s.locate < 0.5))
    s.budget = s.budget - 1.0
    # the step that passes `until` is the last one of this call, and stays tentative
    s.more = select(s.budget > 0.0, select(s.rows > s.row, select(s.until >= s.t, 1.0, 0.0), 0.0), 0.0)
    if hasattr(s, "passing"):
        s.passing = passing(s, a.r)
    s.calm = select(verdict.failed, FAILED, select(s.still > 0.0, STILL, select(ok & last, BREAK, RUNNING)))
    go_on(s, fallen_status(s, fallen))


def fallen_status(s: StepState, fallen: Value) -> Value:
    """Return the status of the stepping loop: EVENT if a guard is negative, unless it has failed or is at rest."""
    # an event takes precedence over the end of a profile piece, but not over a failure or a rest
    return select(fallen, select(s.calm > BREAK, s.calm, EVENT), s.calm)


def dive(s: StepState, rate: Rate, method: Method) -> None:
    """Search the last step for a guard that falls below zero and rises again; set the status of the stepping loop."""
    dips.dive(s, rate, method)
    go_on(s, fallen_status(s, s.locate > 0.5))


def bounded(h: Value, r: Evaluated) -> Value:
    """Return the length h [s] of the next step, limited so that shapes cannot pass through each other between two
    evaluations of their guards."""
    return minimum(h, r.reach[0]) if hasattr(r, "reach") else h


def passing(s: StepState, r: Evaluated) -> Value:
    """Return 1 s plus the time at which the fixed step was first too long to detect passing shapes; 0 if it never was.

    Local time; negative if a note about it was already added.
    """
    # a fixed step is not shortened: it is only noted when shapes could have passed unseen
    blind = select(s.h_max > r.window[0], s.t + 1.0, 0.0)
    return select(abs(s.passing) > 0.0, s.passing, blind)


def go_on(s: StepState, status: Value) -> None:
    """Set the status of the stepping loop, which ends unless it is RUNNING and steps, sample space and time remain."""
    s.status = status
    s.run = select(status > RUNNING, 0.0, s.more)


def complete(s: StepState, rate: Rate, method: Method) -> None:
    """Compute the remaining stages for the dense output of the last step."""
    method.complete(s, rate)
    s.coarse = 0.0


def bisect(s: StepState, rate: Rate, method: Method) -> None:
    """Halve the bracket [lo, hi] around the first zero of a guard in the last step; G holds the guards at hi.

    A zero that only a stage has shown is discarded if the dense output does not confirm it at that time.
    """
    # a zero seen by a stage is checked at that stage first: stages are less accurate than the dense output
    x = select(s.doubt > 0.0, s.hi, 0.5 * (s.lo + s.hi))
    t = s.t0 + x * s.h0
    G = rate(t, t, method.interpolate(s, x)).G
    fallen = any_of(g < 0.0 for g in G)
    none = select(fallen, 0.0, s.doubt)
    s.G = select(fallen, G, s.G)
    s.lo, s.hi = select(fallen, s.lo, x), select(fallen, x, s.hi)
    # a quarter of a nanosecond decides to which nanosecond the event is rounded up
    s.locate = select(none > 0.0, 0.0, select((s.hi - s.lo) * s.h0 > LOCATED, 1.0, 0.0))
    s.doubt = 0.0
    go_on(s, select(none > 0.0, s.calm, s.status))


def commit(s: StepState, quaternions: list[int], velocities: slice, project: Project | None) -> None:
    """Commit the tentative step: update peaks of the tensions, due samples and unit quaternions.

    `project` projects the state onto the constraints and keeps their widest gaps so far. `still` is set when all
    velocities and accelerations vanish after the last command has ended.
    """
    higher = [(s.tentative > 0.0) & (p < T) for T, p in zip(s.T, s.peak, strict=True)]
    s.peak = np.array([select(c, T, p) for c, T, p in zip(higher, s.T, s.peak, strict=True)], dtype=object)
    if hasattr(s, "top"):
        s.top = np.array(
            [select(c, maximum(T, p), p) for c, T, p in zip(higher, s.T, s.top, strict=True)], dtype=object
        )
        watch(s, s.tentative > 0.0)
    s.peak_time = np.array([select(c, s.t, p) for c, p in zip(higher, s.peak_time, strict=True)], dtype=object)
    if project:
        # Newton step onto the constraints once per committed step: drift does not accumulate
        x = project(s.t, s.y)
        s.y = select(s.tentative > 0.0, x.place, s.y)
        s.gap = select(s.tentative > 0.0, maximum(s.gap, abs(x.gap)), s.gap)
    y = s.y.copy()
    # the projection of a quaternion to unit length changes no attitude, since poses normalise it
    for i in quaternions:
        q = s.y[i : i + 4]
        y[i : i + 4] = q * (1.0 / sqrt(q @ q))
    s.y = y
    limit = still_below(s.scale, s.faint)
    # both must be small: at the turning point of a swing only the speed is
    slow = [sum(e * e for e in x[velocities]) < limit for x in (s.y, s.f)]
    # never before the last commanded motion has ended
    s.still = select(s.t >= s.t_rest, select(slow[0], select(slow[1], 1.0, 0.0), 0.0), 0.0)
    s.due = select(s.tentative > 0.0, select(s.t >= s.t_out, 1.0, 0.0), 0.0)
    s.scale = select(s.tentative > 0.0, scale_of(s.scale, y[velocities]), s.scale)
    s.tentative = 0.0


def refresh(s: StepState, rate: Rate, method: Method) -> None:
    """Recompute derivative, tensions and guards at (t, y) after a change of state, laws or discrete states."""
    r = rate(s.t, inside(s), s.y)
    s.f, s.T, s.G, s.h = r.dy, r.T, r.G, bounded(s.h, r)
    if hasattr(s, "passing"):
        s.passing = passing(s, r)
    if hasattr(s, "top") or hasattr(s, "dip"):
        # one evaluation a microsecond ahead replaces the missing step before the first one
        ahead = rate(s.t + NEAR, inside(s), s.y + NEAR * s.f)
        if hasattr(s, "top"):
            begin(s, ahead)
        if hasattr(s, "dip"):
            dips.begin(s, ahead)
    for name, value in method.forgotten().items():
        setattr(s, name, value)
    s.tentative = 0.0


def close(s: StepState, project: Project) -> None:
    """Move the state onto the constraints by one Newton step; store the gaps before it, and the pivots of the rows."""
    x = project(s.t, s.y)
    s.y, s.gap, s.slip, s.pivot = x.place, x.gap, x.slip, x.pivot


def look(s: StepState, row: Row) -> tuple[Value, list[Value]]:
    """Write the present state as a sample row, which the next sample overwrites."""
    return s.row, [*row(s.t, s.y), *kept(s)]


def sample(s: StepState, rate: Rate, row: Row, method: Method) -> tuple[Value, list[Value]]:
    """Write a sample row from the dense output of the committed step; steps are not shortened for samples."""
    values = [*row(s.t_out, method.interpolate(s, (s.t_out - s.t0) * (1.0 / s.h0))), *kept(s)]
    number = s.row
    s.row, s.count = number + 1.0, s.count + 1.0
    # multiples, not sums, of the sample period: no drift on the grid
    s.t_out = s.t_base + s.count * s.dt_out
    s.peak = s.peak * 0.0
    s.due = select(s.t >= s.t_out, 1.0, 0.0)
    return number, values
