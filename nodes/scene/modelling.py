"""The `fidelity:` of a scene file as its part of the plan: groups of joints become names of joints.

A planar motion locks what would leave its plane: across, the gantries and the hinges of the loaders (about y); along,
the trolleys.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from . import plan
from .faults import closest
from .fidelity import PLANAR
from .yard import Yard

__all__ = ["build_fidelity", "planar"]


def build_fidelity(yard: Yard) -> plan.Fidelity:
    """How much is modelled; what is wrong is added to the faults of the scene."""
    given = yard.scene.fidelity
    groups = _groups(yard.loaders, yard.cranes)
    joints = [joint for group in groups.values() for joint in group]
    locked: list[str] = []
    for i, name in enumerate(given.locked):
        if name not in groups and name not in joints:
            told = f"there is no joint '{name}' to lock"
            yard.fault(("fidelity", "locked", i), told, closest(name, [*groups, *joints]))
        locked += groups.get(name, [name])
    made = plan.Fidelity(
        ropes=given.ropes,
        lumps=given.lumps,
        rope_mass=given.rope_mass,
        slings=given.slings,
        girder=given.girder,
        motion=given.motion,
        pads=given.pads,
        locked=tuple(locked),
        islands=given.islands,
        unused_laws=given.unused_laws,
    )
    return planar(made, yard.loaders, yard.cranes)


def planar(fidelity: plan.Fidelity, loaders: Sequence[plan.Loader], cranes: Sequence[plan.Crane]) -> plan.Fidelity:
    """With what would leave the plane of a planar motion locked; the locked joints in one order, however named."""
    groups = _groups(loaders, cranes)
    locked = {*fidelity.locked, *(joint for group in PLANAR.get(fidelity.motion, ()) for joint in groups[group])}
    joints = (joint for group in groups.values() for joint in group)
    return msgspec.structs.replace(fidelity, locked=tuple(joint for joint in joints if joint in locked))


def _groups(loaders: Sequence[plan.Loader], cranes: Sequence[plan.Crane]) -> dict[str, list[str]]:
    """Joints that can be locked, by the name of all of a kind."""
    return {
        "hinges": [f"{x.name}.hinge" for x in loaders],
        "gantries": [f"{c.name}.gantry" for c in cranes],
        "trolleys": [f"{c.name}.{t}-slide" for c in cranes for t in ("upper", "lower")],
    }
