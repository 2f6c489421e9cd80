"""Files of a measured ladder: a page with tables, .png or .svg (the work-precision figure), .csv or .json."""

import json
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
from heavylift.nodes.plan.fidelity import percent
from heavylift.recordings.render.storyboard import save
from heavylift.recordings.sheets.sheet import (
    BAND,
    COLOURS,
    LIMIT,
    PAPER,
    Cell,
    Chart,
    Marked,
    Notes,
    Part,
    Sheet,
    Table,
    columns,
    in_page,
    styled,
    table_csv,
)
from heavylift.recordings.sheets.workbook import printed
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .tradeoff import MeasuredLadder, Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".html", ".pdf", ".xlsx", ".png", ".svg", ".csv", ".json")
CANDIDATES = "Candidates, the fastest first"
HELD = columns("rope", "w [rad/s] .3", "h [ms]", "damping measured [%] .3", "-w h/4 [%] .3")
APART = columns("nodes in", "buys", "wall [s] .2", "kernel [s] .2", "CPU [s] .2", "grants .0",
                "per grant beside the kernel [ms] .3", "recording [MB] .2")  # fmt: skip
FLOOR = 1e-9  # relative error that is drawn at least


def checked(out: str | Path) -> Path:
    """Return the path after checking that a trade-off can be written there."""
    return output_path(out, "a trade-off", KINDS)


def write(measured: MeasuredLadder, out: str | Path, force: bool = False) -> Path:
    """Write a measured trade-off in the format given by the file ending, and return the path."""
    path = checked(out)
    match path.suffix.lower():
        case ".png" | ".svg":
            return save(_drawn(measured, "path"), path, force, dpi=110)
        case ".json":
            text: str | bytes = json.dumps(data(measured), indent=1) + "\n"
        case ".csv":
            text = table_csv(next(table for table in tradeoff_sheet(measured).tables if table.title == CANDIDATES))
        case _:
            text = printed(tradeoff_sheet(measured), path)
    return written(text, path, "a trade-off", KINDS, force)


def data(measured: MeasuredLadder) -> dict[str, Any]:
    """Return a measured trade-off as plain data in SI units, with infinite values as null."""
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


def tradeoff_sheet(measured: MeasuredLadder) -> Sheet:
    """Return the page of a trade-off of speed against accuracy: recommendation, figure, and table of model levels and
    time steps."""
    asked = (f"error of {quantity} [%]" for quantity in measured.ask)
    heads = columns("level", "steps", "kernel [s]", "start [s]", *asked, "failed")
    rows = [_row(measured, row) for row in sorted(measured.rows, key=lambda row: (row.worst == inf, row.run_s))]
    command = (measured.pick.command,) if measured.pick else ()
    parts: list[Part] = [
        Notes("The same run", command),
        Chart("Speed against the worst error", in_page(_drawn(measured, "none"))),
        Table(CANDIDATES, heads, tuple(rows)),
        *_communication(measured),
        Notes("What these numbers are worth", tuple(_worth(measured))),
    ]
    title = f"Speed against accuracy: {measured.scene}"
    return Sheet(title, measured.advice, "" if measured.pick else "bad", tuple(parts))


def _row(measured: MeasuredLadder, row: Row) -> tuple[Cell, ...]:
    """Return the cells of a candidate; errors above the accuracy are marked, and so is the recommended candidate."""
    advised = row is measured.pick
    level = Marked(row.level, "pick") if advised else row.level
    errors = [(row.errors.get(q), row.errors.get(q, 0.0) > measured.limit) for q in measured.ask]
    message = (
        None if e is None else Marked(_short(100.0 * e)) if beyond else _short(100.0 * e) for e, beyond in errors
    )
    return level, row.how, _short(row.run_s), _short(row.start_s), *message, row.reason


def _short(x: float) -> float:
    """The value with two significant digits."""
    return float(f"{x:.2g}")


def _worth(measured: MeasuredLadder) -> list[str]:
    lines = [f"Errors are differences to the finest model level, {measured.reference}, relative to what is asked."]
    for what, moved in measured.worth.items():
        lines.append(f"By {what}, that is itself open by {', '.join(f'{q} {percent(e)}' for q, e in moved.items())}.")
    lines.append("One run at a time on one core, in one process, without a recording; times are CPU time.")
    return [
        *lines,
        f"{measured.spent:.3g} s of {measured.budget:.3g} s were used; {measured.left_out} candidates did not fit in.",
    ]


def _communication(measured: MeasuredLadder) -> list[Table]:
    message = "Two solvers, one for each end of a rope, hold its force for h: it gains energy. Nodes never do so."
    held = tuple((x.pair, x.omega, x.h * 1e3, 100 * x.measured, 100 * x.law) for x in measured.held)
    apart = tuple(
        (x.where, x.buys, x.wall_s, x.kernel_s, x.cpu_s, x.grants, x.per_grant * 1e3, x.recorded_bytes / 1e6)
        for x in measured.distributed
    )
    return [
        Table("Forces held between processes", HELD, held, (message,)),
        Table("What is distributed, what that costs and buys", APART, apart),
    ]


def _drawn(measured: MeasuredLadder, fonts: str) -> "Figure":
    """Draw speed against the largest error, both logarithmic: candidates up and to the left are better."""
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
