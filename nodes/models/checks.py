"""Orders that cannot be: no such actor, a sling that hangs already, a grounded block dragged along.

Each ends the run with a sentence that begins with the line of the scene; the simulator puts path and time
in front.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn

from heavylift.kernel.errors import ModelError
from heavylift.nodes.scene.actions import Brake, Hookup, Move, Order, Unhook
from heavylift.nodes.scene.plan import Plan

from .picture import OFF, Picture


def check(order: Order, plan: Plan, owners: Mapping[str, str], picture: Picture, lugs: Mapping[str, str]) -> None:
    """Refuse an order that contradicts the plan or what is known; `lugs` = lug of each hooked sling."""
    match order:
        case Move():
            if owners.get(order.actuator) != order.model:
                _refuse(order, f"{order.model} has no hook or drive {order.actuator}")
            if order.verb in ("travel", "traverse"):
                _check_ground(order, plan, picture)
        case Hookup():
            _check_hookup(order, plan, picture, lugs)
        case Unhook():
            if picture.ropes.get(order.sling, OFF) == OFF:
                _refuse(order, f"sling {order.sling} is not hooked and cannot be unhooked")
        case Brake():
            if owners.get(order.brake) != order.model:
                _refuse(order, f"{order.model} has no brake {order.brake}")


def _check_ground(order: Move, plan: Plan, picture: Picture) -> None:
    """A crane does not travel while the block stands on its supports and hangs on it."""
    if plan.block is None or not picture.on_ground(plan.block.name):
        return
    loaders = {rope.carries for rope in plan.rig.hook_ropes if rope.crane == order.model}
    for sling in plan.rig.slings:
        if sling.loader in loaders and picture.ropes[sling.name] == "taut":
            _refuse(
                order,
                f"{order.model} cannot {order.verb} while {plan.block.name} stands on its supports and "
                f"{sling.name} is taut, wait until it is lifted or slacken the slings",
            )


def _check_hookup(order: Hookup, plan: Plan, picture: Picture, lugs: Mapping[str, str]) -> None:
    """A sling is hooked once, to a lug that exists."""
    state = picture.ropes.get(order.sling)
    if state is None:
        _refuse(order, f"there is no sling {order.sling}")
    if state != OFF:
        on = f"lug {lugs[order.sling]}" if order.sling in lugs else "its place"
        _refuse(order, f"sling {order.sling} hangs on {on} already, unhook it first")
    if order.lug and (plan.block is None or order.lug not in [lug.name for lug in plan.block.lugs]):
        _refuse(order, f"there is no lug {order.lug}")


def _refuse(order: Order, text: str) -> NoReturn:
    raise ModelError(f"{order.where}: {text}")
