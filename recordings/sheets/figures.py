"""Figures on pages: drawn in placeholder colours, which the page replaces by those of the reader's theme."""

from __future__ import annotations

import io
import re
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#56B4E9", "#7a6fd0", "#6b7682", "#8c3b1b",
           "#17a589", "#c2185b")  # fmt: skip
INK, QUIET, BAND, PAPER, LIMIT = "#1d2733", "#6b7683", "#e6f2ea", "#ffffff", "#a3182b"
THEME = {INK: "var(--ink)", QUIET: "var(--quiet)", BAND: "var(--band)", PAPER: "var(--paper)", LIMIT: "var(--limit)"}


def in_page(figure: Figure) -> str:
    """Return a figure as <svg> with text and colours of the page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
    svg = text.getvalue()
    for colour, variable in THEME.items():
        svg = re.sub(colour, variable, svg, flags=re.IGNORECASE)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'<svg ([^>]*?)height="[^"]*"([^>]*?)width="[^"]*"', r'<svg role="img" \1\2', svg, count=1)


def styled(fonts: str) -> AbstractContextManager[None]:
    """Context with the style of figures in this module's colours; `fonts` of SVG: "none" for text, "path" for
    outlines."""
    from matplotlib import rc_context

    style: dict[Any, Any] = {"svg.hashsalt": "heavylift", "svg.fonttype": fonts,
             "font.size": 9.5, "axes.linewidth": 0.8,
             "text.color": INK, "axes.edgecolor": QUIET, "axes.labelcolor": INK, "xtick.color": QUIET,
             "ytick.color": QUIET, "legend.labelcolor": INK, "axes.facecolor": "none", "path.simplify": True,
             "font.family": ["DejaVu Sans", "sans-serif"]}  # fmt: skip
    return rc_context(style)
