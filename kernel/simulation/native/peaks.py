"""Detection of tension maxima between the ends of steps: whether a step may contain one, and how high it is.

Tensions at the ends of the last two accepted steps (before the first step of a stretch the rate replaces one of them)
bound the maximum in the last one; if they rise past all earlier ones, the rate at the end shows whether the maximum was
passed. If the maximum may be the highest of the run, by more than the tolerance, the dense output is evaluated at
`NODES` times, as accurately as at the ends, and the maximum of a polynomial through these tensions is taken.
"""

import numpy as np
from heavylift.kernel.algebra.dense import inverse
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value, any_of, maximum, minimum, select
from heavylift.kernel.methods.method import Evaluated, Method, Rate, StepState, combine

POINTS = ("Ta", "Tb", "top")  # (n_ropes,) at the starts of the last two steps; highest so far
FLAGS = ("ta", "steep", "hilly", "searched")  # start of the step before the last one; what that calls for; searches
SLIGHT = 1e-4  # of the highest tension, at most: what is not looked for
SEEN = 3.0  # times the bend of a parabola through three ends: a third of a sine's, in steps of up to two radians
NEAR = 1e-6  # [s] to where a rate is measured
NODES = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)  # over a step
POWERS = inverse([[u**j for j in range(len(NODES))] for u in NODES])
ROUNDS = 4  # of Newton, from the highest node


def begin(s: StepState, ahead: Evaluated) -> None:
    """Initialise the detection of tension maxima, with a point extrapolated backwards in place of a previous step."""
    # a point on the tangent before the start: two earlier ends are needed to bound a bend
    s.ta, s.t0, s.Tb, s.Ta = s.t - NEAR, s.t, s.T, 2.0 * s.T - ahead.T
    s.steep = s.hilly = 0.0


def remember(s: StepState) -> None:
    """Store the tensions at the ends of the last accepted step, before the next attempt."""
    # a rejected attempt must not shift the history
    taken = s.t > s.t0
    s.ta, s.Ta, s.Tb = select(taken, s.t0, s.ta), select(taken, s.Tb, s.Ta), select(taken, s.T, s.Tb)


def watch(s: StepState, taken: Value) -> None:
    """Determine whether a rope tension may have passed or approached a new peak within the last accepted step."""
    hills, rises = _bounds(s, select(taken, s.t, s.t0 + 1.0))
    s.hilly = select(taken & any_of(hills), 1.0, 0.0)
    s.steep = select(taken & any_of(rises), 1.0 - s.hilly, 0.0)


def _bounds(s: StepState, end: Value) -> tuple[list[Value], list[Value]]:
    """Return, for each rope, whether the maximum in the step to `end` may be the highest so far, and whether the
    tension may still rise to one."""
    h, before = end - s.t0, s.t0 - s.ta
    # SEEN times the second difference of unequal intervals bounds the curvature
    over, twice, whole = 1.0 / h, 1.0 / before, SEEN / (end - s.ta)
    # a crest lower than this above the known peak changes nothing within the tolerance
    least = 1.0 + minimum(s.tol, SLIGHT)
    hills, rises = [], []
    for a, b, c, top in zip(s.Ta, s.Tb, s.T, s.top, strict=True):
        rise = (c - b) * over
        bend = ((b - a) * twice - rise) * whole
        # crest of the parabola through both ends with the bounded curvature
        crest = 0.5 * (b + c) + 0.25 * (bend * h * h + rise * rise / maximum(bend, 1e-30))
        hills.append((bend * h > abs(rise)) & (crest > least * top))
        # the tension rises past the known peak: only its slope at the end shows whether a crest was passed
        rises.append((c > b) & (2.0 * c - b > least * top))
    return hills, rises


def slope(s: StepState, rate: Rate) -> None:
    """Determine whether a tension that rose during the step falls at its end, so that it has passed a maximum."""
    # backward difference over a microsecond, with the profile piece of the step
    behind = rate(s.t - NEAR, s.t0 + 0.5 * s.h0, s.y - NEAR * s.f).T
    _, rises = _bounds(s, s.t)
    s.hilly = select(any_of(r & (b > c) for r, b, c in zip(rises, behind, s.T, strict=True)), 1.0, 0.0)
    s.steep = 0.0


def climb(s: StepState, rate: Rate, method: Method) -> None:
    """Raise the recorded peaks of ropes to the maxima of their tensions within the last step."""
    among = s.t0 + 0.5 * s.h0
    parts = [(u - NODES[0]) / (NODES[-1] - NODES[0]) for u in NODES]
    inner = [rate(s.t0 + x * s.h0, among, method.interpolate(s, x)).T for x in parts[1:-1]]
    found = []
    for tensions, hill, rise in zip(zip(s.Tb, *inner, s.T, strict=True), *_bounds(s, s.t), strict=True):
        at = TOP(V=tensions)
        found.append((select(hill | rise, at.T[0], 0.0), s.t0 + s.h0 * (at.u[0] - NODES[0]) / (NODES[-1] - NODES[0])))
    new = [top < T for (T, _), top in zip(found, s.top, strict=True)]
    s.top = _chosen(new, [T for T, _ in found], s.top)
    s.peak = _chosen(new, [T for T, _ in found], s.peak)
    s.peak_time = _chosen(new, [t for _, t in found], s.peak_time)
    s.hilly, s.searched = 0.0, s.searched + 1.0


def _chosen(new: list[Value], found: list[Value], old: Value) -> np.ndarray:
    return np.array([select(*x) for x in zip(new, found, old, strict=True)], dtype=object)


def _top(V: Value) -> dict[str, Value]:
    """Return the maximum of a polynomial through tensions at `NODES`, with its place. Newton's method from the highest
    node, bounded by half of the distance to its neighbours."""
    c = [combine(row, list(V)) for row in POWERS]
    first = [j * x for j, x in enumerate(c)][1:]
    second = [j * x for j, x in enumerate(first)][1:]
    best, start, low = V[0], NODES[0], minimum(V[1], V[2])
    for i in range(1, len(NODES)):
        other = minimum(V[i - 1], V[i + 1] if i + 1 < len(NODES) else V[i - 2])
        more = V[i] > best
        best, start, low = select(more, V[i], best), select(more, NODES[i], start), select(more, other, low)
    u = start
    # Newton on the derivative; it goes downhill only where the polynomial is concave
    for _ in range(ROUNDS):
        curve = _at(second, u)
        u = u - select(curve < 0.0, _at(first, u) / select(curve < 0.0, curve, 1.0), 0.0)
        # bounded to the neighbouring nodes: outside another maximum could attract it
        u = minimum(maximum(u, maximum(start - 1.0, NODES[0])), minimum(start + 1.0, NODES[-1]))
    # and to half of the rise between nodes, where a noisy polynomial might overshoot
    value = minimum(_at(c, u), best + 0.5 * (best - low))
    return {"T": [maximum(value, best)], "u": [select(value > best, u, start)]}


def _at(c: list[Value], u: Value) -> Value:
    """Evaluate a polynomial of coefficients c, the constant one first."""
    found = c[-1]
    for x in c[-2::-1]:
        found = x + u * found
    return found


TOP = Function("top", _top, {"V": len(NODES)})
