"""Joints that are not modelled, or only in a plane.

A locked joint is fixed where it starts, and nothing acts on it; a body in planar motion has three degrees of freedom.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import Joint, Vector
from heavylift.kernel.errors import ModelError
from heavylift.nodes.plan.fidelity import Fidelity, held_by
from heavylift.nodes.plan.mechanism import Mechanism

X: Vector = (1.0, 0.0, 0.0)
NORMAL = {"across": (X, (0.0, 1.0, 0.0)), "along": ((0.0, -1.0, 0.0), X)}  # of the plane, and its first direction
LEVEL = 1e-9  # of a quaternion's part that is out of the plane


def locking(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """With locked joints fixed; their drives refuse orders."""
    system = machine.system
    locked = {joint.name for joint in system.joints} & {*fidelity.locked}
    if not locked:
        return machine
    known = {joint.name: joint for joint in system.joints}
    held = {drive.name: held_by(fidelity, known[drive.joint]) for drive in system.drives if drive.joint in locked}
    joints = tuple(_fixed(joint) if joint.name in locked else joint for joint in system.joints)
    acting: dict[str, Any] = {
        kind: tuple(x for x in getattr(system, kind) if x.joint not in locked)
        for kind in ("springs", "stops", "brakes", "locks", "drives")
    }
    actuators = tuple(msgspec.structs.replace(a, held=held.get(a.name, "")) for a in machine.actuators)
    return msgspec.structs.replace(machine, system=replace(system, joints=joints, **acting), actuators=actuators)


def _fixed(joint: Joint) -> Joint:
    slides = joint.kind == "prismatic"
    x, y, z = (p + slides * joint.q0[0] * a for p, a in zip(joint.p_PJ, joint.axis, strict=True))
    return Joint(joint.name, "fixed", joint.parent, joint.child, (x, y, z), joint.R_PJ)


def planar(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """With bodies that are free staying in their plane."""
    free = [joint for joint in machine.system.joints if joint.kind == "free"]
    if fidelity.motion == "spatial" or not free:
        return machine
    joints = tuple(_planar(j, fidelity.motion) if j.kind == "free" else j for j in machine.system.joints)
    return msgspec.structs.replace(machine, system=replace(machine.system, joints=joints))


def _planar(joint: Joint, motion: str) -> Joint:
    """A free joint whose child stays in its plane."""
    normal, first = NORMAL[motion]
    x, y, z, *q = joint.q0
    turned = sum(a * b for a, b in zip(normal, q[:3], strict=True))
    if any(abs(c - turned * n) > LEVEL for c, n in zip(q[:3], normal, strict=True)):
        raise ModelError(
            f"{joint.child}: it starts turned out of the plane of its motion, '{motion}'; model it in space: "
            "fidelity: {motion: spatial}"
        )
    angle = 2.0 * atan2(turned, q[3])
    return Joint(
        joint.name, "planar", joint.parent, joint.child, (x, y, z), axis=normal, second=first, q0=(0.0, 0.0, angle),
        v0=(0.0,) * 3,
    )  # fmt: skip
