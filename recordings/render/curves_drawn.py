"""Figures of curves on paper (matplotlib) and on a page of their own (the bundled uPlot)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.recordings.format.samples import thinned
from numpy.typing import NDArray

from .content import bundled, packed
from .paper import INK, QUIET, banded, limited, on_paper, save, tidied, timed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7a6fd0")
TITLE = 104  # letters of a line of the title
NAMED = 16  # curves of a panel that the legend can name
POINTS = 4000  # instants of a curve on the page


@dataclass
class Curve:
    """Times (n,) [s] and values (n,) in the unit of its panel; dashed for what is laid beside a recording; points for
    what a port has spoken."""

    name: str
    t: NDArray[np.float64]
    y: NDArray[np.float64]
    colour: int
    dashed: bool = False
    spoken: bool = False


@dataclass
class Panel:
    """Curves of one unit, and limits by name of what they belong to."""

    unit: str
    curves: list[Curve]
    limits: dict[str, float] = field(default_factory=dict)
    title: str = ""


@dataclass
class Figure:
    """Panels with a common time; stages are (start [s], name)."""

    title: str
    panels: list[Panel]
    stages: list[tuple[float, str]]


def picture(figure: Figure, out: Path, force: bool = False) -> Path:
    """Draw the figure into a .png or .svg file."""
    from matplotlib.figure import Figure as Canvas

    last = max(float(c.t[-1]) for p in figure.panels for c in p.curves if len(c.t))
    with on_paper():
        canvas = Canvas(figsize=(11.0, 1.0 + 2.9 * len(figure.panels)), layout="constrained", facecolor="white")
        lines = [part for line in figure.title.split("\n") for part in wrap(line, TITLE)]
        canvas.suptitle("\n".join(lines), x=0.01, ha="left", size=12, weight="bold", color=INK)
        grid = canvas.subplots(len(figure.panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(grid, figure.panels, strict=True):
            _stages(axes, figure, last, named=axes is grid[0])
            _panel(axes, panel)
        first = min(float(c.t[0]) for p in figure.panels for c in p.curves if len(c.t))
        if first < last:  # all may be said at one instant
            grid[-1].set_xlim(first, last)
        timed(grid[-1])
        return save(canvas, out, force)


def _stages(axes: Axes, figure: Figure, last: float, named: bool) -> None:
    spans = banded(axes, [t for t, _ in figure.stages], last)
    for i, (start, stop) in enumerate(spans):
        if named and stop - start > 0.04 * last:
            place = ((start + stop) / 2, 1.0)
            axes.annotate(figure.stages[i][1][:18], place, xycoords=("data", "axes fraction"), xytext=(0, 2),
                          textcoords="offset points", ha="center", size=7, color=QUIET)  # fmt: skip


def _panel(axes: Axes, panel: Panel) -> None:
    for curve in panel.curves:
        how: dict[str, Any] = {"ls": (0, (4, 2)), "lw": 0.9} if curve.dashed else {"lw": 1.2}
        if curve.spoken:
            how = {"lw": 0.4, "marker": "."}
        axes.plot(curve.t, curve.y, color=COLOURS[curve.colour % len(COLOURS)], label=curve.name, zorder=3, **how)
    high = max((float(np.nanmax(c.y)) for c in panel.curves if len(c.y)), default=0.0)
    limited(axes, panel.limits, panel.unit, high)
    tidied(axes, f"[{panel.unit}]" if panel.unit else "")
    if panel.title:
        axes.set_title(panel.title, size=9, loc="left", color=INK, pad=14)
    handles, names = axes.get_legend_handles_labels()
    more = len(names) - NAMED
    title = f"and {more} more" if more > 0 else None
    axes.legend(handles[:NAMED], names[:NAMED], loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False,
                fontsize=8, title=title, title_fontsize=8)  # fmt: skip


def page(figure: Figure) -> str:
    """The figure as a self-contained page: curves can be switched, time is zoomed by dragging."""
    content = {
        "title": figure.title,
        "stages": [{"t": t, "name": name} for t, name in figure.stages],
        "panels": [_content(panel) for panel in figure.panels],
    }
    return bundled("curves", content)


def _content(panel: Panel) -> dict[str, object]:
    """Curves of one recording share their times; of too many instants the least and largest of equal parts stay."""
    times: list[np.ndarray] = []
    of: list[int] = []  # table of times by curve
    for curve in panel.curves:
        k = next((i for i, t in enumerate(times) if t is curve.t), len(times))
        times += [curve.t] if k == len(times) else []
        of.append(k)
    keep = [thinned([c.y for c in panel.curves if c.t is t], POINTS) for t in times]
    shown = [
        {"name": c.name, "times": k, "colour": c.colour, "dashed": c.dashed, "y": packed(c.y[keep[k]])}
        for c, k in zip(panel.curves, of, strict=True)
    ]
    kept = [packed(t[k], "<f8") for t, k in zip(times, keep, strict=True)]
    limits = [{"name": name, "y": limit} for name, limit in panel.limits.items()]
    return {"unit": panel.unit, "title": panel.title, "times": kept, "curves": shown, "limits": limits}
