"""Orders to joints that the scene's fidelity holds: found in the plan, before anything runs.

A planar motion locks what would leave its plane, the list `locked` what it names.  A turn orders the trolleys of the
hooks that carry slings then.
"""

from __future__ import annotations

from heavylift.kernel.errors import ModelError
from heavylift.nodes.models.commander.actuator_registry import first_lugs
from heavylift.nodes.models.commander.order_checks import joints_moved
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Hookup, Order, Unhook
from heavylift.nodes.plan.fidelity import held_by

from .findings import Findings

__all__ = ["held_orders"]


def held_orders(built: plan.Plan) -> list[tuple[str, str]]:
    """(where, sentence) of each order that cannot be obeyed; of several to one joint the first."""
    found = Findings()
    lugs = first_lugs(built)
    for action in built.actions:
        for order in action.orders:
            if isinstance(order, Hookup):
                lugs[order.sling] = order.lug
            elif isinstance(order, Unhook):
                lugs.pop(order.sling, None)
            ordered = [joint for joint in _moved(built, order, lugs) if joint in built.fidelity.locked]
            violations = (
                (joint, order.where, f"{held_by(built.fidelity, joint)}, or leave the order out") for joint in ordered
            )
            found.take(f"{order.where} held", violations, where=order.where)
    return found.list()


def _moved(built: plan.Plan, order: Order, lugs: dict[str, str]) -> list[str]:
    """Joints that an order moves; none for a turn that no hook can follow, which is reported when it is given."""
    try:
        return joints_moved(order, built, lugs)
    except ModelError:
        return []
