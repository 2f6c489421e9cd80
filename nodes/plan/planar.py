"""Planar motion locks what would leave its plane: what slides along its normal, and what turns about anything else."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from .fidelity import GROUPS, PLANAR, Fidelity, group_of
from .mechanism import Mechanism


def planar(fidelity: Fidelity, machines: Sequence[Mechanism]) -> Fidelity:
    """With what would leave the plane of a planar motion locked; the locked joints in one order, however named."""
    groups = groups_of(machines)
    locked = {*fidelity.locked, *(joint for group in PLANAR.get(fidelity.motion, ()) for joint in groups[group])}
    joints = (joint for group in groups.values() for joint in group)
    return msgspec.structs.replace(fidelity, locked=tuple(joint for joint in joints if joint in locked))


def groups_of(machines: Sequence[Mechanism]) -> dict[str, list[str]]:
    """Joints that can be locked, by the name of all of a kind."""
    joints = [joint for machine in machines for joint in machine.system.joints]
    return {group: [joint.name for joint in joints if group_of(joint) == group] for group in GROUPS}
