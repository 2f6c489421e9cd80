"""The sheet of `heavylift limits`: how far each number may go, what limits it there, and the use on the way."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite, nan
from typing import TYPE_CHECKING

import numpy as np
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.sheets.figures import COLOURS, LIMIT, in_page
from heavylift.recordings.sheets.sheet import Cell, Chart, Notes, Sheet, Table, columns

from .limiting import FoundLimit
from .page import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEADS = columns("number", "green up to", "red at", "most used there", "to", "in", "at [h:min:s]", "what turns red")
COLUMNS = 3  # of figures
TOLD = (
    "The largest value of each number, alone, for which the verdict of a run is green. "
    "Bars: of the use that turns red, by tighter steps and the next richer rung, at 95 %."
)


def limits_table(found: Sequence[FoundLimit]) -> Table:
    """A row for each number."""
    return Table("How far each number may go", HEADS, tuple(map(_row, found)))


def _row(one: FoundLimit) -> tuple[Cell, ...]:
    if one.wrong:
        return one.path, one.shown(one.green), one.shown(one.red), "", "", "", None, one.wrong
    most = one.most
    where = str(most["limit"]), one.used, str(most["limit stage"]), float(most["limit at [s]"])
    used = where if isfinite(most.get("use", nan)) else ("", "", "", None)
    return one.path, one.limit, one.shown(one.red), *used, one.why


def limits_sheet(scene: LoadedScene, found: Sequence[FoundLimit]) -> Sheet:
    """Table, reasons and curves."""
    drawn = [one for one in found if one.red is not None and len(_points(one)[0]) > 1]
    reasons = Notes("What turns red", tuple(f"{one.path}: {one.wrong or one.why}" for one in found))
    charts = [Chart("Largest use of a load's limit on the way", _figure(drawn))] if drawn else []
    return Sheet(f"How far {scene.plan.name} may go", TOLD, "", (limits_table(found), reasons, *charts))


def _figure(found: Sequence[FoundLimit]) -> str:
    columns = min(COLUMNS, len(found))
    figure = canvas(ceil(len(found) / columns), columns)
    for ax, one in zip(figure.axes, found, strict=False):
        _drawn(ax, one)
    for ax in figure.axes[len(found) :]:
        ax.set_axis_off()
    return in_page(figure)


def _drawn(ax: Axes, one: FoundLimit) -> None:
    x, use, green = _points(one)
    ax.plot(x, 100.0 * use, color=COLOURS[0], lw=1.2, alpha=0.6)
    for good, colour in ((True, COLOURS[2]), (False, LIMIT)):
        ax.plot(x[green == good], 100.0 * use[green == good], "o", ms=4, color=colour, mew=0)
    ax.axhline(100.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
    if one.red is not None:
        ax.axvline(one.red, color=LIMIT, lw=0.9, alpha=0.7)
    ax.set_xlabel(f"{one.path} [{one.unit}]" if one.unit else one.path)
    ax.set_ylabel("use [%]")


def _points(one: FoundLimit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values, uses and whether the verdict is green (n,), of the runs that were judged."""
    rows = [(x, row["use"], row["status"] == "done") for x, row in sorted(one.runs.items()) if "use" in row]
    x, use, green = (np.array(column) for column in zip(*rows, strict=True)) if rows else (np.zeros(0),) * 3
    return x, use, green
