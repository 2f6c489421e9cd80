"""Building a plan from the text of a scene: read, apply settings, validate, build, check.

All errors that a step finds are reported together; a later step starts only if the earlier ones found no error.
"""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.limits.wind import leads_in_wind
from heavylift.nodes.models import node_names
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.connections import frames_on_hooks
from heavylift.nodes.scene.checks.geometry import overloads, start_checks, step_checks
from heavylift.nodes.scene.checks.orders import held_orders, order_checks
from heavylift.nodes.scene.construction.environment.footings import set_up
from heavylift.nodes.scene.construction.environment.touching import check_touches, touches
from heavylift.nodes.scene.construction.levelling import measuring
from heavylift.nodes.scene.construction.machines import (
    block_alone,
    build_fidelity,
    build_machines,
    build_mechanisms,
    check_locked,
    check_parts,
)
from heavylift.nodes.scene.construction.resolve import build_actions
from heavylift.nodes.scene.construction.rigging.ratings import gear_of
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.construction.signals import build_interlocks, build_limits, build_models, check_models
from heavylift.nodes.scene.construction.supports import block_machine
from heavylift.nodes.scene.construction.weighing import weighed
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.gear import geared
from heavylift.nodes.scene.keys.nodes import placement_faults
from heavylift.nodes.scene.keys.validate import override, uncertainties, validate
from heavylift.nodes.scene.text.extending import alike, extended
from heavylift.nodes.scene.text.faults import raise_faults
from heavylift.nodes.scene.text.machine_types import gather
from heavylift.nodes.scene.text.meshes import shaped
from heavylift.nodes.scene.text.source import Data, Fault, Path as InData, SourceText, read
from heavylift.nodes.scene.text.tables import tabled
from heavylift.nodes.statics.aiming import aimed
from heavylift.nodes.statics.resting import rigged, settled, standing
from heavylift.nodes.statics.state import StaticState
from heavylift.nodes.statics.static_path import first_rest
from heavylift.nodes.statics.swinging import swing_free

from .corners import Centres, ends_of, rated, with_centres
from .instances import several
from .loaded_scene import LoadedScene, SceneFacts, on_same_path, planned
from .model_files import imported

CHOICE = {"ask", "accuracy", "method", "tolerance", "step", "fidelity", "samples"}  # keys that say how it is to be run


def facts(scene: schema.Scene) -> SceneFacts:
    """Return the settings for the run of a scene that are not part of its plan, such as method and accuracy."""
    return SceneFacts(
        own=scene.ask,
        written=scene.accuracy,
        named=tuple(sorted({*scene.fidelity.model_fields_set, *(scene.model_fields_set & CHOICE)})),
        placement={node: process for process, hosting in scene.placement.items() for node in hosting.nodes},
        remote=[process for process, hosting in scene.placement.items() if hosting.host == "remote"],
        project=scene.project.model_dump(exclude_defaults=True) if scene.project else {},
        tandem={
            name: cell.tandem
            for name, machine in scene.machines.items()
            for cell in machine.load_cells.values()
            if cell.tandem < 1.0 and len(scene.machines) > 1
        },
    )


def build(
    path: Path, name: str, text: str, overrides: Sequence[str], passing: bool = False, followed: bool = True
) -> LoadedScene:
    """Parse the text of a scene, apply settings, and build the scene.

    `passing`: the scene is one of many variants and is not cached; `followed`: compute the equilibrium path."""
    source = extended(path, name, text, path.parent)
    if not source.data:
        raise_faults(source, source.faults)
    imported(source)
    for setting in overrides:
        override(source, setting)
    alike(source)
    tabled(source)
    geared(source)
    shaped(source)
    gather(source)
    whole = json.dumps(source.data) if overrides or source.data != read(text, name).data else ""
    return _built(source, path, text, overrides, passing, whole, followed)


