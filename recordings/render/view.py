"""A recording as one page: the lift in three dimensions, signals, stages and events with a common time.

`view("run.mcap", "run.html")` writes a self-contained file that any browser opens without network.  The bundle in
`page/` is built from its sources by `npm run build`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.samples import POSE, POSE_COLUMNS, SampleChannel, SampleLayout
from heavylift.recordings.format.text import duration
from heavylift.recordings.format.viewer_messages import Box, boxes_of
from heavylift.recordings.read.extended import ERROR, MEASURED
from heavylift.recordings.read.reader import Recording, guarded
from heavylift.recordings.read.verdict import Judged, recorded_verdict
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import PartFile
from numpy.typing import NDArray

from .bundle import bundled
from .content import event_text, facts_shown, is_inner, load_of, packed, shown, stage_name, thinned

__all__ = ["content", "drawn_boxes", "page", "sample_rows", "view"]

NUMBERS = 2_000_000  # most numbers in a page: 4 bytes each, as base64 10.7 MB
CLEARANCES = 3  # that the page tells
EVENTS = 5000  # most events in a page


def view(path: str | Path, out: str | Path, verdict: Judged | None = None, force: bool = False) -> Path:
    """Write the page of a recording to a .html file; RecordingError if one of them cannot be used.

    `verdict`: where the recording has none of its own.
    """
    out = output_path(out, "a page", (".html",))
    text = page(content(Recording(path), verdict))
    with PartFile(out, "a page", (".html",), force) as file:
        file.stream.write(text.encode())
    return file.path


def page(run: dict[str, Any]) -> str:
    """The page that shows this content."""
    return bundled("page", run, "; img-src data: blob:; connect-src 'self'")


@guarded
def content(rec: Recording, verdict: Judged | None = None) -> dict[str, Any]:
    """All that the page shows of a recording."""
    verdict = verdict or recorded_verdict(rec)
    layout, t, rows = sample_rows(rec)
    columns = shown(layout)
    rows = rows[:, columns.columns]
    ropes = rows[:, 7 * len(columns.bodies) :]
    kept = thinned(load_of(columns.signals, ropes), NUMBERS // max(1, rows.shape[1]))
    rated = rec.fact("rated", {})
    stages = [(e.t_ns * 1e-9, stage_name(e.port, e.value)) for e in rec.events(port="stage")]
    events, told = _events(rec)
    more = [(name, rec.result[name]) for name in ("digest", "reason") if rec.result.get(name)]
    more += [("measured", line) for line in rec.fact("measured", {}).get("told", [])]
    more += [("samples shown", f"{len(kept)} of {len(t)}, peaks kept")] if len(kept) < len(t) else []
    return {
        "title": rec.run.get("scene", rec.run.get("model", rec.path.stem)),
        "status": _status(rec, verdict),
        "facts": facts_shown(rec.run, [*_judged(verdict), *more, *told, *_origin(rec)]),
        **columns.head(),
        "rows": {"t": packed(t[kept], "<f8"), "x": packed(rows[kept])},
        "boxes": drawn_boxes(rec),
        "rig": [{"t": rig.t_ns * 1e-9, "lines": rig.lines} for rig in rec.rigs()],
        "rated": rated,
        "supports": rec.fact("supports", []),
        "stages": [{"t": t, "name": name} for t, name in stages if name],
        "events": events,
        "peaks": [{"name": name, **peak, "rated": rated.get(name)} for name, peak in rec.fact("peaks", {}).items()],
    }


@guarded
def sample_rows(rec: Recording) -> tuple[SampleLayout, NDArray[np.float64], NDArray[np.float64]]:
    """All signals side by side at the instants of the one that was sampled most often, with their layout."""
    signals = {name: rec.signal(name) for name in rec.signals()}
    t = max(
        (s.t for name, s in signals.items() if not name.startswith((MEASURED, ERROR))), key=len, default=np.zeros(0)
    )
    if len(t) < 2:
        raise RecordingError(f"{rec.path}: has no samples to show; let the run last longer")
    channels, parts, start = [], [], 0
    for name, s in signals.items():
        if name.startswith((MEASURED, ERROR)):
            s = s.at(t)
        values = s.values if len(s.t) == len(t) else np.column_stack([np.interp(t, s.t, y) for y in s.values.T])
        names = list(POSE_COLUMNS) if name.startswith(POSE) else s.names
        channels.append(SampleChannel(name, names, s.unit, start, start + len(names)))
        parts.append(values)
        start += len(names)
    return SampleLayout(channels), t, np.hstack(parts)


def _events(rec: Recording) -> tuple[list[dict[str, Any]], list[tuple[str, str]]]:
    """The events for the list, and what is to be said where it is not all of them."""
    found = [
        {"t": e.t_ns * 1e-9, "source": e.source, "text": event_text(e.port, e.type, e.value), "inner": is_inner(e.port)}
        for e in rec.events()
    ]
    if len(found) <= EVENTS:
        return found, []
    kept = [e for e in found if not e["inner"]][:EVENTS]
    return kept, [("events shown", f"the first {len(kept)} of {len(found)}, without orders and inputs")]


def _status(rec: Recording, verdict: Judged | None) -> str:
    status = rec.result.get("status", "cut off")
    colour = f", verdict {'red' if verdict.red else 'green'}" if verdict else ""
    return f"{status}, {duration(float(rec.fact('sim_s', 0.0)))} simulated{colour}"


def _origin(rec: Recording) -> list[tuple[str, str]]:
    return [("recording", rec.path.name), ("made by", rec.library)]


def _judged(verdict: Judged | None) -> list[tuple[str, str]]:
    """The verdict, what was found, and the smallest clearances, among the facts."""
    if verdict is None:
        return []
    rows = [("verdict", verdict.line)]
    rows += [(f.severity, f.sentence + (f", at {duration(f.t)}" if f.t is not None else "")) for f in verdict.findings]
    rows += [
        ("clearance", f"{c.distance:.2f} m, {c.a} and {c.b}, at {duration(c.t)}")
        for c in verdict.clearances[:CLEARANCES]
    ]
    return rows + [("not looked at", sentence) for sentence in verdict.not_looked_at]


def drawn_boxes(rec: Recording) -> list[Box]:
    """The shapes on the bodies."""
    with rec.reading():
        return [box for raw in rec.messages("/scene") for box in boxes_of(raw.data)]
