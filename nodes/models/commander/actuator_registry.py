"""Registry of actuators: the machine that owns each actuator, sling and brake, and their states at the start.

The commander uses it to address its orders and to know the first state; both follow from the plan alone.
"""

from collections.abc import Sequence

from heavylift.nodes.plan.actions import Hookup, Turn
from heavylift.nodes.plan.interlock import Interlock
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from .conditions import OFF, ObservedState

TURN = "turn"  # the Master of a turn-over, and the commander's own actor that moves it


def machines(plan: Plan) -> list[str]:
    """Return the names of all machines, in the order of the plan."""
    return [machine.name for machine in plan.machines]


def turns(plan: Plan) -> bool:
    """Return whether the action list turns the block."""
    return any(isinstance(order, Turn) for action in plan.actions for order in action.orders)


def turn_of(plan: Plan) -> str:
    """Return the name of the virtual master drive that actuators follow when the block turns."""
    return f"{plan.lists[0].name}-{TURN}" if plan.lists else TURN


def hooked_later(plan: Plan) -> list[str]:
    """Return the slings that orders in the action list hook, sorted by name."""
    orders = [order for action in plan.actions for order in action.orders]
    return sorted({order.sling for order in orders if isinstance(order, Hookup)})


def owners(machines: Sequence[Mechanism], interlocks: Sequence[Interlock] = ()) -> dict[str, str]:
    """Return the name of the machine that owns each actuator, rope, brake and interlock that orders can name."""
    found = dict[str, str]()
    for machine in machines:
        system = machine.system
        for group in (system.drives, system.all_ropes, system.brakes, system.locks, system.masters):
            found |= dict.fromkeys((x.name for x in group), machine.name)
    return found | {interlock.name: interlock.machine for interlock in interlocks}


def first_state(machines: Sequence[Mechanism]) -> ObservedState:
    """Return the state of ropes, supports and brakes that the commander knows at the start."""
    observed = ObservedState()
    for machine in machines:
        for rope in machine.system.all_ropes:
            state = "taut" if rope.name in machine.taut else "slack"
            observed.ropes[rope.name] = state if rope.hooked else OFF
        bodies: dict[str, dict[str, list[bool]]] = {}
        faces = {name: face for cargo in machine.cargo for name, face in cargo.faces.items()}
        touching = [(s.name, s.point.body) for s in machine.system.supports]
        touching += [(c.name, c.a.body) for c in machine.system.contacts]
        for name, body in touching:
            closed = bodies.setdefault(machine.standing(body), {}).setdefault(faces.get(name, body), [])
            closed.append(name in machine.closed)
        observed.bodies[machine.name] = tuple(bodies)
        observed.grounded |= {body for body, of in bodies.items() if any(any(closed) for closed in of.values())}
        observed.landed |= {body for body, of in bodies.items() if any(all(closed) for closed in of.values())}
    return observed


def first_lugs(machines: Sequence[Mechanism]) -> dict[str, str]:
    """Return the lug of each sling that is hooked at the start, by sling."""
    return {tie.rope: tie.lug for machine in machines for tie in machine.ties if tie.lug}
