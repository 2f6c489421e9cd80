"""The log of a machine: columns of numbers over time from a CSV file, each fault named by file, row and column.

Separator is comma, semicolon or tab; beside the latter two a comma may be the decimal one.  Rows are counted as in the
file, its head being row 1.  A head may carry its unit: `force [kN]`.  Times are numbers or dates by ISO 8601.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.text import meant
from heavylift.recordings.write.outputs import file_path, unnamable
from numpy.typing import NDArray

__all__ = ["DATES", "Log", "read_log"]

GAP = 5.0  # times the usual step: what is longer is a gap
DATES = "date"  # stands for a unit where times are dates; they are read as seconds since the first row
HEAD = re.compile(r"\s*(.*?)\s*(?:\[([^\]]*)\])?\s*")  # name and unit
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Log:
    """A table of text with its head; `rows` are the numbers of its rows in the file."""

    path: Path
    head: list[tuple[str, str]]
    rows: list[int]
    cells: list[list[str]]
    decimal: str

    def error(self, row: int, column: str, what: str) -> RecordingError:
        """A sentence about a cell."""
        return RecordingError(f"{self.path}: row {row}, column '{column}': {what}")

    def find(self, column: str) -> int:
        """Number of the column with this name, with or without its unit; RecordingError if not just one has it."""
        found = [i for i, (name, unit) in enumerate(self.head) if column in (name, f"{name} [{unit}]")]
        if len(found) == 1:
            return found[0]
        missing = f"there is no such column; {meant(column, [name for name, _ in self.head])}"
        raise self.error(1, column, f"several columns have this name: {found}" if found else missing)

    def unit(self, column: str) -> str:
        """The unit that its head carries, "" if none; `date` of times that are dates."""
        k = self.find(column)
        return self.head[k][1] or (DATES if self.cells and _date(self.cells[0][k]) is not None else "")

    def values(self, column: str) -> Floats:
        """(n,) numbers of a column, each of them finite."""
        k, out = self.find(column), np.empty(len(self.cells))
        for i, (row, cells) in enumerate(zip(self.rows, self.cells, strict=True)):
            text = cells[k].strip()
            try:
                out[i] = float("x" if "_" in text else text.replace(self.decimal, "."))
            except ValueError:
                what = f"'{text}' is no number" if text else "is empty, which is a gap"
                raise self.error(row, column, f"{what}; cut the log where its rows are whole") from None
            if not np.isfinite(out[i]):
                raise self.error(row, column, f"'{text}' is no finite number; cut the log where its rows are whole")
        return out

    def times(self, column: str) -> Floats:
        """(n,) times, which rise without a gap; of dates seconds since the first row."""
        k = self.find(column)
        if self.unit(column) == DATES:
            dates = [_date(cells[k]) for cells in self.cells]
            wrong = next((i for i, date in enumerate(dates) if date is None), None)
            if wrong is not None:
                raise self.error(self.rows[wrong], column, f"'{self.cells[wrong][k]}' is no date, unlike the first row")
            t = np.array([(date - dates[0]).total_seconds() for date in dates if date and dates[0]])
        else:
            t = self.values(column)
        steps = np.diff(t)
        if len(t) < 2:
            raise self.error(self.rows[-1], column, "the log needs at least two rows")
        if len(back := np.flatnonzero(steps <= 0.0)):
            i = int(back[0]) + 1
            told = (
                f"{self.cells[i][k].strip()} comes after {self.cells[i - 1][k].strip()}; times must rise: sort the log"
            )
            raise self.error(self.rows[i], column, told)
        usual = float(np.median(steps))
        if len(wide := np.flatnonzero(steps > GAP * usual * (1 + 1e-9))):
            i = int(wide[0])
            told = f"a gap of {steps[i]:.6g} behind it, where rows are {usual:.6g} apart; cut the log there"
            raise self.error(self.rows[i], column, told)
        return t


def read_log(path: str | Path) -> Log:
    """The table in a CSV file; RecordingError for one that is missing, empty, no text, or has ragged rows."""
    path = file_path(path)
    if unnamable(path) or not path.is_file():
        raise RecordingError(f"{path}: there is no such log; check the name")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            first = file.readline()
            file.seek(0)
            separator = max(";\t,", key=first.count)
            reader = csv.reader(file, delimiter=separator, strict=True)
            table = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except OSError as error:
        raise RecordingError(f"{path}: cannot be opened ({error.strerror}); check its permissions") from None
    except UnicodeDecodeError:
        raise RecordingError(f"{path}: is no text in UTF-8; export the log as CSV again") from None
    except csv.Error as error:
        raise RecordingError(f"{path}: row {reader.line_num}: is no CSV ({error}); export the log again") from None
    if len(table) < 2:
        raise RecordingError(f"{path}: has no rows below its head; export the log again")
    head = [match.groups(default="") for cell in table[0][1] if (match := HEAD.fullmatch(cell))]
    for row, cells in table[1:]:
        if len(cells) != len(head):
            raise RecordingError(f"{path}: row {row}: has {len(cells)} cells below a head of {len(head)}; mend the row")
    return Log(
        path,
        [(name, unit) for name, unit in head],
        [row for row, _ in table[1:]],
        [cells for _, cells in table[1:]],
        "." if separator == "," else ",",
    )


def _date(text: str) -> datetime | None:
    text = text.strip()
    try:
        found = datetime.fromisoformat(text) if not text.isdecimal() else None
    except ValueError:
        return None
    return found.replace(tzinfo=found.tzinfo or UTC) if found else None
