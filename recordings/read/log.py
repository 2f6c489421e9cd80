"""The log of a real machine: columns of numbers over time in a CSV file; errors name file, row and column.

The separator is a comma, semicolon or tab; with the latter two a decimal comma is allowed. Rows are counted as in the
file, whose head is row 1. A column head may contain its unit: `force [kN]`. Times are numbers, or dates by ISO 8601.
"""

import csv
import os
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.text import meant
from heavylift.recordings.write.outputs import file_path
from numpy.typing import NDArray

GAP = 5.0  # times the usual step: what is longer is a gap
TIMES = ("time", "t")  # columns of times, unless a map names another one
CLOCK = {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0, "date": 1.0}  # units of times [s]; dates count from the first
HEAD = re.compile(r"\s*(.*?)\s*(?:\[([^\]]*)\])?\s*", re.S)  # name and unit
CUT = "cut the log where its rows are whole"
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LogTable:
    """A CSV table as text, with `head`: (name, unit) of each column, and `rows`: number of each row in the file."""

    path: Path
    head: list[tuple[str, str]]
    rows: list[int]
    cells: list[list[str]]
    decimal: str

    def error(self, row: int, column: str, what: str) -> RecordingError:
        """Return an error that names the file, the row and the column of a cell."""
        return RecordingError(f"{self.path}: row {row}, column '{column}': {what}")

    def unit(self, column: str) -> str:
        """Return the unit in the header of a column; "" if the header gives none."""
        return self.head[self._number(column)][1]

    def _number(self, column: str) -> int:
        """Return the index of the column with this name, given with or without unit; raises RecordingError."""
        found = [i for i, (name, unit) in enumerate(self.head) if column in (name, f"{name} [{unit}]")]
        if len(found) == 1:
            return found[0]
        missing = f"there is no such column; {meant(column, [name for name, _ in self.head])}"
        several = f"columns {', '.join(str(i + 1) for i in found)} have this name; rename all but one"
        raise self.error(1, column, several if found else missing)

    def values(self, column: str) -> Floats:
        """Return the numbers (n,) of a column; raises RecordingError unless all of them are finite numbers."""
        k, out = self._number(column), np.empty(len(self.cells))
        for i, (row, cells) in enumerate(zip(self.rows, self.cells, strict=True)):
            text = cells[k].strip()
            try:
                out[i] = float("x" if "_" in text else text.replace(self.decimal, "."))
            except ValueError:
                what = f"'{text}' is not a number" if text else "is empty, which is a gap"
                raise self.error(row, column, f"{what}; {CUT}") from None
            if not np.isfinite(out[i]):
                raise self.error(row, column, f"'{text}' is not a finite number; {CUT}")
        return out

    def seconds(self, column: str = "", unit: str = "") -> Floats:
        """Return the times (n,) [s] of the rows; dates are converted to seconds since the first row.

        Each row must have a time, and times must ascend.
        """
        column = column or next((name for name, _ in self.head if name.lower() in TIMES), TIMES[0])
        k = self._number(column)
        dates = [_date(cells[k]) for cells in self.cells]
        unit = unit or self.unit(column) or ("date" if dates[0] else "")
        if unit not in CLOCK:
            what = f"'{unit}' is not a unit of time" if unit else "the unit is missing"
            raise self.error(1, column, f"{what}; write the unit after the name, such as '{column} [s]'")
        if unit == "date":
            if None in dates:
                i = dates.index(None)
                raise self.error(
                    self.rows[i], column, f"'{self.cells[i][k]}' is not a valid date; write it as 2024-05-01T06:00"
                )
            t = np.array([(date - dates[0]).total_seconds() for date in dates if date and dates[0]])
        else:
            t = self.values(column) * CLOCK[unit]
        if len(t) < 2:
            raise self.error(self.rows[-1], column, "the log needs at least two rows")
        steps = np.diff(t)
        usual = float(np.median(np.abs(steps)))
        for i in np.flatnonzero((steps <= 0.0) | (steps > GAP * usual * (1 + 1e-9))).tolist():
            before, after = (self.cells[j][k].strip() for j in (i, i + 1))
            if steps[i] <= 0.0:
                raise self.error(
                    self.rows[i + 1],
                    column,
                    f"{after} comes after {before}; times must be in ascending order: sort the log",
                )
            what = f"a gap of {steps[i]:.6g} s behind it, where rows are {usual:.6g} s apart; cut the log there"
            raise self.error(self.rows[i], column, what)
        return t


def read_log(path: str | Path) -> LogTable:
    """Read a CSV table; raises RecordingError if the file is missing, empty or binary, or if row lengths differ."""
    path = file_path(path)
    if not os.path.isfile(path):  # False also for names that no file can have
        raise RecordingError(f"{path}: this log does not exist; check the name")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            first = file.readline()
            file.seek(0)
            separator = max(";\t,", key=first.count)
            reader = csv.reader(file, delimiter=separator, strict=True)
            table = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except OSError as error:
        raise RecordingError(f"{path}: the file cannot be opened ({error.strerror}); check its permissions") from None
    except UnicodeDecodeError:
        raise RecordingError(f"{path}: the file is not UTF-8 text; export the log as CSV again") from None
    except csv.Error as error:
        raise RecordingError(
            f"{path}: row {reader.line_num} is not valid CSV ({error}); export the log again"
        ) from None
    if len(table) < 2:
        raise RecordingError(f"{path}: the table has no rows below its header; export the log again")
    (_, names), *below = table
    for row, cells in below:
        if len(cells) != len(names):
            raise RecordingError(
                f"{path}: row {row} has {len(cells)} cells, but the header has {len(names)}; correct the row"
            )
    head = [(match[1], match[2] or "") for cell in names if (match := HEAD.fullmatch(cell))]
    rows, texts = [row for row, _ in below], [cells for _, cells in below]
    return LogTable(path, head, rows, texts, "." if separator == "," else ",")


def _date(text: str) -> datetime | None:
    text = text.strip()
    try:
        found = datetime.fromisoformat(text) if not text.isdecimal() else None
    except ValueError:
        return None
    return found.replace(tzinfo=found.tzinfo or UTC) if found else None
