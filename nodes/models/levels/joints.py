"""Joints that are locked, or whose motion is restricted to a plane, at some model levels.

A locked joint is replaced by a rigid connection in its start position, and force laws on it are omitted; a body in
planar motion has three degrees of freedom.
"""

from dataclasses import replace
from typing import Any

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import IDENTITY, JOINTS, Joint, Vector
from heavylift.kernel.errors import ModelError
from heavylift.nodes.plan.fidelity import Fidelity, attitude, held_by, times, turn
from heavylift.nodes.plan.mechanism import Mechanism

X: Vector = (1.0, 0.0, 0.0)
PLANE = {"across": (X, (0.0, 1.0, 0.0)), "along": ((0.0, -1.0, 0.0), X)}  # its normal, and its first direction
LEVEL = 1e-9  # of a quaternion's part that is out of the plane
ONE = ("prismatic", "revolute")  # what can be locked


def locking(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its locked joints replaced by rigid connections; drives of these joints refuse orders."""
    system = machine.system
    moving = (joint for joint in system.joints if joint.kind != "fixed" and joint.q0)  # what closes a loop follows it
    known = {joint.name: joint for joint in moving if joint.name in fidelity.locked}
    if not known:
        return machine
    if other := next((joint for joint in known.values() if joint.kind not in ONE), None):
        raise ModelError(
            f"{other.name}: only a joint that slides or turns about one axis can be locked; remove it from 'locked'"
        )
    locked = {*known}
    held = {drive.name: held_by(fidelity, known[drive.joint]) for drive in system.drives if drive.joint in locked}
    joints = tuple(_fixed(joint) if joint.name in locked else joint for joint in system.joints)
    acting: dict[str, Any] = {
        kind: tuple(x for x in getattr(system, kind) if x.joint not in locked)
        for kind in ("springs", "stops", "brakes", "locks", "drives")
    }
    actuators = tuple(msgspec.structs.replace(a, held=held.get(a.name, a.held)) for a in machine.actuators)
    return msgspec.structs.replace(machine, system=replace(system, joints=joints, **acting), actuators=actuators)


def _fixed(joint: Joint) -> Joint:
    if joint.kind == "revolute":
        R = times(joint.R_PJ, turn(joint.axis, joint.q0[0])) if joint.q0[0] else joint.R_PJ
        return Joint(joint.name, "fixed", joint.parent, joint.child, joint.p_PJ, R, p_CJ=joint.p_CJ, R_CJ=joint.R_CJ)
    distance = product(joint.R_PJ, [joint.q0[0] * a for a in joint.axis])
    x, y, z = (p + d for p, d in zip(joint.p_PJ, distance, strict=True))
    return Joint(
        joint.name, "fixed", joint.parent, joint.child, (x, y, z), joint.R_PJ, p_CJ=joint.p_CJ, R_CJ=joint.R_CJ
    )


def yielding(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its drives as compliant servos, if the model level includes elastic parts."""
    if fidelity.girder == "rigid" or not machine.servos:
        return machine
    rows = {row.drive: row for row in machine.servos}
    drives = tuple(
        replace(drive, kind="servo", kp=row.stiffness, kv=row.damping) if (row := rows.get(drive.name)) else drive
        for drive in machine.system.drives
    )
    return msgspec.structs.replace(machine, system=replace(machine.system, drives=drives), servos=())


def planar(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with the motion of its free bodies restricted to a vertical plane."""
    free = [joint for joint in machine.system.joints if joint.kind == "free"]
    if fidelity.motion == "spatial" or not free:
        return machine
    joints = tuple(_planar(j, fidelity.motion) if j.kind == "free" else j for j in machine.system.joints)
    return msgspec.structs.replace(machine, system=replace(machine.system, joints=joints))


def _planar(joint: Joint, motion: str) -> Joint:
    """Return a planar joint to replace a free joint; it lies in the plane of motion at the start."""
    normal, first = PLANE[motion]
    x, y, z, *q = joint.q0 or JOINTS[joint.kind].rest
    turned = sum(a * b for a, b in zip(normal, q[:3], strict=True))
    angle, own = 2.0 * atan2(turned, q[3]), IDENTITY
    if any(abs(c - turned * n) > LEVEL for c, n in zip(q[:3], normal, strict=True)):
        a, b, c = zip(*attitude(q), strict=True)
        angle, own = 0.0, (a, b, c)
    return Joint(
        joint.name, "planar", joint.parent, joint.child, (x, y, z), axis=normal, second=first, q0=(0.0, 0.0, angle),
        v0=(0.0,) * 3, R_CJ=own,
    )  # fmt: skip
