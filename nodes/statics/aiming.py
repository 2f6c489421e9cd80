"""Where moves end that are to end above lugs: found as the action list is followed at rest up to each of them."""

from __future__ import annotations

from math import pi, sqrt

import msgspec
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import JOINTS, Joint, System, Vector
from heavylift.nodes.models import system
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.mechanism import lug_places

from .goals import axis_of, world
from .state import StaticState
from .static_path import at_rest

LEVEL = 1e-9  # of an axis that is upright, or level
DIGITS = 5  # of a place [m or rad], which rests have on every processor alike


def aimed(built: plan.Plan) -> tuple[plan.Plan, list[tuple[str, str]]]:
    """The plan with goals of its moves to positions above lugs, and (where, sentence) of moves without one."""
    for i, action in enumerate(built.actions):
        moves = [x for x in action.orders if isinstance(x, Move) and x.above and x.to is None]
        if not moves:
            continue
        state, why = _before(built, i)
        orders = list(action.orders)
        for move in moves:
            to = _place(built, move, state) if state else None
            if to is None:
                message = why or f"{move.actuator} does not come above {', '.join(move.above)}"
                return built, [(move.where, message)]
            orders[orders.index(move)] = msgspec.structs.replace(move, to=round(to, DIGITS))
        made = msgspec.structs.replace(action, orders=tuple(orders))
        built = msgspec.structs.replace(built, actions=(*built.actions[:i], made, *built.actions[i + 1 :]))
    return built, []


def _before(built: plan.Plan, number: int) -> tuple[StaticState | None, str]:
    """The equilibrium before an action, or why there is none."""
    from .static_run import StaticRun  # compiles

    r = StaticRun(msgspec.structs.replace(at_rest(built), actions=built.actions[:number], end=None))
    r.walk()
    return (None, r.why) if r.why else (r.states[-1], "")


def _place(built: plan.Plan, move: Move, state: StaticState) -> float | None:
    """The drive coordinate at which the suspended parts are above the centre of lugs."""
    whole = system(built)
    drive = next(x for x in whole.drives if x.name == move.actuator)
    joint = next(x for x in whole.joints if x.name == drive.joint)
    tops = _tops(built, whole, joint.child, state)
    lugs = [world(state, lug.body, lug.p) for name, lug in lug_places(built.machines).items() if name in move.above]
    if not tops:
        return None
    distance = _way(joint, state, _mean(tops), _mean(lugs))
    return None if distance is None else state.references[move.actuator] + distance


def _tops(built: plan.Plan, whole: System, body: str, state: StaticState) -> list[Vector]:
    """Rope exits on a body."""
    carried, before = {body}, 0
    while len(carried) > before:
        before = len(carried)
        carried |= {x.child for x in whole.joints if x.parent in carried and JOINTS[x.kind].n_v < 6}
    hooks = {hook.rope for machine in built.machines for hook in machine.hooks}
    ends = (line.a for rope in whole.straight_ropes if rope.name in hooks for line in rope.lines[:2])
    return [world(state, end.body, end.p) for end in ends if end.body in carried]


def _way(joint: Joint, state: StaticState, top: Vector, to: Vector) -> float | None:
    """Travel of a joint until a point that it carries is above another one."""
    axis = axis_of(joint, state)
    if joint.kind == "prismatic":
        level = axis[0] * axis[0] + axis[1] * axis[1]
        return ((to[0] - top[0]) * axis[0] + (to[1] - top[1]) * axis[1]) / level if level > LEVEL else None
    o = world(state, joint.parent, joint.p_PJ)
    a, b = (tuple(p - q for p, q in zip(point, o, strict=True)) for point in (top, to))
    if abs(axis[2]) > 1.0 - LEVEL:
        turn = float(atan2(b[1], b[0]) - atan2(a[1], a[0])) * axis[2]
        return turn - 2.0 * pi * round(turn / (2.0 * pi))
    if abs(axis[2]) > LEVEL:
        return None
    e = (axis[1], -axis[0], 0.0)  # level, across the axis
    u = axis[1] * a[2] - axis[2] * a[1], axis[2] * a[0] - axis[0] * a[2]
    p, q, far = a[0] * e[0] + a[1] * e[1], u[0] * e[0] + u[1] * e[1], b[0] * e[0] + b[1] * e[1]
    left = p * p + q * q - far * far
    if left < 0.0:
        return None
    low, half = float(atan2(q, p)), float(atan2(sqrt(left), far))
    distances = [turn - 2.0 * pi * round(turn / (2.0 * pi)) for turn in (low + half, low - half)]
    return min(distances, key=abs)


def _mean(points: list[Vector]) -> Vector:
    x, y, z = (sum(values) / len(points) for values in zip(*points, strict=True))
    return x, y, z
