"""How recordings and signals look in a notebook: a table and a small drawing, no script, everything escaped."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from heavylift.recordings.format.samples import POSE, thinned
from heavylift.recordings.format.text import duration

from .settings import settings

__all__ = ["part_html", "recording_html", "signal_html"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
WIDTH, HEIGHT, POINTS = 460, 110, 300
FACTS = ("scene", "seed", "samples_hz")


class Columns(Protocol):
    """A signal (`signal.Signal`)."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def t(self) -> np.ndarray: ...
    @property
    def values(self) -> np.ndarray: ...
    def __len__(self) -> int: ...


class Run(Protocol):
    """A recording (`reader.Recording`)."""

    @property
    def path(self) -> Path: ...
    @property
    def run(self) -> dict[str, Any]: ...
    @property
    def result(self) -> dict[str, Any]: ...
    def fact(self, name: str, default: Any = None) -> Any: ...
    def signals(self) -> list[str]: ...
    def columns(self, name: str) -> list[str]: ...
    def unit(self, name: str) -> str: ...
    def signal(self, name: str) -> Columns: ...
    def stages(self) -> list[tuple[float, str]]: ...


class Named(Protocol):
    """A part of a recording (`part.Part`)."""

    @property
    def name(self) -> str: ...
    @property
    def signals(self) -> list[str]: ...


def signal_html(signal: Columns) -> str:
    """Least and largest value of each column, and its curve."""
    rows = []
    for name, column in zip(signal.names, signal.values.T, strict=True):
        if len(column) and not np.isnan(column).all():
            low, high = int(np.nanargmin(column)), int(np.nanargmax(column))
            cells = [_number(column[low]), _at(signal, low), _number(column[high]), _at(signal, high)]
            rows.append([name, *cells, _number(column[-1])])
    title = f"{signal.name} [{signal.unit}], {len(signal)} samples"
    return _heading(title) + drawing(signal) + _table(["", "least", "at", "largest", "at", "last"], rows)


def recording_html(rec: Run) -> str:
    """Facts, the tensions, peaks of the ropes, and which signals there are."""
    facts = [[name.replace("_", " "), rec.run[name]] for name in FACTS if name in rec.run]
    facts += [[name, text] for name, text in settings(rec.run).items()]
    facts += [["status", rec.result.get("status", "cut off")], ["digest", rec.result.get("digest", "none")]]
    if "sim_s" in rec.result:
        facts.append(["simulated", duration(float(rec.fact("sim_s")))])
    names = [name for name in rec.signals() if not name.startswith(POSE)]
    rows = [[name, rec.unit(name), ", ".join(rec.columns(name))] for name in names]
    poses = [name.removeprefix(POSE) for name in rec.signals() if name.startswith(POSE)]
    rows += [[f"{POSE}*", "m, quaternion", ", ".join(poses)]] if poses else []
    picture = drawing(rec.signal("rope/tension")) if "rope/tension" in names else ""
    stages = [[duration(t), name] for t, name in rec.stages()]
    parts = [_heading(str(rec.path)), _table(["", ""], facts), picture, _table(["from", "stage"], stages)]
    return "".join(parts) + _table(["signal", "unit", "columns"], rows)


def part_html(part: Named) -> str:
    """The signals of a part of the scene."""
    return _heading(part.name) + _table(["signal"], [[name] for name in part.signals])


def drawing(signal: Columns) -> str:
    """The curves of a signal as an SVG element: of many samples the least and the largest of equal parts."""
    t, values = signal.t, signal.values
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
    words = f"{signal.name}: {_number(low)} to {_number(high)} {signal.unit}, {t[0]:g} to {t[-1]:g} s"
    head = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img">'
    return f"{head}<title>{escape(words)}</title>{''.join(lines)}</svg>"


def _at(signal: Columns, k: int) -> str:
    return f"{signal.t[k]:.6g} s"


def _number(x: float) -> str:
    return f"{x:.6g}"


def _heading(text: str) -> str:
    return f"<p><b>{escape(text)}</b></p>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    if not rows:
        return ""
    lines = [f"<tr>{''.join(f'<th>{escape(x)}</th>' for x in head)}</tr>"] if any(head) else []
    lines += [f"<tr>{''.join(f'<td>{escape(x)}</td>' for x in row)}</tr>" for row in rows]
    return f"<table>{''.join(lines)}</table>"
