"""The table of limits of a scene, made from its machine types and its own keys, each limit with its source.

The source of a number is the scene, the machine type or, for a default value, "assumed".
"""

from collections.abc import Iterator, Sequence

from heavylift.kernel.description.forces import MooringLine, Spring, Wind
from heavylift.kernel.description.mechanics import Point
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan.limit import TOUCHING, RatedLimit
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path
from heavylift.recordings.format.spellings import BEAM_LOAD
from msgspec.structs import replace

from .environment.footings import standing_limits, wind_limits
from .rigging.hook_ratings import WAYS, hook_limits
from .rigging.ratings import (
    bridle_limit,
    certificate_limits,
    lug_limits,
    rigging_limits,
    shackle_limit,
    sling_limits,
    tandem_limits,
    with_rigging,
)
from .scene_builder import LOWER, UPPER, SceneBuilder

SLACK = 0.9  # dynamic force upward over the weight, at which slings become slack
ABOVE = "what waves wet above still water is not checked"
EXACT = 1e-9  # relative, of rounding
MOORED = 2.0  # breaking load of a mooring line over its largest tension


def rated_limits(builder: SceneBuilder) -> tuple[RatedLimit, ...]:
    """Return the limits of all load-carrying parts: crane by crane, then rig, lugs and other ropes."""
    machines = builder.machines
    rows = [row for machine in machines for row in (*hook_limits(builder, machine), *rigging_limits(builder, machine))]
    lifting = any(machine.hooks for machine in machines)
    rows = [*with_rigging(builder, [*rows, *tandem_limits(builder)])]
    rows += [
        *_rig(builder),
        *lug_limits(builder),
        *certificate_limits(builder),
        *_supports(builder, lifting),
        *_fenders(builder),
        *_vessels(builder),
        *_splashes(builder, [row for row in rows if row.quantity == "hook load"]),
    ]
    return (*rows, *_ropes(builder))


