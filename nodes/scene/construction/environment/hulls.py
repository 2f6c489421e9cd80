"""Free vessels with hydrodynamics from a file: hydrostatics, radiation forces with memory, and wave loads."""

from collections.abc import Sequence
from itertools import accumulate
from math import pi, sqrt

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.description.forces import InputSignal, Load, Radiation, Wave, WaveSum
from heavylift.kernel.description.mechanics import Point, Vector
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.environment import Vessel, Waves
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.files import content, within
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea.hydrodynamics import Hydrodynamics, loads_in_sea, read_hydrodynamics
from heavylift.nodes.sea.prescribed import MODES, one_wave
from heavylift.nodes.sea.spectra import Component, wave_number

LARGEST = 1 << 24  # of a file [bytes]
SHALLOW = 0.02  # of the length of waves, by which the depth may change it on the average
DRIFTS = (0, 1, 5)  # modes
LEVEL = 0.02  # [rad]: by which it may heel or trim
OUTSIDE = 0.05  # of the energy of waves, at frequencies that the data of a hull do not have
PLACE = 0.01  # of the distance, or [rad]: by which it may lie elsewhere than in its data
AFLOAT = 0.02  # of the displacement, by which the weight may differ from that of the file


def hull_of_vessel(builder: SceneBuilder, name: str) -> Hydrodynamics | None:
    """Return the hydrodynamic data of a vessel, reading their file only once; None without data or after an error."""
    vessel = builder.scene.vessels.get(name)
    if name not in builder.hulls and vessel and (of := vessel.floating):
        found = _hydrodynamics_of(builder, name, of.hydrodynamics) if of.hydrodynamics else None
        builder.hulls[name] = _second(builder, name, of.beside) if of.beside else found
        count = [x.floating.beside for x in builder.scene.vessels.values() if x.floating].count(name)
        if found and found.beside and count != 1:
            message = f"its data are of two hulls near each other, and {count} vessels are 'beside: {name}'"
            remedy = f"write 'floating: {{beside: {name}}}' at the other vessel, or compute data of this hull alone"
            builder.source.fault(("vessels", name, "floating", "hydrodynamics"), message, remedy)
    return builder.hulls.get(name)


def _second(builder: SceneBuilder, name: str, beside: str) -> Hydrodynamics | None:
    """Return the data of a vessel that is the second hull in the file of another vessel; after an error, None."""
    at, vessels = ("vessels", name, "floating", "beside"), builder.scene.vessels
    if beside not in vessels or beside == name:
        builder.source.fault(at, f"there is no other vessel '{beside}'", closest(beside, [*vessels]))
        return None
    first, given = vessels[beside], vessels[name]
    alone = first.floating is None or first.floating.beside
    hull = None if alone else hull_of_vessel(builder, beside)
    if hull is None or hull.beside is None:
        message = f"the data of {beside} are not those of two hulls"
        builder.source.fault(at, message, "compute both together, or give this vessel its own 'hydrodynamics'")
        return None
    x, y, heading = hull.beside.at
    where = first.place((x, y, 0.0))
    away = max(abs(a - b) for a, b in zip(where, given.at, strict=True))
    turned = given.heading - first.heading - heading
    turned -= 2.0 * pi * round(turned / (2.0 * pi))
    if away > PLACE * sqrt(x * x + y * y) or abs(turned) > PLACE:
        angle = (first.heading + heading) * 180.0 / pi
        message = f"its data are for the place [{', '.join(f'{p:.6g} m' for p in where)}] and heading {angle:.6g} deg"
        builder.source.fault(("vessels", name, "at"), message, "place it there, or compute data for its own place")
    return hull.beside.hull


