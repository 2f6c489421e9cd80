"""What slings and shackles may carry by published standards: one row per termination, number of legs or standard.

Two ways of EN 13414-1, never multiplied: legs that are bought as one assembly carry its working load limit together;
legs that are chosen singly each carry their own, with a skew load factor where four hold one rigid load.
"""

from __future__ import annotations

from math import radians, sqrt
from typing import NamedTuple

from .standards import ND_0027, SHARING, SUCCESSOR, partial_factor

EN_13414 = "EN 13414-1"
ZP = 5.0  # working coefficient of wire ropes
LARGEST_LEG, LARGEST_ROPE = 42e3, 0.060  # where its tables end [kg, m]
ENDS = f"the table of {EN_13414} ends at 60 mm and 42 t a leg"
FERRULE = "a ferrule, assumed"
ROUNDED = 0.02  # by which its tables round
KL = {2: ((45.0, 1.4), (60.0, 1.0)), 3: ((45.0, 2.1), (60.0, 1.5)), 4: ((45.0, 2.1), (60.0, 1.5))}  # legs: up to [deg]
YARD_WEAR = 1.2  # 0027/ND, 7.9.4, unless slings are shown to be good
GROMMET = 2.0  # 0027/ND, 7.2.3: straight, half of what is quoted counts
BENT = 2.0  # of its diameters: over less no eye of EN 13414-1 bends
STRAIGHT = 4.0  # D/d from which a hand splice is worse than the bend
EN_13889, LARGEST_SHACKLE = "EN 13889", 25e3  # its shackles end there [kg]


class Termination(NamedTuple):
    """KT of EN 13414-1, if applicable, and the factor of 0027/ND 7.7.1."""

    kt: float | None
    factor: float


TERMINATIONS = {
    "ferrule": Termination(0.9, 1.12),
    "aluminium ferrule": Termination(0.9, 2.0),
    "spliced": Termination(0.8, 1.25),
    "resin": Termination(None, 1.0),
    "swaged": Termination(None, 1.0),
    "cable-laid splice": Termination(None, 1.33),
    "grommet": Termination(None, 1.0),
}
SOCKETS = ("resin", "swaged")  # whose pins bend no rope
CABLE_LAID = ("cable-laid splice", "grommet")
UNREAD = "to be confirmed (EN 13414-3, IMCA M 179: no clause was read): give its 'WLL' and the 'standard' of its gear"


class Terms(NamedTuple):
    """Known properties of a sling: breaking force [N], WLL of one leg [kg], diameters of rope and pins [m]."""

    breaking: float
    WLL: float | None = None
    source: str = ""  # of its working load limit
    termination: str | None = None
    diameter: float | None = None
    pin: float | None = None
    wear: float | None = None
    chosen: bool = True  # somebody has written the breaking force
    single: bool = False  # its legs are chosen singly, and four of them hold one rigid load


class Rated(NamedTuple):
    """Required ratio of breaking force to load with its source, and notes for the planner."""

    factor: float
    source: str
    note: str = ""


def at_rest(x: Terms, gravity: float) -> Rated:
    """Safety factor of one leg at rest."""
    if x.WLL:
        return _skewed(x, Rated(x.breaking / (x.WLL * gravity), x.source or "its working load limit in the scene"))
    known = TERMINATIONS[x.termination or "ferrule"]
    if known.kt is None:
        peak = in_a_run(x)
        return Rated(peak.factor, peak.source, "what its largest tension may be, so the least that is asked at rest")
    heavy = (x.diameter or 0.0) > LARGEST_ROPE or x.breaking * known.kt / ZP > LARGEST_LEG * gravity * (1.0 + ROUNDED)
    if heavy and not x.termination:
        return _skewed(x, Rated(ZP, f"assumed: {ENDS}", "give 'termination' or 'WLL'"))
    force, end = _force(x), x.termination or FERRULE
    message = f"{EN_13414}, Fmin = {force}, Zp = {ZP:g}, KT = {known.kt:g} of {end}"
    if heavy:
        message = f"{message}, assumed: {ENDS}"
    if x.pin and x.diameter and x.pin < BENT * x.diameter:
        message = f"{message}, assumed: its eyes bend over less than {BENT:g} d"
    return _skewed(x, Rated(ZP / known.kt, message))


def _skewed(x: Terms, rated: Rated) -> Rated:
    """The same with the skew load of four individually chosen legs."""
    if not x.single:
        return rated
    skew = SHARING["four slings"]
    note = f"legs chosen singly: skew load factor {skew.factor:g} ({skew.source}, matched pairs within +-2 d)"
    return Rated(rated.factor * skew.factor, rated.source, "; ".join(filter(None, (rated.note, note))))


def in_a_run(x: Terms) -> Rated:
    """Safety factor for the peak tension in a run (0027/ND, 7.3 to 7.10)."""
    name = x.termination or "spliced"
    bend = bending(x.pin / x.diameter) if x.pin and x.diameter and name not in SOCKETS else 1.0
    reduced = max(TERMINATIONS[name].factor, bend)
    wear = x.wear or YARD_WEAR
    whole = GROMMET if name == "grommet" else 1.0
    factor = partial_factor(termination=reduced, wear=wear) * whole
    end = f"{'hand splice' if name == 'spliced' else name}{'' if x.termination else ' assumed'}"
    pins = f", bent over {x.pin / x.diameter:.3g} d" if x.pin and x.diameter else f", pins of {STRAIGHT:g} d assumed"
    pins = "" if name in SOCKETS else pins
    message = f"{ND_0027}, 7.3.1: {_force(x)} over 1.3 x 1.3 x 1.5 x {reduced:.4g} ({end}{pins}) x {wear:g}"
    half = f" x {whole:g} (of a grommet half its quoted force counts, 7.2.3)" if whole > 1.0 else ""
    return Rated(factor, f"{message} (wear){half}, {factor:.4g}; {SUCCESSOR}")


def _force(x: Terms) -> str:
    return f"{x.breaking / 1e3:g} kN{'' if x.chosen else ' assumed'}"


def bending(ratio: float) -> float:
    """Bending factor of a sling around a pin with this ratio of diameters, at least 1 (0027/ND, 7.8.1)."""
    return 1.0 / (1.0 - 0.5 / sqrt(max(ratio, 1.0)))


def assembly(x: Terms, legs: int, gravity: float) -> tuple[tuple[tuple[float, float], ...], str] | None:
    """WLL of an assembly of legs as (angle to the vertical [rad], mass [kg]) with its terms; None if no standard
    applies."""
    rated = at_rest(x._replace(single=False), gravity)
    if legs not in KL or x.WLL or TERMINATIONS[x.termination or "ferrule"].kt is None or rated.note:
        return None
    leg = x.breaking / rated.factor / gravity
    chart = tuple((radians(angle), factor * leg) for angle, factor in KL[legs])
    factors = " and ".join(f"{factor:g} up to {angle:g} degrees" for angle, factor in KL[legs])
    shared = " (three carry)" if legs == 4 else ""
    return chart, f"{rated.source}; an assembly of {legs} legs: KL = {factors}{shared}"


def shackle(WLL: float, standard: str) -> str:
    """Remark on a shackle of a WLL [kg] and a standard; "" if it is plausible."""
    if standard.startswith(EN_13889) and WLL > LARGEST_SHACKLE:
        return f"{EN_13889} ends at {LARGEST_SHACKLE / 1e3:g} t, assumed: RR-C-271 or its maker's certificate counts"
    return "EN 1677 is for hooks, links and components, assumed" if standard.startswith("EN 1677") else ""
