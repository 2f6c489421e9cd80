"""The tables of a sheet as a workbook: a worksheet each, one quantity and one unit per column, numbers as numbers."""

from __future__ import annotations

import io
import re
from itertools import count
from math import isfinite
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.text import GENERATOR

from .sheet import CLOCK, Column, Marked, Sheet, Table, Value, plain

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

DAY_s = 86400.0
WIDEST = 60  # [letters] of a column
LONGEST = 31  # [letters] of the name of a leaf
COLOURS = {"red": "FFA3182B", "undecided": "FF8A6100", "amber": "FF8A6100"}
FORBIDDEN = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")  # characters that no workbook holds
NAMELESS = re.compile(r"[\\/*?:\[\]\x00-\x1f]")  # and no name of a leaf


def workbook_of(sheet: Sheet) -> bytes:
    """Return an .xlsx file; raises RecordingError if its library is not installed."""
    missing = "a workbook needs openpyxl: pip install 'heavylift[xlsx]'; or write the report as .html"
    book = extra("openpyxl", RecordingError(missing)).Workbook()
    book.remove(book.active)
    for i, table in enumerate(sheet.tables):
        leaf = book.create_sheet(_named(table.title, book.sheetnames))
        for row, line in enumerate((sheet.title, sheet.lead) if i == 0 else (), 1):
            _write(leaf.cell(row, 1), line)
        _fill(leaf, table, 1 if i else 4)
    out = io.BytesIO()
    book.save(out)
    with ZipFile(out, "a") as archive:
        archive.comment = GENERATOR.encode()
    return out.getvalue()


def _named(title: str, taken: list[str]) -> str:
    name = NAMELESS.sub(" ", title)[:LONGEST] or "Table"
    others = (f"{name[: LONGEST - 4]} {n}" for n in count(2))
    return name if name not in taken else next(x for x in others if x not in taken)


def _fill(leaf: Worksheet, table: Table, first: int) -> None:
    """Write head, rows and notes of a table into a worksheet, from row `first` on."""
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    for i, column in enumerate(table.columns, 1):
        place = leaf.cell(first, i)
        _write(place, column.heading)
        place.font = Font(bold=True)
        longest = max(len(text) for text in (column.heading, *(column.text(row[i - 1]) for row in table.rows)))
        leaf.column_dimensions[get_column_letter(i)].width = min(WIDEST, longest + 2)
        for k, row in enumerate(table.rows, first + 1):
            place, cell = leaf.cell(k, i), row[i - 1]
            _write(place, _number(column, plain(cell)))
            place.number_format = _form(column)
            if isinstance(cell, Marked):
                place.font = Font(bold=True, color=COLOURS.get(cell.state))
    for k, line in enumerate(table.notes, first + len(table.rows) + 2):
        _write(leaf.cell(k, 1), line)
    leaf.freeze_panes = f"A{first + 1}"


def _number(column: Column, value: Value) -> Value:
    if value is None or isinstance(value, str):
        return value
    return None if not isfinite(value) else value / DAY_s if column.unit == CLOCK else value


def _form(column: Column) -> str:
    if column.unit == CLOCK:
        return "[h]:mm:ss.0"
    return "General" if column.digits is None else f"{0:.{column.digits}f}"


def _write(place: Any, value: Value) -> None:
    """Write a number, or a text that is never taken as a formula, into a cell."""
    if value is not None:
        place.value = FORBIDDEN.sub(" ", value) if isinstance(value, str) else value
        place.data_type = "s" if isinstance(value, str) else "n"