def _hydrodynamics_of(builder: SceneBuilder, name: str, file: str) -> Hydrodynamics | None:
    """Return the hydrodynamic data in a vessel's file; if the file cannot be read, add an error to the scene and return
    None."""
    source, at = builder.source, ("vessels", name, "floating", "hydrodynamics")
    known = {path.stem: path for path in sorted(vessels_folder().glob("*.json"))}
    try:
        path = known[file] if file in known else within(source.root, source.root / file)
        return read_hydrodynamics(content(path, LARGEST), file)
    except FileNotFoundError:
        there = ", ".join(known)
        source.fault(
            at, f"there is no file '{file}' beside the scene, and no bundled hull of this name", f"there are {there}"
        )
    except (OSError, ValueError, SceneError) as error:
        source.fault(at, getattr(error, "strerror", None) or str(error))
    return None


def check_draught(builder: SceneBuilder, name: str, hull: Hydrodynamics, mass: float, centre: Sequence[float]) -> None:
    """Add an error unless a loaded vessel floats upright at the draught of its hydrodynamic file.

    `mass` [kg] and `centre` [m]: of the vessel and all that stands on it, relative to the vessel."""
    displaced = hull.density * hull.volume
    if abs(mass - displaced) > AFLOAT * displaced:
        message = (
            f"it weighs {mass / 1e3:.6g} t with all that stands on it, and its hull displaces {displaced / 1e3:.6g} t"
        )
        builder.source.fault(("vessels", name, "mass"), message, "change its ballast, or take data of another draught")
    heights = [z - centre[2] for z in hull.metacentres]
    for turn, GM in (x for x in zip(("roll", "pitch"), heights, strict=True) if x[1] <= 0.0):
        message = f"with all that stands on it, it is not stable in {turn}: GM is {GM:.3g} m"
        builder.source.fault(("vessels", name, "com"), message, "lower its centre of mass")
    if hull.buoyancy and min(heights) > 0.0:
        ahead, port = (centre[i] - hull.buoyancy[i] for i in (0, 1))
        across, along = heights
        if abs(port) > LEVEL * across or abs(ahead) > LEVEL * along:
            message = (
                f"with all that stands on it, it is {ahead:.3g} m ahead and {port:.3g} m to port of its centre of "
            )
            message += f"buoyancy: more than {LEVEL:.0%} of its metacentric height, so it would not float level"
            builder.source.fault(("vessels", name, "com"), message, "move its ballast")


def check_depth(
    builder: SceneBuilder, name: str, hull: Hydrodynamics, sea: list[Component], depth: float | None
) -> None:
    """Add an error if wave lengths at this water depth [m] differ from those at the depth assumed in a hull's file."""
    if depth == hull.depth:
        return
    theirs, own = (
        sum(x.amplitude * x.amplitude * wave_number(x.frequency, builder.scene.gravity, h) for x in sea)
        for h in (hull.depth, depth)
    )
    ratio = theirs / own
    if abs(ratio - 1.0) > SHALLOW:
        there, here = (f"water {x:g} m deep" if x else "deep water" for x in (hull.depth, depth))
        message = f"its data are for {there}; on {here} the waves are {ratio:.3g} times as long"
        at = ("vessels", name, "floating", "hydrodynamics")
        builder.source.fault(at, message, "compute it for this depth: `heavylift hull --depth`")


def check_energy(builder: SceneBuilder, name: str, hull: Hydrodynamics, sea: list[Component]) -> None:
    """Add an error if too much wave energy is at frequencies that a hull's data do not cover."""
    least, most = hull.loads.frequencies[0], hull.loads.frequencies[-1]
    energy = sum(x.amplitude * x.amplitude for x in sea)
    share = sum(x.amplitude * x.amplitude for x in sea if not least <= x.frequency <= most) / energy
    if share > OUTSIDE:
        rising, tail = sorted(sea), 0.5 * OUTSIDE * energy
        sums = list(accumulate((x.amplitude * x.amplitude for x in rising), initial=0.0))
        needed = [
            x.frequency for x, a, b in zip(rising, sums, sums[1:], strict=False) if b > tail and a < energy - tail
        ]
        message = f"{share:.0%} of the energy of the waves is outside its data from {least:.3g} to {most:.3g} rad/s, "
        message += f"more than {OUTSIDE:.0%}; data from {needed[0]:.3g} to {needed[-1]:.3g} rad/s would be enough"
        at = ("vessels", name, "floating", "hydrodynamics")
        builder.source.fault(at, message, "compute it with finer panels")


