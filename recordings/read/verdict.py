"""The statements of a recording about its run: the verdict with its checks, smallest clearances and limits; peaks; and
contradictions between the recorded result and its events and rows.

The verdict is made with knowledge of the scene (`coordinator.verdict`) and stored as the fact `verdict` of the result.
It is also in the text of `heavylift info FILE`.
"""

from collections import Counter
from math import nan
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from heavylift.kernel.description.findings import NOT_MODELLED, Check, State, clock, findings
from heavylift.kernel.errors import path_text
from heavylift.recordings.format import machines
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.text import duration
from heavylift.recordings.sheets.sheet import Table, listed
from heavylift.recordings.write.sink import Peak

from .contents import READ, Contents
from .reader import Recording

AGAIN = "`heavylift replay --verify` computes all of it again"
ROUNDED = 1e-8  # of a tension, and of 1 MN: more than rows are rounded by
Vector = tuple[float, float, float]


class Clearance(msgspec.Struct, frozen=True, kw_only=True):
    """The smallest distance [m] between two objects in a run, with its time [s], nearest points [m] and place."""

    a: str
    b: str
    distance: float
    t: float
    limit: float  # [m], 0 if only penetration is checked
    p_WA: Vector  # nearest points in the world frame [m]
    p_WB: Vector
    place: str

    @property
    def message(self) -> str:
        """The clearance as a sentence."""
        return f"{self.distance:.2f} m, {self.a} and {self.b}, at {clock(self.t)}"


class RecordedVerdict(msgspec.Struct, frozen=True, kw_only=True):
    """A complete verdict: its state and summary line, and all checks with the worst first.

    `dynamic`: the dynamic factor that a standard prescribes for this lift, and its source. `tables`: first the checks
    as people read them, with those of one kind and state in one row; then tables for the report that require the scene.
    """

    red: bool
    line: str
    state: State = "amber"
    clearances: tuple[Clearance, ...] = ()
    checks: tuple[Check, ...] = ()
    dynamic: tuple[float, str] | None = None
    tables: tuple[Table, ...] = ()

    @property
    def not_modelled(self) -> tuple[str, ...]:
        """Effects that no check of the run includes, as text."""
        return tuple(x.sentence.partition(": ")[2] for x in self.checks if x.why == NOT_MODELLED)

    @property
    def findings(self) -> tuple[Check, ...]:
        """The findings of the verdict, in order of severity: exceeded limits, warnings, notes."""
        return findings(self.checks)


def contents(rec: Recording) -> Contents:
    """Return the contents of a whole recording; the file is read only once."""
    with rec.reading():
        if rec.contents is not None:
            return rec.contents
        found = rec.contents = Contents()
        wanted = [x.name for x in rec.topics.values() if "port" in x.metadata or x.name.startswith(READ)]
        for name, raw in rec.stream(*wanted):
            topic = rec.topics[name]
            found.take(name, topic.metadata, topic.form, raw.publish_time, raw.data)
        found.end()
        return found


def recorded_verdict(rec: Recording) -> RecordedVerdict | None:
    """Return the verdict in a recording; None if the recording contains no verdict."""
    if not rec.result.get("verdict"):
        return None
    with rec.reading():
        return msgspec.convert(rec.fact("verdict"), RecordedVerdict)


def as_recorded(rec: Recording) -> list[str]:
    """Return the names of recorded results that cannot be recomputed, such as the verdict."""
    compared = ["verdict"] if "verdict" in rec.result else []
    compared += ["times of peaks"] if rec.fact("peaks", {}) else []
    return compared + (["digest"] if contents(rec).unknown and "digest" in rec.result else [])


def recorded_peaks(rec: Recording) -> dict[str, Peak]:
    """Return the peak tension [N] and its time [s] of each rope, from the recorded result."""
    with rec.reading():
        found = msgspec.convert(rec.fact("peaks", {}), dict[str, dict[str, float]])
        peaks = {name: Peak(peak["tension"], peak["time"]) for name, peak in found.items()}
        if not np.isfinite([*peaks.values()]).all():
            raise ValueError("a recorded peak is not a number")
        return peaks


def complaints(rec: Recording) -> list[str]:
    """Return sentences about contradictions in a recording, such as damaged bytes or a digest that disagrees."""
    if rec.complaints is None:
        rec.complaints = [f"{rec.path}: {what}" for what in _contradictions(rec) if what]
    return rec.complaints


