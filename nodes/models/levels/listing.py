"""The levels of a plan, from the plainest to the richest, and what each leaves out.

A level is a fidelity; which there are follows from the optional parts of the plan's own machines: levels whose systems
are equal are one.  Exact passes, which change nothing that is seen, are always taken and leave nothing out.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from . import modelled

ROPES: tuple[dict[str, object], ...] = (
    {"ropes": "elastic", "rope_mass": "none"},
    {"ropes": "elastic", "rope_mass": "lumped"},
    {"ropes": "massive", "lumps": 2, "rope_mass": "none"},
    {"ropes": "massive", "lumps": 4, "rope_mass": "none"},
)
RICHEST: dict[str, dict[str, object]] = {  # what leaves nothing out, by pass
    "rope mass": ROPES[-1],
    "elastic bodies": {"girder": "elastic"},
    "elastic slings": {"slings": "elastic"},
    "other supports": {"pads": "all"},
    "motion out of its plane": {"motion": "spatial", "locked": ()},
}


def as_modelled(plan: Plan, machine: Mechanism) -> Mechanism:
    """A machine as far as it is modelled."""
    lift = next((each for each in plan.lists if machine.name in each.machines), plan)
    return modelled(machine, lift.fidelity)


def at(plan: Plan, fidelity: Fidelity) -> Plan:
    """A plan on a level, with all its lifts."""
    lists = tuple(msgspec.structs.replace(each, fidelity=fidelity) for each in plan.lists)
    return msgspec.structs.replace(plan, fidelity=fidelity, lists=lists)


def levels(plan: Plan) -> tuple[Fidelity, ...]:
    """All levels by the size of their systems, the plainest first; what the plan's own fidelity says of motion, locked
    joints, slings and supports holds on each."""
    found: dict[tuple[System, ...], Fidelity] = {}
    for girder in ("rigid", "elastic"):
        for ropes in ROPES:
            level = msgspec.structs.replace(exact(plan), girder=girder, **ropes)
            found.setdefault(_systems(plan, level), level)
    return tuple(sorted(found.values(), key=lambda level: size(plan, level)))


def size(plan: Plan, fidelity: Fidelity) -> int:
    """How many numbers a step has to find: coordinates with those of modes, and forces and rows that act on them."""
    systems = _systems(plan, fidelity)
    freedom = sum(JOINTS[joint.kind].n_v for system in systems for joint in system.joints)
    modes = sum(body.flexible.modes for system in systems for body in system.bodies if body.flexible)
    rows = sum(len(system.laws) + 3 * len(system.rigid_ropes) for system in systems)
    return 2 * (freedom + modes) + rows


def omitted(plan: Plan, fidelity: Fidelity) -> tuple[str, ...]:
    """What a level leaves out against the richest, by pass."""
    own, free = _systems(plan, fidelity), exact(at(plan, Fidelity()))
    found = []
    for name, richest in RICHEST.items():
        full = msgspec.structs.replace(fidelity, **richest)
        if name == "motion out of its plane":
            full = msgspec.structs.replace(full, locked=tuple(x for x in fidelity.locked if x in free.locked))
        if _systems(plan, full) != own:
            found.append(_of_ropes(fidelity) if name == "rope mass" else name)
    return tuple(found)


def _of_ropes(fidelity: Fidelity) -> str:
    if fidelity.ropes == "massive":
        return "more lumps"
    return "rope mass along ropes" if fidelity.rope_mass == "lumped" else "rope mass"


def exact(plan: Plan) -> Fidelity:
    """The plan's own fidelity with the joints locked that a drive holds in place and nothing moves."""
    locked = (*plan.fidelity.locked, *(name for machine in plan.machines for name in _still(plan, machine)))
    return msgspec.structs.replace(plan.fidelity, locked=tuple(dict.fromkeys(locked)))


def reasons(plan: Plan) -> dict[str, str]:
    """Ropes that have no mass on any level, and why."""
    return {row.rope: row.why for machine in plan.machines for row in machine.heavy if row.why}


def _still(plan: Plan, machine: Mechanism) -> Iterator[str]:
    """Joints with a prescribed drive that nothing else acts on, and that nothing orders, follows, measures or stops."""
    if plan.driven:
        return
    named = msgspec.json.encode((plan.actions, plan.models, plan.interlocks, plan.limits)).decode()
    system = machine.system
    acting = [law.along[0] for law in system.laws if law.along] + [x.joint for x in system.locks]
    acting += [x.of for x in system.measured]
    children = [joint.child for each in plan.machines for joint in each.system.joints]
    driven = {drive.joint: drive for drive in system.drives if drive.kind == "prescribed" and not drive.wave}
    for joint in (joint for joint in system.joints if joint.name in driven and joint.kind in ("prismatic", "revolute")):
        words = (joint.name, driven[joint.name].name)
        free = joint.name not in acting and children.count(joint.child) == 1
        if free and not any(f'"{word}"' in named for word in words):
            yield joint.name


def _systems(plan: Plan, fidelity: Fidelity) -> tuple[System, ...]:
    on = at(plan, fidelity)
    return tuple(as_modelled(on, machine).system for machine in on.machines)