def restoring(hull: Hydrodynamics, gravity: float, weight: float, height: float) -> list[list[float]]:
    """Return the hydrostatic stiffness (3, 3) of a floating body in heave [N/m], roll and pitch [N m].

    `weight` [N]; `height` [m]: of the centre of mass above the waterline."""
    across, along = (weight * (metacentre - height) for metacentre in hull.metacentres)
    water = hull.density * gravity
    x, y, xy = (water * moment for moment in hull.moments)
    return [[water * hull.waterplane, y, -x], [y, across, -xy], [-x, -xy, along]]


def radiation(builder: SceneBuilder, name: str, hull: Hydrodynamics) -> list[Radiation]:
    """Return the radiation force law of a vessel's hull, coupled with a second hull beside it, if any.

    The list is empty for the second hull, which is part of the law of the first one."""
    vessels = builder.scene.vessels
    floating = {key: x.floating for key, x in vessels.items() if x.floating}
    if floating[name].beside:
        return []
    alone = Radiation(f"{name}.radiation", Point(name), hull.radiation.F, hull.radiation.G, vessels[name].attitude)
    second = next((key for key, x in floating.items() if x.beside == name), "")
    if not hull.beside or not second:
        return [alone]
    rows, R = hull.beside.hull.radiation.G, vessels[second].attitude
    return [msgspec.structs.replace(alone, beside=Point(second), G_beside=rows, R_beside=R)]


def wave_loads(builder: SceneBuilder, name: str, hull: Hydrodynamics, vessel: Vessel, waves: Waves) -> list[Load]:
    """Return the wave loads and drift loads on a vessel, along and about the axes of the vessel at rest."""
    away = (vessel.at[0] - waves.origin[0], vessel.at[1] - waves.origin[1])
    amplitude, frequency = waves.regular
    regular = [Component(frequency, amplitude, waves.heading, 0.0)] if amplitude else []
    sea = regular or waves.harmonics(builder.scene.seed)
    check_depth(builder, name, hull, sea, waves.depth)
    check_energy(builder, name, hull, regular or waves.bands())
    if "density" in waves.model_fields_set and waves.density != hull.density:
        message = f"the water of {name}'s data has {hull.density:g} kg/m3, not {waves.density:g}"
        builder.source.fault(("waves", "density"), message, "leave it out, or compute data for it")
    sums = loads_in_sea(hull, sea, away, vessel.heading, builder.scene.gravity, waves.ramp, waves.depth)
    signals = [_alone(x) if regular else InputSignal(0.0, waves=x) for x in sums]
    named = [(f"{name}.{mode} wave", i) for i, mode in enumerate(MODES)]
    named += [(f"{name}.{MODES[i]} drift", i) for i in DRIFTS[: len(signals) - 6]]
    return [modal_load(label, name, i, vessel, signal) for (label, i), signal in zip(named, signals, strict=True)]


def _alone(x: WaveSum) -> InputSignal:
    """Return the signal of a sum that has only one harmonic, or of the product of two."""
    c, s = x.cosines[0], x.sines[0]
    if x.by[0]:
        return InputSignal(0.0, wave=Wave(c * x.by[0][0] + s * x.by[1][0], 0.0, x.ramp))
    return InputSignal(0.0, wave=one_wave(x.frequencies[0], c, s, x.ramp))


def modal_load(label: str, name: str, mode: int, vessel: Vessel, signal: InputSignal) -> Load:
    """Return a load of 1 N or 1 N m times a signal in a mode of a vessel, along or about its axes at rest."""
    unit = [1.0 if i == mode % 3 else 0.0 for i in range(3)]
    x, y, z = product(vessel.attitude, unit)
    along: Vector = (x, y, z)
    zero = (0.0, 0.0, 0.0)
    return Load(label, Point(name), along if mode < 3 else zero, along if mode > 2 else zero, signal=signal)
