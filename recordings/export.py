"""The samples of a recording as one table for other programs: CSV, or Parquet where pyarrow is installed.

First column is the time in seconds; every other one is named `signal/column [unit]`.  Numbers are written with all
their digits, so that nothing is lost on the way.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError
from numpy.typing import NDArray

from .partfile import output_path
from .reader import Recording
from .samples import POSE

__all__ = ["chosen", "export"]

SUFFIXES = (".csv", ".parquet")


def export(path: str | Path, out: str | Path, patterns: Sequence[str] = ()) -> Path:
    """Write the signals whose `signal/column` matches one of the patterns (default: all) to a .csv or .parquet file."""
    out = output_path(out)
    if out.suffix.lower() not in SUFFIXES:
        raise RecordingError(f"{out}: a table is written as .csv or .parquet; give it one of these endings")
    rec = Recording(path)
    t, columns = _columns(rec, patterns)
    try:
        if out.suffix.lower() == ".csv":
            with out.open("w", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(["time [s]", *columns])
                writer.writerows(zip(t.tolist(), *(x.tolist() for x in columns.values()), strict=True))
        else:
            _parquet(out, {"time [s]": t, **columns})
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror}); choose another place") from None
    return out


def _parquet(out: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise RecordingError(f"{out}: Parquet needs pyarrow; install heavylift[parquet] or write a .csv") from None
    parquet.write_table(pyarrow.table(columns), out)


def _columns(rec: Recording, patterns: Sequence[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Sample times and the chosen columns; all channels are sampled together, so that times are the same."""
    wanted = chosen(rec, patterns)
    signals = {name: rec.signal(name) for name, _ in wanted}
    columns: dict[str, NDArray[np.float64]] = {}
    for name, column in wanted:
        signal = signals[name]
        unit = signal.unit if not name.startswith(POSE) else "m" if column in "xyz" else "1"
        columns[f"{name}/{column} [{unit}]"] = signal.values[:, signal.names.index(column)]
    return next((x.t for x in signals.values()), np.zeros(0)), columns


def chosen(rec: Recording, patterns: Sequence[str]) -> list[tuple[str, str]]:
    """(signal, column) pairs that match a pattern such as "rope/tension/*", in the order of the recording."""
    every = [(name, column) for name in rec.signals() for column in rec.columns(name)]
    for pattern in patterns:
        if not any(fnmatchcase(f"{name}/{column}", pattern) or name == pattern for name, column in every):
            raise RecordingError(
                f"{rec.path}: no signal matches '{pattern}'; signals are {', '.join(rec.signals()) or 'none'}"
            )
    return [
        (name, column)
        for name, column in every
        if not patterns or any(fnmatchcase(f"{name}/{column}", p) or name == p for p in patterns)
    ]
