"""Recordings in the folder: their verdicts, the data that the page plays back, and reports and drawings to keep."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any

import msgspec
from heavylift.coordinator.verdict.judging import verdict_of
from heavylift.kernel.description.findings import Check
from heavylift.kernel.errors import HeavyliftError, RecordingError, SceneError
from heavylift.nodes.scene.text.files import within
from heavylift.recordings import Recording
from heavylift.recordings.documents.document import alternatives, project_of, report, report_sheet
from heavylift.recordings.documents.facts import facts
from heavylift.recordings.drawings import drawings
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.render.view import content, page
from heavylift.recordings.sheets.sheet import page_of, table_html
from heavylift.recordings.write.partfile import written

ENDING = ".mcap"
SCENES = (".yaml", ".yml")
MOST = 100  # recordings that are listed
STUDY, LIMITS = "summary.html", "-limits.html"  # pages of a sweep in its folder, and of limits
KEPT = {
    ".pdf": "application/pdf", ".dxf": "image/vnd.dxf", ".svg": "image/svg+xml",
    ".xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}  # fmt: skip


def of_checks(state: str, line: str, checks: Iterable[Check], tables: Iterable[str] = ()) -> dict[str, Any]:
    """Return a verdict as plain data, from which the workbench page draws its list of checks."""
    listed = [msgspec.to_builtins(check) | {"word": check.word, "load": check.load} for check in checks]
    return {"state": state, "line": line, "checks": listed, "tables": list(tables)}


def recordings(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the recordings of a folder, newest first, their verdicts, and whether their scenes changed since."""
    found = sorted(((-x.stat().st_mtime_ns, x) for x in folder.glob(f"*{ENDING}")), key=lambda x: (x[0], x[1].name))
    for changed, path in found[:MOST]:
        state, line, scenes = _verdict(path, changed)
        older = any(_changed(folder / name, text) for name, text in scenes)
        yield {"name": path.name, "state": state, "line": line, "older": older}


@lru_cache(4 * MOST)
def _verdict(path: Path, changed: int) -> tuple[str, str, tuple[tuple[str, bytes], ...]]:
    """Return state and line of a recorded verdict, and the name and text of the recorded scene."""
    try:
        rec = Recording(path)
        verdict = verdict_of(rec)
        scenes = tuple((name, text) for name, text in rec.attachments.items() if Path(name).suffix in SCENES)
    except (HeavyliftError, OSError) as error:
        return "none", str(error), ()
    return (verdict.state, verdict.line, scenes) if verdict else ("none", "", scenes)


def _changed(path: Path, text: bytes) -> bool:
    try:
        return path.read_bytes().splitlines() != text.splitlines()
    except OSError:
        return False


def studies(folder: Path) -> list[str]:
    """Return the pages of sweeps and limits in a folder."""
    found = chain(folder.glob(f"*/{STUDY}"), folder.glob(f"*{LIMITS}"))
    return [path.relative_to(folder).as_posix() for path in sorted(found) if path.is_file()]


def played(folder: Path, name: str, other: str = "") -> dict[str, Any]:
    """Return one recording with its verdict for the 3D player of the page, or two with the tables that compare them."""
    rec, verdict = _recorded(folder, name)
    found: dict[str, Any] = {"run": {}, "checks": None, "differences": []}
    beside = None
    if other:
        beside, judged = _recorded(folder, other)
        sheet = alternatives(facts(rec, verdict), facts(beside, judged))
        found["differences"] = [table_html(table) for table in sheet.tables]
    found["run"] = content(rec, verdict, beside)
    if verdict:
        tables = [table_html(table) for table in report_sheet(rec, verdict).tables if not table.blank]
        found["checks"] = of_checks(verdict.state, verdict.line, verdict.checks, tables)
        near = [{"names": [c.a, c.b], "t": c.t, "ends": [c.p_WA, c.p_WB]} for c in verdict.clearances]
        found["checks"] |= {"notes": list(verdict.tables[0].notes if verdict.tables else ()), "ends": "", "near": near}
    return found


def result(folder: Path, kind: str, name: str) -> str:
    """Return the page of a recording in the folder: its 3D `view` or its `report`; raises HeavyliftError if there is no
    such recording."""
    rec, verdict = _recorded(folder, name)
    if kind not in ("view", "report"):
        raise SceneError(f"'{kind}' is not a page of a recording; choose view or report")
    return page(content(rec, verdict)) if kind == "view" else page_of(report_sheet(rec, verdict, pictures=True))


def compared(folder: Path, a: str, b: str) -> str:
    """Return the page that shows two recordings of the folder beside each other; raises HeavyliftError if one does not
    exist."""
    one, other = (facts(*_recorded(folder, name)) for name in (a, b))
    return page_of(alternatives(one, other, pictures=True))


def keep(folder: Path, name: str) -> dict[str, list[str]]:
    """Write report and drawings of a recording into the folder; return the file names, and a sentence for each
    failure."""
    rec, verdict = _recorded(folder, name)
    stem = rec.path.with_suffix("")
    made, refused = list[str](), list[str]()
    for ending in (".pdf", ".xlsx", ".dxf"):
        try:
            made.append(report(rec, f"{stem}-report{ending}", verdict, force=True).name)
        except RecordingError as error:
            refused.append(str(error))
    for number, drawing in enumerate(drawings(rec, verdict, project_of(rec)._asdict()), 1):
        path = Path(f"{stem}-drawing-{number}.svg")
        made.append(written(str(drawing.image), path, "a drawing", (".svg",), True).name)
    return {"made": made, "refused": refused}


def kept(folder: Path, name: str) -> tuple[bytes, str]:
    """Return content and media type of a report, drawing or study page in the folder; raises SceneError if there is
    none."""
    path = _inside(folder, name)
    study = path.name == STUDY or path.name.endswith(LIMITS)
    if not path.is_file() or not (study or path.suffix in KEPT):
        raise SceneError(f"'{name}' is not a report, drawing or study page in this folder; check the name")
    return path.read_bytes(), KEPT.get(path.suffix, "text/html")


def _inside(folder: Path, name: str) -> Path:
    try:
        return within(folder, folder / name)
    except ValueError as error:
        raise SceneError(f"'{name}': {error}") from None


def _recorded(folder: Path, name: str) -> tuple[Recording, RecordedVerdict | None]:
    path = _inside(folder, name)
    if path.suffix != ENDING:
        raise SceneError(f"'{name}' is not a recording; choose a file whose name ends in {ENDING}")
    rec = Recording(path)
    return rec, verdict_of(rec)
