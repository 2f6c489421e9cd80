"""Registry of actuators: which machine owns which actuator, sling and brake, and the state at the start.

The commander addresses orders with it and starts from its state; both follow from the plan alone.
"""

from __future__ import annotations

from heavylift.nodes.plan.actions import Hookup, Turn
from heavylift.nodes.plan.plan import Plan, drive_name

from .observed_state import OFF, Picture

TURN = "turn"  # the Master of a turn-over, and the commander's own actor that moves it


def machines(plan: Plan) -> list[str]:
    """Names of all machines, in the order of the plan."""
    return [machine.name for machine in plan.machines]


def turns(plan: Plan) -> bool:
    """Whether the action list turns the block."""
    return any(isinstance(order, Turn) for action in plan.actions for order in action.orders)


def turn_of(plan: Plan) -> str:
    """The Master of the turns of a plan, which has the name of its lift where there are several."""
    return f"{plan.lists[0].name}-{TURN}" if plan.lists else TURN


def hooked_later(plan: Plan) -> list[str]:
    """Ropes that the action list hooks."""
    orders = [order for action in plan.actions for order in action.orders]
    return sorted({order.sling for order in orders if isinstance(order, Hookup)})


def owners(plan: Plan) -> dict[str, str]:
    """The machine of each actuator, rope, brake and interlock that orders can name."""
    found = {rope.name: rope.crane for rope in plan.rig.hook_ropes}
    found |= {sling.name: sling.loader for sling in plan.rig.slings}
    for crane in plan.cranes:
        found |= {drive_name(crane.name, axis): crane.name for axis in ("gantry", "upper", "lower")}
    for loader in plan.loaders:
        found[f"{loader.name}.hinge.lock"] = loader.name
    for mechanism in plan.mechanisms:
        system = mechanism.system
        names = [d.name for d in system.drives] + [r.name for r in system.all_ropes]
        names += [b.name for b in system.brakes] + [x.name for x in system.locks]
        names += [m.name for m in system.masters]
        found |= dict.fromkeys(names, mechanism.name)
    return found | {interlock.name: interlock.machine for interlock in plan.interlocks}


def first_picture(plan: Plan) -> Picture:
    """What is known at the start."""
    picture = Picture()
    picture.ropes |= {rope.name: "taut" for rope in plan.rig.hook_ropes}
    picture.ropes |= {s.name: OFF if not s.lug else "taut" if s.taut else "slack" for s in plan.rig.slings}
    for block in plan.all_blocks:
        picture.bodies[block.name] = (block.name,)
        faces: dict[str, list[bool]] = {}
        for pad in block.pads:
            faces.setdefault(pad.face, []).append(pad.closed)
        picture.grounded |= {block.name} if any(pad.closed for pad in block.pads) else set()
        picture.landed |= {block.name} if any(all(closed) for closed in faces.values()) else set()
    for mechanism in plan.mechanisms:
        for rope in mechanism.system.all_ropes:
            state = "taut" if rope.name in mechanism.taut else "slack"
            picture.ropes[rope.name] = state if rope.hooked else OFF
        bodies: dict[str, list[bool]] = {}
        for support in mechanism.system.supports:
            bodies.setdefault(mechanism.standing(support.point.body), []).append(support.name in mechanism.closed)
        for contact in mechanism.system.contacts:
            bodies.setdefault(mechanism.standing(contact.a.body), []).append(contact.name in mechanism.closed)
        picture.bodies[mechanism.name] = tuple(bodies)
        picture.grounded |= {body for body, closed in bodies.items() if any(closed)}
        picture.landed |= {body for body, closed in bodies.items() if all(closed)}
    return picture


def first_lugs(plan: Plan) -> dict[str, str]:
    """The lug of each sling that is hooked at the start."""
    return {sling.name: sling.lug for sling in plan.rig.slings if sling.lug}
