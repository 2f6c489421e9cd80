"""A recording as one page: the lift in 3D, signals, stages and events on a common time axis.

`view("run.mcap", "run.html")` writes a self-contained file that any browser opens without a network. The bundle in
`page/` is built from its sources by `npm run build`.
"""

from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from heavylift.kernel.description.findings import NOT_MODELLED
from heavylift.kernel.errors import RecordingError, path_text
from heavylift.recordings.format import machines
from heavylift.recordings.format.samples import POSE, POSE_COLUMNS, SampleChannel, SampleLayout, thinned
from heavylift.recordings.format.text import duration
from heavylift.recordings.format.viewer_messages import DrawnBox
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import AGAIN, RecordedVerdict, recorded_peaks, recorded_verdict
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written
from numpy.typing import NDArray

from .content import PageColumns, bundled, deflated, event_shown, facts_shown, load_of, packed, shown, stage_name

Floats = NDArray[np.float64]
BESIDE = "beside/"  # before the group of a signal of a second recording
GLASS = 0.25  # opacity of its bodies
COARSE = 250_000  # numbers that are seen at once: 4 bytes each, as base64 1.3 MB
FINE = 4_000_000  # most numbers in a page, deflated: the browser unpacks them when the page is there
CLEARANCES = 3  # that the page tells
EVENTS = 5000  # most events in a page


def view(
    path: str | Path,
    out: str | Path,
    verdict: RecordedVerdict | None = None,
    force: bool = False,
    beside: str | Path | None = None,
) -> Path:
    """Write the page of a recording to a .html file; raises RecordingError if a file cannot be read or written.

    `verdict`: used if the recording contains no verdict; `beside`: a second recording, shown as transparent bodies and
    dashed curves.
    """
    out = output_path(out, "a page", (".html",))
    other = None if beside is None else Recording(beside)
    return written(page(content(Recording(path), verdict, other)), out, "a page", (".html",), force)


def page(run: dict[str, object]) -> str:
    """Return the HTML page of a run, with this content inserted."""
    return bundled("page", run, "; img-src data: blob:; connect-src 'self'")


