"""Two alternatives beside each other: verdicts, the largest use of each quantity, tensions, clearances, stages."""

from __future__ import annotations

from collections.abc import Iterable

from heavylift.kernel.description.findings import Check
from heavylift.recordings.format.text import duration
from heavylift.recordings.render.storyboard import storyboard
from heavylift.recordings.sheets.sheet import Cell, Column, Marked, Part, Sheet, Table, columns, words

from .document import picture
from .facts import Facts
from .scene import block_rows, scene_table

WORST = ("red", "undecided", "amber", "green", "none")


def alternatives(a: Facts, b: Facts, pictures: bool = False) -> Sheet:
    """The sheet of two recordings with their verdicts."""
    both, names = (a, b), _names(a, b)
    ends = [[*f.stages[1:], (f.rec.fact("sim_s", 0.0), "")] for f in both]
    stages = [
        {name: after - t for (t, name), (after, _) in zip(f.stages, end, strict=False)}
        for f, end in zip(both, ends, strict=True)
    ]
    peaks = [{name: peak.tension / 1e3 for name, peak in f.peaks.items()} for f in both]
    gaps = [{f"{c.a} and {c.b}": c.distance for c in (f.verdict.clearances if f.verdict else ())} for f in both]
    parts: list[Part] = [
        words("In short", ("", *names), _short(a, b)),
        _uses(a, b, names),
        _table("Peak tensions", "rope", names, peaks, ("kN", 1)),
        _table("Smallest clearances", "between", names, gaps, ("m", 2)),
        _table("Stages", "stage", names, stages, ("s", 1)),
    ]
    for f, name in zip(both, names, strict=True) if pictures else ():
        parts += picture(f.rec, storyboard, f"{name} at some instants")
    states = [f.verdict.state if f.verdict else "" for f in both]
    lines = [f.verdict.line if f.verdict else "no verdict" for f in both]
    lead = ". ".join(f"{name}: {line}" for name, line in zip(names, lines, strict=True))
    worst = min(states, key=lambda state: WORST.index(state) if state else len(WORST))
    return Sheet(f"{names[0]} and {names[1]}", f"{lead}.", worst, tuple(parts))


def _names(a: Facts, b: Facts) -> tuple[str, str]:
    """The scenes, or the files of one scene."""
    one, other = (f.rec.run.get("scene", f.rec.path.stem) for f in (a, b))
    if one != other:
        return one, other
    one, other = a.rec.path.stem, b.rec.path.stem
    return (one, other) if one != other else (f"{one} (1)", f"{other} (2)")


def _short(a: Facts, b: Facts) -> Iterable[tuple[str, str, str]]:
    """Differences of scene, block and durations."""
    facts = [{"duration": duration(f.rec.fact("sim_s", 0.0))} for f in (a, b)]
    for known, f in zip(facts, (a, b), strict=True):
        known |= {what: f"{', '.join(f'{x:g}' for x in values)} {unit}" for what, values, unit in block_rows(f.plan)}
        known |= dict(scene_table(f.rec, f.plan))
    for name in dict.fromkeys([*facts[0], *facts[1]]):
        one, other = (x.get(name, "") for x in facts)
        if one != other or name == "duration":
            yield name, one, other


def _uses(a: Facts, b: Facts, names: tuple[str, str]) -> Table:
    """For each quantity, the worst check in each recording."""
    one, other = (_worst(f.verdict.checks if f.verdict else ()) for f in (a, b))
    each = (heading for name in names for heading in (f"{name}: worst of", "value", "use [%] .1", "state"))
    rows = tuple((quantity, *_cells(one.get(quantity)), *_cells(other.get(quantity))) for quantity in {**one, **other})
    return Table("Largest use of each quantity", columns("check", *each), rows)


def _worst(checks: Iterable[Check]) -> dict[str, Check]:
    found: dict[str, Check] = {}
    for c in checks:
        known = found.get(c.quantity)
        if known is None or (WORST.index(c.state), -(c.use or 0.0)) < (WORST.index(known.state), -(known.use or 0.0)):
            found[c.quantity] = c
    return found


def _cells(c: Check | None) -> tuple[Cell, ...]:
    if c is None:
        return None, None, None, "-"
    return c.subject, c.shown, None if c.use is None else 100.0 * c.use, Marked(c.word, c.state)


def _table(
    title: str, what: str, names: tuple[str, str], values: list[dict[str, float]], unit: tuple[str, int]
) -> Table:
    """Numbers of both by name, and by how much the second is more."""
    one, other = values
    rows = tuple(
        (name, one.get(name), other.get(name), other[name] - one[name] if name in one and name in other else None)
        for name in dict.fromkeys([*one, *other])
    )
    return Table(title, (Column(what), *(Column(name, *unit) for name in (*names, "difference"))), rows)
