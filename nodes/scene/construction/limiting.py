"""The table of limits of a scene: from its machine types and its own keys, each with its source.

A number that the scene gives is the scene's; one of a machine type is the type's; a default is called assumed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from heavylift.kernel.description.forces import Wind
from heavylift.nodes.limits.reeving import ROLLING, drum_ends, lead_factor
from heavylift.nodes.limits.standards import ISO_4308, ROPE_FACTORS, strength_limits
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import TOUCHING, Quantity, RatedLimit
from heavylift.nodes.plan.spellings import BEAM_LOAD
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .environment.footings import standing_limits, wind_limits
from .rigging.ratings import (
    bridle_limit,
    hook_limits,
    lug_limits,
    rigging_limits,
    shackle_limit,
    sling_limits,
    tandem_limits,
)
from .scene_builder import LEVELS, LOWER, UPPER, SceneBuilder


def rated_limits(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> tuple[RatedLimit, ...]:
    """Rows of what holds a load: crane by crane, then those of the rig, of lugs and of other ropes."""
    rows = [row for crane in yard.cranes for row in _crane(yard, crane, yard.scene.cranes[crane.name])]
    rows += [row for crane in yard.cranes for row in rigging_limits(yard, crane)]
    rows += [row for machine in mechanisms for row in (*hook_limits(yard, machine), *rigging_limits(yard, machine))]
    lifting = any(machine.hooks for machine in (*yard.machines, *mechanisms))
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
    of_rails = set[str]() if yard.cranes else {"off_lead_along", "off_lead_across"}
    judged = {"ropes", "wind", "signals", *(limits.model_fields_set - of_rails if hooks else ())}
    for key in sorted(limits.model_fields_set - judged):
        told = "no crane travels on rails: give 'off-lead'" if hooks else "the scene has no hooks: leave it out"
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


def reeving(crane: schema.CraneKeys) -> tuple[int, float, str]:
    """Drum ends and sheave efficiency of a crane's hoists, and their description with what is assumed."""
    ends = drum_ends(crane.falls, crane.drum_ends)
    efficiency = crane.sheave_efficiency or ROLLING
    lead = lead_factor(crane.falls, ends, efficiency)
    ways = f"{ends} drum end{'s' if ends > 1 else ''}{'' if crane.drum_ends else ' (assumed)'}"
    sheaves = f"sheave efficiency {efficiency:g}{'' if crane.sheave_efficiency else ' (assumed)'}"
    return ends, efficiency, f"{crane.falls} falls, {ways}, {sheaves}: lead part {lead:.3f} of the mean"


def rope_factor(crane: schema.CraneKeys) -> tuple[float, str]:
    """Design factor of a crane's hoist ropes, and its source."""
    if crane.rope_factor is not None:
        return crane.rope_factor, "the scene"
    assumed = "" if "mechanism_group" in crane.model_fields_set else ", assumed"
    return ROPE_FACTORS[crane.mechanism_group], f"{ISO_4308}, {crane.mechanism_group}{assumed}"


