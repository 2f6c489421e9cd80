"""The samples of a recording as one table for other programs: CSV, or Parquet where pyarrow is installed.

First column is the time in seconds; every other one is named `signal/column [unit]`.  Numbers are written with all
their digits, so that nothing is lost on the way.  A DEVS run, which has no samples, is a table of its events.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError, extra
from heavylift.recordings.format.text import GENERATOR, cell, meant
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import PartFile
from numpy.typing import NDArray

from .part import chosen
from .port_series import log, silent
from .reader import Recording
from .signal import Signal, titles

Tables = Iterator[list[NDArray[np.float64]]]  # times and columns, a few thousand rows at a time


def export(path: str | Path, out: str | Path, patterns: Sequence[str] = (), force: bool = False) -> Path:
    """Write the signals whose `signal/column` matches one of the patterns (default: all) to a .csv or .parquet file."""
    out = output_path(out, "a table", (".csv", ".parquet"))
    rec = Recording(path)
    if silent(rec):
        with rec.reading():
            heads, rows = log(rec, patterns)
        with PartFile(out, "a table", (".csv", ".parquet"), force) as file, file.writing():
            (_csv_rows if out.suffix.lower() == ".csv" else _parquet_rows)(file.stream, heads, rows)
        return file.path
    wanted = matching(rec, patterns)
    names = list(dict.fromkeys(name for name, _ in wanted))
    places = [(names.index(name), rec.columns(name).index(column)) for name, column in wanted]
    none = np.zeros((0, 1))
    signals = [Signal(none[:, 0], none, [column], rec.unit(name), name) for name, column in wanted]
    heads = ["time [s]", *(f"{signal.name}/{titles(signal)[0]}" for signal in signals)]
    tables = ([np.array(times) / 1e9, *(values[i][:, k] for i, k in places)] for times, values in rec.blocks(names))
    write = _csv if out.suffix.lower() == ".csv" else _parquet
    with rec.reading(), PartFile(out, "a table", (".csv", ".parquet"), force) as file, file.writing():
        write(file.stream, heads, tables)
    return file.path


def _csv(stream: BinaryIO, heads: list[str], tables: Tables) -> None:
    rows = (row for columns in tables for row in zip(*(x.tolist() for x in columns), strict=True))
    _csv_rows(stream, heads, rows)


def _csv_rows(stream: BinaryIO, heads: list[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.TextIOWrapper(stream, "utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(cell, heads))
    writer.writerows(map(cell, row) for row in rows)
    text.detach()


def _arrow() -> tuple[Any, Any]:
    missing = RecordingError("Parquet needs pyarrow; install heavylift[parquet] or write a .csv")
    return extra("pyarrow", missing), extra("pyarrow.parquet", missing)


def _parquet_rows(stream: BinaryIO, heads: list[str], rows: list[list[object]]) -> None:
    pyarrow, parquet = _arrow()
    columns = [[row[i] for row in rows] for i in range(len(heads))]
    table = pyarrow.table([pyarrow.array(_alike(x)) for x in columns], names=heads)
    parquet.write_table(table.replace_schema_metadata({"made by": GENERATOR}), stream)


def _alike(column: list[object]) -> list[object]:
    """Of one type, as a table wants it: fields of one name in messages of several classes may differ."""
    kinds = {type(x) for x in column if x is not None}
    return column if len(kinds) < 2 or kinds == {int, float} else [None if x is None else str(x) for x in column]


def _parquet(stream: BinaryIO, heads: list[str], tables: Tables) -> None:
    pyarrow, parquet = _arrow()
    schema = pyarrow.schema([(head, pyarrow.float64()) for head in heads], metadata={"made by": GENERATOR})
    with parquet.ParquetWriter(stream, schema) as writer:
        for columns in tables:
            writer.write_table(pyarrow.table(columns, schema=schema))


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
