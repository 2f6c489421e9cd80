"""What the action list does to a lift: how far moves go that name a place, and which of them may lift the block.

Both need where everything stands as each action begins, which the static following knows; behind what it cannot follow,
a move to a place has no known way, and any hoist may be the one that lifts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from heavylift.nodes.models.conditions import terms
from heavylift.nodes.scene.actions import Action, Condition, Lifted, Move
from heavylift.nodes.scene.plan import Plan, drive_name

if TYPE_CHECKING:
    from heavylift.nodes.scene.follow import Following
    from heavylift.nodes.scene.standing import State

__all__ = ["by_ways", "lifting"]


def by_ways(plan: Plan, followed: Following) -> Plan:
    """The plan with its moves to a place as moves by a way, as far as it can be followed."""
    known, later = plan.actions[: len(followed.acted)], plan.actions[len(followed.acted) :]
    actions = tuple(_by_way(action, at.before, plan) for action, at in zip(known, followed.acted, strict=True))
    return msgspec.structs.replace(plan, actions=actions + later)


def lifting(plan: Plan, followed: Following, stretch: float) -> list[Move]:
    """All hoisting during which the block may part from its stools; `stretch`: of what it hangs from [m].

    It hangs for sure once it was seen to be lifted, or was hoisted by more than the stretch; a move behind which no
    sling is taut does not lift it.
    """
    found, hangs, stood = list[Move](), False, followed.steps[0].state.at[2]
    for i, action in enumerate(plan.actions):
        here = followed.acted[i] if i < len(followed.acted) else None
        if here is None or here.before.grounded:
            hangs = False
            stood = here.before.at[2] if here else stood
        elif here.before.at[2] - stood > stretch:
            hangs = True
        hangs = hangs or _awaits_lifting(action.when)
        hoists = [m for m in action.orders if isinstance(m, Move) and m.verb == "hoist"]
        if not hangs and (here is None or here.taut):
            found += hoists
        hangs = hangs or any(_awaits_lifting(m.until) for m in hoists)
    return found


def _awaits_lifting(condition: Condition | None) -> bool:
    return any(isinstance(term, Lifted) for term in terms(condition))


def _by_way(action: Action, before: State, plan: Plan) -> Action:
    starts = before.ropes | {drive_name(crane, "gantry"): x for crane, x in before.cranes.items()}
    for crane in plan.cranes:
        for trolley in (crane.upper, crane.lower):
            starts[drive_name(crane.name, trolley.name)] = before.trolleys[crane.name, trolley.name]
    orders = tuple(
        msgspec.structs.replace(m, to=None, by=m.to - starts[m.actuator])
        if isinstance(m, Move) and m.to is not None and m.actuator in starts
        else m
        for m in action.orders
    )
    return msgspec.structs.replace(action, orders=orders)
