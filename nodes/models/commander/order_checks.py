"""Checks for orders that cannot be carried out: unknown actor, locked joint, sling already hooked, crane that would
drag a block standing on the ground.

Each such order is refused with a message. If the order is in the action list, the run ends, and the message begins with
the line in the scene, the path and the time; for an operator's order the message is the answer.
"""

from collections.abc import Container, Mapping, Sequence

from heavylift.kernel.description.mechanics import Joint
from heavylift.nodes.plan.actions import BrakeOrder, Follow, Hookup, Move, Order, StopOrder, Turn, UnhookSling
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.fidelity import held_by
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.verbs import VERBS

from .actuator_registry import TURN, owners
from .conditions import OFF, ObservedState, OrderRejected
from .turn_law import followers


class Machines:
    """The machines of a plan, indexed for checking orders: owners of actuators, and rigging."""

    __fixed__ = True  # as the plan

    def __init__(self, plan: Plan) -> None:
        self.plan, self.parts = plan, plan.machines
        self.owners = owners(self.parts, plan.interlocks)
        self.lugs = lug_places(self.parts)
        joints = {joint.name: joint for machine in self.parts for joint in machine.system.joints}
        drives = (drive for machine in self.parts for drive in machine.system.drives if drive.joint in joints)
        self.joints = {drive.name: joints[drive.joint] for drive in drives}

    def check(self, order: Order, state: ObservedState, lugs: Mapping[str, str]) -> None:
        """Raise OrderRejected for an order that contradicts the plan or the observed state of the lift.

        `lugs`: the lug of each hooked sling."""
        plan = self.plan
        for joint in self.moved(order, lugs):
            if joint.name in plan.fidelity.locked:
                raise OrderRejected(held_by(plan.fidelity, joint))
        match order:
            case Move() | StopOrder():
                if self.owners.get(order.actuator) != order.model:
                    raise OrderRejected(f"{order.model} has no hook or drive {order.actuator}")
                if isinstance(order, Move) and VERBS[order.verb].along:
                    self._check_ground(order, state, lugs)
            case Hookup() | UnhookSling():
                self._check_sling(order, state, lugs)
            case BrakeOrder():
                if self.owners.get(order.brake) != order.model:
                    raise OrderRejected(f"{order.model} has no brake {order.brake}")

    def check_led(self, order: Order, lugs: Mapping[str, str]) -> None:
        """Raise OrderRejected for an order to an actuator that a user model controls."""
        match order:
            case Move():
                asked = [order.actuator]
            case Turn() if self.plan.models:
                asked = [f.actuator for f in self.followers(order, lugs)]
            case _:
                asked = []
        for actuator in asked:
            if who := self.plan.leader(actuator):
                raise OrderRejected(
                    f"{actuator} is controlled by the model {who} and takes no other orders; leave this order out"
                )

    def followers(self, order: Turn, lugs: Mapping[str, str], master: str = TURN) -> list[Follow]:
        """Return the actuators that must follow a turn of a block, with their reference laws."""
        return followers(self.parts, lugs, order.block, master)

    def moved(self, order: Order, lugs: Mapping[str, str]) -> list[Joint]:
        """Return the joints that an order moves; raises OrderRejected for a turn that no hook can follow."""
        match order:
            case Move() if VERBS[order.verb].along:
                asked = [order.actuator]
            case Turn():
                asked = [f.actuator for f in self.followers(order, lugs)]
            case _:
                asked = []
        return [self.joints[actuator] for actuator in asked if actuator in self.joints]

    def lets_fall(self, orders: Sequence[Order], state: ObservedState, lugs: Mapping[str, str]) -> str:
        """Return a description of the body that these orders would drop by unhooking all its taut slings, or ""."""
        off = {order.sling for order in orders if isinstance(order, UnhookSling) and not order.parted}
        held: dict[str, set[str]] = {}
        for tie in (tie for machine in self.parts for tie in machine.ties if off and state.ropes[tie.rope] == "taut"):
            if end := tie.lower or self.lugs.get(lugs.get(tie.rope, "")):
                held.setdefault(end.body, set()).add(tie.rope)
        stands = {name.rpartition(":")[2] for name in state.grounded}
        cargo = {cargo.body for machine in self.parts for cargo in machine.cargo} - stands
        fall = next((body for body, slings in held.items() if body in cargo and slings <= off), "")
        return (
            f"{fall} hangs only in slings to be unhooked and would fall: land it or slacken them first" if fall else ""
        )

    def _check_ground(self, order: Move, state: ObservedState, lugs: Mapping[str, str]) -> None:
        """Raise OrderRejected if a crane is to travel while its load stands on supports."""
        hooks = [hook for machine in self.parts if machine.name == order.model for hook in machine.hooks]
        for tie in (tie for hook in hooks for tie in ties_on(self.parts, hook)):
            held = tie.lower or self.lugs.get(lugs.get(tie.rope, ""))
            if held and state.ropes[tie.rope] == "taut" and state.on_ground(held.body):
                raise OrderRejected(
                    f"{order.model} cannot {order.verb} while {held.body} stands on its supports and "
                    f"{tie.rope} is taut; wait until it is lifted or slacken the slings"
                )

    def _check_sling(self, order: Hookup | UnhookSling, observed: ObservedState, lugs: Mapping[str, str]) -> None:
        """Raise OrderRejected for an unknown sling or lug, and for a sling that is already, or not yet, hooked as the
        order requires."""
        if isinstance(order, Hookup) and order.sling not in observed.ropes:
            raise OrderRejected(f"there is no sling {order.sling}")
        hooked = {name for name, state in observed.ropes.items() if state != OFF}
        if fault := sling_fault(order, hooked, lugs, observed.parted):
            raise OrderRejected(fault)
        if isinstance(order, Hookup) and order.lug and order.lug not in self.lugs:
            raise OrderRejected(f"there is no lug {order.lug}")


def sling_fault(order: Order, hooked: Container[str], lugs: Mapping[str, str], parted: Container[str]) -> str:
    """Return why a sling cannot be hooked (it is hooked or broken) or unhooked (it is not hooked), or ""."""
    match order:
        case Hookup() if order.sling in parted:
            return f"{order.sling} is broken and cannot be hooked again"
        case Hookup() if order.sling in hooked:
            on = f"lug {lugs[order.sling]}" if lugs.get(order.sling) else "its place"
            return f"sling {order.sling} is already hooked to {on}; unhook it first"
        case UnhookSling() if order.sling not in hooked:
            return f"sling {order.sling} is not hooked and cannot be unhooked"
    return ""
