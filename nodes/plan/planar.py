"""Planar motion: locks the joints that would leave the plane: slides along its normal, turns about any other axis.

Axes are those at the start, including the rotation of the joints below them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import IDENTITY, WORLD, Joint, Matrix, Vector

from .fidelity import GROUPS, NORMAL, Fidelity, group_of, leaves
from .mechanism import Mechanism


def planar(fidelity: Fidelity, machines: Sequence[Mechanism]) -> Fidelity:
    """Return the fidelity with the joints that leave the plane of motion locked as well, in a fixed order."""
    joints = [joint for machine in machines for joint in machine.system.joints]
    locked = {*fidelity.locked}
    if fidelity.motion in NORMAL:
        locked |= {joint.name for joint, axis in _axes(joints) if leaves(joint, axis, fidelity.motion)}
    order = dict.fromkeys((*(x for group in groups_of(machines).values() for x in group), *(j.name for j in joints)))
    return msgspec.structs.replace(fidelity, locked=tuple(joint for joint in order if joint in locked))


def groups_of(machines: Sequence[Mechanism]) -> dict[str, list[str]]:
    """Return the joints that can be locked, by the name of their group."""
    joints = [joint for machine in machines for joint in machine.system.joints]
    return {group: [joint.name for joint in joints if group_of(joint) == group] for group in GROUPS}


def turn(axis: Vector, angle: float) -> Matrix:
    """Return the rotation (3, 3) about a unit axis by an angle [rad]."""
    (x, y, z), c, s = axis, cos(angle), sin(angle)
    t = 1.0 - c
    return (
        (t * x * x + c, t * x * y - s * z, t * x * z + s * y),
        (t * x * y + s * z, t * y * y + c, t * y * z - s * x),
        (t * x * z - s * y, t * y * z + s * x, t * z * z + c),
    )


def times(A: Matrix, B: Matrix) -> Matrix:
    """Return the product (3, 3) of two rotations."""
    columns = [product(A, column) for column in zip(*B, strict=True)]
    a, b, c = ((x, y, z) for x, y, z in zip(*columns, strict=True))
    return a, b, c


def attitude(q: Sequence[float]) -> Matrix:
    """Return the rotation (3, 3) of a quaternion x y z w."""
    x, y, z, w = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


def _axes(joints: Sequence[Joint]) -> Iterator[tuple[Joint, Vector]]:
    """Yield each revolute or prismatic joint with its axis in the world at the start."""
    known: dict[str, Matrix] = {WORLD: IDENTITY}
    waiting = list(joints)
    while ready := [joint for joint in waiting if joint.parent in known]:
        for joint in ready:
            frame = times(known[joint.parent], joint.R_PJ)
            x, y, z = product(frame, joint.axis)
            yield joint, (x, y, z)
            own = times(frame, _turned(joint))
            back: Matrix = tuple(zip(*joint.R_CJ, strict=True))  # type: ignore[assignment]
            known.setdefault(joint.child, times(own, back))
        waiting = [joint for joint in waiting if joint not in ready]


def _turned(joint: Joint) -> Matrix:
    if joint.kind == "revolute" and joint.q0:
        return turn(joint.axis, joint.q0[0])
    return attitude(joint.q0[3:]) if joint.kind == "free" and joint.q0 else IDENTITY
