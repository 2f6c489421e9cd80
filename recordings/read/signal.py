"""A signal over time, for users and other programs.

signal = Recording("run.mcap")["rope/tension"]
signal.t, signal["west.H1"], signal.unit      # (n,) [s], (n,), "N"
t, values, names, unit = signal               # all columns at once, values (n, m)

How recordings and signals look in a notebook: a table and a small drawing, no script, everything escaped.

All that a recording has about a part of the scene: a crane, a rope, the block, or what a pattern names.

`rec["west"].tension` are the tensions of all ropes named west.*; the last word of a signal's name is the attribute,
after `measured_` or `error_` where a log stands beside the run.  What hangs on a hook has its rope, too, since
its tension is what people ask for.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError, extra
from heavylift.recordings.format.machines import settings
from heavylift.recordings.format.samples import ERROR, MEASURED, POSE, thinned, unit_of
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.format.spellings import BEAMS
from heavylift.recordings.format.text import duration, meant
from heavylift.recordings.sheets.sheet import Cell, table_html, words
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
    """Return HTML for a notebook about a run: facts, a picture, the stages [s], and the available signals with their
    units and columns."""
    message = {name: text for name in FACTS if (text := run.get(name))} | settings(run)
    message |= {"status": result.get("status", "cut off"), "digest": result.get("digest", "none")}
    message |= {"simulated": duration(float(result["sim_s"]))} if "sim_s" in result else {}
    facts = _table(["", ""], [(name.replace("_", " "), text) for name, text in message.items()])
    begun = _table(["from", "stage"], [(duration(t), name) for t, name in stages])
    return heading(title) + facts + state + begun + _table(["signal", "unit", "columns"], signals)


def signal_html(name: str, unit: str, names: Sequence[str], t: Floats, values: Floats) -> str:
    """Return HTML for a notebook about a signal: a curve, and the minimum and maximum of each column of `values` (n, m)
    at times (n,) [s]."""
    rows = []
    for title, column in zip(names, values.T, strict=True):
        if len(column) and not np.isnan(column).all():
            low, high = int(np.nanargmin(column)), int(np.nanargmax(column))
            cells = [x for k in (low, high) for x in (_number(column[k]), f"{_number(t[k])} s")]
            rows.append([title, *cells, _number(column[-1])])
    head = ["", "least", "at", "largest", "at", "last"]
    return heading(f"{name} [{unit}], {len(t)} samples") + drawing(name, unit, t, values) + _table(head, rows)


def drawing(name: str, unit: str, t: Floats, values: Floats) -> str:
    """Return the curves of a signal as SVG; many samples are reduced to minima and maxima of equal intervals."""
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
    """Return a line of text in bold as HTML."""
    return f"<p><b>{escape(text)}</b></p>"


def _number(x: float) -> str:
    return f"{x:.6g}"


def _table(head: Sequence[str], rows: Iterable[Iterable[Cell]]) -> str:
    return table_html(words("", head, rows))


@dataclass(frozen=True, eq=False)
class Signal:
    """A signal: times (n,) [s], values (n, m), names of the m columns, their unit, and the name of the signal."""

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
        """Return the column (n,) with this name; raises SignalError if there is none."""
        if column not in self.names:
            raise SignalError(f"{self.name or 'the signal'} has no column {column}; {meant(column, self.names)}")
        return self.values[:, self.names.index(column)]

    def at(self, t: Floats) -> "Signal":
        """Return the signal interpolated linearly at other times [s]; NaN outside the time span of the signal."""
        if np.array_equal(t, self.t):
            return self
        columns = [np.interp(t, self.t, x, left=np.nan, right=np.nan) for x in self.values.T]
        return Signal(t, np.column_stack(columns), self.names, self.unit, self.name)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a DataFrame with the time [s] as index and units in the column names."""
        missing = "a DataFrame needs pandas; install heavylift[pandas] or use .t and .values"
        library = extra("pandas", RecordingError(missing))
        index = library.Index(self.t, name="time [s]")
        return library.DataFrame(dict(zip(titles(self), self.values.T, strict=True)), index=index)

    def to_arrow(self) -> "pyarrow.Table":
        """Return a pyarrow Table with the time [s] as first column and units in the column names."""
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
    """Return the title `column [unit]` of each column."""
    return [f"{name} [{unit_of(signal.unit, name)}]" for name in signal.names]


