"""The figure of a run after the paper's Fig. 11: block loader 1 on top, all loaders below, stages marked.

`plot("run.mcap", "run.png")`; the suffix .png or .svg decides the format.  The colours are those of Okabe
and Ito, which colour-blind readers can tell apart; curves that coincide are drawn in shrinking widths, so
all of them are seen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.samples import MEASURED
from heavylift.recordings.format.text import duration
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.settings import settings
from heavylift.recordings.write.outputs import output_path
from numpy.typing import NDArray

from .paper import FORMATS, INK, LIMIT, QUIET, banded, on_paper, save, tidied

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot"]

COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#D55E00", "#E69F00", "#CC79A7", "#000000", "#F0E442")
WIDTH, HEIGHT = 11.0, 7.6  # [in]
LEFT, RIGHT, BOTTOM = 0.075, 0.955, 0.075  # the panels, as shares of the figure
LABEL, SLOPE, GAP = 8.5, 38.0, 17.0  # stage labels: size [pt], angle [degrees], least distance [pt]
LONGEST = 30  # [letters] of a stage label
FINE = 4000  # steps of a band: two a pixel
PEAK = "peak tension "  # of a rope, in a certificate
LEADER = {"arrowstyle": "-", "color": QUIET, "lw": 0.6, "alpha": 0.6, "shrinkA": 0, "shrinkB": 0}


class Curves(NamedTuple):
    """What is drawn: time in `clock`, values (n, m), name and rated value per column, what it is."""

    t: NDArray[np.float64]
    clock: str
    values: NDArray[np.float64]
    peaks: NDArray[np.float64]
    names: list[str]
    rated: list[float | None]
    quantity: str
    measured: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]  # the same of a real machine, by column
    bars: dict[int, float]  # half-width of what a certificate leaves open of a peak, by column


def plot(path: str | Path, out: str | Path, loaders: Mapping[str, str] | None = None, force: bool = False) -> Path:
    """Draw the recording `path` into the file `out`; `loaders` are hook ropes by label, else as recorded."""
    out = output_path(out, "a figure", FORMATS)
    rec = Recording(path)
    with rec.reading(), on_paper():
        curves, scale = _curves(rec, loaders or rec.fact("loaders"))
        return save(_figure(rec, curves, [(t * scale, name) for t, name in rec.stages()]), out, force)


def _curves(rec: Recording, loaders: Mapping[str, str] | None) -> tuple[Curves, float]:
    """Tensions of the loaders, or joint positions if there are no ropes; and clock units per second."""
    name = next((name for name in ("rope/tension", "joint/position") if _has(rec, name)), None)
    if name is None:
        raise RecordingError(f"{rec.path}: has no rope tensions and no joint positions to plot")
    t, values, columns, unit = rec.signal(name)
    chosen = dict(loaders) if loaders and name == "rope/tension" else {column: column for column in columns}
    chosen = dict(list(chosen.items())[: len(COLOURS)])
    missing = [column for column in chosen.values() if column not in columns]
    if missing:
        raise RecordingError(f"{rec.path}: has no rope {missing[0]}; it has {', '.join(columns)}")
    picks = [columns.index(column) for column in chosen.values()]
    peaks = rec.signal("rope/peak").values if name == "rope/tension" and _has(rec, "rope/peak") else values
    factor, unit = (1e-3, "kN") if unit == "N" else (1.0, unit)
    limits = rec.fact("rated", {})
    rated = [limits[column] * factor if column in limits else None for column in chosen.values()]
    long = len(t) > 0 and t[-1] >= 300
    scale, clock = (1 / 60, "min") if long else (1.0, "s")
    quantity = f"{'Tension' if name == 'rope/tension' else 'Position'} [{unit}]"
    measured = {}
    if MEASURED + name in rec.signals():
        real = rec.signal(MEASURED + name)
        shown = {i: real[column] for i, column in enumerate(chosen.values()) if column in real.names}
        measured = {i: (real.t * scale, y * factor) for i, y in shown.items()}
    halves = {bar["name"]: bar["whole"] * factor for bar in rec.fact("certified", {}).get("bars", [])}
    bars = {i: halves[f"{PEAK}{x}"] for i, x in enumerate(chosen.values()) if f"{PEAK}{x}" in halves}
    drawn = values[:, picks] * factor, peaks[:, picks] * factor, [*chosen], rated, quantity, measured, bars
    return Curves(t * scale, clock, *drawn), scale


def _has(rec: Recording, name: str) -> bool:
    return name in rec.signals() and len(rec.signal(name).t) > 1 and rec.columns(name) != []


def _figure(rec: Recording, curves: Curves, stages: Sequence[tuple[float, str]]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT), facecolor="white")
    shown = [text if len(text) <= LONGEST else text[: LONGEST - 1] + "…" for _, text in stages]
    rise = max((0.56 * LABEL * len(text) * np.sin(np.radians(SLOPE)) for text in shown), default=0.0) + 26
    top = 1 - (46 + (rise if stages else 0)) / (72 * HEIGHT)
    several = len(curves.names) > 1
    legend_columns = max(1, int(72 * WIDTH * (RIGHT - LEFT) / (5.2 * max(map(len, curves.names)) + 38)))
    legend_rows = -(-len(curves.names) // legend_columns)
    grid = figure.add_gridspec(
        2 if several else 1,
        1,
        left=LEFT,
        right=RIGHT,
        bottom=BOTTOM,
        top=top,
        height_ratios=(1, 1.15) if several else None,
        hspace=0.12 + 0.08 * legend_rows,
    )
    _heading(figure, rec, curves)
    upper = lowest = figure.add_subplot(grid[0])
    _panel(upper, curves, [0], stages)
    _note_peak(upper, curves)
    if several:
        lowest = figure.add_subplot(grid[1], sharex=upper)
        _panel(lowest, curves, range(len(curves.names)), stages)
        upper.tick_params(labelbottom=False)
        lowest.legend(
            loc="lower left",
            bbox_to_anchor=(0, 1.0),
            ncols=legend_columns,
            frameon=False,
            handlelength=1.6,
            columnspacing=1.6,
            borderaxespad=0.1,
            labelcolor=INK,
        )
        note = "dashed: measured; " * bool(curves.measured)
        note += (
            "bands: peaks with their bars, 95 %; " * bool(curves.bars) + "curves that coincide lie inside one another"
        )
        figure.text(RIGHT, 13 / (72 * HEIGHT), note, size=LABEL, color=QUIET, ha="right")
    if curves.bars:
        figure.text(LEFT, 13 / (72 * HEIGHT), "bands: peaks with their bars at 95 %", size=LABEL, color=QUIET)
    lowest.set_xlabel(f"Time [{curves.clock}]", color=INK)
    _label_stages(upper, [t for t, _ in stages], shown)
    return figure


def _heading(figure: Figure, rec: Recording, curves: Curves) -> None:
    what = curves.quantity.partition(" [")[0]
    facts = [rec.run.get("scene", rec.path.stem), f"{duration(float(rec.fact('sim_s', 0.0)))} simulated"]
    told = settings(rec.run)
    facts += [told[name] for name in ("asked", "steps") if name in told]
    if rec.result.get("status") != "finished":
        facts.append(rec.result.get("status", "cut off"))
    y = 1 - 24 / (72 * HEIGHT)
    figure.text(LEFT, y, f"{what} of {curves.names[0]}", size=14, weight="bold", color=INK)
    figure.text(RIGHT, y, ", ".join(facts), size=9.5, color=QUIET, ha="right")
    if told.get("modelled"):
        figure.text(RIGHT, y - 14 / (72 * HEIGHT), told["modelled"], size=8.5, color=QUIET, ha="right")


def outline(t: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A band in steps finer than a pixel: filled whole, one of 100 000 samples would take a gigabyte."""
    first = np.arange(0, len(t), -(-len(t) // FINE))
    return t[first], np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)


def _panel(axes: Axes, curves: Curves, columns: Sequence[int], stages: Sequence[tuple[float, str]]) -> None:
    for start, _ in banded(axes, [t for t, _ in stages], curves.t[-1]):
        axes.axvline(start, color=QUIET, lw=0.6, alpha=0.6, zorder=1)
    from matplotlib.patheffects import withStroke

    widths = np.linspace(4.4, 1.0, len(columns)) if len(columns) > 1 else [1.5]
    for i, width in zip(columns, widths, strict=True):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(curves.t, curves.values[:, i], color=colour, lw=width, label=curves.names[i], zorder=3)
    if len(columns) == 1:
        i = columns[0]
        band = outline(curves.t, curves.values[:, i], curves.peaks[:, i])
        axes.fill_between(*band, color=COLOURS[i], alpha=0.3, lw=0, zorder=2)
    for i in (i for i in columns if i in curves.measured):
        axes.plot(*curves.measured[i], color=COLOURS[i % len(COLOURS)], lw=1.2, ls=(0, (4, 2)), zorder=4,
                  path_effects=[withStroke(linewidth=2.6, foreground="white")])  # fmt: skip
    tops = {i: float(np.max(curves.peaks[:, i])) for i in columns}
    for i, half in ((i, curves.bars[i]) for i in columns if i in curves.bars):
        axes.axhspan(tops[i] - half, tops[i] + half, color=COLOURS[i % len(COLOURS)], alpha=0.18, lw=0, zorder=1)
    highest = max(top + curves.bars.get(i, 0.0) for i, top in tops.items())
    highest = max([highest, *(float(np.max(curves.measured[i][1])) for i in columns if i in curves.measured)])
    lowest = float(min(0.0, np.min(curves.values[:, list(columns)])))
    near = {x for i in columns if (x := curves.rated[i]) is not None and x < 2.5 * highest}
    for limit in sorted(near):
        axes.axhline(limit, color=LIMIT, lw=1.1, ls=(0, (6, 3)), zorder=2)
    if near:
        told = " to ".join(_number(x) for x in dict.fromkeys((min(near), max(near))))
        axes.annotate(
            f"rated {told} kN",
            (1, max(near)),
            xycoords=("axes fraction", "data"),
            xytext=(-4, 3),
            textcoords="offset points",
            ha="right",
            color=LIMIT,
            size=8.5,
        )
        highest = max(highest, max(near) * 1.02)
    margin = 0.08 * (highest - lowest) or 1.0
    axes.set_ylim(lowest - (margin if lowest < 0 else 0), highest + margin)
    axes.set_xlim(curves.t[0], curves.t[-1])
    tidied(axes, curves.quantity)
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(color=QUIET, labelcolor=INK, length=3)
    axes.yaxis.set_major_formatter(lambda value, _: _number(value))


def _number(value: float) -> str:
    """A number for people, thousands apart by a thin space."""
    text = f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return text.replace(",", "\u2009").replace("-", "\u2212")


def _bar(curves: Curves) -> str:
    """What a certificate leaves open of the first curve's peak."""
    return f" ± {_number(float(f'{curves.bars[0]:.2g}'))}" if 0 in curves.bars else ""


def _note_peak(axes: Axes, curves: Curves) -> None:
    """A dot and a line of text at the largest value of the first curve."""
    k = int(np.argmax(curves.peaks[:, 0]))
    t, value = curves.t[k], curves.peaks[k, 0]
    unit = curves.quantity.partition("[")[2].rstrip("]")
    left = t > 0.75 * curves.t[-1] + 0.25 * curves.t[0]
    axes.plot(t, value, "o", ms=4.5, color=INK, zorder=5)
    axes.annotate(
        f"peak {_number(value)}{_bar(curves)} {unit} at {t:.1f} {curves.clock}",
        (t, value),
        xytext=(-6 if left else 6, 5),
        textcoords="offset points",
        ha="right" if left else "left",
        size=9,
        color=INK,
        zorder=5,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1},
    )


