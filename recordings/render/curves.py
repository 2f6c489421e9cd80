"""Any signals of recordings as curves over time: a panel per unit, rated values as limits, stages shaded.

`curves("run.mcap", ["rope/tension/*", "joint/position/west.*"], "run.html")`; the suffix selects the form: .png or .svg
are pictures, .html is a page with zoom and cursor that needs no network.

Figures of curves on paper (matplotlib) and on a page of their own (the bundled uPlot).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import MEASURED, thinned
from heavylift.recordings.read.export import matching, port_signals, silent
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import titles
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written
from numpy.typing import NDArray

from .content import bundled, packed
from .storyboard import FORMATS, INK, QUIET, banded, limited, on_paper, save, tidied, timed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7a6fd0")
TITLE = 104  # letters of a line of the title
NAMED = 16  # curves of a panel that the legend can name
POINTS = 4000  # instants of a curve on the page


@dataclass
class Curve:
    """A curve in a figure: times (n,) [s] and values (n,) in the unit of its panel.

    `dashed`: the curve comes from the second recording; `spoken`: the values were sent on a port.
    """

    name: str
    t: NDArray[np.float64]
    y: NDArray[np.float64]
    colour: int
    dashed: bool = False
    spoken: bool = False


@dataclass
class Panel:
    """A panel of a figure: curves with a common unit, and limits by name."""

    unit: str
    curves: list[Curve]
    limits: dict[str, float] = field(default_factory=dict)
    title: str = ""


@dataclass
class Figure:
    """A figure of panels with a common time axis; stages are (start [s], name)."""

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


def _stages(axes: "Axes", figure: Figure, last: float, named: bool) -> None:
    spans = banded(axes, [t for t, _ in figure.stages], last)
    for i, (start, stop) in enumerate(spans):
        if named and stop - start > 0.04 * last:
            place = ((start + stop) / 2, 1.0)
            axes.annotate(figure.stages[i][1][:18], place, xycoords=("data", "axes fraction"), xytext=(0, 2),
                          textcoords="offset points", ha="center", size=7, color=QUIET)  # fmt: skip


def _panel(axes: "Axes", panel: Panel) -> None:
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
    """Return a self-contained HTML page with the curves of a figure, which can be selected, and zoomed by dragging."""
    content = {
        "title": figure.title,
        "stages": [{"t": t, "name": name} for t, name in figure.stages],
        "panels": [_content(panel) for panel in figure.panels],
    }
    return bundled("curves", content)


def _content(panel: Panel) -> dict[str, object]:
    """Return a panel as plain data; the curves of a recording share their times and are thinned to the extrema in equal
    parts."""
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


LARGER = {"N": (1e-3, "kN"), "N m": (1e-3, "kN m"), "J": (1e-6, "MJ")}
PANELS = 16  # in one figure
MANY = 60  # curves: more than that nobody can tell apart


def curves(path: str | Path, patterns: Sequence[str], out: str | Path, force: bool = False) -> Path:
    """Draw columns that match a pattern (default: tensions, or ports of a DEVS run) into a .png, .svg or .html file."""
    out = checked(out)
    rec = Recording(path)
    with rec.reading():
        chosen = "; ".join(settings(rec.run).values())
        title = f"{rec.run.get('scene', rec.run.get('model', ''))}, {rec.path.name}" + (f"\n{chosen}" if chosen else "")
        panels = _of_ports(rec, patterns) if silent(rec) else panels_of(rec, patterns or ["rope/tension/*"])
        figure = Figure(title, panels, rec.stages())
        return drawn(figure, out, force)


def checked(out: str | Path) -> Path:
    """Return the path of a figure to be written; raises RecordingError if a figure cannot be written there."""
    return output_path(out, "a figure", (*FORMATS, ".html"))


def drawn(figure: Figure, out: Path, force: bool = False) -> Path:
    """Write a figure in the format that the suffix of `out` names, and return its path."""
    if out.suffix.lower() != ".html":
        return picture(figure, out, force)
    return written(page(figure), out, "a figure", (*FORMATS, ".html"), force)


def panels_of(rec: Recording, patterns: Sequence[str]) -> list[Panel]:
    """Return one panel per unit, with matching and measured columns, and the ropes' rated values as limits."""
    wanted = matching(rec, patterns)
    measured = [(MEASURED + name, column) for name, column in wanted if MEASURED + name in rec.signals()]
    wanted += [x for x in measured if x not in wanted and x[1] in rec.columns(x[0])]
    if len(wanted) > MANY:
        raise RecordingError(
            f"{rec.path}: {len(wanted)} curves are too many for one figure; name fewer, such as 'rope/tension/west.*'"
        )
    rec.load([*dict.fromkeys(name for name, _ in wanted)])
    rated = rec.fact("rated", {})
    panels: dict[str, Panel] = {}
    for name, column in wanted:
        signal = rec.signal(name)
        title = titles(signal)[signal.names.index(column)]
        factor, unit = larger(title[len(column) + 2 : -1])
        panel = panels.setdefault(unit, Panel(unit, []))
        model = next((c for c in panel.curves if f"{MEASURED}{c.name}" == f"{name}/{column}"), None)
        colour = model.colour if model else len(panel.curves)
        panel.curves.append(Curve(f"{name}/{column}", signal.t, signal[column] * factor, colour, model is not None))
        if name in ("rope/tension", "rope/peak") and column in rated:
            panel.limits[column] = rated[column] * factor
    if not any(len(curve.t) > 1 for panel in panels.values() for curve in panel.curves):
        raise RecordingError(f"{rec.path}: the recording has no samples to draw; simulate a longer run")
    return list(panels.values())


def _of_ports(rec: Recording, patterns: Sequence[str]) -> list[Panel]:
    """Return a panel for each port of a DEVS run, with the values sent on it."""
    found = port_signals(rec, patterns)
    if not found:
        raise RecordingError(f"{rec.path}: the recording has no events to draw; simulate a longer run")
    if len(found) > PANELS:
        named = ", ".join(f"'{x.name}'" for x in found[:2])
        raise RecordingError(
            f"{rec.path}: {len(found)} ports are too many for one figure; name some of them, such as {named}"
        )
    return [
        Panel("", [Curve(c, x.t, x[c], i, spoken=True) for i, c in enumerate(x.names)], title=x.name) for x in found
    ]


def larger(unit: str) -> tuple[float, str]:
    """Return factor and name of the unit in which values are displayed, such as 0.001 and kN for N."""
    return LARGER.get(unit, (1.0, unit))
