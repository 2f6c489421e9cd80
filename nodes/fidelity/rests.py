"""How the rest of a load moves along the static path of the action list: what makes it swing, and what makes it bounce.

Between two states of an action the block goes with the moves of the action, in their ramps.  It jumps as it parts from
its stools, from where it stood beside its hooks to below them, and as a hook is taken from it or given to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import msgspec
from heavylift.kernel.algebra.dense import least_norm
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan.actions import Action, After, Hookup, Move, MovesDone, Turn, Unhook
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.statics.state import StaticState

from .following import Following, loads_of
from .lifts import lift_of
from .moving import profile
from .response import Knot, moved, together

Step = tuple[StaticState, StaticState, float]  # two states and the way of the block's rest between them [m]

ABRUPT = 1e-3  # [s] what takes less time is a jump
ASIDE, STRAIGHT = 0.005, 0.02  # [m] way, and jump, that count as none: ropes that stretch differently lean a block so
CLOSE = 0.01  # of the longest way that the load goes: a jump that does not count, if that is less
SLACK = 1.0  # [kg] on a loader that counts as none
AXES = ("x", "y")
ALIKE = 0.01  # parts of ways, so little apart, of moves that are not told from each other


def begins(followed: Following) -> tuple[float, ...]:
    """When stages begin, and the end, at rest [s]."""
    return (*(states[0].t for number, states in _by_action(followed) if number), followed.path.states[-1].t)


def changes(plan: Plan, followed: Following) -> bool:
    """Whether slings are hooked or unhooked while the block hangs."""
    return any(not before.grounded and given for given, before in _given(plan, followed))


def flies_up(plan: Plan, followed: Following) -> bool:
    """Whether slings are unhooked that carry more than all that is left on their rope."""
    weighs = {x.name: x.upper.mass + x.lower.mass for x in lift_of(plan).loaders}
    return any(load > weighs[name] for name, load in _let_go(plan, followed))


def recoils(plan: Plan, followed: Following) -> bool:
    """Whether slings are unhooked that carry something while the block hangs: slack ones set nothing ringing."""
    return any(load > SLACK for _, load in _let_go(plan, followed))


def _let_go(plan: Plan, followed: Following) -> Iterator[tuple[str, float]]:
    """Loaders from which slings are unhooked while the block hangs, and what they carry before [kg]."""
    of = {s.name: s.loader for s in lift_of(plan).rig.slings}
    for given, before in _given(plan, followed):
        let_go = {of[order.sling] for order in given if isinstance(order, Unhook)}
        if let_go and not before.grounded:
            loads = loads_of(plan, before)
            yield from ((name, loads[name]) for name in sorted(let_go))


def _given(plan: Plan, followed: Following) -> Iterator[tuple[list[Hookup | Unhook], StaticState]]:
    """Of each action what it hooks and unhooks, and the state before it."""
    for action, acted in zip(plan.actions, followed.path.acted, strict=False):
        yield [order for order in action.orders if isinstance(order, Hookup | Unhook)], acted.before


def swinging(plan: Plan, followed: Following, axis: int, way: float) -> tuple[Knot, ...]:
    """Knots of the block's rest along the rails (0) or across (1); `way`: the longest that it goes [m]."""
    assert lift_of(plan).block is not None
    knots, name = list[Knot](), lift_of(plan).block.name
    stood = followed.path.states[0].poses[name][0][axis]
    for number, states in _by_action(followed):
        steps: list[Step] = []
        for a, b in pairwise(states):
            here = b.poses[name][0][axis]
            if b.grounded:
                knots += [Knot(b.t, stands=True)] if not a.grounded else []
                stood = stood if a.grounded else here
                continue
            step = here - (stood if a.grounded else a.poses[name][0][axis])
            if a.grounded or b.t - a.t < ABRUPT:
                knots += [Knot(b.t, jump=step)] if abs(step) > min(STRAIGHT, CLOSE * way) else []
            else:
                steps.append((a, b, step))
        if max((abs(way) for way in accumulate(step for *_, step in steps)), default=0.0) > ASIDE:
            knots += _ways(plan.actions[number - 1], states, steps, AXES[axis])
    return together(knots)