def _built(
    source: SourceText,
    path: Path,
    text: str,
    overrides: Sequence[str] = (),
    passing: bool = True,
    whole: str = "",
    followed: bool = True,
    corner: bool = False,
) -> LoadedScene:
    """Build the scene of a source. If its actions are followed, its limits are also evaluated at the worst corner of
    the uncertain inputs, unless the scene is such a `corner` itself."""
    nominal = followed and not corner
    given = deepcopy(source.data) if nominal else {}
    stated = uncertainties(replace(source, data=given, faults=[])) if nominal else {}
    scene = validate(source)
    raise_faults(source, source.faults)
    assert scene is not None
    if scene.lifts:
        return _side_by_side(source, scene, path, text, overrides, passing, followed)
    known = LoadedScene(
        plan.Plan(name=scene.name, gravity=scene.gravity),
        text,
        path,
        msgspec.structs.replace(facts(scene), uncertain=bool(stated)),
        merged=whole,
        settings=tuple(overrides),
        passing=passing,
    )
    made, factors = _constructed(source, scene, known), scene.all_factors
    loaded = _planned(source, made, followed, nominal)
    if followed and factors.wind and factors.area:
        leads = leads_in_wind(loaded.plan, factors, loaded.states)
        loaded = on_same_path(loaded, msgspec.structs.replace(loaded.plan, limits=(*loaded.plan.limits, *leads)))
    if not nominal:
        return loaded

    known_corners = dict[str, LoadedScene]()

    def other(values: Mapping[InData, Data]) -> LoadedScene:
        """Build the scene with other values of some inputs, without first checking the limits of the nominal scene."""
        own = replace(source, data=deepcopy(given), faults=[])
        for at, value in values.items():
            own.at(at[:-1])[at[-1]] = value  # type: ignore[index]
        name = repr([*values.items()])
        if name not in known_corners:
            known_corners[name] = _built(own, path, text, corner=True)
        return known_corners[name]

    def shifted(centres: Centres) -> LoadedScene:
        """Build the scene with other centres of mass of its blocks."""
        own, moved = replace(source, faults=[]), with_centres(scene, centres)
        if block_alone(scene):
            block = block_machine(SceneBuilder(own, moved), ("block",))
            raise_faults(own, own.faults)
            machines = tuple(block if machine.cargo else machine for machine in made.plan.machines)
            there = replace(made, plan=msgspec.structs.replace(made.plan, machines=machines), keys=moved, passing=True)
        else:
            there = _constructed(own, moved, replace(known, passing=True))
        return _planned(own, there)

    limits = rated(loaded, scene, ends_of(scene, stated), other, shifted)
    return on_same_path(loaded, msgspec.structs.replace(loaded.plan, limits=tuple(limits)))


def _constructed(source: SourceText, scene: schema.Scene, known: LoadedScene) -> LoadedScene:
    """Build the plan of a valid scene, without what follows from its equilibrium path; return it added to `known`."""
    builder = build_machines(source, scene)
    check_parts(source, scene)
    machines = tuple(builder.machines)
    lift = msgspec.structs.replace(known.plan, machines=machines, fidelity=build_fidelity(builder, builder.machines))
    builder.machines += build_mechanisms(builder, lift)
    raise_faults(source, source.faults)
    builder.machines = measuring(builder)
    builder.machines = [*set_up(builder, builder.machines)]
    check_locked(builder, builder.machines)
    lift = msgspec.structs.replace(lift, fidelity=build_fidelity(builder, builder.machines))
    builder.interlocks = build_interlocks(builder)
    loaded = replace(
        known,
        plan=msgspec.structs.replace(
            lift,
            **_common(scene),
            machines=tuple(builder.machines),
            models=build_models(builder),
            interlocks=builder.interlocks,
            limits=build_limits(builder),
            gear=tuple(gear_of(builder)),
            place=scene.factors.place or (None if scene.vessels else "onshore"),
            accepts_assumed=builder.scene.assumed == "accept",
            actions=build_actions(builder),
            may_touch=tuple(touches(source, (), scene.may_touch)),
        ),
        keys=scene,
    )
    check_models(source, loaded.plan)
    check_touches(source, loaded.plan)
    raise_faults(source, [*source.faults, *placement_faults(source, scene.placement, node_names(loaded.plan))])
    return loaded


