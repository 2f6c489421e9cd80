"""Vessels as machines: on six prescribed joints that follow the wave, or as a free body in water.

The buoyancy of a free vessel balances the weight on it at the start, acting at the common centre of mass, so the vessel
floats on an even keel with the hydrostatic stiffness given by GM; loads lifted from it or hung on it make it rise, sink
and heel.
"""

from dataclasses import replace

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import Bushing, InputSignal, Load, Matrix6, Radiation, Stream, Wave, WaveSum
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Point, SharedWater, System, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_description
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.shapes import HULL
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder, box
from heavylift.nodes.scene.keys.environment import Floating, Vessel, Waves
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.rigging import Frame
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path
from heavylift.nodes.sea.prescribed import MODES, carried
from heavylift.nodes.sea.spectra import wave_number

from .hulls import check_draught, hull_of_vessel, modal_load, radiation, restoring, wave_loads

MOST = 0.02  # of its displacement may be a load, where its motion is given


def vessel_machine(builder: SceneBuilder, name: str) -> plan.Mechanism:
    """Return a vessel with its motion as a machine; errors are added to the scene."""
    given, source = builder.scene.vessels[name], builder.source
    (xx, yy, zz, xy, xz, yz) = (*(given.inertia or box(given.mass, given.size)), 0.0, 0.0, 0.0)[:6]
    body = Body(name, given.mass, given.com, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    if given.floating is None:
        system = _carried(builder, name, given, body)
    else:
        hull = hull_of_vessel(builder, name)
        added, beside = hull.added_mass if hull else given.floating.added_mass, given.floating.beside
        pair = hull_of_vessel(builder, beside) if beside else None
        shared = SharedWater(beside, pair.beside.added_mass) if pair and pair.beside else None
        system = _free(given, added, replace(body, shared=shared))
    try:
        check_description(system)
    except KernelError as error:
        source.fault(("vessels", name), str(error), on_key=True)
    middle = (0.0, 0.0, 0.5 * given.size[2] - given.draught)
    shape = plan.Shape(body=name, centre=middle, size=given.size, part=HULL)
    return plan.Mechanism(name=name, system=system, shapes=(shape,), where=source.where(("vessels", name)))


def _carried(builder: SceneBuilder, name: str, given: Vessel, body: Body) -> System:
    """Return a vessel on six prescribed joints in series: surge, sway, heave, yaw, pitch, roll."""
    if builder.scene.waves and builder.scene.waves.seas:
        message = "responses are those to one regular wave, and the scene has irregular seas"
        builder.source.fault(("vessels", name, "motion"), message, "write 'motion: forces' with 'hydrodynamics'")
    waves, motions = builder.scene.waves, dict[str, Wave | WaveSum | None]()
    for mode in MODES:
        size, phase = getattr(given.responses, mode)
        motions[mode] = _wave(waves, size, phase - _delay(builder, waves, given.at)) if waves else None
    return carried(body, given.at, given.attitude, motions, builder.scene.gravity)


def _free(given: Vessel, added: Matrix6 | None, body: Body) -> System:
    """Return a vessel on a free joint; `afloat` adds the water forces."""
    half = 0.5 * given.heading
    q0 = (*given.at, 0.0, 0.0, float(sin(half)), float(cos(half)))
    free = Joint(f"{body.name}.free", "free", WORLD, body.name, q0=q0, v0=(0.0,) * 6)
    return System((replace(body, added=added),), (free,))


def _wave(waves: Waves, response: float, phase: float) -> Wave:
    """Return the motion or load with which a vessel responds to the regular wave; `response`: amplitude per wave
    amplitude, `phase` [rad]."""
    amplitude, frequency = waves.regular
    return Wave(amplitude * response, frequency, waves.ramp, phase)


def _delay(builder: SceneBuilder, waves: Waves, at: Vector) -> float:
    """Return the phase lag [rad] of the wave at a place relative to the world's origin."""
    w, gravity = waves.regular[1], builder.scene.gravity
    x, y = (a - b for a, b in zip(at[:2], waves.origin[:2], strict=True))
    distance = x * float(cos(waves.heading)) + y * float(sin(waves.heading))
    return wave_number(w, gravity, waves.depth) * distance if gravity and w else 0.0


def check_decks(builder: SceneBuilder) -> None:
    """Add an error for each block that stands on a vessel that does not exist."""
    scene = builder.scene
    for name, block in scene.all_blocks.items():
        base: Path = ("block",) if block is scene.block else ("blocks", name)
        if block.on not in (WORLD, *scene.vessels):
            message = f"there is no vessel '{block.on}'"
            builder.source.fault((*base, "on"), message, closest(block.on, [WORLD, *scene.vessels]))


def afloat(builder: SceneBuilder, built: list[plan.Mechanism], around: System) -> list[plan.Mechanism]:
    """Return the machines, with water forces added to the floating vessels. Add an error for a load that is too heavy
    for a vessel with prescribed motion."""
    out = []
    for machine in built:
        given = builder.scene.vessels.get(machine.name)
        if given is not None:
            weighed = _standing(builder, machine.name, around)
            if given.floating is None or builder.scene.fidelity.water == "motion given":
                _check_load(builder, machine.name, sum(mass for mass, _ in weighed[0]), built)
            if given.floating is not None:
                forces = _water(builder, machine.name, given, given.floating, [*weighed[0], *weighed[1]])
                machine = msgspec.structs.replace(machine, system=replace(machine.system, forces=forces))
        out.append(machine)
    return out


Masses = list[tuple[float, Vector]]  # each with its place in the world


def _standing(builder: SceneBuilder, name: str, around: System) -> tuple[Masses, Masses]:
    """Return (mass, centre of mass) of a vessel and of each body that joints carry on it, and the same for the blocks
    on its deck."""
    on, at = _bodies(name, around), kinematics.poses(around)
    masses = [(b.mass, kinematics.place(Point(b.name, b.com), at)) for b in around.bodies if b.name in on]
    blocks = [b for b in builder.scene.all_blocks.values() if b.on == name]
    vessel = builder.scene.vessels[name]
    own = [(b.mass, vessel.place([p + q for p, q in zip(b.at, b.com, strict=True)])) for b in blocks]
    return [(mass, (float(p[0]), float(p[1]), float(p[2]))) for mass, p in masses], own


def _bodies(name: str, around: System) -> set[str]:
    """Return the names of a vessel and of the bodies that joints carry on it."""
    on, more = {name}, True
    while more:
        found = {j.child for j in around.joints if j.parent in on}
        more, on = not found <= on, on | found
    return on


def _check_load(builder: SceneBuilder, name: str, displacement: float, built: list[plan.Mechanism]) -> None:
    """Add an error unless the loads on a vessel with prescribed motion are small compared with its displacement."""
    scene = builder.scene
    blocks = scene.all_blocks
    load = sum(block.mass for block in blocks.values() if block.on == name)
    built = [*builder.machines, *built]
    around = System(joints=tuple(j for machine in built for j in machine.system.joints))
    on = _bodies(name, around)
    lines = [line for machine in built for hook in machine.hooks for r in machine.system.all_ropes for line in r.lines
             if r.name == hook.rope]  # fmt: skip
    if any(line.a.body in on for line in lines):
        load += sum(block.mass for block in blocks.values() if block.on != name)
        load += sum(frame.mass for frame in scene.rigging.values() if isinstance(frame, Frame))
        load += sum(b.mass for m in builder.machines if m.name in builder.hooks for b in m.system.bodies)
    if load > MOST * displacement:
        message = (
            f"a load of {load / 1e3:.6g} t is more than {MOST:.0%} of its displacement of {displacement / 1e3:.6g} t"
        )
        message += ", so its motion would not stay as it is given"
        free = scene.vessels[name].floating is not None
        remedy = "leave 'water: motion given' out" if free else "write 'motion: forces', or take a larger vessel"
        builder.source.fault(("fidelity", "water") if free else ("vessels", name, "motion"), message, remedy)


def _water(
    builder: SceneBuilder, name: str, given: Vessel, floating: Floating, standing: Masses
) -> tuple[Bushing | Load | Radiation | Stream, ...]:
    """Return the water forces on a free vessel: buoyancy, hydrostatics with mooring and damping, radiation, waves."""
    scene, waves = builder.scene, builder.scene.waves
    if not scene.gravity:
        builder.source.fault(
            ("gravity",), f"{name} floats, which needs gravity", "give it a motion, or leave gravity out"
        )
        return ()
    mass = sum(mass for mass, _ in standing)
    weight = scene.gravity * mass
    middle = [sum(mass * p[i] for mass, p in standing) * scene.gravity / weight - given.at[i] for i in range(3)]
    middle = product(list(zip(*given.attitude, strict=True)), middle)  # in the vessel
    moor, hull = floating.mooring, hull_of_vessel(builder, name)
    if hull:
        check_draught(builder, name, hull, mass, middle)
        upright = restoring(hull, scene.gravity, weight, middle[2])
    else:
        density = waves.density if waves else Waves.model_fields["density"].default
        area, GM, GML = (x or 0.0 for x in (floating.waterplane, floating.GM, floating.GML))
        upright = [[density * scene.gravity * area, 0.0, 0.0], [0.0, weight * GM, 0.0], [0.0, 0.0, weight * GML]]
    moored = (moor.surge, moor.sway, 0.0, 0.0, 0.0, moor.yaw)
    K = [[k if i == j else 0.0 for j in range(6)] for i, k in enumerate(moored)]
    for row, of in zip(K[2:5], upright, strict=True):
        row[2:5] = of
    stiffness = tuple(map(tuple, K))
    damping: Matrix6 = floating.damping or ((0.0,) * 6,) * 6
    up = Load(f"{name}.buoyancy", Point(name, (middle[0], middle[1], middle[2])), (0.0, 0.0, weight))
    keel = Point(WORLD, given.at), Point(name)
    water = Bushing(f"{name}.water", *keel, stiffness, damping, given.attitude)  # type: ignore[arg-type]
    streams = _streams(builder, name, floating)
    if hull:
        loads = wave_loads(builder, name, hull, given, waves) if waves else []
        return (up, water, *radiation(builder, name, hull), *loads, *streams)
    if waves and waves.seas:
        message = "loads of one regular wave are given, and the scene has irregular seas"
        builder.source.fault(("vessels", name, "floating"), message, "name a file with its 'hydrodynamics'")
    return (up, water, *(_wave_loads(builder, name, given, floating, waves) if waves else ()), *streams)


def _streams(builder: SceneBuilder, name: str, floating: Floating) -> list[Stream]:
    """Return the forces of current and wind on a free vessel by its coefficients."""
    found, scene, (current, wind) = [], builder.scene, (builder.scene.current, builder.scene.wind)
    if current and floating.current:
        direction = (float(cos(current.heading)), float(sin(current.heading)), 0.0)
        steady = InputSignal(current.speed)
        found.append(floating.current.stream(name, "current", direction, steady, current.density))
    elif current:
        message = "the scene has a current, and the vessel has no coefficients for it"
        builder.source.fault(("vessels", name, "floating"), message, "write 'current: {area, length, coefficients}'")
    if wind and floating.wind and name in wind.on:
        message = f"the wind on {name} counts twice, by these sides and by 'floating: {{wind: ...}}'"
        builder.source.fault(("wind", "on", name), message, "leave one of them out", on_key=True)
    if wind and floating.wind:
        times, speeds = zip(*h, strict=True) if (h := wind.history(scene.seed, scene.end)) else ((), ())
        found.append(
            floating.wind.stream(name, "wind", wind.direction, InputSignal(wind.speed, times, speeds), wind.density)
        )
    return found


def _wave_loads(builder: SceneBuilder, name: str, given: Vessel, floating: Floating, waves: Waves) -> list[Load]:
    """Return the loads of the regular wave on a vessel in its six modes."""
    delay, each = _delay(builder, waves, given.at), [getattr(floating.loads, mode) for mode in MODES]
    signals = [InputSignal(0.0, wave=_wave(waves, size, phase - delay)) for size, phase in each]
    return [modal_load(f"{name}.{MODES[i]} wave", name, i, given, x) for i, x in enumerate(signals)]