def bouncing(plan: Plan, followed: Following, rope: str, soft: float) -> tuple[Knot, ...]:
    """Knots of the rest of what hangs from a rope, up and down, once it hangs; `soft`: of all that it hangs from."""
    knots = list[Knot]()
    for number, states in _by_action(followed):
        for a, b in pairwise(states):
            if b.grounded and not a.grounded:
                knots.append(Knot(b.t, stands=True))
            if not (a.grounded or b.grounded) and b.t - a.t < ABRUPT:
                knots.append(Knot(b.t, jump=soft * (b.tensions[rope] - a.tensions[rope])))
        if number and not states[0].grounded:
            for m in plan.actions[number - 1].orders:
                if isinstance(m, Move) and m.actuator == rope:
                    way = states[-1].references[rope] - states[0].references[rope]
                    knots += moved(states[0].t, -way, *_profile(m, states))
    return together(knots)


def awaiting(plan: Plan, followed: Following) -> Iterator[float]:
    """Times from which something of the load is awaited while it hangs [s]."""
    for action, acted, begin in zip(plan.actions, followed.path.acted, begins(followed), strict=False):
        conditions = [action.when, *(m.until for m in action.orders if isinstance(m, Move))]
        seen = [t for c in conditions for t in terms(c) if not isinstance(t, MovesDone | After)]
        if seen and not acted.before.grounded:
            yield begin


def _by_action(followed: Following) -> Iterator[tuple[int, list[StaticState]]]:
    """States of each action, the one that it began in first: at its begin, though it was reached before a wait."""
    states = followed.path.states
    yield 0, [s for s in states if s.action == 0]
    for number, acted in enumerate(followed.path.acted, 1):
        mine = [s for s in states if s.action == number]
        yield number, [replace(acted.before, t=mine[0].t) if mine else acted.before, *mine]


def _ways(action: Action, states: Sequence[StaticState], steps: Sequence[Step], axis: str) -> Iterator[Knot]:
    """The moves along an axis share a way by what they go; where none does, all that hoist make it, those that are over
    at one time together: of hooks at different speeds the block leans out and comes back."""
    way = sum(step for *_, step in steps)
    turn = next((order for order in action.orders if isinstance(order, Turn)), None)
    if turn is not None:
        ramping = turn.rate / turn.accel
        lasts = states[-1].t - states[0].t
        yield from moved(states[0].t, way, min(ramping, lasts / 2.0), max(0.0, lasts - 2.0 * ramping))
        return
    moves = [m for m in action.orders if isinstance(m, Move)]
    along = [m for m in moves if VERBS[m.verb].along == axis]
    ways = {m.actuator: states[-1].references[m.actuator] - states[0].references[m.actuator] for m in along or moves}
    total = sum(map(abs, ways.values()))
    if total <= 0.0:
        yield Knot(states[0].t, jump=way)
        return
    alike = {tuple(round(x, 3) for x in _profile(m, states)): m for m in moves if ways.get(m.actuator)}
    if along or len(alike) == 1:
        for m in along or moves:
            yield from moved(states[0].t, way * abs(ways[m.actuator]) / total, *_profile(m, states))
        return
    ropes = [m.actuator for m in alike.values()]
    gone = [[(b.references[r] - a.references[r]) / ways[r] for r in ropes] for a, b, _ in steps]
    shares = least_norm(gone, [step for *_, step in steps], ALIKE)
    for m, share in zip(alike.values(), shares, strict=True):
        yield from moved(states[0].t, share, *_profile(m, states))


def _profile(m: Move, states: Sequence[StaticState]) -> tuple[float, float]:
    """Durations of a ramp and of the cruise between two, of the way that it went [s]."""
    way = states[-1].references[m.actuator] - states[0].references[m.actuator]
    return profile(msgspec.structs.replace(m, by=way, to=None))
