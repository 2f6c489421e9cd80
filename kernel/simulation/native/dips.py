"""Detection of dips of guards between the ends of steps: a guard that becomes negative and recovers within one step,
unseen by the stages.

As with the maxima of tensions (`peaks`), guards at the ends of the last two accepted steps bound how low a guard may be
in the last step. Only if that is negative, by more than the tolerance, are guards evaluated in the dense output; the
location of an event begins at the minimum of a polynomial through them.
"""

from heavylift.kernel.compiler.symbol import Value, any_of, maximum, minimum, select
from heavylift.kernel.methods.method import Evaluated, Method, Rate, StepState

from .peaks import NEAR, NODES, SEEN, SLIGHT, TOP

ENDS = ("Ga", "Gb")  # (n_guards,) at the starts of the last two steps
FLAG = ("tg", "dip")  # start of the step before the last one; whether a dip is looked for


def begin(s: StepState, ahead: Evaluated) -> None:
    """Initialise the detection of dips of guards, with a point extrapolated backwards in place of a previous step."""
    s.tg, s.t0, s.Gb, s.Ga, s.dip = s.t - NEAR, s.t, s.G, 2.0 * s.G - ahead.G, 0.0


def remember(s: StepState) -> None:
    """Store the guards at the ends of the last accepted step, before the next attempt."""
    taken = s.t > s.t0
    s.tg, s.Ga, s.Gb = select(taken, s.t0, s.tg), select(taken, s.Gb, s.Ga), select(taken, s.G, s.Gb)


def watch(s: StepState, taken: Value) -> None:
    """Determine, after an accepted step without an event, whether a guard may have been below zero within the step."""
    end = select(taken, s.t, s.t0 + 1.0)
    h, over, twice, whole = end - s.t0, 1.0 / (end - s.t0), 1.0 / (s.t0 - s.tg), SEEN / (end - s.tg)
    low = []
    for a, b, c in zip(s.Ga, s.Gb, s.G, strict=True):
        rise = (c - b) * over
        bend = (rise - (b - a) * twice) * whole
        bent = bend * h
        above = bend * (0.5 * (b + c) + _shallow(s, b, c))
        # the parabola through both ends with the bounded curvature goes below the depth that may be missed
        low.append((bent > abs(rise)) & (above < 0.25 * (bent * bent + rise * rise)))
    s.dip = select(taken & any_of(low), 1.0, 0.0)


def _shallow(s: StepState, b: Value, c: Value) -> Value:
    """Return the depth of a dip that may be missed."""
    return minimum(s.tol, SLIGHT) * maximum(abs(b), abs(c))


def dive(s: StepState, rate: Rate, method: Method) -> None:
    """Locate an event at the minimum of a guard in the last step, if it is negative there in the dense output."""
    among = s.t0 + 0.5 * s.h0
    parts = [(u - NODES[0]) / (NODES[-1] - NODES[0]) for u in NODES]
    inner = [rate(s.t0 + x * s.h0, among, method.interpolate(s, x)).G for x in parts[1:-1]]
    found, at = [], 1.0
    for guard in zip(s.Gb, *inner, s.G, strict=True):
        # the maximum of -g is the minimum of the guard
        top = TOP(V=[-g for g in guard])
        below = top.T[0] > _shallow(s, guard[0], guard[-1])
        at = minimum(at, select(below, (top.u[0] - NODES[0]) / (NODES[-1] - NODES[0]), 1.0))
        found.append(below)
    fell = any_of(found) & (at > 0.0) & (at < 1.0)
    # in doubt: the dense output must confirm a zero that no stage has seen
    s.locate, s.doubt = select(fell, 1.0, 0.0), select(fell, 1.0, s.doubt)
    s.hi, s.dip = select(fell, at, s.hi), 0.0