def joined(name: str, parts: list[Signal]) -> Signal:
    """Return one signal that contains the columns of several signals with the same times."""
    values = np.concatenate([part.values for part in parts], axis=1)
    units = list(dict.fromkeys(part.unit for part in parts))
    return Signal(parts[0].t, values, [x for part in parts for x in part.names], " or ".join(units), name)


def only(signal: Signal, columns: list[str]) -> Signal:
    """Return a signal reduced to the given columns."""
    picks = [signal.names.index(column) for column in columns]
    return Signal(signal.t, signal.values[:, picks], columns, signal.unit, signal.name)


class SignalSource(Protocol):
    """Interface through which the parts of a recording read the recording (`reader.Recording`)."""

    @property
    def path(self) -> Path: ...
    def signals(self) -> list[str]: ...
    def columns(self, name: str) -> list[str]: ...
    def signal(self, name: str) -> Signal: ...
    def load(self, names: Sequence[str]) -> None: ...
    def fact(self, name: str, default: Any = None) -> Any: ...
    def events(self, source: str | None = None) -> list[RecordedEvent]: ...


def chosen(rec: SignalSource, pattern: str) -> list[tuple[str, str]]:
    """Return the pairs (signal, column) selected by `signal`, `signal/column` or a pattern such as "rope/tension/*"."""
    every = [(name, column) for name in rec.signals() for column in rec.columns(name)]
    return [(name, column) for name, column in every if name == pattern or fnmatchcase(f"{name}/{column}", pattern)]


class RecordedPart:
    """The signals of one part of the scene as attributes, such as `part.tension`; `part.signals` lists their names."""

    def __init__(self, rec: SignalSource, name: str, columns: dict[str, list[str]]) -> None:
        self._rec, self.name, self._columns = rec, name, columns
        self._words: dict[str, list[str]] = {}
        for signal in columns:
            word = "pose" if signal.startswith(POSE) else signal.rpartition("/")[2]
            word = f"{signal.partition('/')[0]}_{word}" if signal.startswith((MEASURED, ERROR)) else word
            self._words.setdefault(word, []).append(signal)

    @staticmethod
    def of(rec: SignalSource, name: str) -> "RecordedPart":
        """Return the part of a recording with this name ("legs/1" means legs-1); raises SignalError without one."""
        names = (name, name.replace("/", "-"))
        carried = {rope for hung, rope in rec.fact(BEAMS, {}).items() if hung in names}
        found: dict[str, list[str]] = {}
        parts: set[str] = set()
        for signal in rec.signals():
            if signal.startswith(POSE):
                owner = signal.removeprefix(POSE)
                columns = rec.columns(signal) if _in(owner, names) else []
                parts |= {owner, owner.partition(".")[0]}
            else:
                every = rec.columns(signal)
                rope = signal.startswith("rope/")
                columns = [c for c in every if rope and c in carried] + [c for c in every if _in(c, names)]
                parts |= {c for c in every} | {c.partition(".")[0] for c in every}
            if columns:
                found[signal] = columns
        if not found:
            near = meant(name, [*rec.signals(), *sorted(parts)])
            raise SignalError(f"{rec.path}: the recording has no signal or part {name}; {near}")
        return RecordedPart(rec, name, found)

    @property
    def signals(self) -> list[str]:
        """Names of the signals that have columns of this part."""
        return list(self._columns)

    @property
    def events(self) -> list[RecordedEvent]:
        """Events sent by the model that has the name of this part."""
        return self._rec.events(source=self.name.replace("/", "-"))

    def __getattr__(self, word: str) -> Signal:
        if word.startswith("_") or word not in self._words:
            raise AttributeError(f"{self.name} has no {word}; {meant(word, list(self._words))}")
        names = self._words[word]
        self._rec.load(names)
        parts = [only(self._rec.signal(name), self._columns[name]) for name in names]
        if len(parts) == 1:
            return parts[0]
        if word == "pose":  # of several bodies
            parts = [Signal(s.t, s.values, [f"{s.name[len(POSE) :]}.{x}" for x in s.names], s.unit) for s in parts]
            return joined(f"{POSE}{self.name}.*", parts)
        return joined(f"*/{word}", parts)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._words]

    def _repr_html_(self) -> str:
        return heading(self.name) + table_html(words("", ["signal"], [[name] for name in self.signals]))

    def __repr__(self) -> str:
        return f"<{self.name}: {', '.join(self._words)}>"

    def __getstate__(self) -> NoReturn:
        raise TypeError("an object that reads from a recording cannot be pickled; pickle the arrays of its signals")


def _in(column: str, names: tuple[str, ...]) -> bool:
    return any(column == name or column.startswith(f"{name}.") for name in names)
