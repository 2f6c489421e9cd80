"""Sharing of a load that is statically indeterminate, speeds at lift-off and landing, and the factors of standards.

A block on more than three hooks or slings distributes its weight according to their stiffness: a millimetre of length
matters. The printed shares hold for the given lengths.
"""

from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan.actions import LANDS, CrossingCondition, LandedCondition, LiftedCondition, Move
from heavylift.nodes.plan.connections import ties_on
from heavylift.nodes.plan.plan import Plan

from .standards import HOISTING, SHARING, daf, hoisting_factor

DETERMINATE = 3  # hangers of a rigid body whose shares follow from equilibrium alone


def indeterminate(plan: Plan) -> int:
    """Return the number of hooks on a block if their shares of the load are statically indeterminate, else 0."""
    most = 0
    for cargo in (cargo for machine in plan.machines for cargo in machine.cargo):
        hooks = (hook for machine in plan.machines for hook in machine.hooks)
        holds = (any(tie.lug in cargo.lugs for tie in ties_on(plan.machines, hook)) for hook in hooks)
        most = max(most, sum(holds))
    return most if most > DETERMINATE else 0


def shared(plan: Plan) -> list[str]:
    """Return sentences about indeterminate load sharing and the factors that standards give for it."""
    many = indeterminate(plan)
    if not many:
        return []
    message = f"{many} hooks carry the block: their shares are statically indeterminate"
    message += ", computed from the given lengths and stiffness"
    required = "; ".join(f"{s.when}: {s.message} ({s.source})" for s in SHARING.values())
    return [message, f"factors of standards for parts that should carry equal loads: {required}"]


def dynamics_required(plan: Plan) -> tuple[float, str] | None:
    """Return the required dynamic amplification factor and its source; None without a block or without a stated place,
    such as offshore."""
    masses = [cargo.mass for machine in plan.machines for cargo in machine.cargo]
    return daf(plan.place, max(masses)) if masses else None


def touching(plan: Plan, quantity: str, block: str = "") -> list[tuple[int, float]]:
    """Return the number (from 1) and the speed [m/s] of each action that lifts a block off or sets it down.

    `block`: name of the block, or "" for all blocks."""
    lifts, found = quantity == "lift-off speed", list[tuple[int, float]]()
    of = [(m.name, cargo.body) for m in plan.machines for cargo in m.cargo if cargo.body == block or not block]
    models = {name for names in of for name in names}
    for number, action in enumerate(plan.actions, 1):
        for x in (x for x in action.orders if isinstance(x, Move) and x.verb in ("hoist", "lower")):
            for y in terms(x.until):
                on = isinstance(y, CrossingCondition) and y.threshold.quantity == "gap" and y.value == LANDS
                stands = isinstance(y, LiftedCondition if lifts else LandedCondition)
                if ((on and not lifts) or stands) and getattr(y, "model", "") in models:
                    found.append((number, abs(x.speed)))
    return found


def hoisting_factors(plan: Plan) -> list[str]:
    """Return, as text, the factors phi_2 of EN 13001-2 for all hoisting classes at the highest lift-off speed."""
    speeds = [speed for _, speed in touching(plan, "lift-off speed")]
    if not speeds:
        return []
    each = ", ".join(f"{name} {hoisting_factor(max(speeds), name):.3f}" for name in HOISTING)
    return [f"EN 13001-2, 4.2.2.2, lifts off at {max(speeds) * 60:g} m/min: phi_2 = {each}"]
