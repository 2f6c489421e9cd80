"""The figure of a run, after Fig. 11 of the paper: the governing rope on top, the next ones below, stages marked.

`plot("run.mcap", "run.png")`; the suffix .png or .svg selects the format. The colours are those of Okabe and Ito, which
colour-blind readers can distinguish; curves that coincide are drawn with decreasing widths, so that all of them are
visible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import MEASURED
from heavylift.recordings.format.text import duration
from heavylift.recordings.read.export import silent
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import opened
from heavylift.recordings.write.outputs import output_path
from numpy.typing import NDArray

from .curves import curves
from .storyboard import FORMATS, INK, QUIET, banded, digits, limited, on_paper, save, spread, tidied, timed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#D55E00", "#E69F00", "#CC79A7", "#000000", "#F0E442")
WIDTH, HEIGHT = 11.0, 7.6  # [in]
LEFT, RIGHT, BOTTOM = 0.075, 0.955, 0.075  # the panels, as shares of the figure
LABEL, SLOPE, GAP = 8.5, 38.0, 17.0  # stage labels: size [pt], angle [degrees], least distance [pt]
LONGEST, WIDEST = 30, 150  # [letters] of a stage label, of a line of the heading
FINE = 4000  # steps of a band: two a pixel
BEARS = 0.25  # of its largest tension at rest: what carries less is not shown over it
PEAK = "peak tension "  # of a rope, in a certificate
LEADER = {"arrowstyle": "-", "color": QUIET, "lw": 0.6, "alpha": 0.6, "shrinkA": 0, "shrinkB": 0}


Floats = NDArray[np.float64]
Rest = tuple[Floats, Floats]  # (n,) times [s], (n,) tensions at rest [N]


class Curves(NamedTuple):
    """The curves of a plot, one per column: times [s], values and peaks (n, m), names, rated values, quantity."""

    t: Floats
    values: Floats
    peaks: Floats
    names: list[str]
    rated: list[float | None]
    quantity: str
    measured: dict[int, tuple[Floats, Floats]]  # the same of a real machine, by column
    bars: dict[int, float]  # half-width of what a certificate leaves open of a peak, by column
    over: dict[int, tuple[Floats, Floats]]  # (n,) tension and peak over that at rest, by column; NaN where none bears


def plot(
    path: str | Path | Recording,
    out: str | Path,
    ropes: Mapping[str, str] | None = None,
    force: bool = False,
    rest: Mapping[str, Rest] | None = None,
) -> Path:
    """Draw a recording into the file `out` and return its path.

    `ropes`: ropes by label (default: the ropes with the highest utilisation); `rest`: static tensions [N]; if given, an
    additional panel shows the tensions relative to them.
    """
    out = output_path(out, "a figure", FORMATS)
    rec = opened(path)
    if silent(rec):
        return curves(rec.path, [], out, force)
    with rec.reading(), on_paper():
        return save(_figure(rec, _curves(rec, ropes, rest or {}), rec.stages()), out, force)


def _curves(rec: Recording, ropes: Mapping[str, str] | None, rest: Mapping[str, Rest]) -> Curves:
    """Return the curves of tensions, or of joint positions if there are no ropes."""
    wanted = ("rope/tension", "rope/peak") if "rope/tension" in rec.signals() else ("joint/position",)
    rec.load([name for name in wanted if name in rec.signals()])
    name = next((name for name in ("rope/tension", "joint/position") if _has(rec, name)), None)
    if name is None:
        raise RecordingError(
            f"{rec.path}: no tensions or joint positions are recorded to plot; record a scene with ropes or joints"
        )
    t, values, columns, unit = rec.signal(name)
    limits: dict[str, float] = rec.fact("rated", {})
    peaks = values
    if name == "rope/tension" and _has(rec, "rope/peak"):
        peaks = np.maximum(values, rec.signal("rope/peak").values)
    chosen = {column: column for column in columns}
    if name == "rope/tension":
        chosen = (
            dict(ropes) if ropes else {x: x for x in _most_used(columns, peaks, limits) if "~" not in x}
        )  # no pieces
    chosen = dict(list(chosen.items())[: len(COLOURS)])
    missing = [column for column in chosen.values() if column not in columns]
    if missing:
        raise RecordingError(f"{rec.path}: the recording has no rope {missing[0]}; it has {', '.join(columns)}")
    picks = [columns.index(column) for column in chosen.values()]
    factor, unit = (1e-3, "kN") if unit == "N" else (1.0, unit)
    rated = [limits[column] * factor if column in limits else None for column in chosen.values()]
    quantity = f"{'Tension' if name == 'rope/tension' else 'Position'} [{unit}]"
    measured = {}
    if MEASURED + name in rec.signals():
        real = rec.signal(MEASURED + name)
        shown = {i: real[column] for i, column in enumerate(chosen.values()) if column in real.names}
        measured = {i: (real.t, y * factor) for i, y in shown.items()}
    halves = {bar["name"]: bar["whole"] * factor for bar in rec.fact("certified", {}).get("bars", [])}
    bars = {i: halves[f"{PEAK}{x}"] for i, x in enumerate(chosen.values()) if f"{PEAK}{x}" in halves}
    over = {
        i: _over(t, values[:, k], peaks[:, k], rest[x])
        for i, (x, k) in enumerate(zip(chosen.values(), picks, strict=True))
        if x in rest
    }
    drawn = values[:, picks] * factor, peaks[:, picks] * factor, [*chosen], rated, quantity, measured, bars, over
    return Curves(t, *drawn)


def _over(t: Floats, tension: Floats, peak: Floats, rest: Rest) -> tuple[Floats, Floats]:
    """Return the tension and its peak since the last sample (n,), divided by the static tension; NaN where the rope is
    not loaded."""
    still = np.interp(t, *rest)
    still[still <= BEARS * still.max(initial=0.0)] = np.nan
    return tension / still, peak / still


def _most_used(names: Sequence[str], peaks: Floats, rated: Mapping[str, float]) -> list[str]:
    """Return ropes sorted by utilisation, then ropes without a rated tension sorted by tension."""
    most = {x: y for x, y in zip(names, peaks.max(axis=0, initial=0.0), strict=True) if "~" not in x}
    return sorted(most, key=lambda x: (x not in rated, -most[x] / rated.get(x, 1.0)))


def _has(rec: Recording, name: str) -> bool:
    return name in rec.signals() and len(rec.signal(name).t) > 1 and rec.columns(name) != []


def _figure(rec: Recording, curves: Curves, stages: Sequence[tuple[float, str]]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT), facecolor="white")
    shown = [text if len(text) <= LONGEST else text[: LONGEST - 1] + "…" for _, text in stages]
    rise = max((0.56 * LABEL * len(text) * np.sin(np.radians(SLOPE)) for text in shown), default=0.0) + 26
    lines = subtitle(rec)
    top = 1 - (32 + 13 * len(lines) + (rise if stages else 0)) / (72 * HEIGHT)
    several = len(curves.names) > 1
    legend_columns = max(1, int(72 * WIDTH * (RIGHT - LEFT) / (5.2 * max(map(len, curves.names)) + 38)))
    legend_rows = -(-len(curves.names) // legend_columns)
    heights = [1.0, *([1.15] if several else []), *([0.6] if curves.over else [])]
    grid = figure.add_gridspec(
        len(heights), 1, left=LEFT, right=RIGHT, bottom=BOTTOM, top=top, height_ratios=heights,
        hspace=(0.12 + 0.08 * legend_rows) * (1.6 if curves.over else 1.0),
    )  # fmt: skip
    _heading(figure, lines, curves)
    upper = lowest = figure.add_subplot(grid[0])
    _panel(upper, curves, [0], stages)
    _note_peak(upper, curves)
    if several:
        lowest = figure.add_subplot(grid[1], sharex=upper)
        _panel(lowest, curves, range(len(curves.names)), stages)
        upper.tick_params(labelbottom=False)
        lowest.legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=legend_columns, frameon=False, labelcolor=INK,
                      handlelength=1.6, columnspacing=1.6, borderaxespad=0.1)  # fmt: skip
        note = "dashed: measured; " * bool(curves.measured) + "curves that coincide lie inside one another"
        figure.text(RIGHT, 13 / (72 * HEIGHT), note, size=LABEL, color=QUIET, ha="right")
    if curves.over:
        above, lowest = lowest, figure.add_subplot(grid[-1], sharex=upper)
        above.tick_params(labelbottom=False)
        _dynamic(lowest, curves, stages)
    message = "bands: peaks with their bars at 95 %" if curves.bars else ""
    figure.text(LEFT, 13 / (72 * HEIGHT), message, size=LABEL, color=QUIET)
    timed(lowest)
    _label_stages(upper, [t for t, _ in stages], shown)
    return figure


def subtitle(rec: Recording) -> list[str]:
    """Return the lines below the title: scene, duration, requested quantities, modelled effects, integration steps."""
    facts = [rec.run.get("scene", rec.path.stem), f"{duration(rec.fact('sim_s', 0.0))} simulated"]
    message = settings(rec.run)
    facts += [message[name] for name in ("asked", "steps") if name in message]
    if rec.result.get("status") != "finished":
        facts.append(rec.result.get("status", "cut off"))
    return [line for text in (", ".join(facts), message.get("modelled", "")) for line in wrap(text, WIDEST)]


def _heading(figure: Figure, lines: Sequence[str], curves: Curves) -> None:
    what, rated, used = curves.quantity.partition(" [")[0], curves.rated[0], ""
    if rated:
        used = f", {100 * float(np.max(curves.peaks[:, 0])) / rated:.0f} % of its rated tension"
    figure.text(LEFT, 1 - 24 / (72 * HEIGHT), f"{what} of {curves.names[0]}{used}", size=14, weight="bold", color=INK)
    for i, line in enumerate(lines):
        figure.text(LEFT, 1 - (39 + 13 * i) / (72 * HEIGHT), line, size=9, color=QUIET)


def outline(t: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lower and upper outline of a curve, in steps finer than a pixel."""
    # a filled band of 100 000 samples would take a gigabyte
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
    limits = {curves.names[i]: x for i in columns if (x := curves.rated[i]) is not None}
    highest = limited(axes, limits, "kN", highest) * (1.02 if limits else 1.0)
    margin = 0.08 * (highest - lowest) or 1.0
    axes.set_ylim(lowest - (margin if lowest < 0 else 0), highest + margin)
    axes.set_xlim(curves.t[0], curves.t[-1])
    tidied(axes, curves.quantity)
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(color=QUIET, labelcolor=INK, length=3)
    axes.yaxis.set_major_formatter(lambda value, _: digits(value))