def _crane(yard: SceneBuilder, crane: plan.Mechanism, given: schema.CraneKeys) -> Iterator[RatedLimit]:
    path: Path = ("cranes", crane.name)
    hooks, slides = sorted(crane.hooks, key=lambda hook: hook.rope), crane.actuators[1:3]
    trolleys = [
        (of, slide, tuple(hook.rope for hook in hooks if hook.on == f"{crane.name}.{of}"))
        for of, slide in zip(LEVELS, slides, strict=True)
    ]
    every = tuple(hook.rope for hook in hooks)

    def row(
        subject: str, quantity: Quantity, unit: str, key: str, elements: tuple[str, ...], **more: object
    ) -> RatedLimit:
        own = key in given.model_fields_set
        where = yard.source.where((*path, written(key))) if own else crane.where
        message = {"source": "the scene" if own else f"type {given.type}", "where": where, **more}
        return RatedLimit(subject=subject, quantity=quantity, unit=unit, elements=elements, **message)  # type: ignore[arg-type]

    for hook in hooks:
        chart = tuple(given.capacity_chart or ())
        key = "capacity_chart" if chart else "hook_capacity"
        value = None if chart else hook.capacity
        over = "trolley" if chart else ""
        yield row(
            hook.rope, "hook load", "kg", key, (hook.rope,), value=value, chart=chart, over=over, where=hook.where
        )
    for of, slide, ropes in trolleys:
        if ropes:
            key, most = f"{of}_capacity", getattr(given, f"{of}_capacity")
            yield row(f"{crane.name} {of}", "trolley load", "kg", key, ropes, value=most, where=slide.where)
    capacity = next((cell.capacity for cell in crane.cells), given.capacity)
    if every and capacity < given.capacity:
        note = f"{given.tandem:.0%} of its {given.capacity / 1e3:g} t as two cranes lift together"
        yield row(crane.name, "tandem load", "kg", "tandem", every, value=capacity, note=note, where=crane.where)
    elif every:
        yield row(crane.name, "crane load", "kg", "capacity", every, value=capacity, where=crane.where)
    for hook in hooks:
        yield from _hoist(hook, given, row)
    for way in ("along", "across"):
        for hook in hooks:
            yield _off_lead(yard, crane, hook, given, way)
    axes = [("gantry", crane.name, "along", every, crane.where)]
    axes += [("trolley", f"{crane.name} {of}", "across", ropes, slide.where) for of, slide, ropes in trolleys]
    for axis in axes:
        yield from _pushes(given, row, *axis)
    for hook in hooks:
        most, ends = given.highest_hook, (given.shortest_rope, given.drum)
        yield row(hook.rope, "hook height", "m", "highest_hook", (hook.rope,), value=most, where=hook.where)
        yield row(hook.rope, "rope length", "m", "drum", (hook.rope,), between=ends, where=hook.where)
    yield row(crane.name, "rails", "m", "rails", (f"{crane.name}.main",), between=given.rails, where=crane.where)
    for of, slide, _ in trolleys:
        body = f"{crane.name}.{of}"
        yield row(f"{crane.name} {of}", "girder", "m", "girder", (body,), between=given.girder, where=slide.where)


def _hoist(hook: plan.Hoist, given: schema.CraneKeys, row: Callable[..., RatedLimit]) -> Iterator[RatedLimit]:
    """Rope and drum of a hook."""
    (factor, source), (_, _, message) = rope_factor(given), reeving(given)
    at = {"where": hook.where, "note": message}
    yield row(
        hook.rope, "rope factor", "", "rope_factor", (hook.rope,), value=factor, least=True, factor=factor,
        breaking=given.fall_breaking, source=source, **at,
    )  # fmt: skip
    most = given.rope_partial_factor
    own = {"rope_partial_factor": (most, "the scene", message)} if most else {}
    yield from strength_limits("hoist rope", hook.rope, given.fall_breaking, hook.where, own, message)
    pull = {"value": given.drum_pull} if given.drum_pull else {"note": "give 'drum pull'", "source": ""}
    yield row(hook.rope, "drum pull", "N", "drum_pull", (hook.rope,), **{**at, **pull})


def _off_lead(
    yard: SceneBuilder, crane: plan.Mechanism, hook: plan.Hoist, given: schema.CraneKeys, way: str
) -> RatedLimit:
    """How far a hook rope may lead off the vertical: its crane's own limit, or that of the scene."""
    limits, key = yard.scene.limits, f"off_lead_{way}"
    own, scene = getattr(given, key), getattr(limits, key)
    path: Path = ("cranes", crane.name, written(key)) if own is not None else ("limits",)
    value = own if own is not None else scene if scene is not None else limits.off_lead
    given_there = own is not None or scene is not None or "off_lead" in limits.model_fields_set
    quantity: Quantity = "off-lead along" if way == "along" else "off-lead across"
    return RatedLimit(
        subject=hook.rope,
        quantity=quantity,
        unit="rad",
        value=None if value == "unknown" else value,
        elements=(hook.rope,),
        source="the scene" if given_there else "assumed",
        note="" if value != "unknown" else "the machine's limit is unknown",
        where=yard.source.where(path) if given_there else crane.where,
    )


def _pushes(
    given: schema.CraneKeys,
    row: Callable[..., RatedLimit],
    axis: str,
    subject: str,
    way: str,
    ropes: tuple[str, ...],
    where: str,
) -> Iterator[RatedLimit]:
    """What ropes that lead off the vertical may pull on a drive and its brake."""
    for what, does in (("drive", "moves"), ("brake", "holds")) if ropes else ():
        force = getattr(given, f"{axis}_{what}")
        note = f"its {what} {does}" if force else f"give '{axis} {what}'"
        yield row(
            subject, "side force", "N", f"{axis}_{what}", ropes, value=force, over=way, note=note, where=where,
            source="the scene" if force else "",
        )  # fmt: skip


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
