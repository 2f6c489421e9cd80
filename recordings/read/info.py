"""The text of `heavylift info FILE`: what was run, how it ended, how fast, what stands in the file."""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
from heavylift.kernel.errors import path_text
from heavylift.recordings.format import machines
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.text import duration, table

from .reader import Recording
from .verdict import AGAIN, RecordedVerdict, as_recorded, complaints, contents, opened, recorded_peaks, recorded_verdict


def info(path: str | Path | Recording, verdict: RecordedVerdict | None = None) -> str:
    """Describe the recording at `path` in lines of text; `verdict`: replaces a missing one."""
    rec = opened(path)
    verdict = verdict or recorded_verdict(rec)
    with rec.reading():
        parts = [
            _head(rec, verdict),
            _findings(verdict),
            _clearances(verdict),
            _peaks(rec),
            _results(rec),
            _events(rec),
            _signals(rec),
            _channels(rec),
            _attachments(rec),
        ]
    return "\n\n".join(part for part in parts if part)


def info_data(path: str | Path | Recording, verdict: RecordedVerdict | None = None) -> dict[str, Any]:
    """Plain data in SI units: facts of run and result, verdict, file, signals, channels, attachments. `wrong`:
    contradictions; `as_recorded`: values not computed again."""
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
    return "\n".join(f"  {f.severity}: {f.message}" for f in found)


def _clearances(verdict: RecordedVerdict | None) -> str:
    rows = [
        [f"{c.a} and {c.b}", f"{c.distance:.2f} m", duration(c.t), c.place]
        for c in (verdict.clearances if verdict else ())
    ]
    return table(["between", "at least", "at", "where"], rows)


def _peaks(rec: Recording) -> str:
    rated = rec.fact("rated", {})
    rows = []
    for name, peak in ((name, x) for name, x in recorded_peaks(rec).items() if "~" not in name):  # no pieces of ropes
        limit = rated.get(name)
        use = [f"{limit / 1e3:.0f} kN", f"{100 * peak.tension / limit:.0f} %"] if limit else ["", ""]
        rows.append([name, f"{peak.tension / 1e3:.1f} kN", duration(peak.time), *use])
    return table(["rope", "peak", "at", "rated", "use"], rows)


def _results(rec: Recording) -> str:
    rows = [
        [
            path,
            message["type"],
            ", ".join(f"{name} {x:.6g}" if type(x) is float else f"{name} {x}" for name, x in message["value"].items()),
        ]
        for path, message in rec.results().items()
    ]
    return table(["result of", "type", "fields"], rows)


def _events(rec: Recording) -> str:
    count: Counter[str] = Counter()
    ports: dict[str, list[str]] = {}
    for topic in rec.topics.values():
        if "port" in topic.metadata:
            count[topic.metadata["model"]] += topic.messages
            ports.setdefault(topic.metadata["model"], []).append(f"{topic.metadata['port']} {topic.messages}")
    return table(["model", "events", "by port"], [[m, str(n), ", ".join(ports[m])] for m, n in count.items()])


def _signals(rec: Recording) -> str:
    rows = []
    for name in rec.signals():
        if not name.startswith(POSE):
            rows.append([name, str(len(rec.columns(name))), rec.unit(name)])
    poses = [name for name in rec.signals() if name.startswith(POSE)]
    rows += [[f"{POSE}*", str(len(poses)), rec.unit(poses[0])]] if poses else []
    return table(["signal", "columns", "unit"], rows)


def _channels(rec: Recording) -> str:
    rows = [
        [topic.name, str(topic.messages), topic.schema]
        for topic in sorted(rec.topics.values())
        if "port" not in topic.metadata
    ]
    return table(["channel", "messages", "schema"], rows)


def _attachments(rec: Recording) -> str:
    rows = [[name, _size(len(data))] for name, data in rec.attachments.items()]
    if kept := rec.checkpoints:
        rows.append([f"{len(kept)} checkpoints, for `heavylift branch`", _size(sum(kept.values()))])
    return table(["attachment", "size"], rows)


def _size(n: int) -> str:
    return f"{n} B" if n < 1000 else f"{n / 1e3:.1f} kB" if n < 1e6 else f"{n / 1e6:.1f} MB"
