"""Impossible orders: no such actor, a locked joint, a sling that is hooked already, a grounded block dragged along.

Each is refused with a sentence.  One of the action list ends the run, with its line of the scene, path and time in
front; one of an operator is answered so.
"""

from __future__ import annotations

from collections.abc import Container, Mapping

from heavylift.nodes.plan.actions import Brake, Hookup, Move, Order, Stop, Turn, Unhook
from heavylift.nodes.plan.fidelity import held_by
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.verbs import VERBS

from .observed_state import OFF, Picture
from .refused import Refused
from .turn_law import followers


def check(order: Order, plan: Plan, owners: Mapping[str, str], picture: Picture, lugs: Mapping[str, str]) -> None:
    """Raise Refused for an order that contradicts the plan or what is known; `lugs` = lug of each hooked sling."""
    for joint in joints_moved(order, plan, lugs):
        if joint in plan.fidelity.locked:
            raise Refused(held_by(plan.fidelity, joint))
    match order:
        case Move():
            if owners.get(order.actuator) != order.model:
                raise Refused(f"{order.model} has no hook or drive {order.actuator}")
            if VERBS[order.verb].along:
                _check_ground(order, plan, picture)
        case Hookup() | Unhook():
            _check_sling(order, plan, picture, lugs)
        case Brake():
            if owners.get(order.brake) != order.model:
                raise Refused(f"{order.model} has no brake {order.brake}")
        case Stop():
            if owners.get(order.actuator) != order.model:
                raise Refused(f"{order.model} has no hook or drive {order.actuator}")


def check_led(order: Order, plan: Plan, lugs: Mapping[str, str]) -> None:
    """Raise Refused for an order to an actuator that a model leads."""
    match order:
        case Move():
            asked = [order.actuator]
        case Turn() if plan.models:
            asked = [f.actuator for f in followers(plan, lugs)]
        case _:
            asked = []
    for actuator in asked:
        if who := plan.leader(actuator):
            raise Refused(f"{actuator} is led by the model {who} and takes no other orders")


def joints_moved(order: Order, plan: Plan, lugs: Mapping[str, str]) -> list[str]:
    """Joints that an order moves by their drives; raises Refused for a turn that no hook can follow."""
    match order:
        case Move() if VERBS[order.verb].along:
            return [order.actuator.removesuffix(".drive")]
        case Turn():
            return [f.actuator.removesuffix(".drive") for f in followers(plan, lugs)]
    return []


def _check_ground(order: Move, plan: Plan, picture: Picture) -> None:
    """A crane does not travel while the block stands on its supports and hangs on it."""
    if plan.block is None or not picture.on_ground(plan.block.name):
        return
    loaders = {rope.carries for rope in plan.rig.hook_ropes if rope.crane == order.model}
    for sling in plan.rig.slings:
        if sling.loader in loaders and picture.ropes[sling.name] == "taut":
            raise Refused(
                f"{order.model} cannot {order.verb} while {plan.block.name} stands on its supports and "
                f"{sling.name} is taut, wait until it is lifted or slacken the slings"
            )


def _check_sling(order: Hookup | Unhook, plan: Plan, picture: Picture, lugs: Mapping[str, str]) -> None:
    """A sling that exists is hooked once, to a lug that exists, and unhooked where it hangs."""
    if isinstance(order, Hookup) and order.sling not in picture.ropes:
        raise Refused(f"there is no sling {order.sling}")
    hooked = {name for name, state in picture.ropes.items() if state != OFF}
    if fault := sling_fault(order, hooked, lugs, picture.parted):
        raise Refused(fault)
    known = [lug.name for lug in plan.block.lugs] if plan.block else []
    if isinstance(order, Hookup) and order.lug and order.lug not in known:
        raise Refused(f"there is no lug {order.lug}")


def sling_fault(order: Order, hooked: Container[str], lugs: Mapping[str, str], parted: Container[str]) -> str:
    """Why a sling cannot be hooked, since it hangs already or has parted, or unhooked, since it does not hang; "" if it
    can be."""
    match order:
        case Hookup() if order.sling in parted:
            return f"{order.sling} has parted and cannot be hooked again"
        case Hookup() if order.sling in hooked:
            on = f"lug {lugs[order.sling]}" if lugs.get(order.sling) else "its place"
            return f"sling {order.sling} hangs on {on} already, unhook it first"
        case Unhook() if order.sling not in hooked:
            return f"sling {order.sling} is not hooked and cannot be unhooked"
    return ""