def scene_limits(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits that apply to everything that is lifted."""
    limits, written_ = builder.scene.limits, "limits" in builder.scene.model_fields_set
    where = builder.source.where(("limits",)) if written_ or not builder.cranes else builder.cranes[0].where
    hooks = bool(builder.cranes)
    keys = [hook for machine in builder.scene.machines.values() for hook in machine.hooks.values()]
    booms = any(hook.axis for machine in builder.machines for hook in machine.hooks)
    distances = {distance for distance in WAYS if not booms and not any(getattr(hook, distance) for hook in keys)}
    heaves = {"heave"} if builder.scene.vessels and hooks else set[str]()
    checked = {"ropes", "wind", "signals", *heaves, *(limits.model_fields_set - distances - {"heave"} if hooks else ())}
    for key in sorted(limits.model_fields_set - checked):
        message = "no hook has one of its own: give 'off-lead'" if hooks else "the scene has no hooks: leave it out"
        message = "the scene has no vessels: leave it out" if key == "heave" and hooks else message
        builder.source.fault(("limits", written(key)), f"this limit checks nothing: {message}", on_key=True)
    if hooks:
        by = "the scene" if "clearance" in limits.model_fields_set else "assumed"
        yield RatedLimit(
            subject="all", quantity="clearance", unit="m", value=limits.clearance, least=True, source=by, where=where
        )
    winds = tuple(f.name for m in builder.machines for f in m.system.forces if isinstance(f, Wind))
    lifting = [machine for machine in builder.machines if machine.hooks]
    if lifting or winds or limits.wind is not None:
        yield from wind_limits(builder, lifting, winds)
    for machine in lifting:
        yield from standing_limits(builder, machine)
    yield from _heaves(builder, where)


def _heaves(builder: SceneBuilder, where: str) -> Iterator[RatedLimit]:
    """Yield the limit of the heave between each hook and each vessel that does not carry its crane."""
    most, carried = builder.scene.limits.heave, {j.child: j.parent for m in builder.machines for j in m.system.joints}
    for hook in (hook for machine in builder.machines for hook in machine.hooks if most is not None):
        below = [hook.on]
        while below[-1] in carried:
            below.append(carried[below[-1]])
        for vessel in (name for name in builder.scene.vessels if name not in below):
            yield RatedLimit(
                subject=f"{hook.rope} over {vessel}", quantity="relative heave", unit="m", value=most,
                elements=(hook.rope, vessel), source="the scene", where=where,
            )  # fmt: skip


def _supports(builder: SceneBuilder, lifting: bool) -> Iterator[RatedLimit]:
    """Yield the limits of single supports, of the total force at landing, and of the speed at lift-off and landing."""
    limits = builder.scene.limits
    most = limits.impact
    touch, impact = ("the scene" if x in limits.model_fields_set else "assumed" for x in ("touch", "impact"))
    for name, block in builder.scene.all_blocks.items():
        base: Path = ("block",) if builder.scene.block and name == "block" else ("blocks", name)
        pads = (f"{name}.{face}-{i}" for face in (LOWER, UPPER) for i in range(1, len(block.supports.at) + 1))
        both = {"subject": name, "elements": (*pads,), "where": builder.source.where((*base, "supports"))}
        given = block.supports.capacity
        of, note = ("the scene", "") if given else ("", "give 'capacity' of its supports")
        yield RatedLimit(quantity="support load", unit="kg", value=given, source=of, note=note, **both)  # type: ignore[arg-type]
        weight, of = block.mass * builder.scene.gravity, f"{impact}: {most:g} times its weight"
        for quantity in TOUCHING if lifting else ():
            row = {**both, "value": limits.touch, "unit": "m/s", "source": touch}
            yield RatedLimit(quantity=quantity, **row)  # type: ignore[arg-type]
        yield RatedLimit(quantity="impact", unit="N", value=most * weight, factor=most, source=of, **both)  # type: ignore[arg-type]


def _fenders(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits of the reactions of fenders, and of the obstacles that have one; no vessel may miss a face."""
    scene, contacts = builder.scene, dict[str, list[str]]()
    for contact in (contact for machine in builder.machines for contact in machine.system.contacts):
        contacts.setdefault(contact.b.body, []).append(contact.name)
    each = [("fenders", name, x.capacity, (name,)) for name, x in scene.fenders.items()]
    each += [("obstacles", n, x.capacity, (*contacts.get(n, ()),)) for n, x in scene.obstacles.items() if x.capacity]
    for key, name, most, elements in each:
        yield RatedLimit(
            subject=name, quantity="support load", unit="kg", elements=elements,
            value=most / scene.gravity if most and scene.gravity else None,
            source="the scene" if most else "", note="" if most else "give its 'capacity'",
            where=builder.source.where((key, name)),
        )  # fmt: skip
    for name, fender in scene.fenders.items():
        where, of = builder.source.where(("fenders", name)), f"{fender.vessel} beside the face of {name}"
        if fender.size is None:
            yield RatedLimit(subject=of, quantity="inputs", unit="", note="give the 'size' of the face", where=where)
            continue
        numbers = (fender.size[0] / 2, fender.size[1] / 2)
        signal = ScalarSignal(
            "overhang", point=Point(fender.vessel, fender.meets), origin=Point(f"{name}.face"), numbers=numbers
        )
        yield RatedLimit(
            subject=of, quantity="signal", unit="m", value=0.0, signal=signal, source="its size", where=where
        )


def _vessels(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield rows without a value for what no check of a vessel includes: trim by incomplete data, wind, current."""
    scene = builder.scene
    for name, given in scene.vessels.items():
        hull, floating = builder.hulls.get(name), given.floating
        missing = {
            f"trim of {name}": "its data have no centre of buoyancy" if hull and not hull.buoyancy else "",
            f"wind on {name}": "not included; give its coefficients, 'floating: {wind: ...}'"
            if scene.wind and floating and not floating.wind and name not in scene.wind.on
            else "",
            f"current on {name}": "not included: its motion is given" if scene.current and not floating else "",
        }
        streams = {
            "wind": scene.wind and floating and floating.wind,
            "current": scene.current and floating and floating.current,
        }
        if floating and scene.waves and scene.fidelity.water == "motion given":
            leans = any(name in (x.on, x.vessel) for x in scene.fenders.values())
            acting = {**streams, "drift": hull and hull.drift, "fenders": leans, **_pulls(builder, name)}
            missing |= {f"{of} on {name}": "does not move it: its motion is given" for of, x in acting.items() if x}
        for of in (of for of, keys in streams.items() if keys and keys.height is None):
            missing[f"heel of {name} by {of}"] = f"not included; give the 'height' of 'floating: {{{of}: ...}}'"
        if hull and hull.beside and not (damping := hull.beside.damping):
            missing[f"gap damping beside {name}"] = (
                "only waves damp the water between the hulls, whose resonance is then too high; state it, `heavylift "
                "hull --gap-damping`"
            )
        elif hull and hull.beside and damping and damping.other:
            missing[f"gap damping beside {name}"] = (
                f"only waves damp another resonance of the water between the hulls, at {damping.other:.3g} rad/s, "
                "which is then too high"
            )
        for subject, note in ((x, y) for x, y in missing.items() if y):
            where = builder.source.where(("vessels", name))
            yield RatedLimit(subject=subject, quantity="inputs", unit="", note=note, where=where)


def _pulls(builder: SceneBuilder, name: str) -> dict[str, bool]:
    """Return the forces of mechanisms on a vessel of which the response of a given motion knows nothing."""
    found = (f for m in builder.machines if m.name != name for f in m.system.forces if not isinstance(f, MooringLine))
    others = (f for f in found if not (isinstance(f, Spring) and not f.d))
    return {f.name: True for f in others if name in [point.body for point in f.points]}


def _splashes(builder: SceneBuilder, hooks: Sequence[RatedLimit]) -> Iterator[RatedLimit]:
    """Yield the limits of blocks in the splash zone: of slack slings, and of the load on each hook."""
    for machine in builder.machines:
        for cargo in (x for x in machine.cargo if hooks and builder.scene.all_blocks[x.body].splash):
            where = builder.source.where((*(("block",) if cargo.body == "block" else ("blocks", cargo.body)), "splash"))
            yield RatedLimit(
                subject=cargo.body, quantity="slack sling", unit="", value=SLACK, elements=(cargo.body,), where=where,
                source=f"DNV-RP-N103: dynamic force upward over static weight in water; {ABOVE}",
            )  # fmt: skip
            for row in hooks:
                of = {"subject": f"{row.subject} in water", "elements": (*row.elements, cargo.body)}
                yield replace(row, quantity="splash load", source=f"{row.source}; {ABOVE}" if row.source else "", **of)


def _ropes(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits of ropes that the scene gives; a mechanism's rope without limit gets a row without value."""
    slings = {tie.rope for machine in builder.machines for tie in machine.ties}
    hooks = {hook.rope for machine in builder.machines for hook in machine.hooks}
    known = [rope.name for machine in builder.machines for rope in machine.system.all_ropes]
    moored = {x.name: x.breaking for machine in builder.machines for x in machine.system.mooring_lines if x.breaking}
    for name, breaking in ((k, x) for k, x in moored.items() if k not in builder.scene.limits.ropes):
        where = builder.source.where(("mechanism", "forces", name))
        yield RatedLimit(
            subject=name, quantity="rope tension", unit="N", elements=(name,), value=breaking / MOORED, factor=MOORED,
            breaking=breaking, source="assumed: API RP 2SK, quasi-static analysis, no line parted", where=where,
        )  # fmt: skip
    tugged = [x for machine in builder.machines for x in machine.system.tugger_lines if x.capacity]
    for x in (x for x in tugged if x.name not in builder.scene.limits.ropes):
        where = builder.source.where(("mechanism", "forces", x.name))
        yield RatedLimit(
            subject=x.name, quantity="rope tension", unit="N", elements=(x.name,), value=x.capacity, source="the scene",
            note=f"set to {x.tension / 1e3:.6g} kN{' at first' if x.rate else ''}", where=where,
        )  # fmt: skip
    strengths = {**moored, **{x.name: x.capacity for x in tugged}}
    rated = {*builder.scene.limits.ropes, *slings, *hooks, *moored, *(x.name for x in tugged)}
    for name in (name for name in known if name not in rated):
        where = builder.source.where(("mechanism", "ropes", name))
        note = "give it under 'limits: {ropes: ...}'"
        yield RatedLimit(subject=name, quantity="rope tension", unit="N", elements=(name,), note=note, where=where)
    for name, given in builder.scene.limits.ropes.items():
        path: Path = ("limits", "ropes", name)
        if name not in known:
            builder.source.fault(path, f"there is no rope '{name}'", closest(name, known), on_key=True)
        where, breaking = builder.source.where(path), given.breaking or 0.0
        common = {"subject": name, "unit": "N", "elements": (name,), "source": given.source, "where": where}
        most, factor = given.tension or breaking / given.factor, given.factor if breaking else 1.0
        claimed, own = max(most, breaking if name in moored else 0.0), strengths.get(name)
        if own and claimed > own * (1.0 + EXACT):
            message = f"{claimed / 1e3:.6g} kN is more than the {own / 1e3:.6g} kN of the line itself"
            builder.source.fault(path, message, "leave it out, or give no more", on_key=True)
        yield RatedLimit(quantity="rope tension", value=most, factor=factor, breaking=breaking, **common)  # type: ignore[arg-type]
        if given.partial_factor and breaking:
            most, factor = breaking / given.partial_factor, given.partial_factor
            yield RatedLimit(quantity="sling peak", value=most, factor=factor, breaking=breaking, **common)  # type: ignore[arg-type]


def _rig(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits of slings and lifting beams."""
    rig = builder.scene.rig
    if rig is None:
        return
    beams = builder.frames
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
            yield from sling_limits(builder, rig.sling, tie.rope, tie.where, ("rig", "sling"))
            yield bridle_limit(builder, tie.rope, tie.where, bent=tie.rope in bent)
            yield shackle_limit(builder, rig.shackle, tie.rope, ("rig", "shackle"))
