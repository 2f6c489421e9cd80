"""The tables of the document, the same for a page and a workbook: titles, heads, rows of text, a line below.

Every load stands in kN and in t, so that rated tensions and masses that may be carried can be compared at a glance.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import NamedTuple

from heavylift.recordings.format.html import Cell
from heavylift.recordings.format.text import clock, duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import Judged

from .facts import Facts, LoadUse, RopeUse, StageUse
from .loads import Borne

LOADED = ("largest load", "", "at", "may carry", "use")
TONNE = 9806.65  # [N] its weight
TOLD = (  # sentences of facts, what they are, and their title
    ("measured", "run less log, uncertainties at 95 %", "Beside a measured lift"),
    ("certified", "figures, with half-widths at 95 %", "How sure the figures are"),
)
TANDEM = (
    "Two cranes together may carry at most 75 % of what they may carry one by one: what 'may carry' says holds that."
)
SAMPLED = "Directions are those at samples, tensions the largest since the sample before."
CORNERS = (
    "What stands and hangs on a portal is shared by its four corners as by a rigid frame on equal springs; "
    "accelerations of its masses and wind are left out. Divide by the wheels of a corner."
)


class Table(NamedTuple):
    """A table; `kind` is its class on the page, `told` stands below it."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    kind: str = ""
    told: Sequence[str] = ()


def tables(rec: Recording, found: Facts, verdict: Judged | None) -> list[Table]:
    """All tables that have rows, in the order in which a planner reads them."""
    judged, hangs = bool(verdict and verdict.rows), {s.name: s for s in found.slings}
    band = verdict.dynamic[0] if verdict and verdict.dynamic else None
    made = [
        _findings(verdict) if verdict else _warnings(found),
        *([_checks(verdict)] if verdict and verdict.rows else ()),
        *(_rigging(verdict) if verdict else ()),
        *([_clearances(verdict)] if verdict else ()),
        Table("Notes of the kernel", ["what", "at"], [[(told, True), clock(t, 1)] for t, told in found.notes], "told"),
        *(Table(title, [head], [[x] for x in rec.told(fact)], "told") for fact, head, title in TOLD),
        Table("Block", ["what", ""], found.block, "told"),
        Table("Scene", ["what", ""], found.scene, "told"),
        Table("Cranes", ["crane", *LOADED], [_load(c) for c in found.cranes], told=[TANDEM] * (len(found.cranes) > 1)),
        Table("Hooks", ["hook", *LOADED], [_load(h) for h in found.hooks]),
        Table("Ropes", ["rope", "peak", "", "at", "stage", "rated", "use"], [_rope(r, judged) for r in found.ropes]),
        Table(
            "Slings",
            ["sling", "lug", "peak", "", "at", "angle to vertical then", "at most"],
            [
                [r.name, ", ".join(s.lugs), *_force(r.peak), clock(r.when, 1), _degrees(s.angle), _degrees(s.widest)]
                for r in found.ropes
                if (s := hangs.get(r.name))
            ],
        ),
        Table(
            "Lugs",
            ["lug", "at u, v, w", "largest load", "", "at", "along u", "along v", "along w"],
            [[*_borne(x), *(f"{part / 1e3:z.1f} kN" for part in x.parts or ())] for x in found.lugs],
            told=["u, v, w are the axes of the block. " + SAMPLED],
        ),
        Table("Stools", ["stool", "at x, y, z", "largest reaction", "", "at"], [_borne(x) for x in found.stools]),
        Table(
            "Wheel reactions",
            ["corner of a portal", "at x, y, z", "largest reaction", "", "at"],
            [_borne(x) for x in found.portals],
            told=[CORNERS],
        ),
        Table(
            "Stages",
            ["stage", "from", "lasts", "rope used most", "use", "dynamic factor"],
            [_stage(s, band, judged) for s in found.stages],
            told=[_amplified(found, verdict)] if any(s.dynamic for s in found.stages) else [],
        ),
        Table(
            "Course of the block",
            ["stage", "from", "lowest point", "tilt", "centre of gravity at its end, x, y, z"],
            [_course(s, s.tilt, s.com) for s in found.stages if s.com and s.tilt],
            told=["Tilt is the angle of the block's w axis to the vertical."],
        ),
    ]
    return [table for table in made if table.rows]


def _force(newtons: float) -> tuple[str, str]:
    return f"{newtons / 1e3:.1f} kN", f"{newtons / TONNE:.1f} t"


def _degrees(angle: float) -> str:
    return f"{degrees(angle):.1f}°"


