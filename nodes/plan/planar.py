"""Planar motion locks what would leave its plane.

Across, these are the gantries and the hinges of the loaders (about y); along, the trolleys.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from . import plan
from .fidelity import PLANAR


def planar(fidelity: plan.Fidelity, loaders: Sequence[plan.Loader], cranes: Sequence[plan.Crane]) -> plan.Fidelity:
    """With what would leave the plane of a planar motion locked; the locked joints in one order, however named."""
    groups = groups_of(loaders, cranes)
    locked = {*fidelity.locked, *(joint for group in PLANAR.get(fidelity.motion, ()) for joint in groups[group])}
    joints = (joint for group in groups.values() for joint in group)
    return msgspec.structs.replace(fidelity, locked=tuple(joint for joint in joints if joint in locked))


def groups_of(loaders: Sequence[plan.Loader], cranes: Sequence[plan.Crane]) -> dict[str, list[str]]:
    """Joints that can be locked, by the name of all of a kind."""
    return {
        "hinges": [f"{x.name}.hinge" for x in loaders],
        "gantries": [f"{c.name}.gantry" for c in cranes],
        "trolleys": [f"{c.name}.{t}-slide" for c in cranes for t in ("upper", "lower")],
    }
