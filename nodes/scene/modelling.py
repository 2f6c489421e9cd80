"""The `fidelity:` of a scene file as its part of the plan: groups of joints become names of joints.

A planar motion locks what would leave its plane: across, the gantries and the hinges of the loaders (about y); along,
the trolleys.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from . import plan
from .faults import closest
from .fidelity import ACROSS, ALONG
from .yard import Yard

__all__ = ["build_fidelity", "planar"]


def build_fidelity(yard: Yard) -> plan.Fidelity:
    """How much is modelled; what is wrong is added to the faults of the scene."""
    given = yard.scene.fidelity
    groups = {
        "hinges": [f"{x.name}.hinge" for x in yard.loaders],
        "gantries": [f"{c.name}.gantry" for c in yard.cranes],
        "trolleys": [f"{c.name}.{t}-slide" for c in yard.cranes for t in ("upper", "lower")],
    }
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
        locked=tuple(joint for joint in joints if joint in locked),
    )
    return planar(made, yard.loaders, yard.cranes)


def planar(fidelity: plan.Fidelity, loaders: Sequence[plan.Loader], cranes: Sequence[plan.Crane]) -> plan.Fidelity:
    """With what would leave the plane of a planar motion locked."""
    out = list(fidelity.locked)
    if fidelity.motion == ACROSS:
        out += [f"{c.name}.gantry" for c in cranes] + [f"{x.name}.hinge" for x in loaders]
    elif fidelity.motion == ALONG:
        out += [f"{c.name}.{t}-slide" for c in cranes for t in ("upper", "lower")]
    return msgspec.structs.replace(fidelity, locked=tuple(dict.fromkeys(out)))
