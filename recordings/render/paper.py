"""What all figures on paper share: ink, how text is set, how the file is written.

Names come from recordings, so a dollar sign in one is a dollar sign and no formula; equal recordings give equal files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from heavylift.kernel.description.findings import clock
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.partfile import PartFile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, QUIET, BAND, LIMIT = "#1d2733", "#6b7682", "#f1f4f7", "#a3182b"
FORMATS = (".png", ".svg")
STEPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400)  # [s]
TICKS = 9  # at most along an axis of times
NEAR = 2.5  # times what is drawn: a limit that is farther away is not
CLOSE = 0.05  # of the largest value: limits that are nearer to one another share a label


@contextmanager
def on_paper() -> Iterator[None]:
    """Style of drawn and saved figures."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "heavylift", "font.size": 9.5, "axes.linewidth": 0.8, "text.parse_math": False}):
        yield


def tidied(axes: Axes, label: str) -> None:
    """Light grid, no frame at top and right; label of the values."""
    axes.set_ylabel(label, color=INK)
    axes.grid(axis="y", color="#d9dee3", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def timed(axes: Axes) -> None:
    """Run time [s] along x, beyond a minute as h:min:s."""
    from matplotlib.ticker import FixedLocator

    first, last = axes.get_xlim()
    if last < 60.0:
        axes.set_xlabel("Time [s]", color=INK)
        return
    step = next((x for x in STEPS if (last - first) / x <= TICKS), max(STEPS[-1], (last - first) / TICKS))
    axes.xaxis.set_major_locator(FixedLocator([k * step for k in range(math.ceil(first / step), int(last / step) + 1)]))
    axes.xaxis.set_major_formatter(lambda t, _: clock(t, 0 if step >= 1 else 2))
    axes.set_xlabel("Time [h:min:s]" if last >= 3600 else "Time [min:s]", color=INK)


def limited(axes: Axes, limits: Mapping[str, float], unit: str, high: float) -> float:
    """Lines at rated values near the largest value; returns the upper end of the axis."""
    near = {name: limit for name, limit in limits.items() if limit < NEAR * high}
    top = max([high, *near.values()])
    groups: list[list[str]] = []  # those whose lines are close to one another share a label
    for name in sorted(near, key=lambda x: (near[x], x)):
        if groups and near[name] - near[groups[-1][0]] < CLOSE * top:
            groups[-1].append(name)
        else:
            groups.append([name])
    for names in groups:
        values = [near[name] for name in names]
        for limit in sorted(set(values)):
            axes.axhline(limit, color=LIMIT, lw=1.1, ls=(0, (6, 3)), zorder=2)
        message = " to ".join(dict.fromkeys(map(digits, (values[0], values[-1]))))
        of = names[0] + (f" and {len(names) - 1} more" if len(names) > 1 else "")
        text = f"rated {message} {unit}" + (f": {of}" if len(groups) > 1 else "")
        axes.annotate(text, (1, values[-1]), xycoords=("axes fraction", "data"), xytext=(-4, 3), ha="right",
                      textcoords="offset points", color=LIMIT, size=8.5)  # fmt: skip
    return top


def digits(value: float) -> str:
    """A number for people, thousands apart by a thin space."""
    text = f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return text.replace(",", "\u2009").replace("-", "\u2212")


def banded(axes: Axes, times: Sequence[float], last: float) -> Iterator[tuple[float, float]]:
    """Shade every other stage; begin and end of each."""
    for i, (start, stop) in enumerate(pairwise([*times, last])):
        if i % 2 == 0:
            axes.axvspan(start, stop, color=BAND, lw=0, zorder=0)
        yield start, stop


def spread(wanted: Sequence[float], highest: Sequence[float], gap: float) -> list[float]:
    """Places nearest to the wanted ones, at least `gap` apart, none above its `highest`."""
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


def save(figure: Figure, out: Path, force: bool = False, dpi: int = 160) -> Path:
    """Write a figure to a .png or .svg file, and return which (outputs.py); RecordingError if the system refuses."""
    form = out.suffix.lower()[1:]
    message = {"Date": None, "Creator": GENERATOR} if form == "svg" else {"Software": GENERATOR}
    with PartFile(out, "a figure", FORMATS, force) as file, file.writing():
        figure.savefig(file.stream, format=form, dpi=dpi, metadata=message)
    return file.path
