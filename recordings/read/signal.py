"""A signal over time, as it is handed to people and to other programs.

signal = Recording("run.mcap")["rope/tension"]
signal.t, signal["west.H1"], signal.unit      # (n,) [s], (n,), "N"
t, values, names, unit = signal               # all columns at once, values (n, m)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError, extra
from heavylift.recordings.format.samples import unit_of
from heavylift.recordings.format.text import meant
from numpy.typing import NDArray

from .notebook import signal_html

if TYPE_CHECKING:
    import pandas
    import pyarrow

Floats = NDArray[np.float64]


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

    def at(self, t: Floats) -> Signal:
        """The signal at other times [s], between its own by straight lines, beyond them not a number."""
        if np.array_equal(t, self.t):
            return self
        columns = [np.interp(t, self.t, x, left=np.nan, right=np.nan) for x in self.values.T]
        return Signal(t, np.column_stack(columns), self.names, self.unit, self.name)

    def to_pandas(self) -> pandas.DataFrame:
        """A pandas DataFrame: the time [s] as index, units in the column names."""
        missing = "a DataFrame needs pandas; install heavylift[pandas] or use .t and .values"
        library = extra("pandas", RecordingError(missing))
        index = library.Index(self.t, name="time [s]")
        return library.DataFrame(dict(zip(titles(self), self.values.T, strict=True)), index=index)

    def to_arrow(self) -> pyarrow.Table:
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
    """The signal with these of its columns."""
    picks = [signal.names.index(column) for column in columns]
    return Signal(signal.t, signal.values[:, picks], columns, signal.unit, signal.name)
