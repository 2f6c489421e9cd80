"""The table of limits of a scene: from its machine types and its own keys, each with its source.

A number that the scene gives is the scene's; one of a machine type is the type's; a default is called assumed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from heavylift.kernel.description.forces import Wind
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import TOUCHING, RatedLimit
from heavylift.nodes.plan.spellings import BEAM_LOAD
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .environment.footings import standing_limits, wind_limits
from .rigging.hook_ratings import WAYS, hook_limits
from .rigging.ratings import (
    bridle_limit,
    lug_limits,
    rigging_limits,
    shackle_limit,
    sling_limits,
    tandem_limits,
)
from .scene_builder import LOWER, UPPER, SceneBuilder


def rated_limits(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> tuple[RatedLimit, ...]:
    """Rows of what holds a load: crane by crane, then those of the rig, of lugs and of other ropes."""
    machines = [*yard.cranes, *mechanisms]
    rows = [row for machine in machines for row in (*hook_limits(yard, machine), *rigging_limits(yard, machine))]
    lifting = any(machine.hooks for machine in machines)
    rows += [
        *tandem_limits(yard, [*yard.machines, *mechanisms]),
        *_rig(yard),
        *lug_limits(yard),
        *_supports(yard, lifting),
    ]
    return (*rows, *_ropes(yard, mechanisms))


def scene_limits(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> Iterator[RatedLimit]:
    """What counts for everything that is lifted."""
    limits, written_ = yard.scene.limits, "limits" in yard.scene.model_fields_set
    where = yard.source.where(("limits",)) if written_ or not yard.cranes else yard.cranes[0].where
    hooks = bool(yard.cranes) or any(machine.hooks for machine in mechanisms)
    keys = [hook for machine in yard.scene.machines.values() for hook in machine.hooks.values()]
    ways = {way for way in WAYS if not any(getattr(hook, way) for hook in keys)}
    judged = {"ropes", "wind", "signals", *(limits.model_fields_set - ways if hooks else ())}
    for key in sorted(limits.model_fields_set - judged):
        told = "no hook has one of its own: give 'off-lead'" if hooks else "the scene has no hooks: leave it out"
        yard.source.fault(("limits", written(key)), f"nothing is judged by it, for {told}", on_key=True)
    if hooks:
        by = "the scene" if "clearance" in limits.model_fields_set else "assumed"
        yield RatedLimit(
            subject="all", quantity="clearance", unit="m", value=limits.clearance, least=True, source=by, where=where
        )
    winds = tuple(f.name for m in mechanisms for f in m.system.forces if isinstance(f, Wind))
    lifting = [machine for machine in (*yard.machines, *mechanisms) if machine.hooks]
    if lifting or winds or limits.wind is not None:
        yield from wind_limits(yard, lifting, winds)
    for machine in lifting:
        yield from standing_limits(yard, machine)


def _supports(yard: SceneBuilder, lifting: bool) -> Iterator[RatedLimit]:
    """What supports carry: each of them, and all of a block together as it lands; how fast it may lift off and land."""
    limits = yard.scene.limits
    most, by = limits.impact, "the scene" if "impact" in limits.model_fields_set else "assumed"
    for name, block in yard.scene.all_blocks.items():
        base: Path = ("block",) if yard.scene.block and name == "block" else ("blocks", name)
        pads = (f"{name}.{face}-{i}" for face in (LOWER, UPPER) for i in range(1, len(block.supports.at) + 1))
        both = {"subject": name, "elements": (*pads,), "where": yard.source.where((*base, "supports"))}
        given = block.supports.capacity
        of, note = ("the scene", "") if given else ("", "give 'capacity' of its supports")
        yield RatedLimit(quantity="support load", unit="kg", value=given, source=of, note=note, **both)  # type: ignore[arg-type]
        weight, of = block.mass * yard.scene.gravity, f"{by}: {most:g} times its weight"
        by = "the scene" if "touch" in limits.model_fields_set else "assumed"
        for quantity in TOUCHING if lifting else ():
            row = {**both, "value": limits.touch, "unit": "m/s", "source": by}
            yield RatedLimit(quantity=quantity, **row)  # type: ignore[arg-type]
        yield RatedLimit(quantity="impact", unit="N", value=most * weight, factor=most, source=of, **both)  # type: ignore[arg-type]


def _ropes(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> Iterator[RatedLimit]:
    """Ropes that the scene itself limits; those of a mechanism without a limit are unknown."""
    rigged = {sling for m in mechanisms for slings in m.rigged.values() for sling in slings}
    hooks = {hook.rope for m in mechanisms for hook in m.hooks}
    free = [rope.name for m in mechanisms for rope in m.system.all_ropes]
    for name in (name for name in free if name not in {*yard.scene.limits.ropes, *rigged, *hooks}):
        where = yard.source.where(("mechanism", "ropes", name))
        note = "give it under 'limits: {ropes: ...}'"
        yield RatedLimit(subject=name, quantity="rope tension", unit="N", elements=(name,), note=note, where=where)
    known = [*yard.ropes, *(tie.rope for tie in yard.slings()), *free]
    for name, given in yard.scene.limits.ropes.items():
        path: Path = ("limits", "ropes", name)
        if name not in known:
            yard.source.fault(path, f"there is no rope '{name}'", closest(name, known), on_key=True)
        where, breaking = yard.source.where(path), given.breaking or 0.0
        message = {"subject": name, "unit": "N", "elements": (name,), "source": given.source, "where": where}
        most, factor = given.tension or breaking / given.factor, given.factor if breaking else 1.0
        yield RatedLimit(quantity="rope tension", value=most, factor=factor, breaking=breaking, **message)  # type: ignore[arg-type]
        if given.partial_factor and breaking:
            most, factor = breaking / given.partial_factor, given.partial_factor
            yield RatedLimit(quantity="sling peak", value=most, factor=factor, breaking=breaking, **message)  # type: ignore[arg-type]


def _rig(yard: SceneBuilder) -> Iterator[RatedLimit]:
    """Slings and the beams that they hang on."""
    rig = yard.scene.rig
    if rig is None:
        return
    beams = [machine for machine in yard.machines if machine.latches]
    for beam in beams:
        slings, (cell,) = tuple(tie.rope for tie in beam.ties), beam.cells
        source = "the scene" if "capacity" in rig.beams[beam.name].model_fields_set else "assumed"
        yield RatedLimit(
            subject=beam.name, quantity=BEAM_LOAD, unit="N", value=cell.rated, elements=slings, source=source,
            where=beam.where,
        )  # fmt: skip
    for beam in beams:
        bent = {rope.name for rope in beam.system.reevings}
        for tie in beam.ties:
            yield from sling_limits(yard, rig.sling, tie.rope, tie.where, ("rig", "sling"))
            yield bridle_limit(yard, tie.rope, tie.where, bent=tie.rope in bent)
            yield shackle_limit(yard, rig.shackle, tie.rope, ("rig", "shackle"))
