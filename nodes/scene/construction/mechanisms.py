"""All that a scene makes of parts, one coupled model each: its machines, its mechanism, the wind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
from heavylift.kernel.description.mechanics import System, merge
from heavylift.nodes.models import system
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys, MechanismKeys, Parts
from heavylift.nodes.scene.keys.schema import Scene
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.source import Path, Source
from heavylift.nodes.statics.static_path import at_rest

from .beams import placed
from .environment.obstacles import obstacles_machine
from .environment.vessels import afloat, check_decks
from .machines import load_cells, with_hooks
from .mechanism import build_mechanism
from .rigging.tree import RiggingTree
from .scene_builder import SceneBuilder
from .supports import block_machine

WIND = "wind"


def build_mechanisms(builder: SceneBuilder, lift: plan.Plan) -> tuple[plan.Mechanism, ...]:
    """Build mechanisms in order, each relative to the lift (at rest as in a run) and to earlier ones; faults are added
    to those of the scene."""
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
    built = afloat(builder, built, around)
    if (air := _wind(source, scene, around)) is not None:
        built.append(build_mechanism(source, air, scene.gravity, around, (WIND,)))
    return tuple(built)


def _used(hooks: Mapping[str, HookKeys], tree: RiggingTree | None) -> dict[str, HookKeys]:
    """Hooks without those that are left out where nothing hangs on them."""
    return {name: x for name, x in hooks.items() if x.unused == "kept" or (tree is not None and tree.of_any(name))}


def _wind(source: Source, scene: Scene, around: System) -> MechanismKeys | None:
    """Wind forces, if there is wind."""
    if scene.wind is None:
        return None
    known = [body.name for body in around.bodies]
    for body in scene.wind.on:
        if body not in known:
            source.fault((WIND, "on", body), f"there is no body '{body}'", closest(body, known), on_key=True)
    forces = scene.wind.forces(scene.block.size if scene.block else None, scene.seed, scene.end)
    if scene.mechanism is not None and scene.mechanism.name == WIND:
        source.fault(("mechanism", "name"), f"'{WIND}' is what the wind is called; give the mechanism another name")
    if not forces:
        source.fault((WIND,), "there is no block in the wind; name bodies and their sides under 'on'", on_key=True)
    return None if source.faults else MechanismKeys.model_construct(name=WIND, forces=forces)
