"""How far a load comes aside although nothing moves it there: it is let go off-lead, or its hooks go their own ways.

A block whose lugs do not hang below their hooks swings as it parts from its stools.  Where one hook is hoisted alone,
the block leans, and its centre of mass moves aside; so it does where trolleys or cranes that carry it move apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.plan import HookRope, Plan, drive_name
from heavylift.nodes.statics.static_state import State

from .hooks import Hook
from .moving import Parting

__all__ = ["aside"]

STRAIGHT = 0.02  # [m] aside that counts as none: ropes that stretch differently lean the block that much, see `hooks`
Aside = tuple[float, float]  # along the rails, across them [m]


def aside(plan: Plan, hooks: Sequence[Hook], partings: Sequence[Parting]) -> Aside:
    """Largest of all causes, added up."""
    off = [_unbalanced(hooks), *(_off_lead(plan, hooks, x.before) for x in partings if x.before)]
    apart, tilted = _apart(plan, hooks), _tilted(plan, hooks, partings)
    ways = [max(x[i] for x in off) + apart[i] + tilted[i] for i in (0, 1)]
    along, across = (way if way > STRAIGHT else 0.0 for way in ways)
    return along, across


def _off_lead(plan: Plan, hooks: Sequence[Hook], state: State) -> Aside:
    """How far lugs stand beside the hooks that will lift them."""
    assert plan.block is not None
    places = {lug.name: lug.p for lug in plan.block.lugs}
    loaders = {s.name: s.loader for s in plan.rig.slings}
    along, across = 0.0, 0.0
    for rope in _carrying(plan, hooks):
        lugs = [places[lug] for sling, lug in state.lugs.items() if loaders[sling] == rope.carries]
        if not lugs:
            continue
        x, y, z = (sum(p[k] for p in lugs) / len(lugs) for k in range(3))
        crane = next(c for c in plan.cranes if c.name == rope.crane)
        trolley = next(h.trolley for h in crane.hooks if h.rope == rope.name)
        exit_x = sum(line.a.p[0] for line in rope.lines) / len(rope.lines)
        along = max(along, abs(state.at[0] + x - state.cranes[rope.crane] - exit_x))
        lug_y = state.at[1] + y * cos(state.theta) + z * sin(state.theta)
        across = max(across, abs(lug_y - state.trolleys[rope.crane, trolley]))
    return along, across


def _apart(plan: Plan, hooks: Sequence[Hook]) -> Aside:
    """How far gantries, and trolleys, that carry the block ever move apart."""
    carrying = _carrying(plan, hooks)
    gantries = {drive_name(rope.crane, "gantry") for rope in carrying}
    of = {h.rope: drive_name(c.name, h.trolley) for c in plan.cranes for h in c.hooks}
    return _spread(plan, gantries), _spread(plan, {of[rope.name] for rope in carrying})


def _spread(plan: Plan, drives: set[str]) -> float:
    ways, most = dict.fromkeys(sorted(drives), 0.0), 0.0
    for action in plan.actions:
        for m in action.orders:
            if isinstance(m, Move) and m.actuator in ways:
                ways[m.actuator] += m.by or 0.0
        most = max([most, *(abs(a - b) for a, b in combinations(ways.values(), 2))])
    return most


def _tilted(plan: Plan, hooks: Sequence[Hook], partings: Sequence[Parting]) -> Aside:
    """How far the centre of mass moves aside as hooks are hoisted by different ways once the block may hang."""
    lifts = {x.action for x in partings}
    ways, along, across = {h.rope: 0.0 for h in hooks}, 0.0, 0.0
    for i, action in enumerate(plan.actions):
        if i in lifts:
            ways = dict.fromkeys(ways, 0.0)
        for m in action.orders:
            if isinstance(m, Move) and m.actuator in ways:
                ways[m.actuator] += m.by or 0.0
        for a, b in combinations(hooks, 2):
            if (apart := norm([p - q for p, q in zip(a.place, b.place, strict=True)])) > 0.0:
                leans = abs(ways[a.rope] - ways[b.rope]) / apart * (a.reach - a.length) / apart
                along = max(along, leans * abs(a.place[0] - b.place[0]))
                across = max(across, leans * abs(a.place[1] - b.place[1]))
    return along, across


def _unbalanced(hooks: Sequence[Hook]) -> Aside:
    """How far the centre of mass is from where the hooks hold what they share."""
    weight = sum(h.share for h in hooks)
    x, y = (abs(sum(h.share * h.place[k] for h in hooks)) / weight for k in range(2))
    return x, y


def _carrying(plan: Plan, hooks: Sequence[Hook]) -> list[HookRope]:
    ropes = {h.rope for h in hooks}
    return [rope for rope in plan.rig.hook_ropes if rope.name in ropes]