def _contradictions(rec: Recording) -> list[str]:
    found, digest, peaks = contents(rec), rec.result.get("digest"), recorded_peaks(rec)
    problems = [rec.damage()]
    if digest and found.torn:
        problems.append(found.torn)
    elif digest and not found.unknown and found.digest != digest:
        problems.append(f"events and rows give the digest {found.digest}, the result says {digest[:64]}")
    if "samples" in rec.result and (n := rec.fact("samples", 0)) != found.rows:
        problems.append(f"there are {found.rows} samples, the result says {n:g}")
    for name in sorted(peaks.keys() | found.peaks.keys()) if rec.result else []:
        stated, is_ = (x[name].tension if name in x else nan for x in (peaks, found.peaks))
        if not abs(stated - is_) <= ROUNDED * max(abs(is_), 1e6):
            problems.append(
                f"the peak of {name} is {is_ / 1e3:.6g} kN in the rows, the result says {stated / 1e3:.6g} kN"
            )
    return problems


def opened(path: str | Path | Recording) -> Recording:
    """Return the recording at a path; a recording that is already open is returned unchanged."""
    return path if isinstance(path, Recording) else Recording(path)


def info(path: str | Path | Recording, verdict: RecordedVerdict | None = None) -> str:
    """Return a description of the recording at `path` as text; `verdict` replaces the recorded verdict if given."""
    rec = opened(path)
    verdict = verdict or recorded_verdict(rec)
    with rec.reading():
        parts = [
            _head(rec, verdict), _findings(verdict), _clearances(verdict), _peaks(rec), _results(rec), _events(rec),
            _signals(rec), _channels(rec), _attachments(rec),
        ]  # fmt: skip
    return "\n\n".join(part for part in parts if part)


def info_data(path: str | Path | Recording, verdict: RecordedVerdict | None = None) -> dict[str, Any]:
    """Return a description of a recording as plain data in SI units.

    Facts of run and result, verdict, file, signals, channels, attachments. `wrong`: contradictions in the recording;
    `as_recorded`: values that cannot be computed again.
    """
    rec = opened(path)
    verdict = verdict or recorded_verdict(rec)
    with rec.reading():
        return {
            "path": path_text(rec.path),
            "bytes": rec.size,
            "library": rec.library,
            "run": {name: rec.fact(name) for name in rec.run},
            "result": {name: rec.fact(name) for name in rec.result if name != "verdict"},
            "settings": settings(rec.run),
            "verdict": msgspec.to_builtins(verdict),
            "wrong": complaints(rec),
            "as_recorded": as_recorded(rec),
            "signals": [{"name": s, "unit": rec.unit(s), "columns": rec.columns(s)} for s in rec.signals()],
            "notes": [{"t": t, "sentence": sentence} for t, sentence in rec.notes()],
            "stages": [{"t": t, "name": name} for t, name in rec.stages()],
            "channels": [{"topic": t.name, "schema": t.schema, "messages": t.messages} for t in rec.topics.values()],
            "checkpoints": [{"t": t / 1e9, "bytes": size} for (t, _), size in rec.checkpoints.items()],
            "attachments": {name: len(data) for name, data in rec.attachments.items()},
        }


