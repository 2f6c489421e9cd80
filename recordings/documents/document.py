"""The planner's document of a run as a sheet: approval, verdict, tables, tensions, pictures and drawings of the lift.

Also the comparison of two alternatives: verdicts, the highest utilisation of each quantity, tensions, clearances,
stages.
"""

import datetime
import tempfile
from collections.abc import Callable, Iterable, Iterator
from math import inf
from pathlib import Path
from typing import NamedTuple

from heavylift.kernel.description.findings import Check
from heavylift.kernel.errors import RecordingError, path_text
from heavylift.recordings.drawings import drawings, write_dxf
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.text import duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import AGAIN, RecordedVerdict, as_recorded, complaints, opened, recorded_verdict
from heavylift.recordings.render.plot import plot
from heavylift.recordings.render.storyboard import storyboard
from heavylift.recordings.sheets.sheet import Cell, Chart, Column, Marked, Part, Sheet, Table, columns, words
from heavylift.recordings.sheets.workbook import FORMATS, write
from heavylift.recordings.write.outputs import output_path

from .facts import Facts, block_rows, facts, scene_table
from .tables import tables_of

DRAWN = (".dxf",)


class Project(NamedTuple):
    """Project data printed on the document, from the scene or the command line."""

    name: str = ""
    number: str = ""
    author: str = ""
    date: str = ""
    revision: str = "0"


def project_of(rec: Recording, **given: str) -> Project:
    """Return the project data of the recorded scene; values in `given` replace those of the scene."""
    known = {name: str(text) for name, text in rec.fact("project", {}).items() if name in Project._fields}
    stated = Project(**known | {name: text for name, text in given.items() if text})
    return stated if stated.date else stated._replace(date=datetime.date.today().isoformat())


def report(
    path: str | Path | Recording,
    out: str | Path,
    verdict: RecordedVerdict | None = None,
    force: bool = False,
    **given: str,
) -> Path:
    """Write the report of a recording to a .html, .pdf, .xlsx, .json or .txt file, or its drawings to a .dxf file.

    Raises RecordingError if a file cannot be read or written.

    `verdict`: verdict for a recording that has none (`heavylift report` computes it); `given`: fields of `Project` that
    override those of the scene.
    """
    out = output_path(out, "a report", (*FORMATS, *DRAWN))
    if out.suffix.lower() in DRAWN:
        rec = opened(path)
        found = verdict or recorded_verdict(rec)
        return write_dxf(rec, out, found, project_of(rec, **given)._asdict(), force)
    drawn = out.suffix.lower() in (".html", ".pdf")
    return write(report_sheet(opened(path), verdict, drawn, **given), out, "a report", force)


def report_sheet(rec: Recording, verdict: RecordedVerdict | None = None, pictures: bool = False, **given: str) -> Sheet:
    """Return the report of a recording as a sheet; `pictures`: include pictures, for formats that can be printed."""
    found, project = facts(rec, verdict), project_of(rec, **given)
    lead, state = _lead(rec, found)
    first, *rest = tables_of(found) or [Table("", ())]
    curves = picture(rec, plot, "Tensions over time") if pictures else ()
    parts: list[Part] = [_issue(rec, project), first, *curves, *rest]
    if pictures:
        parts += picture(rec, storyboard, "The lift at some instants")
        parts += drawings(rec, found.verdict, project._asdict())
    title = f"Lift report: {project.name or rec.run.get('scene', rec.path.stem)}"
    return Sheet(title, lead, state, tuple(parts))


def _issue(rec: Recording, project: Project) -> Table:
    """Return the table of revision and date, with three lines for signatures."""
    rows = [
        ("revision", project.revision, project.date, ""),
        ("prepared", project.author, project.date if project.author else "", ""),
        ("checked", "", "", ""),
        ("approved", "", "", ""),
    ]
    if project.number or project.name:
        rows.insert(0, ("project", ", ".join(filter(None, (project.number, project.name))), "", ""))
    heads = tuple(map(Column, ("", "name", "date", "signature")))
    return Table("Issue", heads, tuple(rows), (_origin(rec),), blank=True)


