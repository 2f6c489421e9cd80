"""Factors of published standards, each with the name and clause of its source.

ISO 4308-1 is withdrawn and replaced by ISO 16625; crane ropes are still chosen by its factors. 0027/ND (GL Noble
Denton) rev 11.2 of 2016 was continued as DNVGL-ST-N001 and DNV-ST-N001.

Allowed loads of slings and shackles by published standards: one row for each termination, number of legs or standard.

EN 13414-1 has two methods, which are never combined: legs bought as one assembly carry its working load limit together;
legs chosen singly carry each their own, with a skew load factor if four hold one rigid load.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import prod, radians, sqrt
from typing import Literal, NamedTuple, TypeAlias

from heavylift.nodes.plan.limit import Quantity, RatedLimit

ISO_4308 = "ISO 4308-1 (withdrawn for ISO 16625), Zp of running ropes"
ND_0027 = "0027/ND rev 11.2"
SUCCESSOR = "its successor is DNV-ST-N001"
ROPE_FACTORS = {"M1": 3.15, "M2": 3.35, "M3": 3.55, "M4": 4.0, "M5": 4.5, "M6": 5.6, "M7": 7.1, "M8": 9.0}  # running
SLINGS = "EN 13414-1, working coefficient 5"

DAF_MOST = (100e3, 300e3, 1000e3, 2500e3, float("inf"))  # up to [kg]
DAF = {  # by place, for each of them; up to the first one a + b sqrt(100 t / mass)
    "onshore": ((1.10, 0.0), 1.05, 1.05, 1.03, 1.03),
    "inshore": ((1.07, 0.05), 1.12, 1.10, 1.08, 1.05),
    "offshore": ((1.0, 0.25), 1.25, 1.20, 1.15, 1.10),
}
LIGHTEST = 3e3  # what is lighter counts as that [kg]

# 7.4 to 7.10: load, consequence, hand splice of a wire rope, wear in a yard, material of a certified wire rope, twist
RIGGING = {"load": 1.3, "consequence": 1.3, "termination": 1.25, "wear": 1.2, "material": 1.5, "twist": 1.0}
LEAST = 2.3  # 7.3.1: the product is not below this times termination, wear and twist

# EN 13001-2, partial safety factors: hoist load in combinations A; EN 13001-3-2, clause 5: rope resistance factor
# 1.35 + 5 / ((D/d)^0.8 - 4), 2.07 at least, which it is from D/d = 20 on
RUNNING = {"load": 1.34, "rope resistance": 2.07}
RUNNING_SOURCE = "EN 13001-2 (1.34) and EN 13001-3-2, clause 5 (2.07), sheaves of D/d >= 20 assumed"

HOISTING = {"HC1": (1.05, 0.17), "HC2": (1.10, 0.34), "HC3": (1.15, 0.51), "HC4": (1.20, 0.68)}  # least, per m/s


@dataclass(frozen=True)
class Sharing:
    """A rigging whose slings share the load unequally, with the load factor that a standard requires for it."""

    when: str
    message: str
    factor: float  # most loaded over the mean
    source: str


TANDEM = {2: 1.20, 3: 1.33, 4: 1.50}  # cranes that are not synchronised: capacity over the share of each
TANDEM_SOURCE = "Queensland mobile crane code, 14.3.2"

SHARING = {
    "four slings": Sharing(
        "four matched slings to one rigid load", "1.25 on each diagonal in turn", 1.25, f"{ND_0027}, 5.6.12"
    ),
    "over a hook": Sharing("a sling doubled over a hook", "45:55", 1.1, f"{ND_0027}, 5.8.1"),
    "sliding": Sharing("a doubled sling that slides while upending", "32.5:67.5", 1.35, f"{ND_0027}, 5.8.2"),
    "greased sheave": Sharing("a doubled sling over a greased sheave", "49:51", 1.02, f"{ND_0027}, 5.8.3"),
}


def daf(place: str | None, mass: float) -> tuple[float, str] | None:
    """Return the dynamic amplification factor for a mass [kg] lifted onshore, inshore or offshore, and its source; None
    for any other place."""
    if place not in DAF:
        return None
    (a, b), *others = DAF[place]
    i = next(i for i, most in enumerate(DAF_MOST) if mass <= most)
    factor = others[i - 1] if i else a + b * sqrt(DAF_MOST[0] / max(mass, LIGHTEST))
    return factor, f"{ND_0027}, table 5-1, {place}"


def hoisting_factor(speed: float, hoisting_class: str) -> float:
    """Return phi_2 of EN 13001-2, 4.2.2.2: the dynamic factor for lifting a load off the ground.

    phi_2 = phi_2,min + beta_2 v_h, with the hook speed v_h [m/s]."""
    least, slope = HOISTING[hoisting_class]
    return least + slope * speed


def partial_factor(**given: float) -> float:
    """Return the required ratio of breaking force to largest sling tension, by the partial factors of 0027/ND 7.3.1."""
    each = RIGGING | given
    reduced = each["termination"] * each["wear"] * each["twist"]
    return max(each["load"] * each["consequence"] * each["material"] * reduced, LEAST * reduced)


@dataclass(frozen=True)
class Strength:
    """A strength requirement of a standard: the quantity may be at most the breaking force divided by `factor`.

    `own`: key of the scene that replaces the factor."""

    of: Literal["sling", "hoist rope"]
    quantity: Quantity
    factor: float
    source: str
    own: str = ""


STRENGTHS = (  # a limit by another standard is one row
    Strength("sling", "sling tension", 5.0, SLINGS, "factor"),
    Strength("sling", "sling peak", partial_factor(), f"{ND_0027}, 7.3.1, hand splice; {SUCCESSOR}", "partial_factor"),
    Strength("hoist rope", "rope peak", prod(RUNNING.values()), RUNNING_SOURCE, "rope_partial_factor"),
)


Own: TypeAlias = Mapping[str, tuple[float, str, str]]  # by key: a factor with its source and a note


def strength_limits(
    of: str, name: str, breaking: float, where: str, given: Own, note: str = ""
) -> Iterator[RatedLimit]:
    """Yield the strength limits of a sling or hoist rope, one for each standard.

    `breaking`: breaking force [N]; `given`: factors of the scene that replace those of the standard."""
    for row in (row for row in STRENGTHS if row.of == of):
        factor, source, more = given.get(row.own) or (row.factor, row.source, note)
        yield RatedLimit(
            subject=name, quantity=row.quantity, unit="N", value=breaking / factor, factor=factor, breaking=breaking,
            elements=(name,), source=source, note=more, where=where,
        )  # fmt: skip


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
    """Properties of a sling termination: factor KT of EN 13414-1 (None: does not apply), factor of 0027/ND 7.7.1."""

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
    """The properties of a sling that determine its strength: breaking force [N], WLL of one leg [kg], diameters [m]."""

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
    """The ratio of breaking force to load that a standard requires, with its source and a note for the planner."""

    factor: float
    source: str
    note: str = ""


def at_rest(x: Terms, gravity: float) -> Rated:
    """Return the safety factor that one leg of a sling needs for its static load."""
    if x.WLL:
        return _skewed(x, Rated(x.breaking / (x.WLL * gravity), x.source or "its working load limit in the scene"))
    known = TERMINATIONS[x.termination or "ferrule"]
    if known.kt is None:
        peak = in_a_run(x)
        return Rated(
            peak.factor, peak.source, "the limit of its peak tension, which its static load must not exceed either"
        )
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
    """Return a rating, multiplied by the skew load factor if the sling is one of four legs that were chosen
    individually."""
    if not x.single:
        return rated
    skew = SHARING["four slings"]
    note = f"legs chosen singly: skew load factor {skew.factor:g} ({skew.source}, matched pairs within +-2 d)"
    return Rated(rated.factor * skew.factor, rated.source, "; ".join(filter(None, (rated.note, note))))


def in_a_run(x: Terms) -> Rated:
    """Return the safety factor that a sling needs for its peak tension in a run (0027/ND, 7.3 to 7.10)."""
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
    half = f" x {whole:g} (a grommet counts with half its quoted force, 7.2.3)" if whole > 1.0 else ""
    return Rated(factor, f"{message} (wear){half}, {factor:.4g}; {SUCCESSOR}")


def _force(x: Terms) -> str:
    return f"{x.breaking / 1e3:g} kN{'' if x.chosen else ' assumed'}"


def bending(ratio: float) -> float:
    """Return the bending factor of a sling around a pin, from the ratio of pin to sling diameter (0027/ND, 7.8.1)."""
    return 1.0 / (1.0 - 0.5 / sqrt(max(ratio, 1.0)))


def assembly(x: Terms, legs: int, gravity: float) -> tuple[tuple[tuple[float, float], ...], str] | None:
    """Return the WLL of an assembly of sling legs, and the basis of this rating in words; None if no rating applies.

    The WLL is a list of pairs (angle to the vertical [rad], mass [kg])."""
    rated = at_rest(x._replace(single=False), gravity)
    if legs not in KL or x.WLL or TERMINATIONS[x.termination or "ferrule"].kt is None or rated.note:
        return None
    leg = x.breaking / rated.factor / gravity
    chart = tuple((radians(angle), factor * leg) for angle, factor in KL[legs])
    factors = " and ".join(f"{factor:g} up to {angle:g} degrees" for angle, factor in KL[legs])
    shared = " (three carry)" if legs == 4 else ""
    return chart, f"{rated.source}; an assembly of {legs} legs: KL = {factors}{shared}"


def shackle(WLL: float, standard: str) -> str:
    """Return a remark if the standard does not cover a shackle with this WLL [kg]; otherwise ""."""
    if standard.startswith(EN_13889) and WLL > LARGEST_SHACKLE:
        return f"{EN_13889} ends at {LARGEST_SHACKLE / 1e3:g} t, assumed: RR-C-271 or the maker's certificate applies"
    return "EN 1677 is for hooks, links and components, assumed" if standard.startswith("EN 1677") else ""
