"""The work-precision figure and the time history under it: on paper as PNG or SVG, and inside the page.

Speed against the worst error of what was asked, both logarithmic, so up and to the left is better.  Colour tells the
rung, the mark tells the method.  Errors below FLOOR are drawn at it.  The colours of the page are those of the reader's
theme: what is drawn in INK, QUIET, BAND and PAPER here is a variable of its style there.
"""

from __future__ import annotations

import io
import re
from contextlib import AbstractContextManager
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.recordings.format.samples import thinned
from heavylift.recordings.render.paper import save

from .playing import Played
from .verdict import Row, front

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .measuring import Measured

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#56B4E9", "#7a6fd0", "#6b7682", "#8c3b1b",
           "#17a589", "#c2185b")  # fmt: skip
MARKS = {"semi-implicit-euler": "v", "rk4": "s", "dopri5": "o", "dop853": "D", "radau5": "P"}
INK, QUIET, BAND, PAPER, LIMIT = "#1d2733", "#6b7683", "#e6f2ea", "#ffffff", "#a3182b"
THEME = {INK: "var(--ink)", QUIET: "var(--quiet)", BAND: "var(--band)", PAPER: "var(--paper)", LIMIT: "var(--limit)"}
FLOOR = 1e-9  # relative error
POINTS = 1500  # of a curve over time


def drawn(measured: Measured, out: Path, force: bool = False) -> Path:
    """Write the figure as .png or .svg, and return where."""
    return save(_canvas(measured, "path"), out, force, dpi=110)


def inline(measured: Measured) -> str:
    """The figure as an <svg> element with text of the page."""
    return in_page(_canvas(measured, "none"))


def in_page(figure: Figure) -> str:
    """A figure drawn in this module's inks as an <svg> element with text and colours of the page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
    svg = text.getvalue()
    for colour, variable in THEME.items():
        svg = re.sub(colour, variable, svg, flags=re.IGNORECASE)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'<svg ([^>]*?)height="[^"]*"([^>]*?)width="[^"]*"', r'<svg role="img" \1\2', svg, count=1)


def curve(run: Played, measured: Measured) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and values of what is drawn over time: the rope of the largest peak [kN], or the place that goes
    farthest."""
    true = measured.true.shown
    if measured.ask[0] == "rope tension":
        k = int(np.argmax(true.peaks))
        t, y = run.shown.t, run.shown.tension[:, k] * 1e-3
    else:
        k = int(np.argmax(np.ptp(true.places, axis=0)))
        t, y = run.shown.t, run.shown.places[:, k]
    keep = thinned([y], POINTS)
    return t[keep], y[keep]


def styled(fonts: str) -> AbstractContextManager[None]:
    """Within it figures have the inks of this module; `fonts` of an SVG: "none" is text, "path" outlines."""
    from matplotlib import rc_context

    style: dict[Any, Any] = {"svg.hashsalt": "heavylift", "svg.fonttype": fonts,
             "font.size": 9.5, "axes.linewidth": 0.8,
             "text.color": INK, "axes.edgecolor": QUIET, "axes.labelcolor": INK, "xtick.color": QUIET,
             "ytick.color": QUIET, "legend.labelcolor": INK, "axes.facecolor": "none", "path.simplify": True,
             "font.family": ["DejaVu Sans", "sans-serif"]}  # fmt: skip
    return rc_context(style)


def _canvas(measured: Measured, fonts: str) -> Figure:
    from matplotlib.figure import Figure

    with styled(fonts):
        canvas = Figure(figsize=(11.0, 8.4), facecolor=PAPER, layout="constrained")
        upper, lower = canvas.subplots(2, 1, height_ratios=(1.7, 1))
        _precision(upper, measured)
        _history(lower, measured)
        canvas.draw_without_rendering()
        return canvas


