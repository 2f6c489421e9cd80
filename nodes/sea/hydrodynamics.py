"""The file of a hull's hydrodynamics: hydrostatics, added mass, radiation with the error of its fit, wave loads.

The file is JSON in SI units. Modes are surge, sway, heave, roll, pitch and yaw about the origin of the vessel, with x
to its bow, y to port, z up from the waterline at rest. A wave load is complex: a wave with the elevation cos(w t) at
the origin loads the hull with Re(X exp(i w t)) per metre of amplitude. Headings are the directions to which the waves
travel, relative to the bow.
"""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import pi

import msgspec
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import Matrix6, Row6, WaveSum
from heavylift.kernel.description.mechanics import Vector
from heavylift.kernel.errors import SceneError

from .spectra import Component, wave_number

VERSION = 1
GAP = 0.25 * pi  # [rad] between headings: a wider one hides how loads change
EXACTLY = 1e-6  # [rad, or of the size]: rounding of other codes
WORST = 0.05  # of the largest added mass or damping of a mode: a fit that misses more is refused
FINE = 0.5  # [rad] of the fastest component in a cubic piece: 2e-4 of its amplitude
SIDES = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0)  # how loads change where a wave comes from the other side of a symmetric hull


class FitError(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Largest errors of the fitted radiation model, relative to the largest added mass and damping of each mode."""

    added_mass: float
    damping: float


class RadiationStates(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The passive state-space model of the radiation force; see `Radiation` in the kernel."""

    F: tuple[tuple[float, ...], ...]
    G: tuple[Row6, ...]
    error: FitError


class WaveLoads(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Wave loads: frequencies [rad/s] and headings [rad], both in ascending order, and the real and imaginary parts of
    the loads, indexed by [heading][frequency]."""

    frequencies: tuple[float, ...]
    headings: tuple[float, ...]
    real: tuple[tuple[Row6, ...], ...]
    imaginary: tuple[tuple[Row6, ...], ...]


class MeanDrift(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Mean drift forces per square of wave amplitude: surge and sway [N/m2], yaw [N/m].

    Frequencies and headings are as in `WaveLoads`."""

    frequencies: tuple[float, ...]
    headings: tuple[float, ...]
    values: tuple[tuple[tuple[float, float, float], ...], ...]


class Hydrodynamics(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The hydrodynamics of a hull at one draught: hydrostatics, radiation and wave loads.

    `metacentres`: heights of the transverse and the longitudinal metacentre above the waterline [m]; `symmetric`: port
    and starboard are alike, so the headings cover only half a turn."""

    version: int
    name: str
    source: str
    density: float  # of the water [kg/m3]
    volume: float  # displaced [m3]
    waterplane: float  # [m2]
    metacentres: tuple[float, float]
    added_mass: Matrix6  # at infinite frequency
    radiation: RadiationStates
    loads: WaveLoads
    symmetric: bool = True
    depth: float | None = None  # of the water [m]; None: deep
    moments: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the waterplane: of x, of y [m3], and of x y [m4]
    buoyancy: Vector | None = None  # its centre [m]; None: below the centre of mass
    drift: MeanDrift | None = None
    beside: "SecondHull | None" = None

    def load(self, frequency: float, heading: float) -> list[complex]:
        """Return the wave loads X [N/m, N] at a frequency and heading; zero above the highest frequency in the file.

        They are interpolated linearly as complex numbers; below the lowest frequency, the loads at the lowest one are
        used.
        """
        of = self.loads
        mirrored, corners = _corners(of, frequency, heading)
        if frequency > of.frequencies[-1]:
            return [0j] * 6
        parts = [(of.real[m][n], of.imaginary[m][n], share) for m, n, share in corners]
        found = [complex(sum(s * x[j] for x, _, s in parts), sum(s * y[j] for _, y, s in parts)) for j in range(6)]
        return [side * x for side, x in zip(SIDES, found, strict=True)] if mirrored else found

    def drifting(self, frequency: float, heading: float) -> list[float]:
        """Return the mean drift in surge, sway and yaw at a frequency and heading, interpolated linearly; outside the
        range of frequencies, the drift at the nearest frequency."""
        assert self.drift
        mirrored, corners = _corners(self.drift, frequency, heading)
        found = [sum(share * self.drift.values[m][n][j] for m, n, share in corners) for j in range(3)]
        return [found[0], -found[1], -found[2]] if mirrored else found


class GapDamping(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Damping ratio added to the resonance of the water between two hulls, resonance frequency [rad/s], source of the
    ratio, and frequency of another resonance with a similar peak and less damping than the ratio, if any."""

    ratio: float
    frequency: float
    source: str
    other: float | None = None


class SecondHull(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A second hull near the first one, with the hydrodynamics of both in each other's waves.

    The data are its own, of which G belongs to the states of the first hull, its place x, y [m] and heading [rad] in
    the axes of the first hull, and the added mass at infinite frequency that gives the momentum of the water about it
    for the motion of the first hull."""

    hull: Hydrodynamics
    at: tuple[float, float, float]
    added_mass: Matrix6
    damping: GapDamping | None = None


def one_sided(headings: Sequence[float]) -> bool:
    """Return whether the headings cover only one side of a symmetric hull."""
    return min(headings) >= 0.0 and max(headings) <= pi + EXACTLY


def _corners(of: WaveLoads | MeanDrift, frequency: float, heading: float) -> tuple[bool, list[tuple[int, int, float]]]:
    """Return whether a wave comes from the other side of a symmetric hull, and the indices of headings and
    frequencies to be interpolated, with their shares."""
    turned, half = heading - 2.0 * pi * round(heading / (2.0 * pi)), one_sided(of.headings)
    i, a = _between(of.headings, abs(turned) if half else turned)
    k, b = _between(of.frequencies, frequency)
    along = (i, 1.0 - a), (i + 1, a)
    pairs = [(m, n, x * y) for n, y in ((k, 1.0 - b), (k + 1, b)) for m, x in along]
    return half and turned < 0.0, pairs


def read_hydrodynamics(text: bytes, file: str) -> Hydrodynamics:
    """Return the hydrodynamics in a file; raises SceneError if it contains none or an inaccurate radiation fit."""
    try:
        found = msgspec.json.decode(text, type=Hydrodynamics)
    except msgspec.DecodeError as error:
        raise SceneError(f"{file} is not a file of a hull's hydrodynamics: {error}") from None
    if found.version != VERSION:
        raise SceneError(f"{file} has version {found.version}; this heavylift reads version {VERSION}")
    check(found, file)
    return found


def check(found: Hydrodynamics, file: str) -> None:
    """Raise SceneError unless a hull's tables are complete for all headings and its radiation fit is accurate."""
    tables: list[tuple[WaveLoads | MeanDrift, Sequence[Sequence[object]]]]
    tables = [(found.loads, found.loads.real), (found.loads, found.loads.imaginary)]
    for of, rows in [*tables, *([(found.drift, found.drift.values)] if found.drift else [])]:
        rising = all(b > a for row in (of.frequencies, of.headings) for a, b in pairwise(row))
        if not (rising and min(len(of.frequencies), len(of.headings)) > 1):
            raise SceneError(
                f"{file}: frequencies and headings of the loads must be in ascending order, at least two of each"
            )
        if [len(row) for row in rows] != [len(of.frequencies)] * len(of.headings):
            raise SceneError(f"{file}: the loads need one row for each heading and frequency")
        low = 0.0 if found.symmetric and one_sided(of.headings) else -pi
        widest = max(b - a for a, b in pairwise(of.headings))
        if of.headings[0] > low + EXACTLY or of.headings[-1] < pi - EXACTLY or widest > GAP + EXACTLY:
            raise SceneError(
                f"{file}: headings of loads or drift must cover 0 to 180 deg of a symmetric hull, or a full turn, with "
                f"gaps of at most {round(GAP * 180.0 / pi)} deg"
            )
    if found.depth is not None and not found.depth > 0.0:
        raise SceneError(f"{file}: the depth of the water must be positive, not {found.depth:g} m")
    if found.beside:
        check(found.beside.hull, file)
    others = [found.beside.hull.radiation] if found.beside else []
    if any(len(x.G) != len(found.radiation.F) for x in (found.radiation, *others) if found.radiation.F):
        raise SceneError(f"{file}: G of the radiation states needs one row for each row of F")
    worst = max(found.radiation.error.added_mass, found.radiation.error.damping)
    if worst > WORST:
        raise SceneError(
            f"{file}: the error of the radiation fit is {worst:.1%} of the largest coefficient, more than {WORST:.0%}; "
            "use finer panels and a lid, or leave out the frequencies of waves too short for the panels"
        )


def _between(places: Sequence[float], x: float) -> tuple[int, float]:
    """Return the index of the interval of ascending places that contains x, and the fraction (0 to 1) of x in it."""
    i = min(max(bisect_right(places, x) - 1, 0), len(places) - 2)
    return i, min(max((x - places[i]) / (places[i + 1] - places[i]), 0.0), 1.0)


def loads_in_sea(
    hull: Hydrodynamics,
    sea: Sequence[Component],
    at: tuple[float, float],
    bow: float,
    gravity: float,
    ramp: float,
    depth: float | None = None,
) -> list[WaveSum]:
    """Return the six wave loads of a sea on a hull whose bow points in the direction `bow` [rad].

    They are followed by the drift loads in surge, sway and yaw if the hull has drift data.

    `at`: position of the hull's origin relative to the origin of the waves' phases [m]; `depth`: of the water [m], None
    for deep water. Slow drift is Newman's approximation (Journal of Ship Research 18 (1974) 47-53): the mean of the
    drifts D_i and D_j of two waves acts at the difference of their frequencies, together the real part of sum a_i D_i
    exp(i phase_i) times the conjugate of sum a_j exp(i phase_j).
    """
    n = 9 if hull.drift else 6
    sums: list[tuple[list[float], list[float]]] = [([], []) for _ in range(n + 1)]  # the last: the elevation
    for w, size, to, phase in sea:
        k = wave_number(w, gravity, depth)
        angle = phase - k * (at[0] * float(cos(to)) + at[1] * float(sin(to)))
        c, s = float(cos(angle)), float(sin(angle))
        found = hull.load(w, to - bow) + ([complex(x) for x in hull.drifting(w, to - bow)] if hull.drift else [])
        for X, (cosines, sines) in zip([*found, 1.0 + 0j], sums, strict=True):
            cosines.append(size * (X.real * c - X.imag * s))
            sines.append(-size * (X.real * s + X.imag * c))
    frequencies = tuple(x.frequency for x in sea)
    piece = FINE / max(frequencies)
    *pairs, elevation = [(tuple(a), tuple(b)) for a, b in sums]
    return [WaveSum(frequencies, *x, ramp, piece, ((), ()) if i < 6 else elevation) for i, x in enumerate(pairs)]
