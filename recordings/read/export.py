"""The samples of a recording as one table for other programs: CSV, or Parquet where pyarrow is installed.

First column is the time in seconds; every other one is named `signal/column [unit]`.  Numbers are written with all
their digits, so that nothing is lost on the way.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError
from heavylift.recordings.format.text import meant
from heavylift.recordings.write.outputs import GENERATOR, output_path
from heavylift.recordings.write.partfile import PartFile
from numpy.typing import NDArray

from .part import chosen
from .reader import Recording
from .signal import titles

__all__ = ["export", "matching"]


def export(path: str | Path, out: str | Path, patterns: Sequence[str] = (), force: bool = False) -> Path:
    """Write the signals whose `signal/column` matches one of the patterns (default: all) to a .csv or .parquet file."""
    out = output_path(out, "a table", (".csv", ".parquet"))
    rec = Recording(path)
    with rec.reading():
        t, columns = _columns(rec, patterns)
    with PartFile(out, "a table", (".csv", ".parquet"), force) as file, file.writing():
        if out.suffix.lower() == ".csv":
            text = io.TextIOWrapper(file.stream, "utf-8", newline="")
            writer = csv.writer(text, lineterminator="\n")
            writer.writerow(["time [s]", *columns])
            writer.writerows(zip(t.tolist(), *(x.tolist() for x in columns.values()), strict=True))
            text.detach()
        else:
            _parquet(out, file.stream, {"time [s]": t, **columns})
    return file.path


def _parquet(out: Path, stream: BinaryIO, columns: dict[str, NDArray[np.float64]]) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise RecordingError(f"{out}: Parquet needs pyarrow; install heavylift[parquet] or write a .csv") from None
    parquet.write_table(pyarrow.table(columns, metadata={"made by": GENERATOR}), stream)


def _columns(rec: Recording, patterns: Sequence[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Times of the first chosen signal and all columns there: what was measured has other times than the run."""
    wanted = matching(rec, patterns)
    rec.load([*dict.fromkeys(name for name, _ in wanted)])
    signals = {name: rec.signal(name) for name, _ in wanted}
    t = next((x.t for x in signals.values()), np.zeros(0))
    columns: dict[str, NDArray[np.float64]] = {}
    for name, column in wanted:
        signal = signals[name]
        k = signal.names.index(column)
        columns[f"{name}/{titles(signal)[k]}"] = signal.at(t).values[:, k]
    return t, columns


def matching(rec: Recording, patterns: Sequence[str]) -> list[tuple[str, str]]:
    """(signal, column) pairs that match one of the patterns (all without one), in the order of the recording."""
    every = chosen(rec, "*")
    wanted: set[tuple[str, str]] = set()
    for pattern in patterns:
        found = chosen(rec, pattern)
        if not found:
            raise SignalError(f"{rec.path}: no signal matches '{pattern}'; {meant(pattern, rec.signals())}")
        wanted |= set(found)
    return [pair for pair in every if not patterns or pair in wanted]