def _planned(source: SourceText, loaded: LoadedScene, followed: bool = True, nominal: bool = False) -> LoadedScene:
    """Add to the plan of a scene what follows from its equilibrium path, and check it. If `nominal`, check static
    overloads, too."""
    scene, (shaped, unknown) = loaded.scene, aimed(loaded.plan)
    shaped, more = swing_free(shaped, keep=not loaded.passing) if not unknown else (shaped, [])
    raise_faults(source, [Fault(source.path_of(where), sentence) for where, sentence in (*unknown, *more)])
    loaded = replace(loaded, plan=shaped)
    if not loaded.passing and nominal:
        planned.get()(loaded)
    raise_faults(source, _impossible(source, loaded, nominal))
    bent = any(block.flexible for block in scene.all_blocks.values())
    still = {name for name, hook in frames_on_hooks(loaded.plan.machines).items() if hook.ends}
    own = (machine for machine in loaded.plan.machines if machine.name not in still)
    hung = bent or any(machine.ties and not machine.hooks for machine in own)
    sinks = any(hook.ends for machine in loaded.plan.machines for hook in machine.hooks)
    if (sinks or hung) and (first := _first_rest(loaded, followed)):
        loaded = on_same_path(loaded, (rigged if hung else standing)(loaded.plan, first))
        if bent:
            loaded = on_same_path(loaded, settled(loaded.plan))
    return on_same_path(loaded, weighed(loaded.plan))


def _side_by_side(
    source: SourceText,
    scene: schema.Scene,
    path: Path,
    text: str,
    overrides: Sequence[str],
    passing: bool,
    followed: bool,
) -> LoadedScene:
    """Build a scene of several lifts, each of which is built as if it were alone."""

    def alone(own: SourceText) -> LoadedScene:
        alike(own)
        tabled(own)
        geared(own)
        shaped(own)
        gather(own)
        return _built(own, path, text, followed=followed, whole=json.dumps(own.data))

    found, rests, lifts = several(source, scene, path, alone)
    may_touch = (*found.may_touch, *touches(source, (), scene.may_touch))
    built = msgspec.structs.replace(found, **_common(scene), may_touch=may_touch)
    check_touches(source, built)
    raise_faults(source, [*source.faults, *placement_faults(source, scene.placement, node_names(built))])
    inside: dict[str, Any] = {
        name: {"at": [f"{x!r} m" for x in scene.lifts[name].at], **json.loads(lift.merged)}
        for name, lift in lifts.items()
    }
    several_lifts: Any = source.data["lifts"]
    for name, lift in several_lifts.items():
        inside[name] |= {"start": lift["start"]} if "start" in lift else {}
    return LoadedScene(
        built, text, path,
        msgspec.structs.replace(facts(scene), uncertain=any(lift.facts.uncertain for lift in lifts.values())),
        merged=json.dumps({**source.data, "lifts": inside}), settings=tuple(overrides), passing=passing, apart=rests,
        keys=scene,
    )  # fmt: skip


def _common(scene: schema.Scene) -> dict[str, Any]:
    """Return the settings of a scene that apply to the whole run."""
    return {
        "tolerance": scene.step_tolerance,
        "method": scene.method,
        "step": scene.step,
        "seed": scene.seed,
        "microsteps": scene.microsteps,
        "samples_hz": scene.samples,
        "end": scene.end,
    }


def _first_rest(loaded: LoadedScene, followed: bool) -> StaticState | None:
    """Return the equilibrium at the start; None if there is none."""
    if followed:
        return next(iter(loaded.statics.states), None)
    with suppress(HeavyliftError):
        return first_rest(loaded.plan)
    return None


def _impossible(source: SourceText, loaded: LoadedScene, followed: bool) -> list[Fault]:
    """Return the errors of a scene that cannot be built or carried out; if there are none, its static overloads."""
    scene, built = loaded.scene, loaded.plan
    found = start_checks(scene, built) or held_orders(built)
    hooks = any(machine.hooks for machine in built.machines)
    if followed and not found and hooks:
        found = order_checks(scene, built, loaded.statics)
        found = found or step_checks(scene, built, loaded.statics.states)
        found = found or overloads(built, loaded.statics)
    return [Fault(source.path_of(where), sentence, on_key=True) for where, sentence in found]
