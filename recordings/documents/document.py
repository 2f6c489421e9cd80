"""The planner's document as one page that prints well: approval, verdict, tables, the tensions, the lift in pictures.

Self-contained HTML (a browser prints it to PDF on A4); pictures travel inside as data.  Everything that comes from the
recording is escaped.  The same tables make a workbook.
"""

from __future__ import annotations

import base64
import datetime
import tempfile
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import NamedTuple

from heavylift.kernel.errors import RecordingError, path_text
from heavylift.recordings.format.html import bullets, document, table
from heavylift.recordings.format.settings import settings
from heavylift.recordings.format.text import GENERATOR, duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import AGAIN, Judged, as_recorded, complaints, opened, recorded_verdict
from heavylift.recordings.render.plot import plot
from heavylift.recordings.render.storyboard import storyboard
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .browser import print_page
from .facts import Facts, facts
from .tables import Table, tables
from .workbook import workbook

FORMATS = (".html", ".pdf", ".xlsx")
APPROVED = ("", "name", "date", "signature")
PRINTED = f"% {GENERATOR}\n".encode()  # a comment behind the end of a PDF


class Issue(NamedTuple):
    """What the document says of itself: its revision, and who prepared it, if that is known."""

    revision: str = "0"
    author: str = ""


FIRST = Issue()


def report(
    path: str | Path | Recording,
    out: str | Path,
    verdict: Judged | None = None,
    force: bool = False,
    issue: Issue = FIRST,
) -> Path:
    """Write the document of a recording to a .html, .pdf or .xlsx file; RecordingError if one of them cannot be used.

    `verdict`: of who knows the scene, where the recording has none of its own (`heavylift report` gives it).
    """
    out = output_path(out, "a report", FORMATS)
    rec = opened(path)
    verdict = verdict or recorded_verdict(rec)
    found = facts(rec, verdict)
    title = f"Lift report: {rec.run.get('scene', rec.path.stem)}"
    first = Table("Issue", APPROVED, _approval(issue), "issue", [_origin(rec)])
    made, (told, state) = [first, *tables(rec, found, verdict)], _verdict(rec, found, verdict)
    if out.suffix.lower() == ".xlsx":
        return written(workbook(title, told, made), out, "a report", FORMATS, force)
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict {state}">{escape(told)}</p>',
        _section(first),
        *_picture(rec, plot, "tensions over time"),
        *map(_section, made[1:]),
        *_picture(rec, storyboard, "the lift at some instants"),
    ]
    page = document(title, "", parts)
    data = print_page(page, out) + PRINTED if out.suffix.lower() == ".pdf" else page.encode()
    return written(data, out, "a report", FORMATS, force)


def _approval(issue: Issue) -> list[list[str]]:
    """Revision and date, and three lines to be signed."""
    date = datetime.date.today().isoformat()
    return [
        ["revision", issue.revision, date, ""],
        ["prepared", issue.author, date if issue.author else "", ""],
        ["checked", "", "", ""],
        ["approved", "", "", ""],
    ]


def _section(part: Table) -> str:
    told = (
        bullets(part.told, "quiet")
        if len(part.told) > 1
        else "".join(f'<p class="quiet">{escape(x)}</p>' for x in part.told)
    )
    return f"<section>{table(part.head, part.rows, part.kind, part.title)}{told}</section>"


def _origin(rec: Recording) -> str:
    facts_ = [f"{duration(rec.fact('sim_s', 0.0))} simulated", *settings(rec.run).values()]
    facts_ += [f"digest {rec.result['digest']}"] if rec.result.get("digest") else []
    facts_ += [f"{' and '.join(told)} as recorded; {AGAIN}"] if (told := as_recorded(rec)) else []
    versions = [rec.library, f"python {rec.run.get('python', 'unknown')}", rec.run.get("platform", "")]
    return "; ".join([*facts_, *filter(None, versions), f"from {path_text(rec.path.name)}"])


def _verdict(rec: Recording, found: Facts, verdict: Judged | None) -> tuple[str, str]:
    """The document in a few sentences, and their state: that of the verdict, or `bad`."""
    status = rec.result.get("status", "cut off")
    used = [r for r in found.ropes if r.rated]
    most = max(used, key=lambda r: r.peak / (r.rated or 1.0), default=None)
    told = f"The run {status}." if status == "finished" else f"The run is {status}: {rec.result.get('reason', '')}"
    bad = status != "finished"
    if verdict is not None:
        recorded = ", as recorded" if "verdict" in rec.result else ""
        told, bad = f"Verdict{recorded}: {verdict.line}. {told}", bad or verdict.red
    else:
        n = len(found.warnings)
        told += f" {n} warning{'s' if n > 1 else ''}, listed below." if n else " It has no verdict."
        told += " The kernel has notes on how it was computed, listed below." if found.notes else ""
        bad = bad or bool(n or found.notes)
    if most and most.rated:
        told += f" The rope used most is {most.name}: {100 * most.peak / most.rated:.0f} % of its rated tension."
    wrong = complaints(rec)
    state = "bad" if bad or wrong else verdict.state if verdict else ""
    return " ".join([*(f"Wrong: {what}." for what in wrong), told]), state


def _picture(rec: Recording, draw: Callable[[Recording, Path], Path], name: str) -> list[str]:
    """A drawing as PNG in base64; none of what a recording has nothing of."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            picture = draw(rec, Path(folder) / "drawn.png")
        except RecordingError:
            return []
        data = base64.b64encode(picture.read_bytes()).decode()
    return [f'<p><img src="data:image/png;base64,{data}" alt="{name}"></p>']