def _precision(axes: Axes, measured: Measured) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    rows = [row for row in measured.rows if row.worst < inf]
    for rung, method in dict.fromkeys((row.rung, row.method) for row in rows):
        mine = [r for r in rows if (r.rung, r.method) == (rung, method)]  # from loose to tight
        x, y = [max(r.worst, FLOOR) for r in mine], [r.waits_s for r in mine]
        axes.plot(x, y, "-", color=_colour(measured, rung), marker=MARKS[method], ms=5, lw=0.9, alpha=0.85, zorder=3)
    best = front(rows)
    axes.step([max(r.worst, FLOOR) for r in best], [r.waits_s for r in best], where="post", color=INK, lw=1.6,
              alpha=0.5, zorder=2)  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_yaxis()  # up is faster
    places = [measured.limit, *(max(row.worst, FLOOR) for row in rows)]
    axes.set_xlim(min(places) / 2, max(places) * 2)
    axes.axvspan(axes.get_xlim()[0], measured.limit, color=BAND, lw=0, zorder=0)
    axes.axvline(measured.limit, color=LIMIT, lw=1.1, ls=(0, (6, 3)), zorder=1)
    _crosses(axes, measured)
    pick = measured.verdict.pick
    if pick is not None:
        axes.plot(max(pick.worst, FLOOR), pick.waits_s, "*", ms=20, mfc="none", mec=LIMIT, mew=1.6, zorder=6)
    axes.grid(color=QUIET, alpha=0.25, lw=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.xaxis.set_major_formatter(lambda x, _: f"{100 * x:g} %")
    axes.yaxis.set_major_formatter(lambda y, _: f"{y:g} s")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"Worst error of {', '.join(measured.ask)}")
    axes.set_ylabel("Time to wait, start and run")
    axes.set_title(f"{measured.scene}: speed against accuracy", loc="left", size=13, weight="bold")
    _legend(axes, measured, rows)


def _crosses(axes: Axes, measured: Measured) -> None:
    """Settings that failed, by method, at the right edge under all that did not."""
    failed = [row for row in measured.rows if row.worst == inf]
    methods = dict.fromkeys(row.method for row in failed)
    if methods:
        top, part = axes.get_ylim()[1], 0.04 + 0.05 * len(methods)
        slowest = max((row.waits_s for row in measured.rows if row.worst < inf), default=top * 10.0)
        axes.set_ylim((slowest / top**part) ** (1.0 / (1.0 - part)), top)
    place = axes.transAxes
    for i, method in enumerate(methods):
        mine = [row for row in failed if row.method == method]
        for k, row in enumerate(mine):
            axes.plot(0.985 - 0.014 * k, 0.04 + 0.05 * i, "x", ms=6, mew=1.6, color=_colour(measured, row.rung),
                      transform=place, zorder=5)  # fmt: skip
        axes.text(0.985 - 0.014 * len(mine), 0.04 + 0.05 * i, f"{method}: refused or cut ", size=8, color=QUIET,
                  ha="right", va="center", transform=place)  # fmt: skip


def _legend(axes: Axes, measured: Measured, rows: list[Row]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=_colour(measured, rung), lw=3, label=rung)
        for rung in dict.fromkeys(r.rung for r in measured.rows)
    ]
    handles += [
        Line2D([], [], color=QUIET, marker=mark, ls="", ms=5, label=method)
        for method, mark in MARKS.items()
        if any(r.method == method for r in rows)
    ]
    handles += [
        Line2D([], [], color=LIMIT, marker="*", ls="", ms=11, mfc="none", label="to be used"),
        Line2D([], [], color=INK, lw=1.6, alpha=0.5, label="nothing faster is as exact"),
        Line2D([], [], color=LIMIT, lw=1.1, ls=(0, (6, 3)), label="limit"),
    ]
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8.5)


def _history(axes: Axes, measured: Measured) -> None:
    curves = [("reference", measured.true, INK, 2.6, 0.45)]
    pick, following = measured.verdict.pick, measured.verdict.next_faster
    if following is not None:
        curves.append((f"next faster that fails: {following}", measured.shown[str(following)], COLOURS[1], 1.0, 1.0))
    if pick is not None:
        curves.append((f"to be used: {pick}", measured.shown[str(pick)], COLOURS[0], 1.0, 1.0))
    for name, run, colour, width, alpha in curves:
        axes.plot(*curve(run, measured), color=colour, lw=width, alpha=alpha, label=name)
    true = measured.true.shown
    if measured.ask[0] == "rope tension":
        axes.set_ylabel(f"Tension of {true.ropes[int(np.argmax(true.peaks))]} [kN]")
    else:
        axes.set_ylabel(f"{true.columns[int(np.argmax(np.ptp(true.places, axis=0)))]} [{measured.unit}]")
    axes.set_xlabel("Time [s]")
    axes.grid(color=QUIET, alpha=0.25, lw=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, fontsize=8.5, ncols=1)


def _colour(measured: Measured, rung: str) -> str:
    names = list(dict.fromkeys(row.rung for row in measured.rows))
    return COLOURS[names.index(rung) % len(COLOURS)]
