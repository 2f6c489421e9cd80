"""Contents of the page as plain data, in the same form for a file and for a run in progress.

Numbers are sent as base64 of little-endian floats. Samples are thinned to a maximum number: of those that would share a
pixel, only the two with the largest and the smallest load of the ropes are kept.
"""

import base64
import hashlib
import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import POSE, POSE_COLUMNS, SampleLayout, unit_of
from heavylift.recordings.format.text import LISTED
from numpy.typing import NDArray

Floats = NDArray[np.float64]
PAGE = Path(__file__).parents[1] / "page"
LEFT_OUT = ("account", "rope/peak_time", "rope/length_rate")  # for tables, not for the eye
FLOATING = {*POSE_COLUMNS, "vx", "vy", "vz", "wx", "wy", "wz"}  # of free joints: the scene shows these
INNER = ("order", "input", "state")  # ports on which models talk among themselves
SENTENCES = LISTED | {  # by type of message, with what only a list of all events tells
    "Attitude": lambda x: (
        f"{x['actor']} turned {'past' if x['rising'] else 'back below'} {degrees(x['angle']):.4g} degrees"
    ),
    "Done": lambda x: f"move of {x['actor']} done",
    "Reached": lambda x: f"{x['actor']} reached",
}
FACTS = ("scene", "model", "seed", "samples_hz", "python", "platform")


class PageColumns(NamedTuple):
    """The columns of a sample row that the page shows: poses of all bodies, then signals as (group, name, unit)."""

    bodies: list[str]
    signals: list[tuple[str, str, str]]
    columns: NDArray[np.intp]

    def head(self) -> dict[str, object]:
        """Return the names of bodies and signals as plain data."""
        return {
            "bodies": [{"name": name} for name in self.bodies],
            "signals": [{"group": group, "name": name, "unit": unit} for group, name, unit in self.signals],
        }


def shown(layout: SampleLayout) -> PageColumns:
    """Return the columns of a sample row that the page shows."""
    poses = [c for c in layout.channels if c.topic.startswith(POSE)]
    columns = [k for c in poses for k in range(c.start, c.stop)]
    signals = []
    for c in layout.channels:
        if c.topic.startswith((POSE, *LEFT_OUT)):
            continue
        for k, name in enumerate(c.names):
            if not (c.topic.startswith("joint/") and name.rpartition(".")[2] in FLOATING):
                signals.append((c.topic, name, unit_of(c.unit, name)))
                columns.append(c.start + k)
    return PageColumns([c.topic.removeprefix(POSE) for c in poses], signals, np.array(columns, np.intp))


def packed(values: Floats, kind: str = "<f4") -> str:
    """Return an array as base64 of little-endian floats in C order; raises ValueError if a number is too large."""
    largest = np.abs(values).max(initial=0.0, where=np.isfinite(values))
    if largest > np.finfo(kind).max:
        raise ValueError(f"the number {largest:.3g} is too large to be drawn")
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()


def deflated(values: NDArray[np.generic]) -> str:
    """Return an array as base64 of deflate-compressed bytes, with bytes of equal significance grouped together."""
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(-1, values.dtype.itemsize).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode()


def event_shown(t_ns: int, source: str, port: str, type_: str, value: object) -> dict[str, object]:
    """Return an event as the page shows it: time, source, and a sentence or its type and fields."""
    fields = value if isinstance(value, dict) else {"": value}
    inner = is_inner(port)
    message = None if inner else _sentence(type_, fields)
    if message is None:
        carried = ", ".join(f"{name} {_text(x)}".strip() for name, x in fields.items() if x not in (None, "", [], {}))
        message = f"{port}: {type_}" + (f" ({carried})" if carried else "")
    return {"t": t_ns * 1e-9, "source": source, "text": message, "inner": inner}


def _sentence(type_: str, fields: Mapping[str, Any]) -> str | None:
    """Return a sentence for planners about an event; None for events that do not concern them."""
    try:
        return str(SENTENCES[type_](dict(fields))) or None
    except (LookupError, ValueError, ArithmeticError, AttributeError, TypeError):
        return None  # of a model that only calls its message so


def facts_shown(run: Mapping[str, str], more: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the facts of a run that the page shows, as (name, text)."""
    return [(name.replace("_", " "), run[name]) for name in FACTS if name in run] + [*settings(run).items(), *more]


def stage_name(port: str, value: object) -> str | None:
    """Return the name of the stage that begins with an event; None if the event does not begin a stage."""
    name = value.get("name") if isinstance(value, dict) else None
    return _text(name) if port == "stage" and name else None


def is_inner(port: str) -> bool:
    """Return whether a port only connects models within a coupled model."""
    return port.startswith(INNER)


def _inert(json: str) -> str:
    """Return JSON in which characters that could end a script element or begin markup are escaped."""
    return json.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else msgspec.json.encode(value).decode()


def load_of(signals: Sequence[tuple[str, str, str]], rows: Floats) -> Floats:
    """Return the load shown for each sample row: the sum of all rope tensions, or of all signals without ropes."""
    ropes = [k for k, (group, _, _) in enumerate(signals) if group == "rope/tension"]
    load: Floats = np.nansum(rows[:, ropes or list(range(len(signals)))], axis=1)  # logs may cover a part of the run
    return load


def bundled(name: str, content: object, policy: str = "") -> str:
    """Return the self-contained HTML page `name` from the folder `page/`, with `content` inserted.

    Its Content-Security-Policy allows only the script of the page, identified by its hash, and the requests that
    `policy` allows.
    """
    script = (PAGE / f"{name}.js").read_text(encoding="utf-8").replace("</script", "<\\/script")
    sha256 = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    parts = {
        "style": (PAGE / f"{name}.css").read_text(encoding="utf-8"),
        "run": _inert(msgspec.json.encode(content).decode()),
        "script": script,
        "policy": f"default-src 'none'; script-src 'sha256-{sha256}'; style-src 'unsafe-inline'{policy}",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], (PAGE / f"{name}.html").read_text(encoding="utf-8"))