def content(
    rec: Recording, verdict: RecordedVerdict | None = None, beside: Recording | None = None
) -> dict[str, object]:
    """Return all data that the page of a recording shows. `beside`: a second recording whose data are added."""
    with rec.reading():
        verdict = verdict or recorded_verdict(rec)
        layout, names = layout_of(rec), rec.signals()
        columns = shown(layout)
        loads = _loads(rec, columns)
        width = max(1, len(columns.columns)) * (1 if beside is None else 2)
        kept = thinned([loads], FINE // width)
        signals = rec.picked(names, kept)
        t, rows = signals[names[0]].t, np.hstack([s.values for s in signals.values()])[:, columns.columns]
        head, boxes = columns.head(), rec.boxes()
        if beside is not None:
            with beside.reading():
                other = _ghost(beside, columns, t)
            rows, boxes = np.hstack([other.poses, rows, other.values]), [*boxes, *other.boxes]
            more_signals = [*columns.signals, *other.signals]
            head = PageColumns([*other.bodies, *columns.bodies], more_signals, columns.columns).head()
            head["beside"] = beside.path.name
        seen = thinned([loads[kept]], COARSE // width)
        fine = {"detail": {"t": deflated(t), "x": deflated(rows.T.astype("<f4"))}} if len(seen) < len(kept) else {}
        rated = rec.fact("rated", {})
        stages = [(e.t_ns * 1e-9, stage_name(e.port, e.value)) for e in rec.events(port="stage")]
        events, message = _events(rec)
        message += [("beside", f"{beside.path.name}, as glass and dashed curves")] if beside is not None else []
        more = [("as recorded", f"verdict, digest and peaks; {AGAIN}")] if rec.result else []
        more += [(name, rec.result[name]) for name in ("digest", "reason") if rec.result.get(name)]
        more += [(fact, line) for fact in ("measured", "certified") for line in rec.message(fact)]
        more += [("samples shown", f"{len(kept)} of {len(loads)}, peaks kept")] if len(kept) < len(loads) else []
        made = [("recording", path_text(rec.path.name)), ("made by", rec.library)]
        return {
            "title": rec.run.get("scene", rec.run.get("model", rec.path.stem)),
            "status": _status(rec, verdict),
            "facts": facts_shown(rec.run, [*_verdict_rows(verdict), *more, *message, *made]),
            **head,
            "rows": {"t": packed(t[seen], "<f8"), "x": packed(rows[seen])},
            **fine,
            "block": _block(rec),
            "boxes": boxes,
            "rig": [{"t": rig.t_ns * 1e-9, "lines": rig.lines} for rig in rec.rigs()],
            "rated": rated,
            "supports": [s for s in rec.fact("supports", []) if not s.get("on")],  # what moves is drawn as it is
            "stages": [{"t": t, "name": name} for t, name in stages if name],
            "events": events,
            "peaks": [
                {"name": name, **x._asdict(), "rated": rated.get(name)} for name, x in recorded_peaks(rec).items()
            ],
        }


def _loads(rec: Recording, columns: PageColumns) -> Floats:
    """Return the sum of rope loads at each sample, by which samples are thinned."""
    names = ["rope/tension"] if "rope/tension" in rec.signals() else list(dict.fromkeys(s[0] for s in columns.signals))
    return np.concatenate([load_of([], np.hstack(values)) for _, values in rec.blocks(names or rec.signals())])


def _block(rec: Recording) -> dict[str, object] | None:
    """Return the name, mass [kg], centre of mass and lugs of the block, in its frame [m]; None without a block."""
    block = machines.block(machines.plan_of(rec.attachments))
    if not block:
        return None
    return {
        "name": block["body"],
        "mass": block["mass"],
        "com": block.get("com", (0.0, 0.0, 0.0)),
        "lugs": [{"name": name, "p": p} for name, p in block.get("lugs", {}).items()],
    }


def sample_rows(rec: Recording) -> tuple[SampleLayout, Floats, Floats]:
    """Return the layout of the sample rows of a recording, the common times of all signals [s], and the rows."""
    with rec.reading():
        layout, parts = layout_of(rec), [(times, np.hstack(values)) for times, values in rec.blocks(rec.signals())]
        return layout, np.concatenate([times for times, _ in parts]) / 1e9, np.vstack([rows for _, rows in parts])


def layout_of(rec: Recording) -> SampleLayout:
    """Return the layout of rows that contain all signals of a recording; raises RecordingError if the recording has no
    samples to show."""
    least = min((rec.topics[topic].messages for topic in ("/samples", "/poses") if topic in rec.topics), default=0)
    if least < 2 or not rec.signals():
        models = "a DEVS model has messages only: `heavylift plot` draws them"
        instead = models if "model" in rec.run else "let the run last longer"
        raise RecordingError(f"{rec.path}: the recording has no samples to show; {instead}")
    channels, start = [], 0
    for name in rec.signals():
        names = list(POSE_COLUMNS) if name.startswith(POSE) else rec.columns(name)
        channels.append(SampleChannel(name, names, rec.unit(name), start, start + len(names)))
        start += len(names)
    return SampleLayout(channels)


def _events(rec: Recording) -> tuple[list[dict[str, object]], list[tuple[str, str]]]:
    """Return the events for the page's list, and a remark if the list is incomplete."""
    found = [event_shown(e.t_ns, e.source, e.port, e.type, e.value) for e in rec.events()]
    if len(found) <= EVENTS:
        return found, []
    kept = [e for e in found if not e["inner"]][:EVENTS]
    return kept, [("events shown", f"the first {len(kept)} of {len(found)}, without orders and inputs")]


def _status(rec: Recording, verdict: RecordedVerdict | None) -> str:
    status = rec.result.get("status", "cut off")
    colour = f", verdict {verdict.state}" if verdict else ""
    return f"{status}, {duration(rec.fact('sim_s', 0.0))} simulated{colour}"


def _verdict_rows(verdict: RecordedVerdict | None) -> list[tuple[str, str]]:
    """Return the verdict, findings, and the smallest clearances as rows of the facts."""
    if verdict is None:
        return []
    rows = [("verdict", verdict.line)]
    rows += [(x.word, x.message) for x in verdict.findings]
    rows += [("clearance", c.message) for c in verdict.clearances[:CLEARANCES]]
    return rows + [(NOT_MODELLED, what) for what in verdict.not_modelled]


class _Ghost(NamedTuple):
    """A second recording on the page: names and shapes of transparent bodies; signals as (group, name, unit); poses (n,
    7 bodies), values (n, signals)."""

    bodies: list[str]
    boxes: list[DrawnBox]
    signals: list[tuple[str, str, str]]
    poses: Floats
    values: Floats


def _ghost(rec: Recording, like: PageColumns, t: Floats) -> _Ghost:
    """Return the bodies and signals of another recording at times (n,) [s]; after its end bodies stay in place and
    signals are NaN."""
    known, drawn = rec.signals(), rec.boxes()
    bodies = [b for b in like.bodies if POSE + b in known and any(box.body == b for box in drawn)]
    signals = [s for s in like.signals if s[0] in known and s[1] in rec.columns(s[0])]
    rec.load([*(POSE + b for b in bodies), *dict.fromkeys(group for group, _, _ in signals)])
    poses, values = [np.zeros((len(t), 0))], [np.zeros((len(t), 0))]
    for body in bodies:
        pose = rec.signal(POSE + body)
        x = pose.at(np.clip(t, pose.t[0], pose.t[-1])).values.copy()
        x[:, 3:] /= np.linalg.norm(x[:, 3:], axis=1, keepdims=True)
        poses.append(x)
    at = {group: rec.signal(group).at(t) for group, _, _ in signals}
    values += [at[group][name][:, None] for group, name, _ in signals]
    names = {body: f"{body} {rec.path.name}" for body in bodies}
    boxes = [
        msgspec.structs.replace(box, body=names[box.body], colour=(*box.colour[:3], GLASS))
        for box in drawn
        if box.body in names
    ]
    other = [(BESIDE + group, name, unit) for group, name, unit in signals]
    return _Ghost(list(names.values()), boxes, other, np.hstack(poses), np.hstack(values))
