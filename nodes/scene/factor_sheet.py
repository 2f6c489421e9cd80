"""Tables of hooks, rigging and factors, which `check` and reports have in common.

Loads are in t, loads of slings in kN.
"""

from collections.abc import Iterator, Sequence

from heavylift.nodes.limits.factors import BASES, NAMES
from heavylift.nodes.plan.limit import Reach, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.sheets.sheet import Table, columns, trimmed


def hooks(plan: Plan) -> Table:
    """Return the table of hooks: rated loads, radius charts and reeving."""
    rows = []
    for machine in plan.machines:
        for hook in machine.hooks:
            most = hook.capacity / 1e3 if hook.capacity else max((load for _, load in hook.chart), default=0.0) / 1e3
            reach = f"{hook.chart[0][0]:g} to {hook.chart[-1][0]:g} m" if hook.chart else ""
            force = hook.breaking / 1e3 if hook.breaking else None
            falls = hook.falls or None
            rows.append((machine.name, hook.rope, hook.block_mass / 1e3, most or None, reach, falls, force))
    heads = columns("crane", "hook", "hook block [t] .1", "rated [t] .1", "chart over radius", "falls .0",
                    "breaking force of the rope [kN] .0")  # fmt: skip
    return trimmed(Table("Hooks", heads, tuple(rows)))


def charts_used(found: Sequence[Reach]) -> Table:
    """Return the table of hook radii and utilisations of load charts by stage, without rows equal to the row before."""
    numbers = [(x.hook, x.stage, f"{x.radius:.2f} {x.load:.0f} {x.capacity:.0f}") for x in found]
    changed = (x for i, x in enumerate(found) if not i or numbers[i] != numbers[i - 1])
    rows = tuple(
        (x.stage, x.hook, x.when, x.t, x.radius, x.load / 1e3, x.capacity / 1e3, 100.0 * x.use) for x in changed
    )
    heads = columns("stage", "hook", "", "at [h:min:s]", "radius [m] .2", "load [t] .1", "chart [t] .1", "use [%] .1")
    note = "Load with hook block and the rigging that has a mass; the next longer radius of the chart counts."
    return Table("Radius and chart", heads, rows, (note,))


def rigging(plan: Plan, uses: Sequence[Use], *, ran: bool = True) -> Iterator[Table]:
    """Yield the tables of a rigging sheet: static loads, factors, design loads, loads of a run (if `ran`), gear."""
    met = {(use.limit.subject, use.limit.quantity): use.value for use in uses}
    for of, unit, message in (("", "kg", "t"), (" of slings", "N", "kN")):
        mine, rows = [use for use in uses if use.limit.rest and use.value and use.limit.unit == unit], []
        named = [name for name in NAMES if any(x.name == name for use in mine for x in use.limit.factors)]
        for use in mine:
            limit, rest, value = use.limit, use.limit.rest, use.value
            assert rest is not None
            assert value is not None
            factors = {x.name: x.value for x in limit.factors}
            simulated = None if rest.alone or not ran else met.get((limit.subject, BASES[limit.quantity]))
            most = value / use.use if use.use else None
            loads = (None if x is None else x / 1e3 for x in (value, most, simulated))
            used = None if use.use is None else 100.0 * use.use
            part = limit.quantity.partition(" ")[0]
            rows.append((part, limit.subject, rest.value / 1e3, *map(factors.get, named), *loads, used, use.stage))
        form = f"[{message}] .1"
        heads = columns("part", "", f"load at rest {form}", *(f"{name} .3" for name in named), f"design load {form}",
                        f"limit {form}", f"simulated {form}", "used [%] .1", "most loaded in")  # fmt: skip
        yield trimmed(Table(f"Design loads{of}", heads, tuple(rows), tuple(sources(mine))))
    heads = columns("item", "number .0", "kind", "WLL [t] .2", "mass each [kg] .1", "standard", "termination",
                    "certificate", "where")  # fmt: skip
    items = tuple(
        (x.name, x.number, x.kind, x.WLL / 1e3 if x.WLL else None, x.mass or None, x.standard, x.termination,
         x.certificate or "none", ", ".join(x.at))
        for x in plan.gear
    )  # fmt: skip
    yield trimmed(Table("Rigger's list", heads, items))


def sources(uses: Sequence[Use]) -> list[str]:
    """Return the sources of the load factors of these limits, without repetition."""
    found: dict[tuple[str, str], list[float]] = {}
    for x in (x for use in uses for x in use.limit.factors):
        found.setdefault((x.name, x.source), []).append(x.value)
    return [
        f"{name} {min(values):.4g}{f' to {max(values):.4g}' if max(values) - min(values) > 1e-4 else ''}: {source}"
        for (name, source), values in found.items()
    ]
