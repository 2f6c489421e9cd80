"""A signal over time, as it is handed to people and to other programs.

signal = Recording("run.mcap")["rope/tension"]
signal.t, signal["west.H1"], signal.unit      # (n,) [s], (n,), "N"
t, values, names, unit = signal               # all columns at once, values (n, m)

How recordings and signals look in a notebook: a table and a small drawing, no script, everything escaped.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError, extra
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import thinned, unit_of
from heavylift.recordings.format.text import duration, meant
from heavylift.recordings.sheets.page import table_html
from heavylift.recordings.sheets.sheet import Cell, words
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import pyarrow

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
    state: str,
) -> str:
    """Facts of a run, a picture, stages [s], and available signals: name, unit, columns."""
    message = {name: text for name in FACTS if (text := run.get(name))} | settings(run)
    message |= {"status": result.get("status", "cut off"), "digest": result.get("digest", "none")}
    message |= {"simulated": duration(float(result["sim_s"]))} if "sim_s" in result else {}
    facts = _table(["", ""], [(name.replace("_", " "), text) for name, text in message.items()])
    begun = _table(["from", "stage"], [(duration(t), name) for t, name in stages])
    return heading(title) + facts + state + begun + _table(["signal", "unit", "columns"], signals)


def signal_html(name: str, unit: str, names: Sequence[str], t: Floats, values: Floats) -> str:
    """Minimum and maximum of each column (n, m) at times (n,), and a curve."""
    rows = []
    for title, column in zip(names, values.T, strict=True):
        if len(column) and not np.isnan(column).all():
            low, high = int(np.nanargmin(column)), int(np.nanargmax(column))
            cells = [x for k in (low, high) for x in (_number(column[k]), f"{_number(t[k])} s")]
            rows.append([title, *cells, _number(column[-1])])
    head = ["", "least", "at", "largest", "at", "last"]
    return heading(f"{name} [{unit}], {len(t)} samples") + drawing(name, unit, t, values) + _table(head, rows)


def drawing(name: str, unit: str, t: Floats, values: Floats) -> str:
    """Curves of a signal as SVG; for many samples minima and maxima of equal parts."""
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


@dataclass(frozen=True, eq=False)
class Signal:
    """Simulation times (n,) [s], values (n, m), the names of the m columns, their unit, and the signal's own name."""

    t: Floats
    values: Floats
    names: list[str]
    unit: str
    name: str = ""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.t, self.values, self.names, self.unit))

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, column: str) -> Floats:
        """(n,) the column of this name."""
        if column not in self.names:
            raise SignalError(f"{self.name or 'the signal'} has no column {column}; {meant(column, self.names)}")
        return self.values[:, self.names.index(column)]

    def at(self, t: Floats) -> "Signal":
        """The signal at other times [s], linearly interpolated; NaN outside."""
        if np.array_equal(t, self.t):
            return self
        columns = [np.interp(t, self.t, x, left=np.nan, right=np.nan) for x in self.values.T]
        return Signal(t, np.column_stack(columns), self.names, self.unit, self.name)

    def to_pandas(self) -> "pandas.DataFrame":
        """A DataFrame: index time [s], units in the column names."""
        missing = "a DataFrame needs pandas; install heavylift[pandas] or use .t and .values"
        library = extra("pandas", RecordingError(missing))
        index = library.Index(self.t, name="time [s]")
        return library.DataFrame(dict(zip(titles(self), self.values.T, strict=True)), index=index)

    def to_arrow(self) -> "pyarrow.Table":
        """A pyarrow Table: the time [s] first, units in the column names."""
        missing = "a Table needs pyarrow; install heavylift[parquet] or use .t and .values"
        return extra("pyarrow", RecordingError(missing)).table(
            {"time [s]": self.t, **dict(zip(titles(self), self.values.T, strict=True))}
        )

    def _repr_html_(self) -> str:
        return signal_html(self.name, self.unit, self.names, self.t, self.values)

    def __repr__(self) -> str:
        span = f", {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else ""
        return f"<Signal {self.name} [{self.unit}]: {len(self.t)} samples{span}, columns {', '.join(self.names)}>"


def titles(signal: Signal) -> list[str]:
    """`column [unit]` of each column."""
    return [f"{name} [{unit_of(signal.unit, name)}]" for name in signal.names]


def joined(name: str, parts: list[Signal]) -> Signal:
    """Signals of the same samples side by side under one name."""
    values = np.concatenate([part.values for part in parts], axis=1)
    units = list(dict.fromkeys(part.unit for part in parts))
    return Signal(parts[0].t, values, [x for part in parts for x in part.names], " or ".join(units), name)


def only(signal: Signal, columns: list[str]) -> Signal:
    """The signal with selected columns."""
    picks = [signal.names.index(column) for column in columns]
    return Signal(signal.t, signal.values[:, picks], columns, signal.unit, signal.name)
