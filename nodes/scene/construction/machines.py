"""Cranes with girders or with frames on their hooks, these frames, and blocks; the fidelity of the scene.

All mechanisms of a scene, each of which becomes one coupled model: its machines, its `mechanism:`, and the wind.
"""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

import msgspec
from heavylift.kernel.description.mechanics import WORLD, RemovedMethod, System, merge
from heavylift.nodes.models import system
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.connections import carried_hooks, is_root
from heavylift.nodes.plan.fidelity import groups_of, planar
from heavylift.nodes.plan.mechanism import Cell
from heavylift.nodes.scene.construction.rigging.edges import lugs_of
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys, MechanismKeys, Parts
from heavylift.nodes.scene.keys.schema import Scene
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.source import Path, SourceText
from heavylift.nodes.statics.static_path import at_rest
from heavylift.recordings.format.spellings import BEAM, BEAMS

from .beams import on_hook, placed
from .environment.fenders import fenders_machine
from .environment.obstacles import obstacles_machine
from .environment.vessels import afloat, check_decks, vessel_machine
from .mechanism import build_mechanism
from .rigging.tree import RiggingTree
from .scene_builder import SceneBuilder
from .supports import block_machine


def build_machines(source: SourceText, scene: schema.Scene) -> SceneBuilder:
    """Build the machines of a lift: cranes, frames and blocks; errors are added to the scene."""
    builder = SceneBuilder(source, scene)
    builder.vessels = [vessel_machine(builder, name) for name in scene.vessels]
    if scene.rig:
        _hang(builder, scene.rig)
    cranes = _staged(builder)
    blocks = [block_machine(builder, ("block",))] if scene.block else []
    blocks += [block_machine(builder, ("blocks", name)) for name in scene.blocks] if cranes else []
    frames = []
    for frame, (owner, _) in builder.hooks.items() if scene.rig and not source.faults else ():
        assert scene.rig is not None
        i = next(i for i, crane in enumerate(cranes) if crane.name == owner)
        hung, made = on_hook(builder, scene.rig, frame, scene.rig.beams[frame], cranes[i])
        cranes[i] = with_hooks(builder, cranes[i], hung)
        frames.append(made)
    builder.machines += [*cranes, *frames, *blocks]
    if scene.rig:
        _groups(builder, scene.rig)
    return builder


def with_hooks(builder: SceneBuilder, crane: plan.Mechanism, hung: plan.Mechanism) -> plan.Mechanism:
    """Return a crane with the hooks, ropes and actuators of `hung` added."""
    of = ("actuators", "taut", "heavy", "bends", "shapes", "ties", "hooks")
    both = {key: getattr(crane, key) + getattr(hung, key) for key in of}
    both |= {"system": merge([crane.system, hung.system], crane.system.gravity)}
    crane = msgspec.structs.replace(crane, **both)
    return msgspec.structs.replace(crane, cells=load_cells(builder, crane))


def check_parts(source: SourceText, scene: schema.Scene) -> None:
    """Add an error if a part that a lift needs is missing, or if nothing in the scene can move."""
    block = scene.block is not None or bool(scene.blocks)
    parts = {"cranes": bool(scene.machines), "block": block, "rig": scene.rig is not None}
    other = scene.machines or scene.vessels or scene.obstacles or scene.floor
    if not any(parts.values()):
        if scene.mechanism is None and not scene.vessels:
            source.fault((), "a scene needs cranes, a block and a rig, or a mechanism")
    elif not all(parts.values()) and (scene.rig or not other):
        there, missing = (" and ".join(key for key in parts if bool(parts[key]) is has) for has in (True, False))
        source.fault((), f"a scene with {there} needs {missing}, too")
    names = {*(scene.rig.beams if scene.rig else ())}
    for key in ("machines", "blocks", "vessels"):
        for name in getattr(scene, key):
            if name in names and not (key == "machines" and scene.rig and name in scene.rig.beams):
                source.fault((key, name), f"the name '{name}' is given twice: another machine has it", on_key=True)
            names.add(name)
    if scene.mechanism and scene.mechanism.name in names:
        message = f"the name '{scene.mechanism.name}' is given twice: another machine has it, too"
        source.fault(("mechanism", "name"), message)
    _check_ends(source, scene)


def _check_ends(source: SourceText, scene: schema.Scene) -> None:
    """Add errors for an impossible end or tolerance of the run."""
    if scene.tolerance_of == "rope tension" and scene.method not in get_args(RemovedMethod):
        source.fault(("tolerance of",), "no method has a tolerance of rope tension alone; leave this key out")
    if not scene.actions and scene.end is None:
        source.fault((), "the scene never ends: give it 'actions' or an 'end', such as 'end: 60 s'")


