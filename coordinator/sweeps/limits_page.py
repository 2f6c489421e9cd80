"""The page of `heavylift limits`: how far each number may go, what limits it there, and the use on the way."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import ceil, isfinite, nan
from typing import TYPE_CHECKING

import numpy as np
from heavylift.coordinator.ladder.pictures import COLOURS, LIMIT, STYLE, in_page, wide
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.format import text
from heavylift.recordings.format.html import Cell, bullets, document, table
from heavylift.recordings.format.text import clock

from .limiting import Limited
from .page import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEAD = ["number", "green up to", "red at", "most used there", "to", "in", "at", "what turns red"]
COLUMNS = 3  # of figures


def listed(found: Sequence[Limited]) -> str:
    """The table as text."""
    return text.table(HEAD, [_row(one) for one in found])


def _row(one: Limited) -> list[str]:
    """A line of the table."""
    if one.wrong:
        return [one.path, one.shown(one.green), one.shown(one.red), "", "", "", "", one.wrong]
    most = one.most
    used = most.get("use", nan)
    where = [str(most["limit"]), one.used, str(most["limit stage"]), clock(most["limit at [s]"], 1)]
    return [one.path, one.limit, one.shown(one.red), *(where if isfinite(used) else [""] * 4), one.why]


def limits_page(scene: LoadedScene, found: Sequence[Limited]) -> str:
    """Self-contained HTML without scripts."""
    title = f"How far {scene.plan.name} may go"
    rows: list[list[Cell]] = [[*_row(one)] for one in found]
    body = [
        f"<h1>{escape(title)}</h1>",
        '<p class="quiet">The largest value of each number, alone, for which the verdict of a run is green. Bars: of '
        "the use that turns red, by tighter steps and the next richer rung, at 95 %.</p>",
        wide(table(HEAD[:-1], [row[:-1] for row in rows], "left1")),
        "<h2>What turns red</h2>",
        bullets(f"{one.path}: {one.wrong or one.why}" for one in found),
        "<h2>Largest use of a load's limit on the way</h2>",
        f"<figure>{_figure([one for one in found if one.red is not None and len(_points(one)[0]) > 1])}</figure>",
    ]
    return document(title, STYLE, body)


def _figure(found: Sequence[Limited]) -> str:
    if not found:
        return ""
    columns = min(COLUMNS, len(found))
    figure = canvas(ceil(len(found) / columns), columns)
    for ax, one in zip(figure.axes, found, strict=False):
        _drawn(ax, one)
    for ax in figure.axes[len(found) :]:
        ax.set_axis_off()
    return in_page(figure)


def _drawn(ax: Axes, one: Limited) -> None:
    x, use, green = _points(one)
    ax.plot(x, 100.0 * use, color=COLOURS[0], lw=1.2, alpha=0.6)
    for good, colour in ((True, COLOURS[2]), (False, LIMIT)):
        ax.plot(x[green == good], 100.0 * use[green == good], "o", ms=4, color=colour, mew=0)
    ax.axhline(100.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
    if one.red is not None:
        ax.axvline(one.red, color=LIMIT, lw=0.9, alpha=0.7)
    ax.set_xlabel(f"{one.path} [{one.unit}]" if one.unit else one.path)
    ax.set_ylabel("use [%]")


def _points(one: Limited) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values, uses and whether the verdict is green (n,), of the runs that were judged."""
    rows = [(x, row["use"], row["status"] == "done") for x, row in sorted(one.runs.items()) if "use" in row]
    x, use, green = (np.array(column) for column in zip(*rows, strict=True)) if rows else (np.zeros(0),) * 3
    return x, use, green
