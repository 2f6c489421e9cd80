"""Where the shares of a lift are statically indeterminate, and what standards take them to be.

A block on more than three hooks or slings of its own shares its weight by their stiffness: a millimetre of length
decides.  The printed shares are those of the lengths as they are written.
"""

from __future__ import annotations

import numpy as np
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan.actions import Action, LandedCondition, LiftedCondition, Move
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.mechanism import ties_on
from heavylift.nodes.plan.plan import Plan

from .signals import Column, SignalColumns
from .standards import HOISTING, SHARING, daf, hoisting_factor

DETERMINATE = 3  # hangers of a rigid body whose shares follow from equilibrium alone


def indeterminate(plan: Plan) -> int:
    """Number of hooks of a block if their shares are statically indeterminate, else 0."""
    most = 0
    for cargo in (cargo for machine in plan.machines for cargo in machine.cargo):
        hooks = (hook for machine in plan.machines for hook in machine.hooks)
        holds = (any(tie.lug in cargo.lugs for tie in ties_on(plan.machines, hook)) for hook in hooks)
        most = max(most, sum(holds))
    return most if most > DETERMINATE else 0


def shared(plan: Plan) -> list[str]:
    """Sentences about load sharing and the factors in standards for it."""
    many = indeterminate(plan)
    if not many:
        return []
    message = f"{many} hooks carry the block: their shares are statically indeterminate"
    message += ", shown as lengths and stiffness make them"
    required = "; ".join(f"{s.when}: {s.message} ({s.source})" for s in SHARING.values())
    return [message, f"standards allow for it where parts should carry alike: {required}"]


def dynamics_required(plan: Plan) -> tuple[float, str] | None:
    """The dynamic amplification that a standard foresees for the block, and its source; None where none is lifted,
    or nobody says where."""
    masses = [cargo.mass for machine in plan.machines for cargo in machine.cargo]
    return daf(plan.place, max(masses)) if masses else None


def touching(plan: Plan, kind: type[LiftedCondition] | type[LandedCondition]) -> list[tuple[Action, float]]:
    """Actions that hoist until a block is lifted, or lower until it has landed, with their speeds [m/s]."""
    moves = ((action, x) for action in plan.actions for x in action.orders if isinstance(x, Move))
    winding = ((action, x) for action, x in moves if x.verb in ("hoist", "lower"))
    return [(action, abs(x.speed)) for action, x in winding if any(isinstance(y, kind) for y in terms(x.until))]


def touch_speed(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column:
    """The fastest ordered hook speed (n,) [m/s] in stages with lift-off or landing."""
    values = np.full(len(signals.t), np.nan)
    for action, speed in touching(plan, LiftedCondition if limit.quantity == "lift-off speed" else LandedCondition):
        here = signals.within(action.stage)
        values[here] = np.where(values[here] > speed, values[here], speed)
    return values


def hoisting_factors(plan: Plan) -> list[str]:
    """The factors that EN 13001-2 foresees at the fastest hook speed at which a load is taken up, in each class."""
    speeds = [speed for _, speed in touching(plan, LiftedCondition)]
    if not speeds:
        return []
    each = ", ".join(f"{name} {hoisting_factor(max(speeds), name):.3f}" for name in HOISTING)
    return [f"EN 13001-2, 4.2.2.2, lifts off at {max(speeds) * 60:g} m/min: phi_2 = {each}"]
