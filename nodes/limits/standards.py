"""Factors of published standards, each with name and clause.

ISO 4308-1 is withdrawn and replaced by ISO 16625; crane ropes are still chosen by its factors. 0027/ND (GL Noble
Denton) rev 11.2 of 2016 was continued as DNVGL-ST-N001 and DNV-ST-N001.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import prod, sqrt
from typing import Literal, TypeAlias

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
    """Assumed unequal sharing in statically indeterminate rigging."""

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
    """Return the dynamic amplification factor for a mass [kg] at a place, with its source; None for an unknown
    place."""
    if place not in DAF:
        return None
    (a, b), *others = DAF[place]
    i = next(i for i, most in enumerate(DAF_MOST) if mass <= most)
    factor = others[i - 1] if i else a + b * sqrt(DAF_MOST[0] / max(mass, LIGHTEST))
    return factor, f"{ND_0027}, table 5-1, {place}"


def hoisting_factor(speed: float, hoisting_class: str) -> float:
    """Return phi_2 = phi_2,min + beta_2 v_h of a load lifted off the ground at a hook speed [m/s] (EN 13001-2,
    4.2.2.2)."""
    least, slope = HOISTING[hoisting_class]
    return least + slope * speed


def partial_factor(**given: float) -> float:
    """Return the required breaking force over the largest dynamic tension: the product of the partial factors of a
    sling (0027/ND 7.3.1)."""
    each = RIGGING | given
    reduced = each["termination"] * each["wear"] * each["twist"]
    return max(each["load"] * each["consequence"] * each["material"] * reduced, LEAST * reduced)


@dataclass(frozen=True)
class Strength:
    """A requirement on strength: the quantity may reach the breaking force over `factor`, with source. A scene may
    override the factor by the key `own`."""

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
    """Yield the limits of a sling or hoist rope by each standard; `breaking` [N]; `given`: overriding factors."""
    for row in (row for row in STRENGTHS if row.of == of):
        factor, source, more = given.get(row.own) or (row.factor, row.source, note)
        yield RatedLimit(
            subject=name, quantity=row.quantity, unit="N", value=breaking / factor, factor=factor, breaking=breaking,
            elements=(name,), source=source, note=more, where=where,
        )  # fmt: skip
