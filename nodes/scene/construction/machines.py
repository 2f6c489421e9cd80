"""Cranes, loaders, block and rig of a scene file, and its fidelity, as their part of the plan.

Names are resolved here and defaults become numbers; loaders hang and the block lies in equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import get_args

import msgspec
from heavylift.kernel.description.mechanics import RemovedMethod
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.planar import groups_of, planar
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.machines import GoliathBody, GoliathDrive
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, Source

from .loaders import add_loader
from .stools import build_block
from .yard import LOWER, UPPER, Level, Yard, box, parts_of, ramp_of, trolley_start


def build_machines(source: Source, scene: schema.Scene) -> Yard:
    """All machines of the scene; what is wrong is added to the faults of the source."""
    yard = Yard(source, scene)
    if scene.block:
        yard.block = build_block(yard, scene.block)
    if scene.rig:
        _hang(yard, scene.rig)
    lifting = {crane for crane, _ in yard.hooks.values()}
    for name, crane in scene.cranes.items():
        yard.cranes.append(_crane(yard, name, crane, tandem=len(lifting) > 1))
    if scene.rig:
        for name, loader in scene.rig.loaders.items():
            if name in yard.hooks:
                add_loader(yard, scene.rig, name, loader)
        _groups(yard, scene.rig)
    return yard


def check_parts(source: Source, scene: schema.Scene) -> None:
    """A lift needs cranes, a rig and a block, which alone does beside machines, vessels and obstacles; a scene needs
    something that moves."""
    if scene.cranes and scene.blocks:
        told = "the loaders of a goliath carry one block, `block:`; `rigging:` of cranes of other types lifts several"
        return source.fault(("blocks",), told, on_key=True)
    block = scene.block is not None or bool(scene.blocks)
    parts = {"cranes": bool(scene.cranes), "block": block, "rig": scene.rig is not None}
    missing = [key for key, there in parts.items() if not there]
    beside = scene.machines or scene.vessels or scene.obstacles or scene.floor
    if len(missing) == len(parts):
        if scene.mechanism is None and not scene.machines and not scene.vessels:
            source.fault((), "a scene needs cranes, a block and a rig, or a mechanism")
    elif missing and not (missing == ["cranes", "rig"] and beside):
        there = " and ".join(key for key in parts if key not in missing)
        source.fault((), f"a scene with {there} needs {' and '.join(missing)}, too")
    names = {*scene.cranes, *(scene.rig.loaders if scene.rig else ())}
    for key in ("machines", "blocks", "vessels"):
        for name in getattr(scene, key):
            if name in names:
                source.fault((key, name), f"the name '{name}' is given twice: another machine has it", on_key=True)
            names.add(name)
    if scene.mechanism and scene.mechanism.name in names:
        message = f"the name '{scene.mechanism.name}' is given twice: another machine has it, too"
        source.fault(("mechanism", "name"), message)
    _check_ends(source, scene)


def _check_ends(source: Source, scene: schema.Scene) -> None:
    """The run ends some time, and its tolerance is that of the state."""
    if scene.tolerance_of == "rope tension" and scene.method not in get_args(RemovedMethod):
        source.fault(("tolerance of",), "no method has a tolerance of rope tension alone; leave this key out")
    if not scene.actions and scene.end is None:
        source.fault((), "the scene never ends: give it 'actions' or an 'end', such as 'end: 60 s'")


def _hang(yard: Yard, rig: schema.Rig) -> None:
    """Which loader hangs on which hook."""
    known = [f"{crane} {hook}" for crane, given in yard.scene.cranes.items() for hook in parts_of(given).hooks]
    taken: dict[str, str] = {}
    for name, loader in rig.loaders.items():
        path: Path = ("rig", "loaders", name, "hook")
        words = " ".join(loader.hook.split())
        if words not in known:
            yard.source.fault(path, f"there is no hook '{loader.hook}'", closest(words, known))
        elif words in taken:
            yard.source.fault(path, f"the hook {words} already carries {taken[words]}")
        else:
            taken[words] = name
            crane, hook = words.split()
            yard.hooks[name] = (crane, hook)
        if name in yard.scene.cranes:
            yard.source.fault(path[:-1], f"the name '{name}' is given twice: a crane has it, too", on_key=True)
    used: dict[str, str] = {}
    for name, loader in rig.loaders.items():
        for i, lug in enumerate(loader.lugs or ()):
            path = ("rig", "loaders", name, "lugs", i)
            lugs = yard.scene.block.lugs if yard.scene.block else {}
            if lug not in lugs:
                yard.source.fault(path, f"the block has no lug '{lug}'", closest(lug, lugs))
            elif lug in used:
                yard.source.fault(path, f"the lug {lug} already carries a sling of {used[lug]}")
            used.setdefault(lug, name)


def _crane(yard: Yard, name: str, crane: schema.Crane, *, tandem: bool) -> plan.Crane:
    where, parts = yard.source.where(("cranes", name)), parts_of(crane)
    accel, pulses = ramp_of(crane.ramp)

    def axis(start: float, ends: tuple[float, float], servo: GoliathDrive) -> plan.Axis:
        omega = 2 * math.pi * servo.frequency
        mass = sum(getattr(parts.bodies, moved).mass for moved in servo.moves)
        kp, kv = mass * omega * omega, 2 * servo.damping * mass * omega
        return plan.Axis(
            start=start, lower=ends[0], upper=ends[1], accel=accel, kp=kp, kv=kv, pulses=pulses,
            emergency=crane.emergency,
        )  # fmt: skip

    def inertia(body: GoliathBody) -> plan.Inertia:
        return plan.Inertia(mass=body.mass, com=body.com, moments=box(body.mass, body.box))

    def trolley(which: Level, body: GoliathBody, servo: GoliathDrive, capacity: float) -> plan.Trolley:
        moved = axis(trolley_start(yard, name, crane, which), crane.girder, servo)
        place = yard.source.where(("cranes", name, f"{which} trolley"))
        return plan.Trolley(name=which, body=inertia(body), axis=moved, capacity=capacity, where=place)

    if crane.drum_ends and crane.falls % crane.drum_ends:
        message = f"{crane.falls} falls cannot be shared by {crane.drum_ends} drum ends: give an even number of falls"
        yard.source.fault(("cranes", name, "drum ends"), f"{message}, or 'drum ends: 1'", on_key=True)
    hooks = []
    for loader, (owner, hook) in yard.hooks.items():
        if owner == name:
            place = yard.source.where(("rig", "loaders", loader, "hook"))
            hooks.append(
                plan.Hook(
                    name=hook,
                    rope=f"{name}.{hook}",
                    trolley=parts.hooks[hook].on,
                    accel=accel,
                    shortest=crane.shortest_rope,
                    drum=crane.drum,
                    highest=crane.highest_hook,
                    capacity=crane.hook_capacity,
                    block_mass=crane.hook_block,
                    emergency=crane.emergency,
                    where=place,
                )
            )
    return plan.Crane(
        name=name,
        main=inertia(parts.bodies.main),
        gantry=axis(crane.at, crane.rails, parts.drives.gantry),
        upper=trolley(UPPER, parts.bodies.upper, parts.drives.upper, crane.upper_capacity),
        lower=trolley(LOWER, parts.bodies.lower, parts.drives.lower, crane.lower_capacity),
        hooks=tuple(sorted(hooks, key=lambda hook: hook.name)),
        capacity=crane.capacity * (crane.tandem if tandem else 1.0),
        girder=plan.Girder(
            mass=crane.girder_mass,
            stiffness=crane.girder_stiffness,
            span=crane.span,
            height=(crane.upper_exit + crane.lower_exit) / 2,
            damping=crane.girder_damping,
        ),
        width=crane.width,
        where=where,
    )


def _groups(yard: Yard, rig: schema.Rig) -> None:
    on_hook = {" ".join(yard.hooks[loader]): loader for loader in yard.hooks}
    for name, members in rig.groups.items():
        found = []
        for i, member in enumerate(members):
            words = " ".join(member.split())
            if words not in on_hook:
                path: Path = ("rig", "groups", name, i)
                yard.source.fault(path, f"no loader hangs on a hook '{member}'", closest(words, on_hook))
            else:
                found.append(on_hook[words])
        yard.groups[name] = tuple(dict.fromkeys(found))


def build_fidelity(yard: Yard, machines: Sequence[plan.Mechanism]) -> plan.Fidelity:
    """How much is modelled of these machines, groups of joints as names of joints."""
    given, groups = yard.scene.fidelity, groups_of(machines)
    locked = [joint for name in given.locked for joint in groups.get(name, [name])]
    return planar(msgspec.convert(given.model_dump() | {"locked": locked}, plan.Fidelity), machines)


def check_locked(yard: Yard, machines: Sequence[plan.Mechanism]) -> None:
    """What is to be locked exists; what is wrong is added to the faults of the scene."""
    known = [*groups_of(machines), *(joint.name for machine in machines for joint in machine.system.joints)]
    for i, name in enumerate(yard.scene.fidelity.locked):
        if name not in known:
            yard.source.fault(("fidelity", "locked", i), f"there is no joint '{name}' to lock", closest(name, known))