def _dynamic(axes: Axes, curves: Curves, stages: Sequence[tuple[float, str]]) -> None:
    """Draw tensions relative to the static ones, which shows their dynamic part."""
    for start, _ in banded(axes, [t for t, _ in stages], curves.t[-1]):
        axes.axvline(start, color=QUIET, lw=0.6, alpha=0.6, zorder=1)
    for i, (over, peak) in curves.over.items():
        axes.plot(curves.t, over, color=COLOURS[i % len(COLOURS)], lw=0.9, zorder=3)
        axes.fill_between(*outline(curves.t, over, peak), color=COLOURS[i % len(COLOURS)], alpha=0.3, lw=0, zorder=2)
    axes.axhline(1.0, color=QUIET, lw=0.6, zorder=2)
    axes.set_xlim(curves.t[0], curves.t[-1])
    tidied(axes, "over its static value")
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(color=QUIET, labelcolor=INK, length=3)


def _bar(curves: Curves) -> str:
    """Return the certificate's error estimate of the first curve's peak as text; "" if there is none."""
    return f" ± {digits(float(f'{curves.bars[0]:.2g}'))}" if 0 in curves.bars else ""


def _note_peak(axes: Axes, curves: Curves) -> None:
    """Mark the largest value of the first curve with a dot and a line of text."""
    k = int(np.argmax(curves.peaks[:, 0]))
    t, value = curves.t[k], curves.peaks[k, 0]
    unit = curves.quantity.partition("[")[2].rstrip("]")
    high = curves.rated[0] is not None and value > 0.85 * curves.rated[0]  # the limit has its label above
    left = t > 0.75 * curves.t[-1] + 0.25 * curves.t[0]
    axes.plot(t, value, "o", ms=4.5, color=INK, zorder=5)
    axes.annotate(
        f"peak {digits(value)}{_bar(curves)} {unit} at {clock(t, 0 if curves.t[-1] >= 600 else 1)}",
        (t, value),
        xytext=(-6 if left else 6, -14 if high else 5),
        textcoords="offset points",
        ha="right" if left else "left",
        size=9,
        color=INK,
        zorder=5,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1},
    )


def _label_stages(axes: Axes, times: Sequence[float], names: Sequence[str]) -> None:
    """Write the names of stages above the panel, at a distance from each other, with lines to their starts."""
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
                text, top, xycoords="axes fraction", xytext=(place - at, up), textcoords="offset points",
                rotation=SLOPE, rotation_mode="anchor", size=min(LABEL, gap * 0.62), color=INK,
                arrowprops=None if text else LEADER,
            )  # fmt: skip