def _hang(builder: SceneBuilder, rig: schema.RigKeys) -> None:
    """Assign the frames under `rig` to hooks, and add errors for unknown or doubly used hooks and lugs."""
    known = [hook.replace(".", " ", 1) for given in builder.scene.machines.values() for hook in given.hooks]
    taken: dict[str, str] = {}
    for name, beam in rig.beams.items():
        path: Path = ("rig", BEAMS, name, "hook")
        words = " ".join(beam.hook.split())
        if words not in known:
            builder.source.fault(path, f"there is no hook '{beam.hook}'", closest(words, known))
        elif words in taken:
            builder.source.fault(path, f"the hook {words} already carries {taken[words]}")
        else:
            taken[words] = name
            crane, hook = words.split()
            given = builder.scene.machines[crane]
            ground = (WORLD, *given.bodies, *builder.scene.vessels)
            if other := [x.parent for x in given.joints.values() if x.parent not in ground]:
                message = f"{crane} stands on {other[0]}: hang `rigging` on its hooks, no frame of `rig`"
                builder.source.fault(path, message)
                continue
            builder.hooks[name] = (crane, hook)
        if name in builder.scene.machines:
            builder.source.fault(path[:-1], f"the name '{name}' is given twice: a crane has it, too", on_key=True)
    used, lugs = dict[str, str](), lugs_of(builder.scene)
    for name, beam in rig.beams.items():
        for i, lug in enumerate(beam.lugs or ()):
            path = ("rig", BEAMS, name, "lugs", i)
            if lug not in lugs:
                message = f"no block has a lug '{lug}'" if builder.scene.blocks else f"the block has no lug '{lug}'"
                builder.source.fault(path, message, closest(lug, lugs))
            elif lug in used:
                builder.source.fault(path, f"the lug {lug} already carries a sling of {used[lug]}")
            used.setdefault(lug, name)
        if len({lugs[lug].body for lug in beam.lugs or () if lug in lugs}) > 1:
            builder.source.fault(("rig", BEAMS, name, "lugs"), "all slings of one hook must hang on the same block")


def _staged(builder: SceneBuilder) -> list[plan.Mechanism]:
    """Return the machines on whose hooks frames of `rig` hang, still without their hooks."""
    scene, found = builder.scene, list[plan.Mechanism]()
    carrying = {crane for crane, _ in builder.hooks.values()}
    for name, given in scene.machines.items():
        if name in carrying:
            keys = placed(builder, name, given).model_copy(update={"hooks": {}})
            lift, base = merge([vessel.system for vessel in builder.vessels], scene.gravity), ("machines", name)
            made = build_mechanism(builder.source, keys, scene.gravity, lift, base, edges=scene.edges)
            found.append(made)
    return found


def load_cells(builder: SceneBuilder, machine: plan.Mechanism) -> tuple[Cell, ...]:
    """Return the load cells of a machine, whose rated loads [N] include the hook blocks.

    Only a body that carries several hooks, or that has no body below it, gets a load cell."""
    given, found = builder.scene.machines.get(machine.name), list[Cell]()
    for body, x in given.load_cells.items() if given else ():
        own = carried_hooks(machine, body)
        if len(own) > 1 or (own and is_root(machine, body)):
            most = x.capacity * (x.tandem if builder.tandem else 1.0)
            rated = (most + sum(hook.block_mass for hook in own)) * builder.scene.gravity
            ropes = tuple(hook.rope for hook in own)
            found.append(Cell(name=f"{body}.load", body=body, ropes=ropes, rated=rated, capacity=most))
    return tuple(found)


def _groups(builder: SceneBuilder, rig: schema.RigKeys) -> None:
    on_hook = {" ".join(builder.hooks[beam]): beam for beam in builder.hooks}
    for name, members in rig.groups.items():
        found = []
        for i, member in enumerate(members):
            words = " ".join(member.split())
            if words not in on_hook:
                path: Path = ("rig", "groups", name, i)
                builder.source.fault(path, f"no {BEAM} hangs on a hook '{member}'", closest(words, on_hook))
            else:
                found.append(on_hook[words])
        builder.groups[name] = tuple(dict.fromkeys(found))


def build_fidelity(builder: SceneBuilder, machines: Sequence[plan.Mechanism]) -> plan.Fidelity:
    """Return the model level of these machines, with names of groups replaced by the names of their joints."""
    given, groups = builder.scene.fidelity, groups_of(machines)
    locked = [joint for name in given.locked for joint in groups.get(name, [name])]
    return planar(msgspec.convert(given.model_dump() | {"locked": locked}, plan.Fidelity), machines)


def check_locked(builder: SceneBuilder, machines: Sequence[plan.Mechanism]) -> None:
    """Add an error for each locked joint that does not exist."""
    known = [*groups_of(machines), *(joint.name for machine in machines for joint in machine.system.joints)]
    for i, name in enumerate(builder.scene.fidelity.locked):
        if name not in known:
            builder.source.fault(("fidelity", "locked", i), f"there is no joint '{name}' to lock", closest(name, known))


WIND = "wind"