def _place(place: tuple[float, float, float]) -> str:
    return ", ".join(f"{x:.2f}".replace("-0.00", "0.00") for x in place) + " m"


def _borne(x: Borne) -> list[Cell]:
    return [x.name, _place(x.place) if x.place else "", *_force(x.force), clock(x.when, 1)]


def _findings(verdict: Judged) -> Table:
    """What was found, red ones first."""
    rows: list[list[Cell]] = []
    for f in verdict.findings:
        where = f" [{f.where}]" if f.where else ""
        rows.append(
            [f.severity, (f"{f.sentence}{where}", f.severity == "red"), "" if f.t is None else clock(f.t, 1), f.stage]
        )
    return Table("Findings", ["", "what", "at", "stage"], rows, "told")


def _clearances(verdict: Judged) -> Table:
    """The smallest ones, and what nobody looked at."""
    rows: list[list[Cell]] = []
    for c in verdict.clearances:
        red = any(f.kind == "clearance" and f.subject == f"{c.a} and {c.b}" for f in verdict.findings)
        kept = f"{c.limit:g} m" if c.limit else "not touched"
        rows.append([f"{c.a} and {c.b}", (f"{c.distance:.2f} m", red), kept, clock(c.t, 1), c.place])
    unseen = [f"Not looked at: {x}" for x in verdict.not_looked_at]
    return Table("Smallest clearances", ["between", "at least", "to be kept", "at", "where"], rows, "placed", unseen)


def _warnings(found: Facts) -> Table:
    rows: list[list[Cell]] = [[w.who, (w.what, True), clock(w.when, 1)] for w in found.warnings]
    return Table("Warnings", ["who", "what", "at"], rows, "told")


def _amplified(found: Facts, verdict: Judged | None) -> str:
    """The largest dynamic factor of the run beside that which a standard foresees."""
    each = [(factor, crane, s.name) for s in found.stages for crane, factor in s.dynamic.items()]
    factor, crane, stage = max(each)
    told = f"Dynamic factor: {factor:.3f} simulated ({crane}, {stage})"
    if verdict is None or verdict.dynamic is None:
        return f"{told}."
    return f"{told}, {verdict.dynamic[0]:g} foreseen ({verdict.dynamic[1]}); what is beyond it is marked."


def _load(c: LoadUse) -> list[Cell]:
    use = c.load / c.capacity if c.capacity else 0.0
    weight, mass = _force(c.load * TONNE / 1e3)
    return [c.name, mass, weight, clock(c.when, 1), f"{c.capacity / 1e3:.0f} t", (f"{100 * use:.0f} %", use > 1)]


def _rope(r: RopeUse, judged: bool) -> list[Cell]:
    """A rope; its rating is that at its longest, so the table of limits tells what is beyond, if there is one."""
    rated: list[Cell] = ["", ""]
    if r.rated:
        use = r.peak / r.rated
        rated = [f"{r.rated / 1e3:.0f} kN", (f"{100 * use:.0f} %", use > 1 and not judged)]
    return [r.name, *_force(r.peak), clock(r.when, 1), r.stage, *rated]


def _checks(verdict: Judged) -> Table:
    """All checks, worst first."""
    rows: list[list[Cell]] = [[(cell, row[0] == "red") for cell in row] for row in verdict.rows]
    return Table("Checks", verdict.head, rows, "placed limits", verdict.told)


def _rigging(verdict: Judged) -> list[Table]:
    """From loads at rest to design loads, and what riggers fetch."""
    given = (("Design loads", verdict.sheet), ("Rigger's list", verdict.gear))
    return [Table(title, rows[0], rows[1:], "placed") for title, rows in given if rows]


def _stage(s: StageUse, band: float | None, judged: bool) -> list[Cell]:
    factors = ", ".join(f"{crane} {factor:.3f}" for crane, factor in s.dynamic.items())
    beyond = band is not None and any(factor > band for factor in s.dynamic.values())
    use = (f"{100 * s.use:.0f} %" if s.rope else "", s.use > 1 and not judged)
    return [s.name, clock(s.start, 1), duration(s.end - s.start), s.rope, use, (factors, beyond)]


def _course(s: StageUse, tilt: tuple[float, float], com: tuple[float, float, float]) -> list[Cell]:
    low = "" if s.lowest is None else f"{s.lowest:.2f} m"
    least, most = map(_degrees, tilt)
    return [s.name, clock(s.start, 1), low, least if least == most else f"{least} to {most}", _place(com)]
