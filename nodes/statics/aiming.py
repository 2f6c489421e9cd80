"""End positions of moves: for moves that end above lugs, found by following the action list statically up to each of
them.

Also, for each action, the positions that its moves would reach, even if limits stop them earlier.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import pi, sqrt

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import IDENTITY, JOINTS, Joint, System, Vector
from heavylift.nodes.models import system
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.connections import beneath, lug_places

from .state import Pose, StaticState
from .static_path import Followed, at_rest

GROUND: Pose = ((0.0, 0.0, 0.0), IDENTITY)
SLACK = 1.0  # [N] of a sling that carries nothing


def world(x: StaticState, body: str, p: Vector) -> Vector:
    """Return the world position [m] of a point p on a body."""
    o, R = x.poses.get(body, GROUND)
    a, b, c = (o[i] + R[i][0] * p[0] + R[i][1] * p[1] + R[i][2] * p[2] for i in range(3))
    return a, b, c


def goal_states(built: plan.Plan, path: Followed) -> list[StaticState]:
    """Return the state at the start, and the states in which the moves of each action have reached their ends.

    These states contain positions only, without suspended bodies."""
    found = [goal(built, plan.Action(orders=()), x) for x in path.states[:1]]
    if built.lists:
        return [*found, *path.goals]
    for number, acted in enumerate(path.acted, 1):
        action = built.actions[number - 1]
        if any(isinstance(m, Move) for m in action.orders):
            stage = action.stage or f"action {number}"
            found.append(replace(goal(built, action, acted.before), action=number, stage=stage))
    return found


def goal(built: plan.Plan, action: plan.Action, before: StaticState) -> StaticState:
    """Return the state in which the drives and hooks are at the end positions of an action's moves.

    Moves without a known end position are ignored."""
    own = [actuator.name for machine in built.machines for actuator in machine.actuators]
    now = {name: before.references[name] for name in own if name in before.references}
    for move in (m for m in action.orders if isinstance(m, Move)):
        if move.actuator in now and (move.to is not None or move.by is not None):
            now[move.actuator] = move.to if move.to is not None else now[move.actuator] + (move.by or 0.0)
    poses = {body: pose for machine in built.machines for body, pose in _moved(machine, before, now)}
    return replace(before, event="", tensions={}, supports={}, hooked={}, poses=poses, references=now)


def _moved(machine: plan.Mechanism, before: StaticState, now: dict[str, float]) -> Iterator[tuple[str, Pose]]:
    drives = {drive.joint: drive.name for drive in machine.system.drives if drive.name in now}

    def distance(body: str) -> Vector | None:
        """Return the displacement of a body (3,) [m] by the moves of an action; None if the body is also turned."""
        x, y, z = 0.0, 0.0, 0.0
        for joint in (joint for joint in beneath(machine, body) if joint.name in drives):
            drive = drives[joint.name]
            if far := now[drive] - before.references[drive]:
                if joint.kind != "prismatic":
                    return None
                a, b, c = (far * e for e in axis_of(joint, before))
                x, y, z = x + a, y + b, z + c
        return x, y, z

    slides = (joint for joint in machine.system.joints if joint.kind == "prismatic" and joint.name in drives)
    for body in dict.fromkeys(joint.child for joint in slides):
        if (far := distance(body)) is not None:
            yield body, _pose(before, body, far)
    for hook in machine.hooks:
        if (far := distance(hook.on)) is not None and hook.rope in now:
            up = before.references[hook.rope] - now[hook.rope]
            yield hook.eye.body, _pose(before, hook.eye.body, (far[0], far[1], far[2] + up))


def axis_of(joint: Joint, x: StaticState) -> list[float]:
    """Return the direction (3,) of a joint's axis in the world frame."""
    R = x.poses.get(joint.parent, GROUND)[1]
    return product(R, product(joint.R_PJ, joint.axis))


def _pose(x: StaticState, body: str, way: Vector) -> Pose:
    p, R = x.poses[body]
    return (p[0] + way[0], p[1] + way[1], p[2] + way[2]), R


LEVEL = 1e-9  # of an axis that is upright, or level
DIGITS = 5  # of a place [m or rad], which rests have on every processor alike


def aimed(built: plan.Plan) -> tuple[plan.Plan, list[tuple[str, str]]]:
    """Return the plan, with end positions for moves that are ordered to end above lugs, and the errors found.

    Each error is (place in the scene, sentence), for a move that has no such position."""
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
    """Return the equilibrium before an action, or None and the reason why there is none."""
    from .static_run import StaticRun  # compiles

    r = StaticRun(msgspec.structs.replace(at_rest(built), actions=built.actions[:number], end=None))
    r.walk()
    if r.why:
        return None, r.why
    r.models.give_back()
    return r.states[-1], ""


def _place(built: plan.Plan, move: Move, state: StaticState) -> float | None:
    """Return the coordinate of a move's drive at which the upper ends of its ropes are above the centre of the lugs;
    None if there is none."""
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
    """Return the upper ends of the hook ropes on a body and on the bodies that it carries."""
    carried, before = {body}, 0
    while len(carried) > before:
        before = len(carried)
        carried |= {x.child for x in whole.joints if x.parent in carried and JOINTS[x.kind].n_v < 6}
    hooks = {hook.rope for machine in built.machines for hook in machine.hooks}
    ends = (line.a for rope in whole.straight_ropes if rope.name in hooks for line in rope.lines[:2])
    return [world(state, end.body, end.p) for end in ends if end.body in carried]


def _way(joint: Joint, state: StaticState, top: Vector, to: Vector) -> float | None:
    """Return how far a joint must move until a point that it carries is above another point; None if it cannot."""
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
