"""Where the moves of each action are to lead, though limits may stop them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from heavylift.kernel.algebra.dense import product
from heavylift.kernel.description.mechanics import IDENTITY, Joint, Vector
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.mechanism import beneath

from .state import Pose, StaticState
from .static_path import Followed

GROUND: Pose = ((0.0, 0.0, 0.0), IDENTITY)
SLACK = 1.0  # [N] of a sling that carries nothing


def world(x: StaticState, body: str, p: Vector) -> Vector:
    """World position of a point of a body [m]."""
    o, R = x.poses.get(body, GROUND)
    a, b, c = (o[i] + R[i][0] * p[0] + R[i][1] * p[1] + R[i][2] * p[2] for i in range(3))
    return a, b, c


def goal_states(built: plan.Plan, path: Followed) -> list[StaticState]:
    """States at the start and at the goals of each action's moves: positions only, without suspended parts."""
    found = [goal(built, plan.Action(orders=()), x) for x in path.states[:1]]
    for number, acted in enumerate(path.acted if not built.lists else (), 1):
        action = built.actions[number - 1]
        if any(isinstance(m, Move) for m in action.orders):
            stage = action.stage or f"action {number}"
            found.append(replace(goal(built, action, acted.before), action=number, stage=stage))
    return found


def goal(built: plan.Plan, action: plan.Action, before: StaticState) -> StaticState:
    """The goals of moves with known ends, for straight drives and hooks."""
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
        """Displacement of a body; None if something turns it."""
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
    """The axis of a joint in the world."""
    R = x.poses.get(joint.parent, GROUND)[1]
    return product(R, product(joint.R_PJ, joint.axis))


def _pose(x: StaticState, body: str, way: Vector) -> Pose:
    p, R = x.poses[body]
    return (p[0] + way[0], p[1] + way[1], p[2] + way[2]), R
