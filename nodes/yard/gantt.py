"""The schedule of a yard as a Gantt chart: one row for each block, in the order of their starts, with steps in
different colours."""

from collections.abc import Sequence
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from heavylift.recordings.sheets.sheet import COLOURS, INK, LIMIT, PAPER, QUIET, in_page, styled

from .fields import at
from .network import Yard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LABELLED = 60  # blocks whose names are legible


def figure(yard: Yard, spans: Sequence[tuple[float, float, bool]]) -> "Figure":
    """Return a Gantt chart of the start and end [s] of all activities, with the critical ones outlined."""
    from matplotlib import dates
    from matplotlib.figure import Figure

    drawing: Any = dates  # without types

    first = dict[str, float]()
    for one, (start, _, _) in zip(yard.activities, spans, strict=True):
        first[one.block] = min(start, first.get(one.block, start))
    blocks = sorted(first, key=lambda block: first[block])
    place, steps = {block: n for n, block in enumerate(blocks)}, [*dict.fromkeys(x.step for x in yard.activities)]
    with styled("none"):
        made = Figure(figsize=(11.0, min(2.0 + 0.16 * len(blocks), 12.0)), facecolor=PAPER, layout="constrained")
        axes = made.subplots()
        for k, step in enumerate(steps):
            own = [n for n, one in enumerate(yard.activities) if one.step == step]
            days = [[float(drawing.date2num(at(yard.start, t))) for t in spans[n][:2]] for n in own]
            axes.barh(
                [place[yard.activities[n].block] for n in own], [max(b - a, 1 / 48) for a, b in days],
                left=[a for a, _ in days], height=0.8, color=COLOURS[k % len(COLOURS)], label=step,
                edgecolor=[LIMIT if spans[n][2] else "none" for n in own], linewidth=0.8,
            )  # fmt: skip
        for key, day in yard.contract.items():
            when = drawing.date2num(day + timedelta(1))
            axes.axvline(when, color=LIMIT, lw=0.8, ls="--")
            axes.text(
                when, 0.02, key, transform=axes.get_xaxis_transform(), color=LIMIT, fontsize=8, rotation=90, ha="right"
            )
        axes.set_ylim(len(blocks) - 0.5, -0.5)
        few = len(blocks) <= LABELLED
        axes.set_yticks(range(len(blocks)) if few else [], blocks if few else [])
        locator = drawing.AutoDateLocator()
        axes.xaxis.set_major_locator(locator)
        axes.xaxis.set_major_formatter(drawing.ConciseDateFormatter(locator))
        axes.grid(axis="x", color=QUIET, lw=0.4, alpha=0.3)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        axes.yaxis.label.set_color(INK)
        axes.legend(loc="upper right", fontsize=8, frameon=False)
    return made


def gantt(yard: Yard, spans: Sequence[tuple[float, float, bool]]) -> str:
    """Return the Gantt chart as an <svg> element for a page."""
    return in_page(figure(yard, spans))
