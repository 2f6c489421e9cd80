"""The tables of the document as a workbook: a sheet each; cells that read as a number, share or time are one."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.html import Cell
from heavylift.recordings.format.text import GENERATOR

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

    from .tables import Table

NUMBER = re.compile(r"(-?\d+)(?:\.(\d+))?( ?(?:%|°|[A-Za-z]+[23]?(?:[ /][A-Za-z]+[23]?)*))?")
TIME = re.compile(r"(?:(\d+):)?(\d+):(\d\d(?:\.\d)?)")
DAY_s = 86400.0
WIDEST = 60  # [letters] of a column
FORBIDDEN = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")  # characters that no workbook holds


def workbook(title: str, told: str, tables: Sequence[Table]) -> bytes:
    """A .xlsx file; RecordingError if the library for it is not installed."""
    missing = "a workbook needs openpyxl: pip install 'heavylift[xlsx]'; or write the report as .html"
    book = extra("openpyxl", RecordingError(missing)).Workbook()
    if book.active is not None:
        book.remove(book.active)
    for table in tables:
        sheet, first = book.create_sheet(table.title[:31]), 1
        if table is tables[0]:
            for row, line in enumerate((title, told), 1):
                _write(sheet.cell(row, 1), line)
            first = 4
        _fill(sheet, table, first)
    out = io.BytesIO()
    book.save(out)
    with ZipFile(out, "a") as archive:
        archive.comment = GENERATOR.encode()
    return out.getvalue()


def _fill(sheet: Worksheet, table: Table, first: int) -> None:
    """Head, rows and the lines below, from this row of the sheet on."""
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    for row, cells in enumerate([table.head, *table.rows], first):
        for column, content in enumerate(cells, 1):
            text, bad = content if isinstance(content, tuple) else (content, False)
            value, form = number(text)
            place = sheet.cell(row, column)
            _write(place, value)
            place.number_format = form
            place.font = Font(bold=row == first or bad, color="FFA3182B" if bad else None)
    for row, line in enumerate(table.told, first + len(table.rows) + 2):
        _write(sheet.cell(row, 1), line)
    for column in range(len(table.head)):
        longest = max(len(_plain(row[column])) for row in [table.head, *table.rows] if column < len(row))
        sheet.column_dimensions[get_column_letter(column + 1)].width = min(WIDEST, longest + 2)
    sheet.freeze_panes = f"A{first + 1}"


def number(text: str) -> tuple[str | float, str]:
    """What a cell holds, and how it is shown: numbers with units behind them, shares, times of the run; else text."""
    if found := TIME.fullmatch(text):
        hours, minutes, seconds = found.groups(default="0")
        return (3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds)) / DAY_s, "[h]:mm:ss.0"
    if not (found := NUMBER.fullmatch(text)):
        return text, "General"
    whole, digits, unit = found.groups(default="")
    form = "0" + ("." + "0" * len(digits) if digits else "")
    value = float(f"{whole}.{digits or 0}")
    if unit.strip() == "%":
        return value / 100.0, f"{form}%"
    return value, form + f'"{unit}"'.replace('""', "")


def _plain(cell: Cell) -> str:
    return cell if isinstance(cell, str) else cell[0]


def _write(place: Any, value: str | float) -> None:
    """Put a number, or a text that is no formula, into a cell of a sheet."""
    place.value = FORBIDDEN.sub(" ", value) if isinstance(value, str) else value
    place.data_type = "s" if isinstance(value, str) else "n"
