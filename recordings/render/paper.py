"""What all figures on paper share: ink, how text is set, how the file is written.

Names come from recordings, so a dollar sign in one is a dollar sign and no formula; equal recordings give equal files.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.partfile import PartFile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["BAND", "FORMATS", "INK", "LIMIT", "QUIET", "banded", "on_paper", "save", "tidied"]

INK, QUIET, BAND, LIMIT = "#1d2733", "#6b7682", "#f1f4f7", "#a3182b"
FORMATS = (".png", ".svg")


@contextmanager
def on_paper() -> Iterator[None]:
    """Within it figures are drawn and saved."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "heavylift", "font.size": 9.5, "axes.linewidth": 0.8, "text.parse_math": False}):
        yield


def tidied(axes: Axes, label: str) -> None:
    """Light lines across, no frame at the top and on the right; the label of the values."""
    axes.set_ylabel(label, color=INK)
    axes.grid(axis="y", color="#d9dee3", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def banded(axes: Axes, times: Sequence[float], last: float) -> Iterator[tuple[float, float]]:
    """Shade every other stage of those that begin at these times; begin and end of each."""
    for i, (start, stop) in enumerate(pairwise([*times, last])):
        if i % 2 == 0:
            axes.axvspan(start, stop, color=BAND, lw=0, zorder=0)
        yield start, stop


def save(figure: Figure, out: Path, force: bool = False, dpi: int = 160) -> Path:
    """Write a figure to a .png or .svg file, and return which (outputs.py); RecordingError if the system refuses."""
    form = out.suffix.lower()[1:]
    told = {"Date": None, "Creator": GENERATOR} if form == "svg" else {"Software": GENERATOR}
    with PartFile(out, "a figure", FORMATS, force) as file, file.writing():
        figure.savefig(file.stream, format=form, dpi=dpi, metadata=told)
    return file.path
