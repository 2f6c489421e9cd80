"""Data structure of the comparison page: a row is one figure of a source beside ours, a case computes its rows.

    @case(TABLE, "source", "tests/kernel/test_x.py")
    def name() -> Iterator[Row]: ...

Cases are kept in the order in which they are written; `full` marks those that `--check` leaves to `--full`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import ceil, log10
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
KERNEL = sorted({str(path.parent.relative_to(TESTS)) for path in TESTS.glob("kernel/**/*.py")})
for folder in (*KERNEL, "chain", "extremes"):  # whose builders of scenes the cases share
    if str(TESTS / folder) not in sys.path:
        sys.path.append(str(TESTS / folder))

FORMS = {form["id"]: form for form in json.loads((TESTS / "data" / "closed_forms.json").read_text())}
ROUND_OFF = 1e-9
LEAST = 0.01  # of what is allowed: a smaller difference is reported as less than this, since its digits say nothing


@dataclass(frozen=True)
class Row:
    """A figure of the source, ours, and how far apart they may be.

    `within` is relative, or in the row's unit if the row is `absolute` (where the figure is 0).  A `bound` is not to be
    exceeded; there `within` only says how many digits are worth printing.
    """

    quantity: str
    theirs: float
    ours: float
    within: float
    unit: str = ""
    absolute: bool = False
    bound: bool = False

    @property
    def difference(self) -> float:
        """Ours less theirs, relative unless the row is absolute."""
        return self.ours - self.theirs if self.absolute else self.ours / self.theirs - 1.0

    @property
    def missed(self) -> bool:
        return self.ours > self.theirs if self.bound else not abs(self.difference) <= self.within

    def cells(self) -> str:
        """Quantity to tolerance, as they stand in the page."""
        digits = min(max(ceil(-log10(self.within)) + 1, 3), 10)
        unit = f" {self.unit}" if self.unit else ""
        figures = [f"{value:#.{digits}g}".rstrip(".") + unit for value in (self.theirs, self.ours)]
        if self.absolute:
            figures = [self._message(value, "-") if value else f"0{unit}" for value in (self.theirs, self.ours)]
        apart = self._message(self.difference, "+")
        apart = f"**{apart}: missed**" if self.missed else apart
        within = "at most theirs" if self.bound else self._message(self.within)
        return f"{self.quantity} | {figures[0]} | {figures[1]} | {apart} | {within}"

    def _message(self, value: float, sign: str = "") -> str:
        least = LEAST * self.within if self.absolute else max(LEAST * self.within, ROUND_OFF)
        if sign and abs(value) < least:
            return f"< {self._message(least)}"
        if self.absolute:
            return f"{value:{sign}.0e} {self.unit}".rstrip()
        if abs(value) >= 1.0:
            return f"{100 * value:{sign}.0f} %"
        return f"{100 * value:{sign}.2g} %" if abs(value) >= 1e-4 else f"{value:{sign}.0e}"


@dataclass(frozen=True)
class Case:
    """Rows of one source, the table they stand in, and the file that holds the comparison to account."""

    table: str
    source: str
    shown: str
    compute: Callable[[], Iterator[Row]]
    full: bool
    why: str

    @property
    def name(self) -> str:
        return self.compute.__name__

    def lines(self) -> list[tuple[Row, str]]:
        """Each row with its line of the page; the first one names the source and links to the test."""
        rows = list(self.compute())
        first = f"| [{self.source}](../{self.shown}) | "
        return [(row, f"{'| | ' if number else first}{row.cells()} |") for number, row in enumerate(rows)]


CASES: list[Case] = []


def case(table: str, source: str, shown: str, full: bool = False, why: str = "") -> Callable[[Any], Any]:
    """Registers a function that yields rows; `why` some of them miss."""

    def register(compute: Callable[[], Iterator[Row]]) -> Callable[[], Iterator[Row]]:
        CASES.append(Case(table, source, shown, compute, full, why))
        return compute

    return register
