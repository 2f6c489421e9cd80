"""Method and tolerance: each method is one small function that predicts, for a tolerance, what its steps cost and what
they add to the error of each quantity; `stepped` takes the cheapest of those that stay below what the rung has left.

    steps per second   explicit: what stability asks (`cost.attempts`); all: accuracy, c tol^(-1/p); at least 10
    rope tension       phi' min(1, (w h)^2 / 12), w: of the load on its hook, whose peak a step h must follow;
                       explicit methods at the edge of stability let stiff modes rattle: c tol^q over the stretch
    other quantities   0.03 sqrt(tol) of swing and position, tol if that is more, 0.1 sqrt(tol) of the time of lift-off

phi' is the dynamic factor less 1 (`chance`).  The constants are measured on lifts at random (STEPS.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt

from heavylift.kernel.algebra.elementary import power
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import LOOSEST, Fidelity

from .case import Case
from .chance import Errors, lightly_hooked, overshoot
from .cost import LONGEST, Cost, attempts, duration, radau_algebra, states

PARTS = 1.0, sqrt(sqrt(10.0)), sqrt(10.0), sqrt(sqrt(1000.0))  # of a decade
TOLERANCES = tuple(float(f"1e-{(k + 3) // 4}") * PARTS[-k % 4] for k in range(8, 49))  # 1e-2 to 1e-12
SMOOTH, EVENT, RIGID = 0.03, 0.1, 0.01  # errors over sqrt(tol): of swing and place, of lift-off, of rigid ropes' peaks

BOTH_SIDES = 2.0  # a place is an excursion to either side of the rest
DAMPED = 0.03  # usual damping of ropes
RATTLES = 2e4, 2e5  # how much more loads rattle without any, up to two lumps and more; measured
SNAPS = 10.0  # times the fourth power of their number: how much more lumps do as slack slings come taut; measured
PARTS_LATE = 0.002  # of tension and position, where a load that has stood parts again, beside `chance`
UNEVEN = 2.5  # how much worse long steps follow a block whose corners part at different speeds; measured
LET_GO = 1e-3  # tolerance of `radau5` above which it may follow a load that is let go aside another way; measured
LANDS_LIGHT = 4.0  # how much worse long steps follow a load that stands again under light hooks; measured
SMALL = 0.6  # [m] a swing below it is followed less well by `radau5`
DAMPS = "nothing damps what it would damp away"


@dataclass(frozen=True)
class Stepped:
    """A method at a tolerance: predicted errors and cost of its steps, and why; whether it can do the rung at all."""

    method: str
    tolerance: float
    errors: Errors
    cost: Cost
    reason: str
    allowed: bool = True

    def within(self, left: Errors) -> bool:
        """Whether it can do the rung and what the steps add stays below what is left for each quantity asked."""
        return self.allowed and self.exact(left)

    def exact(self, left: Errors) -> bool:
        """Whether the predicted errors alone do."""
        return all(self.errors[q] <= e for q, e in left.items())

    def worst(self, left: Errors) -> float:
        """Largest predicted error of what is asked."""
        return max(self.errors[q] for q in left)


Method = Callable[[Case, Fidelity, float], Stepped]


def dopri5(case: Case, at: Fidelity, tolerance: float) -> Stepped:
    """Bound by the stability of the stiffest mode: 6 evaluations a step."""
    stable = attempts(case, at)
    often = max(stable, 133.0 * power(1e-10 / tolerance, 0.2))
    errors = _errors(case, at, tolerance, often, rattle=1600.0 * tolerance * tolerance)
    why = f"explicit: the stiffest mode asks for {stable:.0f} steps a second"
    return Stepped("dopri5", tolerance, errors, _cost(case, at, 6.0 * often), why, tolerance <= LOOSEST)


def dop853(case: Case, at: Fidelity, tolerance: float) -> Stepped:
    """The same with steps two and a third times as long and 12 evaluations."""
    stable = max(1.0 / LONGEST, 0.43 * attempts(case, at))
    often = max(stable, 25.0 * power(1e-10 / tolerance, 0.125))
    errors = _errors(case, at, tolerance, often, rattle=3.5 * power(tolerance, 1.5))
    why = f"explicit: the stiffest mode asks for {stable:.0f} steps a second"
    return Stepped("dop853", tolerance, errors, _cost(case, at, 12.0 * often), why, tolerance <= LOOSEST)


def radau5(case: Case, at: Fidelity, tolerance: float) -> Stepped:
    """As long as the state allows: dense behind events, where loads bounce, and of up to 10 s where nothing happens.
    Jacobians are made anew at the ends of a stage and where iterations become slow, with two iterations a step."""
    n, lasts, events = states(case, at), duration(case), case.stages
    steps = (25.0 * events + 2.5 * min(lasts, 20.0 * events)) * power(1e-3 / tolerance, 0.25)
    steps += 0.5 * lasts * sqrt(1e-4 / tolerance)
    root, damped = sqrt(tolerance), power(tolerance, 1.25)
    jumps = (3.0 if case.changes else 1.0) * (1.0 if case.even else UNEVEN) * (2.0 if case.swings.jumps else 1.0)
    errors: Errors = {
        "rope tension": max(0.15 * root, 40.0 * damped),
        "swing": jumps * max(0.11 * root, 40.0 * damped) * max(1.0, SMALL / max(case.swings.most, 1e-3)),
        "position": jumps * max(0.11 * root, 30.0 * damped) * max(1.0, BOTH_SIDES * case.swings.most / case.way),
        "lift-off time": 2.0 * EVENT * root * (4.0 if case.again else 1.0),
    }
    if case.swings.lands and lightly_hooked(case):
        errors["position"] *= LANDS_LIGHT
        errors["lift-off time"] *= LANDS_LIGHT
    if case.again:
        errors["rope tension"] += PARTS_LATE
        errors["position"] += PARTS_LATE
    spent = 8.5 * steps + 7.5 * n * events
    linear = radau_algebra(n, 0.35 * steps + 15.0 * events, 2.15 * steps, steps)
    able = at.ropes != "rigid" and at.slings != "rigid"
    why = f"implicit: {steps:.0f} steps" if able else "it does not keep rigid ropes"
    if _bare(case):
        able, why = False, DAMPS
    able = able and not ((case.swings.jumps or case.swings.lands) and tolerance > LET_GO)
    return Stepped("radau5", tolerance, errors, Cost(n, attempts(case, at), spent, linear), why, able)


METHODS: dict[str, Method] = {
    "dopri5": dopri5,
    "dop853": dop853,
    "radau5": radau5,
}


def stepped(
    case: Case, at: Fidelity, left: Errors, methods: Sequence[str] = tuple(METHODS), tolerance: float | None = None
) -> list[Stepped]:
    """Each method at its cheapest sufficient tolerance, or at this one, the cheapest first; what cannot keep to `left`
    comes last."""
    tried = TOLERANCES if tolerance is None else (tolerance,)
    found = [_cheapest(METHODS[name], case, at, left, tried) for name in methods]
    return sorted(found, key=lambda s: (not s.within(left), not s.allowed, s.cost.product))


def _cheapest(method: Method, case: Case, at: Fidelity, left: Errors, tolerances: Sequence[float]) -> Stepped:
    tried = [method(case, at, tolerance) for tolerance in tolerances]
    least = min(s.worst(left) for s in tried)
    finest = [s for s in tried if s.worst(left) <= least]  # the loosest first; where none is predicted, a usual one
    fallback = finest[0] if isfinite(least) else tried[len(tried) // 2]
    otherwise = next((s for s in tried if s.exact(left)), fallback)  # of a method that the scene names all the same
    return min((s for s in tried if s.within(left)), key=lambda s: s.cost.product, default=otherwise)


def _cost(case: Case, at: Fidelity, evaluations: float, linear: float = 0.0) -> Cost:
    """Of a run from what a second of it costs."""
    lasts = duration(case)
    return Cost(states(case, at), attempts(case, at), evaluations * lasts, linear * lasts)


def _damping(case: Case) -> float:
    """Of a load on its hook, part of the critical."""
    return min(h.rubs / sqrt(h.soft_rope * h.load) / 2.0 for h in case.hooks)


def _bare(case: Case) -> bool:
    """Whether what rings on its ropes goes on ringing."""
    return _damping(case) < DAMPED / 3.0


def _errors(case: Case, at: Fidelity, tolerance: float, often: float, rattle: float = 0.0) -> Errors:
    """`often`: steps per second; `rattle`: of a hook in stiff modes [m]."""
    bends = at.girder == "elastic"
    root = sqrt(tolerance)
    smooth = max(SMOOTH * root, tolerance)
    away = smooth * max(1.0, BOTH_SIDES * case.swings.most / case.way)
    errors: dict[Asked, float] = {"swing": smooth, "position": away, "lift-off time": EVENT * root}
    if at.ropes == "rigid":
        errors["rope tension"] = RIGID * root
        return errors
    turned = [h.omega(bends) / often for h in case.hooks]
    missed = (overshoot(case, h, bends) * min(1.0, x * x / 12.0) for h, x in zip(case.hooks, turned, strict=True))
    stretch = min(h.stretch(case.gravity, bends) for h in case.hooks)
    lumps = at.lumps if at.ropes == "massive" else 1
    snaps = SNAPS * lumps * lumps * lumps * lumps if lumps > 1 else 1.0
    rattle *= max(snaps, 1.0 / (_damping(case) / DAMPED + 1.0 / RATTLES[lumps > 2]))
    errors["rope tension"] = max(missed) + rattle / stretch
    return errors
