"""The planner's document as one page that prints well: tables, warnings, the figure of tensions, the lift in pictures.

Self-contained HTML (a browser prints it to PDF); pictures travel inside as data.  Everything that comes from the
recording is escaped.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable
from html import escape
from pathlib import Path

from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.html import Cell, bullets, document, table
from heavylift.recordings.format.text import GENERATOR, duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.settings import settings
from heavylift.recordings.read.verdict import Judged, LimitTable, recorded_verdict
from heavylift.recordings.render.plot import plot
from heavylift.recordings.render.storyboard import storyboard
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .browser import print_page
from .facts import Facts, LoadUse, RopeUse, StageUse, facts

__all__ = ["report"]

LOADED = ("largest load", "at", "may carry", "use")
RULE = "Two cranes together may carry at most 75 % of what they may carry one by one: what 'may carry' says holds that."
STYLE = (Path(__file__).parents[1] / "page" / "report.css").read_text()
PRINTED = f"% {GENERATOR}\n".encode()  # a comment behind the end of a PDF

TOLD = (  # sentences of facts, what they are, and their title
    ("measured", "run less log, uncertainties at 95 %", "Beside a measured lift"),
    ("certified", "figures, with half-widths at 95 %", "How sure the figures are"),
)


def report(path: str | Path, out: str | Path, verdict: Judged | None = None, force: bool = False) -> Path:
    """Write the document of a recording to a .html or .pdf file; RecordingError if one of them cannot be used.

    `verdict`: of who knows the scene, where the recording has none of its own (`heavylift report` gives it).
    """
    out = output_path(out, "a report", (".html", ".pdf"))
    rec = Recording(path)
    verdict = verdict or recorded_verdict(rec)
    page = _page(rec, facts(rec, verdict), _pictures(rec), verdict)
    data = print_page(page, out) + PRINTED if out.suffix.lower() == ".pdf" else page.encode()
    return written(data, out, "a report", (".html", ".pdf"), force)


def _page(rec: Recording, found: Facts, pictures: list[str], verdict: Judged | None) -> str:
    limits = verdict.limits if verdict else None
    judged = limits is not None
    title = f"Lift report: {rec.run.get('scene', rec.path.stem)}"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="quiet">{escape(_origin(rec))}</p>',
        _verdict(rec, found, verdict),
        _findings(verdict) if verdict else _warnings(found),
        *(_limits(limits) if limits else ()),
        *(_clearances(verdict) if verdict else ()),
        _notes(found),
        *(table([head], [[x] for x in rec.told(fact)], "told", title) for fact, head, title in TOLD),
        table(["what", ""], found.scene, "told", "Scene"),
        table(["crane", *LOADED], [_load(c) for c in found.cranes], title="Cranes"),
        f'<p class="quiet">{RULE}</p>' if len(found.cranes) > 1 else "",
        table(["hook", *LOADED], [_load(h) for h in found.hooks], title="Hooks"),
        table(["rope", "peak", "at", "stage", "rated", "use"], [_rope(r, judged) for r in found.ropes], title="Ropes"),
        table(
            ["stage", "from", "lasts", "rope used most", "use", "dynamic factor", "block above ground"],
            [_stage(s, limits.dynamic[0] if limits and limits.dynamic else None, judged) for s in found.stages],
            title="Stages",
        ),
        f'<p class="quiet">{escape(_amplified(found, limits))}</p>' if any(s.dynamic for s in found.stages) else "",
        *(f'<p><img src="data:image/png;base64,{data}" alt=""></p>' for data in pictures),
    ]  # fmt: skip
    return document(title, STYLE, parts)


def _origin(rec: Recording) -> str:
    facts_ = [f"{duration(float(rec.fact('sim_s', 0.0)))} simulated", *settings(rec.run).values()]
    facts_ += [f"digest {rec.result['digest']}"] if rec.result.get("digest") else []
    versions = [rec.library, f"python {rec.run.get('python', 'unknown')}", rec.run.get("platform", "")]
    return "; ".join([*facts_, *filter(None, versions), f"from {rec.path.name}"])


def _verdict(rec: Recording, found: Facts, verdict: Judged | None) -> str:
    status = rec.result.get("status", "cut off")
    used = [r for r in found.ropes if r.rated]
    most = max(used, key=lambda r: r.peak / (r.rated or 1.0), default=None)
    told = f"The run {status}." if status == "finished" else f"The run is {status}: {rec.result.get('reason', '')}"
    bad = status != "finished"
    if verdict is not None:
        told, bad = f"Verdict: {verdict.line}. {told}", bad or verdict.red
    else:
        n = len(found.warnings)
        told += f" {n} warning{'s' if n > 1 else ''}, listed below." if n else " It has no verdict."
        told += " The kernel has notes on how it was computed, listed below." if found.notes else ""
        bad = bad or bool(n or found.notes)
    if most and most.rated:
        told += f" The rope used most is {most.name}: {100 * most.peak / most.rated:.0f} % of its rated tension."
    return f'<p class="verdict{" bad" * bad}">{escape(told)}</p>'


def _findings(verdict: Judged) -> str:
    """What was found, red ones first."""
    rows: list[list[Cell]] = []
    for f in verdict.findings:
        where = f" [{f.where}]" if f.where else ""
        told = f"{f.sentence}{where}"
        rows.append([f.severity, (told, f.severity == "red"), "" if f.t is None else _clock(f.t), f.stage])
    return table(["", "what", "at", "stage"], rows, "told", "Findings")


def _clearances(verdict: Judged) -> list[str]:
    """The smallest ones, and what nobody looked at."""
    rows: list[list[Cell]] = []
    for c in verdict.clearances:
        red = any(f.kind == "clearance" and f.subject == f"{c.a} and {c.b}" for f in verdict.findings)
        kept = f"{c.limit:g} m" if c.limit else "not touched"
        rows.append([f"{c.a} and {c.b}", (f"{c.distance:.2f} m", red), kept, _clock(c.t), c.place])
    unseen = bullets(verdict.not_looked_at, "quiet")
    return [
        table(["between", "at least", "to be kept", "at", "where"], rows, "placed", "Smallest clearances"),
        f'<p class="quiet">Not looked at:</p>{unseen}' if unseen else "",
    ]


def _notes(found: Facts) -> str:
    return table(["what", "at"], [[(told, True), _clock(t)] for t, told in found.notes], title="Notes of the kernel")


def _warnings(found: Facts) -> str:
    return table(
        ["who", "what", "at"], [[w.who, (w.what, True), _clock(w.when)] for w in found.warnings], title="Warnings"
    )


def _amplified(found: Facts, limits: LimitTable | None) -> str:
    """The largest dynamic factor of the run beside that which a standard foresees."""
    each = [(factor, crane, s.name) for s in found.stages for crane, factor in s.dynamic.items()]
    factor, crane, stage = max(each)
    told = f"Dynamic factor: {factor:.3f} simulated ({crane}, {stage})"
    if limits is None or limits.dynamic is None:
        return f"{told}."
    return f"{told}, {limits.dynamic[0]:g} foreseen ({limits.dynamic[1]}); what is beyond it is marked."


def _load(c: LoadUse) -> list[Cell]:
    use = c.load / c.capacity if c.capacity else 0.0
    return [
        c.name,
        f"{c.load / 1e3:.1f} t",
        _clock(c.when),
        f"{c.capacity / 1e3:.0f} t",
        (f"{100 * use:.0f} %", use > 1),
    ]


def _rope(r: RopeUse, judged: bool) -> list[Cell]:
    """A rope; its rating is that at its longest, so the table of limits tells what is beyond, if there is one."""
    rated: list[Cell] = ["", ""]
    if r.rated:
        use = r.peak / r.rated
        rated = [f"{r.rated / 1e3:.0f} kN", (f"{100 * use:.0f} %", use > 1 and not judged)]
    return [r.name, f"{r.peak / 1e3:.1f} kN", _clock(r.when), r.stage, *rated]


def _limits(limits: LimitTable) -> list[str]:
    """The table of limits, and what was assumed or not judged."""
    rows: list[list[Cell]] = [[(cell, _beyond(cell)) for cell in row] for row in limits.rows]
    return [table(limits.head, rows, "placed", "Limits"), bullets(limits.told, "quiet")]


def _beyond(cell: str) -> bool:
    """Whether a cell is a use of more than everything."""
    number = cell.removesuffix(" %")
    return number != cell and number.replace(".", "", 1).isdecimal() and float(number) > 100.0


def _stage(s: StageUse, band: float | None, judged: bool) -> list[Cell]:
    factors = ", ".join(f"{crane} {factor:.3f}" for crane, factor in s.dynamic.items())
    beyond = band is not None and any(factor > band for factor in s.dynamic.values())
    low = "" if s.lowest is None else f"{s.lowest:.2f} m"
    use = (f"{100 * s.use:.0f} %", s.use > 1 and not judged)
    return [s.name, _clock(s.start), duration(s.end - s.start), s.rope, use, (factors, beyond), low]


def _clock(seconds: float) -> str:
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02}:{rest:04.1f}" if hours else f"{minutes}:{rest:04.1f}"


def _pictures(rec: Recording) -> list[str]:
    """The lift and its tensions as PNG in base64; what a recording has nothing of is left out."""
    found = []
    drawings: list[Callable[[Path, Path], Path]] = [storyboard, plot]
    with tempfile.TemporaryDirectory() as folder:
        for number, draw in enumerate(drawings):
            try:
                picture = draw(rec.path, Path(folder) / f"{number}.png")
            except RecordingError:
                continue
            found.append(base64.b64encode(picture.read_bytes()).decode())
    return found