def _head(rec: Recording, verdict: RecordedVerdict | None) -> str:
    run = rec.run
    lines = [("model", run["model"]) if "model" in run else ("scene", run.get("scene", "without a name"))]
    lines += [("settings", f"seed {run['seed']}")] if run.get("seed") else []
    lines += settings(run).items()
    reason = rec.result.get("reason")
    status = rec.result.get("status", "cut off")
    lines.append(("status", f"{status}: {reason}" if reason else status))
    placement = rec.fact("placement", {}) if "placement" in run else {}
    if len(placement) not in (0, len(rec.fact("nodes", []))):
        shown = (p if nodes == [p] else f"{p}: {', '.join(nodes)}" for p, nodes in placement.items())
        lines.append(("processes", "; ".join(shown)))
    if rec.result:
        sim, wall = rec.fact("sim_s", 0.0), rec.fact("wall_s", 0.0)
        factor = f", {sim / wall:.3g} x real time" if wall > 0 else ""
        lines.append(("time", f"{duration(sim)} simulated in {duration(wall)}{factor}"))
        again = ", computed again" if "digest" in rec.result and not (complaints(rec) or contents(rec).unknown) else ""
        lines.append(("digest", f"{rec.result.get('digest', 'none')}{again}"))
    lines += [("plan", message)] if (message := machines.unread(machines.plan_of(rec.attachments))) else []
    lines += [("wrong", what) for what in complaints(rec)]
    lines += [("recorded", f"{' and '.join(known)}; {AGAIN}")] if (known := as_recorded(rec)) else []
    if verdict is not None:
        recorded = " (as recorded)" if "verdict" in rec.result else ""
        lines.append(("verdict", f"{verdict.line}{recorded}"))
    else:
        lines += [("note", sentence) for _, sentence in rec.notes()]
    if branch := rec.fact("branch"):
        stage = f" (stage {branch['stage']})" if branch["stage"] else ""
        lines.append(("branch", f"of {branch['of']}, equal to it up to {branch['t']:.3f} s{stage}"))
    lines += [(fact, line) for fact in ("measured", "certified") for line in rec.message(fact)]
    lines.append(("file", f"{_size(rec.size)}, {sum(t.messages for t in rec.topics.values())} messages, {rec.library}"))
    return "\n".join([str(rec.path), *(f"  {name:<9} {text}" for name, text in lines)])


def _findings(verdict: RecordedVerdict | None) -> str:
    found = verdict.findings if verdict else ()
    return "\n".join(f"  {x.word}: {x.message}" for x in found)


def _clearances(verdict: RecordedVerdict | None) -> str:
    rows = [
        [f"{c.a} and {c.b}", f"{c.distance:.2f} m", duration(c.t), c.place]
        for c in (verdict.clearances if verdict else ())
    ]
    return listed(["between", "at least", "at", "where"], rows)


def _peaks(rec: Recording) -> str:
    rated = rec.fact("rated", {})
    rows = []
    for name, peak in ((name, x) for name, x in recorded_peaks(rec).items() if "~" not in name):  # no pieces of ropes
        limit = rated.get(name)
        use = [f"{limit / 1e3:.0f} kN", f"{100 * peak.tension / limit:.0f} %"] if limit else ["", ""]
        rows.append([name, f"{peak.tension / 1e3:.1f} kN", duration(peak.time), *use])
    return listed(["rope", "peak", "at", "rated", "use"], rows)


def _results(rec: Recording) -> str:
    rows = [
        [
            path,
            message["type"],
            ", ".join(f"{name} {x:.6g}" if type(x) is float else f"{name} {x}" for name, x in message["value"].items()),
        ]
        for path, message in rec.results().items()
    ]
    return listed(["result of", "type", "fields"], rows)


def _events(rec: Recording) -> str:
    count: Counter[str] = Counter()
    ports: dict[str, list[str]] = {}
    for topic in rec.topics.values():
        if "port" in topic.metadata:
            count[topic.metadata["model"]] += topic.messages
            ports.setdefault(topic.metadata["model"], []).append(f"{topic.metadata['port']} {topic.messages}")
    return listed(["model", "events", "by port"], [[m, str(n), ", ".join(ports[m])] for m, n in count.items()])


def _signals(rec: Recording) -> str:
    rows = []
    for name in rec.signals():
        if not name.startswith(POSE):
            rows.append([name, str(len(rec.columns(name))), rec.unit(name)])
    poses = [name for name in rec.signals() if name.startswith(POSE)]
    rows += [[f"{POSE}*", str(len(poses)), rec.unit(poses[0])]] if poses else []
    return listed(["signal", "columns", "unit"], rows)


def _channels(rec: Recording) -> str:
    rows = [
        [topic.name, str(topic.messages), topic.schema]
        for topic in sorted(rec.topics.values())
        if "port" not in topic.metadata
    ]
    return listed(["channel", "messages", "schema"], rows)


def _attachments(rec: Recording) -> str:
    rows = [[name, _size(len(data))] for name, data in rec.attachments.items()]
    if kept := rec.checkpoints:
        rows.append([f"{len(kept)} checkpoints, for `heavylift branch`", _size(sum(kept.values()))])
    return listed(["attachment", "size"], rows)


def _size(n: int) -> str:
    return f"{n} B" if n < 1000 else f"{n / 1e3:.1f} kB" if n < 1e6 else f"{n / 1e6:.1f} MB"
