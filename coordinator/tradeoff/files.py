"""What is written of a measured scene: .html (the page), .png or .svg (the figure), .csv or .json (the table)."""

from __future__ import annotations

import csv
import io
import json
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec
from heavylift.recordings.format.text import cell
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .figure import drawn
from .measuring import Measured
from .page import page
from .verdict import Answer, Row, answers

KINDS = (".html", ".png", ".svg", ".csv", ".json")


def checked(out: str | Path) -> Path:
    """The path if a report can be written there."""
    return output_path(out, "a trade-off", KINDS)


def write(measured: Measured, out: str | Path, force: bool = False) -> Path:
    """Write in the form that the ending asks for, and return where (recordings/write/outputs.py)."""
    path = checked(out)
    match path.suffix.lower():
        case ".html":
            text = page(measured)
        case ".csv":
            text = _csv(measured)
        case ".json":
            text = _json(data(measured))
        case _:
            return drawn(measured, path, force)
    return written(text, path, "a trade-off", KINDS, force)


def _json(whole: dict[str, object]) -> str:
    """A line for each key, and for each entry of a list, so that two reports can be compared by eye."""
    lines = []
    for key, value in whole.items():
        text = json.dumps(value)
        if isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n  " + ",\n  ".join(map(json.dumps, value)) + "\n ]"
        lines.append(f" {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def data(measured: Measured) -> dict[str, object]:
    """Everything but the time histories as plain data, SI units; what is infinite is null."""
    pick, following = measured.verdict.pick, measured.verdict.next_faster
    converged = {name: {q: _number(e) for q, e in moved.items()} for name, moved in measured.converged.items()}
    return {
        "scene": measured.scene,
        "ask": list(measured.ask),
        "limit": measured.limit,
        "verdict": measured.verdict.sentence,
        "more": measured.verdict.more,
        "command": measured.words(pick) if pick else "",
        "answers": [_answer(measured, answer) for answer in answers(measured.ask, measured.rows)],
        "use": pick and _row(pick, measured.limit),
        "next_faster_that_fails": following and _row(following, measured.limit),
        "reference": {"setting": str(measured.reference), "moved_by": converged},
        "machine": msgspec.to_builtins(measured.machine),
        "budget_s": measured.budget,
        "spent_s": _number(measured.spent),
        "settings_left_out": measured.left_out,
        "settings_settled": measured.settled,
        "rungs": {rung.name: rung.words for rung in measured.rungs},
        "settings": [_row(row, measured.limit) for row in measured.rows],
        "held_forces": [msgspec.to_builtins(x) for x in measured.held],
        "distributed": [msgspec.to_builtins(x) | {"s_per_grant": x.per_grant} for x in measured.distributed],
    }


def _answer(measured: Measured, answer: Answer) -> dict[str, object]:
    found: dict[str, object] = {"ask": answer.quantity, "limit": answer.limit, "setting": None}
    if answer.row is None:
        return found
    numbers = {"waits_s": _number(answer.row.waits_s), "real_time_factor": _number(answer.row.speed)}
    numbers |= {"error": _number(answer.row.worst)}
    return found | {"setting": str(answer.row), **numbers, "command": measured.words(answer.row)}


def _row(row: Row, limit: float) -> dict[str, Any]:
    passes = {q: e <= limit for q, e in row.errors.items()}
    numbers = {"waits_s": row.waits_s, "start_s": row.start_s, "wall_s": row.wall_s, "cpu_s": row.cpu_s}
    numbers |= {"real_time_factor": row.speed, "messages": row.messages}
    more = {"position": row.position, "energy": row.energy, "constraint_drift_m": row.drift, "spread": row.spread}
    return {
        **{"rung": row.rung, "method": row.method, "setting": row.how},
        **{name: _number(x) for name, x in numbers.items()},
        "errors": {q: _number(e) for q, e in row.errors.items()},
        "passes": passes,
        **{name: _number(x) for name, x in more.items()},
        **{"runs": row.runs, "reason": row.reason, "notes": list(row.notes)},
    }


def _number(x: float | None) -> float | None:
    """To four digits."""
    if x is None or not isfinite(x):
        return None
    return x if isinstance(x, int) else float(f"{x:.4g}")


def _csv(measured: Measured) -> str:
    """One line a setting; errors relative, units in the names of the columns."""
    out = io.StringIO()
    head = ["rung", "method", "step or tolerance", *(f"{what} [s]" for what in ("waits", "start", "wall", "CPU"))]
    head += ["real-time factor", "messages"]
    head += [column for q in measured.ask for column in (f"{q} error", f"{q} passes")]
    head += [f"places [{measured.unit}]", "energy error", "constraint drift [m]", "runs", "spread of CPU", "failed"]
    table = csv.writer(out, lineterminator="\n")
    table.writerow(map(cell, head))
    for row in measured.rows:
        known = _row(row, measured.limit)
        times = ("waits_s", "start_s", "wall_s", "cpu_s", "real_time_factor")
        cells = [known[k] for k in ("rung", "method", "setting", *times, "messages")]
        for q in measured.ask:
            passes = known["passes"].get(q)
            cells += [known["errors"].get(q), "" if passes is None else "yes" if passes else "no"]
        cells += [known[k] for k in ("position", "energy", "constraint_drift_m", "runs", "spread")]
        table.writerow(map(cell, [*cells, row.reason]))
    return out.getvalue()