def _origin(rec: Recording) -> str:
    facts = [f"{duration(rec.fact('sim_s', 0.0))} simulated", *settings(rec.run).values()]
    facts += [f"digest {rec.result['digest']}"] if rec.result.get("digest") else []
    facts += [f"{' and '.join(known)} as recorded; {AGAIN}"] if (known := as_recorded(rec)) else []
    versions = [rec.library, f"python {rec.run.get('python', 'unknown')}", rec.run.get("platform", "")]
    return "; ".join([*facts, *filter(None, versions), f"from {path_text(rec.path.name)}"])


def _lead(rec: Recording, found: Facts) -> tuple[str, str]:
    """Return a summary of the document in a few sentences, and its state: that of the verdict, or `bad`."""
    status, verdict = rec.result.get("status", "cut off"), found.verdict
    reason = rec.result.get("reason", "")
    ended = {"finished": "The run finished.", "failed": f"The run failed: {reason}."}
    message = ended.get(status, f"The run is {status}: {reason}")
    recorded = ", as recorded" if "verdict" in rec.result else ""
    line = f"Verdict{recorded}: {verdict.line}." if verdict else "It has no verdict."
    message = f"{line} {message}" if verdict else f"{message} {line}"
    message += " The kernel has notes on how it was computed, listed below." if rec.notes() and not verdict else ""
    rated = rec.fact("rated", {})
    wrong, beyond = complaints(rec), any(x.tension > (rated.get(name) or inf) for name, x in found.peaks.items())
    bad = wrong or status != "finished" or (not verdict and (rec.notes() or beyond))
    state = "bad" if bad else verdict.state if verdict else ""
    return " ".join([*(f"Wrong: {what}." for what in wrong), message]), state


def picture(rec: Recording, draw: Callable[[Recording, Path], Path], title: str) -> Iterator[Chart]:
    """Yield a PNG chart of a recording drawn by the function `draw`; yield nothing if the recording lacks the data."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            yield Chart(title, draw(rec, Path(folder) / "drawn.png").read_bytes())
        except RecordingError:
            return


WORST = ("red", "undecided", "amber", "green", "none")


def alternatives(a: Facts, b: Facts, pictures: bool = False) -> Sheet:
    """Return a sheet that compares two recordings and their verdicts."""
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
    """Return headings for two recordings: their scenes, or the file names if the scene is the same."""
    one, other = (f.rec.run.get("scene", f.rec.path.stem) for f in (a, b))
    if one != other:
        return one, other
    one, other = a.rec.path.stem, b.rec.path.stem
    return (one, other) if one != other else (f"{one} (1)", f"{other} (2)")


def _short(a: Facts, b: Facts) -> Iterable[tuple[str, str, str]]:
    """Return rows for differences in scene, block and durations: name and both values."""
    facts = [{"duration": duration(f.rec.fact("sim_s", 0.0))} for f in (a, b)]
    for known, f in zip(facts, (a, b), strict=True):
        known |= {what: f"{', '.join(f'{x:g}' for x in values)} {unit}" for what, values, unit in block_rows(f.plan)}
        known |= dict(scene_table(f.rec, f.plan))
    for name in dict.fromkeys([*facts[0], *facts[1]]):
        one, other = (x.get(name, "") for x in facts)
        if one != other or name == "duration":
            yield name, one, other


def _uses(a: Facts, b: Facts, names: tuple[str, str]) -> Table:
    """Return the table of the governing check of each quantity in both recordings."""
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
    """Return the table of values by name in both recordings, with their differences (second minus first)."""
    one, other = values
    rows = tuple(
        (name, one.get(name), other.get(name), other[name] - one[name] if name in one and name in other else None)
        for name in dict.fromkeys([*one, *other])
    )
    return Table(title, (Column(what), *(Column(name, *unit) for name in (*names, "difference"))), rows)
