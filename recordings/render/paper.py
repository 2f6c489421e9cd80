"""What all figures on paper share: ink, how text is set, how the file is written.

Names come from recordings, so a dollar sign in one is a dollar sign and no formula; equal recordings give equal files.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.partfile import PartFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BAND", "FORMATS", "INK", "LIMIT", "QUIET", "on_paper", "save"]

INK, QUIET, BAND, LIMIT = "#1d2733", "#6b7682", "#f1f4f7", "#a3182b"
FORMATS = (".png", ".svg")


@contextmanager
def on_paper() -> Iterator[None]:
    """Within it figures are drawn and saved."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "heavylift", "font.size": 9.5, "axes.linewidth": 0.8, "text.parse_math": False}):
        yield


def save(figure: Figure, out: Path, force: bool = False, dpi: int = 160) -> Path:
    """Write a figure to a .png or .svg file, and return which (outputs.py); RecordingError if the system refuses."""
    form = out.suffix.lower()[1:]
    told = {"Date": None, "Creator": GENERATOR} if form == "svg" else {"Software": GENERATOR}
    with PartFile(out, "a figure", FORMATS, force) as file, file.writing():
        figure.savefig(file.stream, format=form, dpi=dpi, metadata=told)
    return file.path
