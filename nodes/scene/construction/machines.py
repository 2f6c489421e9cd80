"""Cranes on rails, lifting beams, block and rig of a scene file, and its fidelity, as their part of the plan.

Names are resolved here and defaults become numbers; beams hang and the block lies in equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import get_args

import msgspec
from heavylift.kernel.description.mechanics import WORLD, Body, Drive, Joint, RemovedMethod, System, Vector
from heavylift.nodes.limits.messages import past_the_end
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import Cell, Girder
from heavylift.nodes.plan.planar import groups_of, planar
from heavylift.nodes.plan.spellings import BEAM, BEAMS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.machines import PortalBody, PortalParts
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, Source

from .beams import OnHook, on_hook, trolley_start
from .environment.footings import footing_of
from .rigging.slings import lugs_of
from .scene_builder import LEVELS, LOWER, UPPER, SceneBuilder, box, parts_of, ramp_of
from .stools import block_machine

LEG, GIRDER = 4.0, 8.0  # widths of a portal's legs and of its girder [m]
DECK = 2.0  # from the exits of the ropes to the girder, which lies between their two levels [m]
TOUCH = 1e-6  # [m]
TROLLEY = 4.0  # height of a trolley [m]


def build_machines(source: Source, scene: schema.Scene) -> SceneBuilder:
    """All machines of the scene; what is wrong is added to the faults of the source."""
    yard = SceneBuilder(source, scene)
    blocks = [block_machine(yard, ("block",))] if scene.block else []
    blocks += [block_machine(yard, ("blocks", name)) for name in scene.blocks] if scene.cranes else []
    if scene.rig:
        _hang(yard, scene.rig)
    hung = {name: on_hook(yard, scene.rig, name, scene.rig.beams[name]) for name in yard.hooks} if scene.rig else {}
    words = (word for given in scene.rigging.values() for word in getattr(given, "holders", ()))
    others = {word.replace(".", " ").split()[0] for word in words} - {*scene.rigging}
    lifting = {crane for crane, _ in yard.hooks.values()} | others
    for name, crane in scene.cranes.items():
        own = [hung[beam] for beam, (owner, _) in yard.hooks.items() if owner == name]
        yard.machines.append(_crane(yard, name, crane, own, tandem=len(lifting) > 1))
    yard.machines += [x.beam for x in hung.values()] + blocks
    if scene.rig:
        _groups(yard, scene.rig)
    return yard


def check_parts(source: Source, scene: schema.Scene) -> None:
    """A lift needs cranes, a rig and a block, which alone does beside machines, vessels and obstacles; a scene needs
    something that moves."""
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
    names = {*scene.cranes, *(scene.rig.beams if scene.rig else ())}
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


def _hang(yard: SceneBuilder, rig: schema.RigKeys) -> None:
    """Which beam hangs on which hook."""
    known = [f"{crane} {hook}" for crane, given in yard.scene.cranes.items() for hook in parts_of(given).hooks]
    taken: dict[str, str] = {}
    for name, beam in rig.beams.items():
        path: Path = ("rig", BEAMS, name, "hook")
        words = " ".join(beam.hook.split())
        if words not in known:
            yard.source.fault(path, f"there is no hook '{beam.hook}'", closest(words, known))
        elif words in taken:
            yard.source.fault(path, f"the hook {words} already carries {taken[words]}")
        else:
            taken[words] = name
            crane, hook = words.split()
            yard.hooks[name] = (crane, hook)
        if name in yard.scene.cranes:
            yard.source.fault(path[:-1], f"the name '{name}' is given twice: a crane has it, too", on_key=True)
    used, lugs = dict[str, str](), lugs_of(yard.scene)
    for name, beam in rig.beams.items():
        for i, lug in enumerate(beam.lugs or ()):
            path = ("rig", BEAMS, name, "lugs", i)
            if lug not in lugs:
                told = f"no block has a lug '{lug}'" if yard.scene.blocks else f"the block has no lug '{lug}'"
                yard.source.fault(path, told, closest(lug, lugs))
            elif lug in used:
                yard.source.fault(path, f"the lug {lug} already carries a sling of {used[lug]}")
            used.setdefault(lug, name)
        if len({lugs[lug].body for lug in beam.lugs or () if lug in lugs}) > 1:
            yard.source.fault(("rig", BEAMS, name, "lugs"), "the slings of one hook hang on one block")


def _crane(
    yard: SceneBuilder, name: str, crane: schema.CraneKeys, hung: Sequence[OnHook], *, tandem: bool
) -> plan.Mechanism:
    """A main body on rails with two trolleys on servos, from which its hook ropes hang."""
    parts, (accel, pulses) = parts_of(crane), ramp_of(crane.ramp)
    starts = {"gantry": crane.at} | {f"{of}-slide": trolley_start(yard, name, crane, of) for of in LEVELS}
    if crane.drum_ends and crane.falls % crane.drum_ends:
        message = f"{crane.falls} falls cannot be shared by {crane.drum_ends} drum ends: give an even number of falls"
        yard.source.fault(("cranes", name, "drum ends"), f"{message}, or 'drum ends: 1'", on_key=True)
    bodies, joints, drives, actuators = list[Body](), list[Joint](), list[Drive](), list[plan.Actuator]()
    servos = {"gantry": parts.drives.gantry, "upper-slide": parts.drives.upper, "lower-slide": parts.drives.lower}
    main, at = f"{name}.main", (0.0, 0.0, 0.0)
    for (slide, servo), (part, body) in zip(servos.items(), parts.bodies, strict=True):
        bodies.append(_body(f"{name}.{part}", body))
        joint, on = f"{name}.{slide}", part == "main"
        parent, axis = (WORLD, (1.0, 0.0, 0.0)) if on else (main, (0.0, 1.0, 0.0))
        joints.append(Joint(joint, "prismatic", parent, bodies[-1].name, at, axis=axis, q0=(starts[slide],), v0=(0.0,)))
        omega, mass = 2 * math.pi * servo.frequency, sum(getattr(parts.bodies, moved).mass for moved in servo.moves)
        gains = mass * omega * omega, 2 * servo.damping * mass * omega
        drives.append(Drive(f"{joint}.drive", joint, "servo", *gains))
        lower, upper = crane.rails if on else crane.girder
        place: Path = ("cranes", name) if on else ("cranes", name, f"{part} trolley")
        if not lower - TOUCH <= starts[slide] <= upper + TOUCH:
            subject, along = (name, ("x", "rails")) if on else (f"{name} {part}", ("y", "girder"))
            told = past_the_end(subject, along[0], starts[slide], along[1], (lower, upper))
            yard.source.fault(place, told, on_key=True)
        actuators.append(
            plan.Actuator(
                name=drives[-1].name, start=starts[slide], accel=accel, lower=lower, upper=upper, pulses=pulses,
                emergency=crane.emergency, where=yard.source.where(place),
            )
        )  # fmt: skip
    girder = Girder(
        body=main, slides=(joints[1].name, joints[2].name), mass=crane.girder_mass, stiffness=crane.girder_stiffness,
        span=crane.span, height=(crane.upper_exit + crane.lower_exit) / 2, damping=crane.girder_damping,
    )  # fmt: skip
    system = System(
        bodies=tuple(bodies),
        joints=tuple(joints),
        drives=tuple(drives),
        ropes=tuple(x.rope for x in hung),
        gravity=yard.scene.gravity,
    )
    capacity = crane.capacity * (crane.tandem if tandem else 1.0)
    return plan.Mechanism(
        name=name,
        system=system,
        actuators=(*actuators, *(x.winch for x in hung)),
        taut=tuple(x.rope.name for x in hung),
        hooks=tuple(x.hoist for x in hung),
        heavy=tuple(x.heavy for x in hung),
        cells=tuple(_cells(yard, name, crane, capacity, sorted(hung, key=lambda x: x.hook))),
        girders=(girder,),
        shapes=(*_portal(name, crane, girder, hung), *_trolleys(name, parts)),
        levels=True,
        footing=footing_of(yard.source, ("cranes", name, "parts"), parts.stands, [x.name for x in bodies], f"{name}."),
        where=yard.source.where(("cranes", name)),
    )


def _body(name: str, given: PortalBody) -> Body:
    x, y, z = box(given.mass, given.box)
    return Body(name, given.mass, given.com, ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)))


def _cells(
    yard: SceneBuilder, name: str, crane: schema.CraneKeys, capacity: float, hung: Sequence[OnHook]
) -> Iterator[Cell]:
    """Load cells of all hooks together, and of those of a trolley that has several; rated for the blocks, too."""
    groups: dict[str, tuple[float, list[OnHook]]] = {"main": (capacity, [*hung])} if hung else {}
    for of, most in ((UPPER, crane.upper_capacity), (LOWER, crane.lower_capacity)):
        own = [x for x in hung if x.hoist.on == f"{name}.{of}"]
        if len(own) > 1:
            groups[of] = most, own
    for part, (most, own) in groups.items():
        body, ropes = f"{name}.{part}", tuple(x.rope.name for x in own)
        rated = (most + sum(x.hoist.block_mass for x in own)) * yard.scene.gravity
        yield Cell(name=f"{body}.load", body=body, ropes=ropes, rated=rated, capacity=most)


def _portal(name: str, crane: schema.CraneKeys, girder: Girder, hung: Sequence[OnHook]) -> Iterator[plan.Shape]:
    """Girder between the two levels of rope exits (about its axis if nothing hangs from it), two pairs of legs on the
    rails under cross beams, each on a sill as long as the portal is wide over its buffers."""
    exits, axis = [line.a.p[2] for x in hung for line in x.rope.lines], girder.height
    low, high = (min(exits) + DECK, max(exits) - DECK) if exits else (axis - LEG, axis + LEG)
    span, half = 2.0 * parts_of(crane).bodies.main.com[1], crane.width / 2 - LEG

    def shape(part: str, centre: Vector, size: Vector) -> plan.Shape:
        return plan.Shape(body=f"{name}.main", centre=centre, size=size, thing=f"portal of {name}", part=part)

    yield shape("girder", (0.0, span / 2, (low + high) / 2), (GIRDER, span + LEG, max(high - low, LEG)))
    for x in (-half, half):
        for y in (0.0, span):
            yield shape("leg", (x, y, low / 2), (LEG, LEG, low))
    for y in (0.0, span):
        yield shape("sill", (0.0, y, LEG / 4), (crane.width, LEG, LEG / 2))
        yield shape("cross beam", (0.0, y, low + LEG / 2), (crane.width - LEG, LEG, LEG))


def _trolleys(name: str, parts: PortalParts) -> Iterator[plan.Shape]:
    for of, body in ((UPPER, parts.bodies.upper), (LOWER, parts.bodies.lower)):
        size = (*body.box[:2], TROLLEY)
        yield plan.Shape(body=f"{name}.{of}", centre=body.com, size=size, thing=f"{of} trolley of {name}")


def _groups(yard: SceneBuilder, rig: schema.RigKeys) -> None:
    on_hook = {" ".join(yard.hooks[beam]): beam for beam in yard.hooks}
    for name, members in rig.groups.items():
        found = []
        for i, member in enumerate(members):
            words = " ".join(member.split())
            if words not in on_hook:
                path: Path = ("rig", "groups", name, i)
                yard.source.fault(path, f"no {BEAM} hangs on a hook '{member}'", closest(words, on_hook))
            else:
                found.append(on_hook[words])
        yard.groups[name] = tuple(dict.fromkeys(found))


def build_fidelity(yard: SceneBuilder, machines: Sequence[plan.Mechanism]) -> plan.Fidelity:
    """How much is modelled of these machines, groups of joints as names of joints."""
    given, groups = yard.scene.fidelity, groups_of(machines)
    locked = [joint for name in given.locked for joint in groups.get(name, [name])]
    return planar(msgspec.convert(given.model_dump() | {"locked": locked}, plan.Fidelity), machines)


def check_locked(yard: SceneBuilder, machines: Sequence[plan.Mechanism]) -> None:
    """What is to be locked exists; what is wrong is added to the faults of the scene."""
    known = [*groups_of(machines), *(joint.name for machine in machines for joint in machine.system.joints)]
    for i, name in enumerate(yard.scene.fidelity.locked):
        if name not in known:
            yard.source.fault(("fidelity", "locked", i), f"there is no joint '{name}' to lock", closest(name, known))