def build_mechanisms(builder: SceneBuilder, lift: plan.Plan) -> tuple[plan.Mechanism, ...]:
    """Build the mechanisms in order; each mechanism may act on bodies of the lift and of earlier mechanisms.

    Errors go to the scene."""
    source, scene = builder.source, builder.scene
    done = [machine.name for machine in builder.cranes]
    bases: dict[Path, Parts[Any]] = {
        ("machines", name): placed(builder, name, machine)
        for name, machine in scene.machines.items()
        if name not in done
    }
    if scene.mechanism is not None:
        bases["mechanism",] = scene.mechanism
    fixed = bool(scene.obstacles or scene.floor)
    if not bases and scene.wind is None and not (scene.rigging or scene.blocks or scene.vessels or fixed):
        return ()
    check_decks(builder)
    stands = (*builder.vessels, *lift.machines)
    if stands:
        raise_faults(source, source.faults)
    held = msgspec.structs.replace(at_rest(lift).fidelity, locked=lift.fidelity.locked)
    around = system(msgspec.structs.replace(lift, fidelity=held, machines=stands)) if stands else System()
    blocks = [block_machine(builder, ("blocks", name)) for name in scene.blocks] if not done else []
    built = [*builder.vessels, *blocks]
    if source.faults:
        return tuple(built)
    around = merge([around, *(block.system for block in blocks)], scene.gravity) if blocks else around
    if fixed:
        built.append(obstacles_machine(builder, around))
        around = merge([around, built[-1].system], scene.gravity)
    if source.faults:
        return tuple(built)
    taken = {".".join(words) for words in builder.hooks.values()}
    tree = RiggingTree(source, scene, around, taken) if scene.rigging else None
    for crane in builder.cranes:
        spare = {name: x for name, x in scene.machines[crane.name].hooks.items() if name not in taken}
        if own := _used(spare, tree):
            keys = MechanismKeys.model_construct(name=crane.name, hooks=own)
            hung = build_mechanism(source, keys, scene.gravity, around, ("machines", crane.name), tree, scene.edges)
            builder.machines[builder.machines.index(crane)] = with_hooks(builder, crane, hung)
            around = merge([around, hung.system], scene.gravity)
    if source.faults:
        return tuple(built)
    for base, given in bases.items():
        given = given.model_copy(update={"hooks": _used(given.hooks, tree)})
        built.append(build_mechanism(source, given, scene.gravity, around, base, tree, scene.edges))
        if source.faults:
            return tuple(built)  # what others name of it is not known
        built[-1] = msgspec.structs.replace(built[-1], cells=load_cells(builder, built[-1]))
        around = merge([around, built[-1].system], scene.gravity)
    for base, name in tree.own() if tree else ():
        assert tree is not None
        made = build_mechanism(source, tree.made(name, around), scene.gravity, around, base, None, scene.edges)
        built.append(msgspec.structs.replace(made, ties=tuple(tree.ties(name))))
        if source.faults:
            return tuple(built)
        around = merge([around, built[-1].system], scene.gravity)
    if scene.fenders:
        built.append(fenders_machine(builder, around))
        if source.faults:
            return tuple(built)
    built = afloat(builder, built, around)
    if (air := _wind(source, scene, around)) is not None:
        built.append(build_mechanism(source, air, scene.gravity, around, (WIND,)))
    return tuple(built)


def block_alone(scene: Scene) -> bool:
    """Return whether a scene has one block and otherwise only lifting frames and the cranes that carry them."""
    others = scene.mechanism, scene.wind, scene.rigging, scene.blocks, scene.vessels, scene.obstacles, scene.floor
    carrying = {beam.hook.split()[0] for beam in scene.rig.beams.values()} if scene.rig else set()
    return bool(scene.block) and not any((*others, scene.edges, scene.fenders)) and {*scene.machines} <= carrying


def _used(hooks: Mapping[str, HookKeys], tree: RiggingTree | None) -> dict[str, HookKeys]:
    """Return the hooks except those that carry no rigging and are to be left out in this case."""
    return {name: x for name, x in hooks.items() if x.unused == "kept" or (tree is not None and tree.of_any(name))}


def _wind(source: SourceText, scene: Scene, around: System) -> MechanismKeys | None:
    """Return the wind forces as a mechanism; None without wind."""
    if scene.wind is None:
        return None
    known = [body.name for body in around.bodies]
    for body in scene.wind.on:
        if body not in known:
            source.fault((WIND, "on", body), f"there is no body '{body}'", closest(body, known), on_key=True)
    forces = scene.wind.forces(scene.block.size if scene.block else None, scene.seed, scene.end)
    if scene.mechanism is not None and scene.mechanism.name == WIND:
        source.fault(("mechanism", "name"), f"'{WIND}' is reserved for the wind; give the mechanism another name")
    if not forces and any(x.floating and x.floating.wind for x in scene.vessels.values()):
        return None
    if not forces:
        source.fault((WIND,), "there is no block in the wind; name bodies and their sides under 'on'", on_key=True)
    return None if source.faults else MechanismKeys.model_construct(name=WIND, forces=forces)
