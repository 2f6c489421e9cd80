"""Scenes at rest at the start: blocks on their supports, hooks and frames on their ropes, elastic bodies deflected."""

from dataclasses import replace
from math import sqrt

import msgspec
from heavylift.kernel.description.mechanics import Body, Joint
from heavylift.nodes.plan import plan

from .state import Pose, StaticState
from .static_path import first_rest

SETTLES = 5  # a hundredth of what friction holds after each three
WRITTEN = 1e-6  # [m, rad] by which a start may be off its rest: rounding of what is written


def standing(built: plan.Plan, first: StaticState) -> plan.Plan:
    """Return the plan with its blocks at rest on their supports.

    A block whose pose in the scene differs by less than `WRITTEN` keeps this pose."""
    machines = tuple(_stands(x, first) if x.cargo else x for x in built.machines)
    return msgspec.structs.replace(built, machines=machines)


def _stands(block: plan.Mechanism, first: StaticState) -> plan.Mechanism:
    (body,), (joint,) = block.system.bodies, block.system.joints
    p, R = first.poses[body.name]
    turned = max(abs(R[i][j] - (i == j)) for i in range(3) for j in range(3))
    # a start that the scene writes within rounding of the rest is kept, so that it keeps its digits
    written = max(turned, *(abs(a - b) for a, b in zip(p, joint.q0, strict=False))) <= WRITTEN
    if written and body.flexible is None:
        return block
    return _rested(block, {body.name}, first)


def settled(built: plan.Plan) -> plan.Plan:
    """Return the plan with flexible blocks at rest on their supports, computed iteratively. Iteration is needed because
    friction holds each support where it first touches."""
    # each repetition begins with friction unloaded where the last one ended
    for _ in range(SETTLES):
        built = rigged(built, first_rest(built))
    return built


def rigged(built: plan.Plan, first: StaticState) -> plan.Plan:
    """Return the plan with its blocks, hooks and frames in their equilibrium poses, and with its taut ropes listed."""
    machines, hooks = list[plan.Mechanism](), [hook for machine in built.machines for hook in machine.hooks]
    free = {hook.eye.body for hook in hooks if not hook.ends}  # others hang at rest as they are written
    for machine in standing(built, first).machines:
        if not machine.cargo:
            machine = _rested(machine, {machine.name, *free} & {body.name for body in machine.system.bodies}, first)
            taut = (r.name for r in machine.system.all_ropes if r.hooked and first.tensions[r.name] > 0.0)
            machine = msgspec.structs.replace(machine, taut=tuple(taut))
        machines.append(machine)
    return msgspec.structs.replace(built, machines=tuple(machines))


def _rested(machine: plan.Mechanism, bodies: set[str], first: StaticState) -> plan.Mechanism:
    """Return a machine with the given bodies in their poses at rest, with the bodies that hang on them by joints."""
    hung = {*bodies} - {machine.name}

    def joint(x: Joint) -> Joint:
        if x.kind == "free" and x.child in bodies:
            return replace(x, q0=_rest(first.poses[x.child]))
        if x.parent not in hung:
            return x
        hung.add(x.child)
        return replace(x, q0=(first.coordinates[x.name],)) if x.kind in ("prismatic", "revolute") else x

    system = replace(
        machine.system,
        joints=tuple(map(joint, machine.system.joints)),
        bodies=tuple(_bent(x, first) if x.name in bodies else x for x in machine.system.bodies),
    )
    return msgspec.structs.replace(machine, system=system)


def _bent(body: Body, first: StaticState) -> Body:
    bends = body.flexible
    return replace(body, flexible=replace(bends, start=first.modes.get(body.name, ()))) if bends else body


def _rest(pose: Pose) -> tuple[float, float, float, float, float, float, float]:
    """Return a pose as position and quaternion (x, y, z, w)."""
    p, R = pose
    # the largest diagonal element keeps the division well conditioned
    if R[0][0] + R[1][1] + R[2][2] < 0.0:  # turned by more than 120 degrees, most about the axis i
        i = max(range(3), key=lambda axis: R[axis][axis])
        j, k, q = (i + 1) % 3, (i + 2) % 3, [0.0] * 4
        q[i] = 0.5 * sqrt(1.0 + R[i][i] - R[j][j] - R[k][k])
        q[j], q[k], q[3] = (
            (a + b) / (4.0 * q[i]) for a, b in ((R[i][j], R[j][i]), (R[i][k], R[k][i]), (R[k][j], -R[j][k]))
        )
        return (*p, q[0], q[1], q[2], q[3])
    w = 0.5 * sqrt(1.0 + R[0][0] + R[1][1] + R[2][2])
    x, y, z = ((R[i][j] - R[j][i]) / (4.0 * w) for i, j in ((2, 1), (0, 2), (1, 0)))
    return (*p, x, y, z, w)
