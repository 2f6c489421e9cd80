"""The planner's document of a run as a sheet: approval, verdict, tables, tensions, the lift in pictures, drawings."""

from __future__ import annotations

import datetime
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from heavylift.kernel.errors import RecordingError, path_text
from heavylift.recordings.drawings import drawings, write_dxf
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.text import duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import AGAIN, RecordedVerdict, as_recorded, complaints, opened, recorded_verdict
from heavylift.recordings.render.plot import plot
from heavylift.recordings.render.storyboard import storyboard
from heavylift.recordings.sheets.sheet import Chart, Column, Part, Sheet, Table
from heavylift.recordings.sheets.writing import FORMATS, write
from heavylift.recordings.write.outputs import output_path

from .facts import Facts, facts
from .tables import tables_of

DRAWN = (".dxf",)


class Project(NamedTuple):
    """Project data of the document, from the scene or the command line."""

    name: str = ""
    number: str = ""
    author: str = ""
    date: str = ""
    revision: str = "0"


def project_of(rec: Recording, **given: str) -> Project:
    """Project data of the scene, overridden by `given`."""
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
    """Write the document of a recording to a .html, .pdf, .xlsx, .json or .txt file, or its drawings to a .dxf file;
    RecordingError if one of them cannot be used.

    `verdict`: of who knows the scene, where the recording has none of its own (`heavylift report` gives it); `given`:
    what `Project` names, instead of what the scene says.
    """
    out = output_path(out, "a report", (*FORMATS, *DRAWN))
    if out.suffix.lower() in DRAWN:
        rec = opened(path)
        found = verdict or recorded_verdict(rec)
        return write_dxf(rec, out, found, project_of(rec, **given)._asdict(), force)
    drawn = out.suffix.lower() in (".html", ".pdf")
    return write(report_sheet(opened(path), verdict, drawn, **given), out, "a report", force)


def report_sheet(rec: Recording, verdict: RecordedVerdict | None = None, pictures: bool = False, **given: str) -> Sheet:
    """The document of a recording; pictures only for printable formats."""
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
    """Revision and date, and three lines to be signed."""
    rows = [
        ("revision", project.revision, project.date, ""),
        ("prepared", project.author, project.date if project.author else "", ""),
        ("checked", "", "", ""),
        ("approved", "", "", ""),
    ]
    if project.number or project.name:
        rows.insert(0, ("project", project.number, project.name, ""))
    heads = tuple(map(Column, ("", "name", "date", "signature")))
    return Table("Issue", heads, tuple(rows), (_origin(rec),), blank=True)


def _origin(rec: Recording) -> str:
    facts = [f"{duration(rec.fact('sim_s', 0.0))} simulated", *settings(rec.run).values()]
    facts += [f"digest {rec.result['digest']}"] if rec.result.get("digest") else []
    facts += [f"{' and '.join(known)} as recorded; {AGAIN}"] if (known := as_recorded(rec)) else []
    versions = [rec.library, f"python {rec.run.get('python', 'unknown')}", rec.run.get("platform", "")]
    return "; ".join([*facts, *filter(None, versions), f"from {path_text(rec.path.name)}"])


def _lead(rec: Recording, found: Facts) -> tuple[str, str]:
    """The document in a few sentences, and their state: that of the verdict, or `bad`."""
    status, verdict = rec.result.get("status", "cut off"), found.verdict
    message = f"The run {status}." if status == "finished" else f"The run is {status}: {rec.result.get('reason', '')}"
    recorded = ", as recorded" if "verdict" in rec.result else ""
    line = f"Verdict{recorded}: {verdict.line}." if verdict else "It has no verdict."
    message = f"{line} {message}" if verdict else f"{message} {line}"
    message += " The kernel has notes on how it was computed, listed below." if rec.notes() and not verdict else ""
    rated = rec.fact("rated", {})
    uses = {name: peak.tension / rated[name] for name, peak in found.peaks.items() if rated.get(name)}
    if uses:
        most = max(uses, key=lambda name: uses[name])
        message += f" Most used rope: {most}, {100 * uses[most]:.0f} % of its rated tension."
    wrong = complaints(rec)
    bad = wrong or status != "finished" or (not verdict and (rec.notes() or max(uses.values(), default=0.0) > 1.0))
    state = "bad" if bad else verdict.state if verdict else ""
    return " ".join([*(f"Wrong: {what}." for what in wrong), message]), state


def picture(rec: Recording, draw: Callable[[Recording, Path], Path], title: str) -> Iterator[Chart]:
    """A figure as PNG; none if the recording lacks the data."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            yield Chart(title, draw(rec, Path(folder) / "drawn.png").read_bytes())
        except RecordingError:
            return
