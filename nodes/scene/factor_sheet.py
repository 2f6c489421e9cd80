"""The factor sheet and the rigger's list, as numbers for reports and as texts for the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from heavylift.nodes.limits.factors import BASES, NAMES
from heavylift.nodes.limits.messages import percent, shown
from heavylift.nodes.plan.limit import RatedLimit, Use
from heavylift.nodes.plan.plan import Plan


class FactorLine(NamedTuple):
    """A line of the sheet: loads in the unit of `limit`, `factors` by name, `met`: what a run has simulated."""

    limit: RatedLimit
    rest: float
    factors: dict[str, float]
    design: float
    most: float | None
    use: float | None
    met: float | None
    stage: str


def lines(uses: Sequence[Use]) -> list[FactorLine]:
    """The factor sheet of uses of limits: a line for each hook, sling, shackle and lug."""
    met = {(use.limit.subject, use.limit.quantity): use for use in uses}
    found = []
    for use in uses:
        limit, rest = use.limit, use.limit.rest
        if rest is not None and use.value is not None:
            base = met.get((limit.subject, BASES[limit.quantity]))
            most = use.value / use.use if use.value and use.use else None
            simulated = base.value if base and not rest.alone else None
            factors = {x.name: x.value for x in limit.factors}
            found.append(FactorLine(limit, rest.value, factors, use.value, most, use.use, simulated, use.stage))
    return found


def named(found: Sequence[FactorLine]) -> list[str]:
    """The factors of some lines, in order."""
    return [name for name in NAMES if any(name in line.factors for line in found)]


def sheet(uses: Sequence[Use]) -> tuple[tuple[str, ...], ...]:
    """The same as a head and rows of texts; nothing without one."""
    found = lines(uses)
    names = named(found)
    head = ("part", "", "load at rest", *names, "design load", "limit", "used", "met", "most loaded in")
    rows = [
        (
            x.limit.quantity.partition(" ")[0], x.limit.subject, shown(x.limit, x.rest),
            *(f"{x.factors[name]:.4g}" if name in x.factors else "" for name in names), shown(x.limit, x.design),
            shown(x.limit, x.most), "" if x.use is None else percent(x.use),
            "" if x.met is None else shown(x.limit, x.met), x.stage,
        )
        for x in found
    ]  # fmt: skip
    return (head, *rows) if rows else ()


def sources(uses: Sequence[Use]) -> list[str]:
    """Where the factors of a sheet come from, each once."""
    each = [x for use in uses for x in use.limit.factors]
    found: dict[tuple[str, str], list[float]] = {}
    for x in each:
        found.setdefault((x.name, x.source), []).append(x.value)
    return [
        f"{name} {min(values):.4g}{f' to {max(values):.4g}' if max(values) - min(values) > 1e-4 else ''}: {source}"
        for (name, source), values in found.items()
    ]


def gear(plan: Plan) -> tuple[tuple[str, ...], ...]:
    """The rigger's list: head and a row for each item; nothing where the scene names none."""
    head = ("item", "number", "kind", "WLL", "mass each", "standard", "termination", "certificate", "where")
    rows = [
        (
            x.name, str(x.number), x.kind, f"{x.WLL / 1e3:g} t" if x.WLL else "", f"{x.mass:g} kg" if x.mass else "",
            x.standard, x.termination, x.certificate or "none", ", ".join(x.at),
        )
        for x in plan.gear
    ]  # fmt: skip
    return (head, *rows) if rows else ()
