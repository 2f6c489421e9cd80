"""The `fidelity:` of a scene file as its part of the plan: groups of joints become names of joints."""

from __future__ import annotations

from heavylift.nodes.plan import plan
from heavylift.nodes.plan.planar import groups_of, planar
from heavylift.nodes.scene.text.faults import closest

from .yard import Yard

__all__ = ["build_fidelity"]


def build_fidelity(yard: Yard) -> plan.Fidelity:
    """How much is modelled; what is wrong is added to the faults of the scene."""
    given = yard.scene.fidelity
    groups = groups_of(yard.loaders, yard.cranes)
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
    )
    return planar(made, yard.loaders, yard.cranes)
