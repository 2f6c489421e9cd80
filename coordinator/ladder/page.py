"""What is written of a measured ladder: .html (a page), .png or .svg (the work-precision figure), .csv or .json."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from html import escape
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
from heavylift.nodes.plan.fidelity import percent
from heavylift.recordings.format.html import Cell, bullets, document, table
from heavylift.recordings.format.text import cell
from heavylift.recordings.render.paper import save
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .pictures import BAND, COLOURS, LIMIT, PAPER, STYLE, in_page, styled, wide
from .tradeoff import Measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".html", ".png", ".svg", ".csv", ".json")
FLOOR = 1e-9  # relative error that is drawn at least


def checked(out: str | Path) -> Path:
    """The path if a report can be written there."""
    return output_path(out, "a trade-off", KINDS)


def write(measured: Measured, out: str | Path, force: bool = False) -> Path:
    """Write in the form that the ending asks for, and return where."""
    path = checked(out)
    match path.suffix.lower():
        case ".html":
            text = page(measured)
        case ".csv":
            text = _csv(measured)
        case ".json":
            text = json.dumps(data(measured), indent=1) + "\n"
        case _:
            return save(_drawn(measured, "path"), path, force, dpi=110)
    return written(text, path, "a trade-off", KINDS, force)


def data(measured: Measured) -> dict[str, Any]:
    """All of it as plain data, SI units; what is infinite is null."""
    found = msgspec.to_builtins(measured)
    found["distributed"] = [
        x | {"s_per_grant": y.per_grant} for x, y in zip(found["distributed"], measured.distributed, strict=True)
    ]
    return {key: _finite(value) for key, value in found.items()}


def _finite(x: object) -> object:
    if isinstance(x, dict):
        return {key: _finite(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [_finite(value) for value in x]
    return None if isinstance(x, float) and not isfinite(x) else x


def page(measured: Measured) -> str:
    """A page without scripts, for the screen and on paper."""
    title = f"Speed against accuracy: {measured.scene}"
    good = sorted((row for row in measured.rows if row.worst < inf), key=lambda row: row.run_s)
    failed = [[row.level, row.how, row.reason] for row in measured.rows if row.worst == inf]
    head = ["level", "steps", "kernel s", "start s", *measured.ask]
    body: list[list[Cell]] = [
        [row.level, row.how, f"{row.run_s:.3g}", f"{row.start_s:.3g}"]
        + [(percent(row.errors[q]), row.errors[q] > measured.limit) for q in measured.ask]
        for row in good
    ]
    marks = ["pick" if row is measured.pick else "" for row in good]
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict{"" if measured.pick else " bad"}">{escape(measured.advice)}</p>',
        f"<pre>{escape(measured.pick.command)}</pre>" if measured.pick else "",
        f"<figure>{in_page(_drawn(measured, 'none'))}</figure>",
        "<h2>Rungs, the fastest first</h2>",
        wide(table(head, body, "left2", marks=marks)),
        f"<h2>Without a run</h2>\n{wide(table(['level', 'steps', 'why'], failed, 'left3'))}" if failed else "",
        *_communication(measured),
        "<h2>What these numbers are worth</h2>",
        bullets(_worth(measured)),
    ]
    return document(title, STYLE, parts)


def _worth(measured: Measured) -> list[str]:
    lines = [f"Errors are differences to the finest rung, {measured.reference}, relative to what is asked."]
    for what, moved in measured.worth.items():
        lines.append(f"By {what}, that is itself open by {', '.join(f'{q} {percent(e)}' for q, e in moved.items())}.")
    lines.append("One run at a time on one core, in one process, without a recording; times are CPU time.")
    return [
        *lines,
        f"{measured.spent:.3g} s of {measured.budget:.3g} s were used; {measured.left_out} rungs did not fit in.",
    ]


def _communication(measured: Measured) -> list[str]:
    parts: list[str] = []
    if measured.held:
        told = "Two solvers, one for each end of a rope, hold its force for h: it gains energy. Nodes never do so."
        rows: Sequence[Sequence[Cell]] = [
            [x.pair, f"{x.omega:.3g}", f"{x.h * 1e3:g}", f"{100 * x.measured:.3f} %", f"{100 * x.law:.3f} %"]
            for x in measured.held
        ]
        head = ["rope", "w [rad/s]", "h [ms]", "damping measured", "-w h/4"]
        parts += [
            "<h2>Forces held between processes</h2>",
            f'<p class="quiet">{told}</p>',
            wide(table(head, rows, "left1")),
        ]
    if measured.distributed:
        rows = [
            [x.where, x.buys, f"{x.wall_s:.3g}", f"{x.kernel_s:.3g}", f"{x.cpu_s:.3g}", str(x.grants),
             f"{x.per_grant * 1e3:.3g}", f"{x.recorded_bytes / 1e6:.3g}"]
            for x in measured.distributed
        ]  # fmt: skip
        head = [
            "nodes in",
            "buys",
            "wall s",
            "kernel s",
            "CPU s",
            "grants",
            "ms per grant beside the kernel",
            "recording MB",
        ]
        parts += ["<h2>What is distributed, what that costs and buys</h2>", wide(table(head, rows, "left2"))]
    return parts


def _csv(measured: Measured) -> str:
    """One line a rung; errors relative."""
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(
        map(cell, ["level", "steps", "start [s]", "kernel [s]", *(f"{q} error" for q in measured.ask), "failed"])
    )
    for row in measured.rows:
        lines.writerow(
            map(
                cell,
                [row.level, row.how, row.start_s, row.run_s, *(row.errors.get(q) for q in measured.ask), row.reason],
            )
        )
    return out.getvalue()


def _drawn(measured: Measured, fonts: str) -> Figure:
    """Speed against the worst error, both logarithmic: up and to the left is better."""
    from matplotlib.figure import Figure

    with styled(fonts):
        canvas = Figure(figsize=(11.0, 5.6), facecolor=PAPER, layout="constrained")
        axes = canvas.subplots()
        rows = [row for row in measured.rows if row.worst < inf]
        for i, level in enumerate(dict.fromkeys(row.level for row in rows)):
            mine = [row for row in rows if row.level == level]
            x, y = [max(row.worst, FLOOR) for row in mine], [row.run_s for row in mine]
            axes.plot(x, y, "-o", color=COLOURS[i % len(COLOURS)], ms=5, lw=0.9, label=level)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.invert_yaxis()
        axes.axvspan(axes.get_xlim()[0], measured.limit, color=BAND, lw=0, zorder=0)
        axes.axvline(measured.limit, color=LIMIT, lw=1.1, ls=(0, (6, 3)), zorder=1)
        axes.set_xlabel(f"worst error of {', '.join(measured.ask)}")
        axes.set_ylabel("CPU seconds of the kernel (up is faster)")
        axes.legend(frameon=False, loc="lower left")
        canvas.draw_without_rendering()
        return canvas
