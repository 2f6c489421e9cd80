"""Whether the `end` of a scene cuts its action list for certain: the shortest time that the list takes, from below.

Moves by a way and to a goal take their way over their speed, waits their time; what goes on until something holds may
take no time at all, and so may a move to a goal from where nobody knows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heavylift.nodes.scene.actions import After, Move, MovesDone, Turn, Wait

from .findings import Finding

if TYPE_CHECKING:
    from heavylift.nodes.scene.actions import Action
    from heavylift.nodes.scene.plan import Plan

__all__ = ["cut_by_end"]


def cut_by_end(plan: Plan) -> list[Finding]:
    """A red finding at the first action that cannot be done before the scene ends; none where it may be."""
    if plan.end is None or plan.block is None:
        return []
    at, angle, t, begun = _starts(plan), plan.start, 0.0, 0.0
    for number, action in enumerate(plan.actions):
        if number and isinstance(action.when, After):
            t = begun + action.when.seconds
        elif number and not (action.when is None or isinstance(action.when, MovesDone)):
            t = begun  # what it waits for may hold at once
        begun, lasts = t, 0.0
        for order in action.orders:
            lasts = max(lasts, _lasts(order, at, angle))
            angle = order.to if isinstance(order, Turn) else angle
        only_waits = all(isinstance(order, Wait) for order in action.orders)
        if t >= plan.end or (t + lasts > plan.end and not (only_waits and number == len(plan.actions) - 1)):
            return [_finding(plan, action, number, t + (0.0 if only_waits else lasts))]
        t += lasts
    return []


def _finding(plan: Plan, action: Action, number: int, t: float) -> Finding:
    name = f"the stage '{action.stage}'" if action.stage else f"action {number + 1}"
    told = f"the end of the scene at {plan.end:g} s cuts the lift: {name} is done after {t:.0f} s at the earliest"
    return Finding(
        severity="red", kind="cut", subject="run", sentence=told, where=action.where, stage=action.stage,
        value=t, limit=plan.end, unit="s",
    )  # fmt: skip


def _starts(plan: Plan) -> dict[str, float | None]:
    """Where actuators stand at the start; None: nobody knows."""
    found: dict[str, float | None] = {rope.name: rope.L0 for rope in plan.rig.hook_ropes}
    for crane in plan.cranes:
        found[f"{crane.name}.gantry.drive"] = crane.gantry.start
        found[f"{crane.name}.upper-slide.drive"] = crane.upper.axis.start
        found[f"{crane.name}.lower-slide.drive"] = crane.lower.axis.start
    return found


def _lasts(order: object, at: dict[str, float | None], angle: float) -> float:
    """The shortest time of an order [s]; what it moves is then elsewhere."""
    match order:
        case Wait():
            return order.seconds
        case Turn() if order.until is None:
            at.clear()  # trolleys and winches follow
            return abs(order.to - angle) / order.rate
        case Turn():
            at.clear()
        case Move():
            here = at.get(order.actuator)
            way = (
                order.by
                if order.by is not None
                else order.to - here
                if order.to is not None and here is not None
                else 0.0
            )
            known = order.to if order.to is not None else here + way if here is not None else None
            at[order.actuator] = None if order.until is not None or (order.by is None and order.to is None) else known
            return 0.0 if order.until is not None else abs(way) / abs(order.speed)
    return 0.0
