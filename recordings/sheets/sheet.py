"""Sheets: content of a verdict, a report, a study or a trade-off, before it is printed.

A column holds one quantity in one unit, which its heading names; a cell is a number in that unit, a time of the run in
a `CLOCK` column [s], a text, or empty. `Marked` colours a cell by a state.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any, NamedTuple, TypeAlias

import msgspec
from heavylift.kernel.description.findings import clock
from heavylift.recordings.format.text import GENERATOR

CLOCK = "h:min:s"
Value: TypeAlias = str | float | None


class Marked(NamedTuple):
    """A cell value with the colour of a state: red, amber, undecided, green, or a choice."""

    value: Value
    state: str = "red"


Cell: TypeAlias = Value | Marked


class Column(msgspec.Struct, frozen=True, omit_defaults=True):
    """A column: a quantity with unit; `digits` after the decimal point, default as needed; a column of texts has
    neither."""

    name: str
    unit: str = ""
    digits: int | None = None

    @property
    def heading(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def numeric(self) -> bool:
        """Whether its cells are numbers."""
        return bool(self.unit) or self.digits is not None

    def text(self, cell: Cell) -> str:
        """Return a cell of this column as text."""
        value = plain(cell)
        if value is None or isinstance(value, str):
            return value or ""
        if self.unit == CLOCK:
            return clock(value, 1 if self.digits is None else self.digits)
        if not isfinite(value):
            return "beyond any" if value > 0 else ""
        return f"{value:.6g}" if self.digits is None else f"{value:z.{self.digits}f}"


def columns(*headings: str) -> tuple[Column, ...]:
    """Return columns made from headings: `stage`, `peak [kN] .1`, `at [h:min:s]`; the number after the unit is that of
    decimals."""
    found = []
    for heading in headings:
        message, _, digits = heading.partition(" .")
        name, _, unit = message.removesuffix("]").partition(" [")
        found.append(Column(name, unit, int(digits) if digits else None))
    return tuple(found)


class Table(msgspec.Struct, frozen=True, omit_defaults=True):
    """A table with notes; not printed without rows. `blank`: a form to be filled in."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...] = ()
    notes: tuple[str, ...] = ()
    blank: bool = False


class Chart(msgspec.Struct, frozen=True):
    """A drawing as <svg> or PNG bytes, with its caption."""

    title: str
    image: str | bytes
    notes: tuple[str, ...] = ()


class Notes(msgspec.Struct, frozen=True):
    """Sentences under a heading."""

    title: str
    lines: tuple[str, ...]


Part: TypeAlias = Table | Chart | Notes


class Sheet(msgspec.Struct, frozen=True):
    """A sheet: title, summary, state (colour), and the parts in reading order."""

    title: str
    lead: str
    state: str
    parts: tuple[Part, ...]

    @property
    def tables(self) -> tuple[Table, ...]:
        """The tables that have rows."""
        return tuple(part for part in self.parts if isinstance(part, Table) and part.rows)


def plain(cell: Cell) -> Value:
    """Return the value of a cell, without its mark."""
    return cell.value if isinstance(cell, Marked) else cell


def words(title: str, heads: Iterable[str], rows: Iterable[Iterable[Cell]], *notes: str) -> Table:
    """Return a table of texts."""
    return Table(title, tuple(map(Column, heads)), tuple(map(tuple, rows)), notes)


def trimmed(table: Table) -> Table:
    """Return a table without empty columns."""
    kept = [i for i in range(len(table.columns)) if any(plain(row[i]) not in ("", None) for row in table.rows)]
    columns, rows = table.columns, table.rows
    picked = tuple(tuple(row[i] for i in kept) for row in rows)
    return msgspec.structs.replace(table, columns=tuple(columns[i] for i in kept), rows=picked)


def data_of(sheet: Sheet) -> dict[str, Any]:
    """Return a sheet as plain data without charts; times in seconds."""
    tables = [
        {
            "title": table.title,
            "columns": [{"name": x.name, "unit": "s" if x.unit == CLOCK else x.unit} for x in table.columns],
            "rows": [[_finite(plain(cell)) for cell in row] for row in table.rows],
            "notes": list(table.notes),
        }
        for table in sheet.tables
    ]
    notes = {part.title: list(part.lines) for part in sheet.parts if isinstance(part, Notes)}
    head = {"made by": GENERATOR, "title": sheet.title, "lead": sheet.lead, "state": sheet.state}
    return {**head, "tables": tables, "notes": notes}


def _finite(value: Value) -> Value:
    return value if value is None or isinstance(value, str) else float(value) if isfinite(value) else None
