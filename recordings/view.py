"""A recording as one page: the lift in three dimensions, signals, stages and events with a common time.

`view("run.mcap", "run.html")` writes a self-contained file that any browser opens without network.  The bundle in
`page/` is built from its sources by `npm run build`; numbers travel as base64 of little-endian floats in a JSON
element in which no markup can begin.
"""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from heavylift.kernel.errors import RecordingError
from numpy.typing import NDArray

from .drawing import Box, boxes_of
from .info import duration
from .partfile import output_path
from .reader import RecordedEvent, Recording
from .samples import POSE, POSE_COLUMNS

__all__ = ["view"]

PAGE = Path(__file__).parent / "page"
LEFT_OUT = ("account", "rope/peak_time", "rope/length_rate")  # for tables, not for the eye
FLOATING = {*POSE_COLUMNS, "vx", "vy", "vz", "wx", "wy", "wz"}  # of free joints: the scene shows these
INNER = ("order", "input")  # ports on which models talk among themselves
FACTS = ("scene", "accuracy", "seed", "samples_hz", "python", "platform")


def view(path: str | Path, out: str | Path) -> Path:
    """Write the page of a recording to a .html file; RecordingError if one of them cannot be used."""
    out = output_path(out)
    if out.suffix.lower() not in (".html", ".htm"):
        raise RecordingError(f"{out}: a page is written as .html; give it this ending")
    page = (PAGE / "page.html").read_text()
    parts = {
        "style": (PAGE / "page.css").read_text(),
        "run": inert(msgspec.json.encode(content(Recording(path))).decode()),
        "script": (PAGE / "page.js").read_text().replace("</script", "<\\/script"),
    }
    try:
        out.write_text(re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], page))
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror}); choose another place") from None
    return out


def inert(json: str) -> str:
    """The same JSON without a character that could end a script element or begin markup."""
    return json.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def content(rec: Recording) -> dict[str, Any]:
    """All that the page shows."""
    poses = [name for name in rec.signals() if name.startswith(POSE)]
    signals = {name: rec.signal(name) for name in rec.signals() if not name.startswith((POSE, *LEFT_OUT))}
    times = next((rec.signal(name).t for name in rec.signals()), np.zeros(0))
    if len(times) < 2:
        raise RecordingError(f"{rec.path}: has no samples to show; let the run last longer")
    rated = rec.fact("rated", {})
    return {
        "title": f"{rec.run.get('scene', rec.path.stem)}",
        "status": _status(rec),
        "facts": _facts(rec),
        "t": _packed(times, "<f8"),
        "bodies": [{"name": name.removeprefix(POSE), "x": _packed(rec.signal(name).values)} for name in poses],
        "boxes": _boxes(rec),
        "rig": [{"t": rig.t_ns * 1e-9, "lines": rig.lines} for rig in rec.rigs()],
        "rated": rated,
        "signals": [
            {"group": group, "name": name, "unit": signal.unit, "y": _packed(signal.values[:, i])}
            for group, signal in signals.items()
            for i, name in enumerate(signal.names)
            if not (group.startswith("joint/") and name.rpartition(".")[2] in FLOATING)
        ],
        "stages": [{"t": e.t_ns * 1e-9, "name": _text(e.value.get("name"))} for e in rec.events(port="stage")],
        "events": [
            {"t": e.t_ns * 1e-9, "source": e.source, "text": _told(e), "inner": e.port in INNER} for e in rec.events()
        ],
        "peaks": [{"name": name, **peak, "rated": rated.get(name)} for name, peak in rec.fact("peaks", {}).items()],
    }


def _packed(values: NDArray[np.float64], kind: str = "<f4") -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else msgspec.json.encode(value).decode()


def _status(rec: Recording) -> str:
    status = rec.result.get("status", "cut off")
    return f"{status}, {duration(float(rec.fact('sim_s', 0.0)))} simulated"


def _facts(rec: Recording) -> list[tuple[str, str]]:
    facts = [(name.replace("_", " "), rec.run[name]) for name in FACTS if name in rec.run]
    facts += [(name, rec.result[name]) for name in ("digest", "reason") if rec.result.get(name)]
    return [*facts, ("recording", rec.path.name), ("made by", rec.library)]


def _boxes(rec: Recording) -> list[Box]:
    with rec.reading():
        return [box for raw in rec.messages("/scene") for box in boxes_of(raw.data)]


def _told(event: RecordedEvent) -> str:
    """An event in a few words: its type and what it carries."""
    value = event.value if isinstance(event.value, dict) else {"": event.value}
    shown = ", ".join(f"{name} {_text(x)}".strip() for name, x in value.items() if x not in (None, "", [], {}))
    return f"{event.port}: {event.type}" + (f" ({shown})" if shown else "")
