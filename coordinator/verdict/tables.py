"""Tables that a verdict carries for the report, made of what only the plan knows: each a function of it in `TABLES`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from heavylift.nodes.plan.limit import Reach, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene.factor_sheet import lines, named
from heavylift.recordings.sheets.sheet import Table, columns, trimmed


def hooks(plan: Plan) -> Iterator[Table]:
    """Hooks as their cranes have them: what they may carry, at which radius by a chart, and how they are reeved."""
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
    yield trimmed(Table("Hooks", heads, tuple(rows)))


def charts_used(found: Sequence[Reach]) -> list[Table]:
    """Radius and use of the chart in each stage."""
    rows = tuple((x.stage, x.hook, x.when, x.t, x.radius, x.load / 1e3, x.capacity / 1e3, 100.0 * x.use) for x in found)
    heads = columns("stage", "hook", "", "at [h:min:s]", "radius [m] .2", "load [t] .1", "chart [t] .1", "use [%] .1")
    note = "Load with hook block and rigging; the next longer radius of the chart counts."
    return [Table("Radius and chart", heads, rows, (note,))] if rows else []


def rigging(plan: Plan, uses: Sequence[Use]) -> Iterator[Table]:
    """From loads at rest to design loads, those of slings as forces, and what riggers fetch."""
    for of, unit, told in (("", "kg", "t"), (" of slings", "N", "kN")):
        found = [line for line in lines(uses) if line.limit.unit == unit]
        names, form = named(found), f"[{told}] .1"
        heads = columns("part", "", f"load at rest {form}", *(f"{name} .3" for name in names), f"design load {form}",
                        f"limit {form}", "used [%] .1", f"met {form}", "most loaded in")  # fmt: skip
        rows = tuple(
            (x.limit.quantity.partition(" ")[0], x.limit.subject, x.rest / 1e3, *map(x.factors.get, names),
             x.design / 1e3, *(y if y is None else y * k for y, k in ((x.most, 1e-3), (x.use, 100.0), (x.met, 1e-3))),
             x.stage)
            for x in found
        )  # fmt: skip
        yield trimmed(Table(f"Design loads{of}", heads, rows))
    heads = columns("item", "number .0", "kind", "WLL [t] .2", "mass each [kg] .1", "standard", "termination",
                    "certificate", "where")  # fmt: skip
    items = tuple(
        (x.name, x.number, x.kind, x.WLL / 1e3 if x.WLL else None, x.mass or None, x.standard, x.termination,
         x.certificate or "none", ", ".join(x.at))
        for x in plan.gear
    )  # fmt: skip
    yield trimmed(Table("Rigger's list", heads, items))


TABLES: tuple[Callable[[Plan], Iterator[Table]], ...] = (hooks,)


def tables_of_plan(plan: Plan) -> tuple[Table, ...]:
    """All that have rows."""
    return tuple(table for make in TABLES for table in make(plan) if table.rows)
