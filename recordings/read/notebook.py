"""How recordings and signals look in a notebook: a table and a small drawing, no script, everything escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
from heavylift.recordings.format.samples import thinned
from heavylift.recordings.format.settings import settings
from heavylift.recordings.format.text import duration
from heavylift.recordings.sheets.page import table_html
from heavylift.recordings.sheets.sheet import Cell, words
from numpy.typing import NDArray

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
WIDTH, HEIGHT, POINTS = 460, 110, 300
FACTS = ("scene", "seed", "samples_hz")
Floats = NDArray[np.float64]


def recording_html(
    title: str,
    run: Mapping[str, str],
    result: Mapping[str, str],
    stages: Iterable[tuple[float, str]],
    signals: Sequence[Sequence[str]],
    picture: str,
) -> str:
    """Facts of a run, a picture, its stages [s], and which signals there are: name, unit, columns."""
    told = {name: text for name in FACTS if (text := run.get(name))} | settings(run)
    told |= {"status": result.get("status", "cut off"), "digest": result.get("digest", "none")}
    told |= {"simulated": duration(float(result["sim_s"]))} if "sim_s" in result else {}
    facts = _table(["", ""], [(name.replace("_", " "), text) for name, text in told.items()])
    begun = _table(["from", "stage"], [(duration(t), name) for t, name in stages])
    return heading(title) + facts + picture + begun + _table(["signal", "unit", "columns"], signals)


def signal_html(name: str, unit: str, names: Sequence[str], t: Floats, values: Floats) -> str:
    """Least and largest value of each column (n, m) at the times (n,), and its curve."""
    rows = []
    for title, column in zip(names, values.T, strict=True):
        if len(column) and not np.isnan(column).all():
            low, high = int(np.nanargmin(column)), int(np.nanargmax(column))
            cells = [x for k in (low, high) for x in (_number(column[k]), f"{_number(t[k])} s")]
            rows.append([title, *cells, _number(column[-1])])
    head = ["", "least", "at", "largest", "at", "last"]
    return heading(f"{name} [{unit}], {len(t)} samples") + drawing(name, unit, t, values) + _table(head, rows)


def drawing(name: str, unit: str, t: Floats, values: Floats) -> str:
    """The curves of a signal as an SVG element: of many samples the least and the largest of equal parts."""
    good = values[np.isfinite(values)]
    if len(t) < 2 or not good.size or t[-1] <= t[0]:
        return ""
    low, high = float(good.min()), float(good.max())
    scale = (HEIGHT - 8) / (high - low) if high > low else 0.0
    lines = []
    for i, column in enumerate(values.T):
        k = np.flatnonzero(np.isfinite(column))
        k = k[thinned([column[k]], POINTS)]
        points = " ".join(
            f"{WIDTH * (t[j] - t[0]) / (t[-1] - t[0]):.1f},{HEIGHT - 4 - (column[j] - low) * scale:.1f}" for j in k
        )
        lines.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[i % len(COLOURS)]}"/>')
    words = f"{name}: {_number(low)} to {_number(high)} {unit}, {t[0]:g} to {t[-1]:g} s"
    head = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img">'
    return f"{head}<title>{escape(words)}</title>{''.join(lines)}</svg>"


def heading(text: str) -> str:
    """A line of text in bold."""
    return f"<p><b>{escape(text)}</b></p>"


def _number(x: float) -> str:
    return f"{x:.6g}"


def _table(head: Sequence[str], rows: Iterable[Iterable[Cell]]) -> str:
    return table_html(words("", head, rows))
