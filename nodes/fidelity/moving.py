"""What the action list does: how far moves go that name a place, which may lift the block, how long all of them last.

Both need where everything stands as each action begins, which the static following knows; behind what it cannot follow,
a move to a place has no known way, and any hoist may be the one that lifts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import msgspec
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan.actions import Action, Condition, Lifted, Move, Turn, Wait
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.pulses import times

from .following import Following, State
from .lifts import drive_name, lift_of


@dataclass(frozen=True)
class Parting:
    """Hoisting during which the block may part from its stools, and the state in which it begins, if that is known."""

    action: int
    moves: tuple[Move, ...]
    before: State | None


def by_ways(plan: Plan, followed: Following) -> Plan:
    """The plan with its moves to a place as moves by a way, as far as it can be followed; actions that begin after the
    end of the scene are left out."""
    known, later = plan.actions[: len(followed.acted)], plan.actions[len(followed.acted) :]
    actions = tuple(_by_way(action, at.before, plan) for action, at in zip(known, followed.acted, strict=True))
    return msgspec.structs.replace(plan, actions=actions if followed.known else actions + later)


def lifting(plan: Plan, followed: Following, stretch: float) -> list[Parting]:
    """All hoisting during which the block may part from its stools; `stretch`: of what it hangs from [m].

    It hangs for sure once it was seen to be lifted, or was hoisted by more than the stretch; a move behind which no
    sling is taut does not lift it.
    """
    found, hangs, stood = list[Parting](), False, followed.steps[0].state.at[2]
    for i, action in enumerate(plan.actions):
        here = followed.acted[i] if i < len(followed.acted) else None
        if here is None or here.before.grounded:
            hangs = False
            stood = here.before.at[2] if here else stood
        elif here.before.at[2] - stood > stretch:
            hangs = True
        hangs = hangs or _awaits_lifting(action.when)
        hoists = tuple(m for m in action.orders if isinstance(m, Move) and m.verb == "hoist")
        if hoists and not hangs and (here is None or here.taut):
            found.append(Parting(i, hoists, here.before if here else None))
        hangs = hangs or any(_awaits_lifting(m.until) for m in hoists)
    return found


def tilted(followed: Following, ropes: Sequence[str]) -> float:
    """How far winches of hooks that hold the block wind against each other while it hangs [m]."""
    most, begin = 0.0, None
    for state in followed.path.states:
        begin = None if state.grounded else begin or state
        if begin is not None:
            wound = [state.references[rope] - begin.references[rope] for rope in ropes]
            most = max(most, max(wound) - min(wound))
    return most


def _place(state: State, crane: str, trolley: str) -> tuple[float, float]:
    """Of a trolley, along the rails and across [m]."""
    return state.cranes[crane], state.trolleys[crane, trolley]


def _awaits_lifting(condition: Condition | None) -> bool:
    return any(isinstance(term, Lifted) for term in terms(condition))


def _by_way(action: Action, before: State, plan: Plan) -> Action:
    starts = before.ropes | {drive_name(crane, "gantry"): x for crane, x in before.cranes.items()}
    for crane in lift_of(plan).cranes:
        for trolley in (crane.upper, crane.lower):
            starts[drive_name(crane.name, trolley.name)] = before.trolleys[crane.name, trolley.name]
    orders = tuple(
        msgspec.structs.replace(m, to=None, by=m.to - starts[m.actuator])
        if isinstance(m, Move) and m.to is not None and m.actuator in starts
        else m
        for m in action.orders
    )
    return msgspec.structs.replace(action, orders=orders)


def lasts(action: Action) -> float:
    """Duration of an action, about [s]."""
    message = [_duration(order) for order in action.orders if isinstance(order, Move)]
    return max([*message, *(order.seconds for order in action.orders if isinstance(order, Wait))], default=0.0)


def turning(plan: Plan) -> float:
    """Of all turns of the block, about [s]."""
    message = [order for action in plan.actions for order in action.orders if isinstance(order, Turn)]
    angles = [plan.start, *(turn.to for turn in message)]
    return sum(abs(turn.to - before) / turn.rate for before, turn in zip(angles, message, strict=False))


def _duration(m: Move) -> float:
    """Of a move whose way is known; of another its ramps [s]."""
    ramping, cruising = profile(m)
    return 2.0 * ramping + cruising


def profile(m: Move) -> tuple[float, float]:
    """Durations of a ramp and of the cruise between two [s]; no cruise where the way is not known."""
    if not m.accel or not m.speed or m.by == 0.0:
        return 0.0, 0.0
    if m.pulses:  # ramps in two pulses count as even ones, which leave some swing
        way = None if m.by is None else abs(m.by)
        _, first, cruising, second = times(m.pulses, way, abs(m.speed), m.accel, m.periods)
        return 0.5 * (first + second), cruising
    if m.by is None:
        return abs(m.speed) / m.accel, 0.0
    speed = min(abs(m.speed), sqrt(m.accel * abs(m.by)))
    return (speed / m.accel, abs(m.by) / speed - speed / m.accel) if speed else (0.0, 0.0)