def _label_stages(axes: Axes, times: Sequence[float], names: Sequence[str]) -> None:
    """The stages' names above the panel, apart from one another, each with a line to its instant."""
    first, last = axes.get_xlim()
    points = 72 * WIDTH * (RIGHT - LEFT)
    wanted = [(t - first) / (last - first) * points for t in times]
    reach = [0.56 * LABEL * len(name) * np.cos(np.radians(SLOPE)) for name in names]
    room = points + 72 * WIDTH * (1 - RIGHT) - 6
    gap = min(GAP, points / max(1, len(names)))
    places = spread(wanted, [room - r for r in reach], gap)
    for place, at, name in zip(places, wanted, names, strict=True):
        top = (at / points, 1)
        for text, up in (("", 14), (name, 17)):
            axes.annotate(
                text,
                top,
                xycoords="axes fraction",
                xytext=(place - at, up),
                textcoords="offset points",
                rotation=SLOPE,
                rotation_mode="anchor",
                size=min(LABEL, gap * 0.62),
                color=INK,
                arrowprops=None if text else LEADER,
            )


def spread(wanted: Sequence[float], highest: Sequence[float], gap: float) -> list[float]:
    """Places nearest to the wanted ones, rising by `gap` or more, none above its `highest`."""
    blocks: list[tuple[float, int]] = []  # mean place of labels that touch, how many they are
    for i, place in enumerate(wanted):
        blocks.append((place - i * gap, 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, n), (b, m) = blocks[-2:]
            blocks[-2:] = [((a * n + b * m) / (n + m), n + m)]
    free = [mean for mean, n in blocks for _ in range(n)]
    places = [max(0.0, mean) + i * gap for i, mean in enumerate(free)]
    for i in reversed(range(len(places))):
        after = places[i + 1] - gap if i + 1 < len(places) else highest[i]
        places[i] = min(places[i], highest[i], after)
    return places
