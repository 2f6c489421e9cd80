"""The tables of a sheet as a workbook: one worksheet for each table, one quantity and unit in each column, numbers as
numbers.

Also printing of a page as PDF with a browser on this machine: Chromium or a relative of it, without a window.

Also writing a sheet to a file: a page, PDF, workbook, text or plain data, depending on the suffix of the file name.
"""

import io
import re
import shutil
import subprocess
import tempfile
from itertools import count
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import msgspec
from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .sheet import CLOCK, Column, Marked, Sheet, Table, Value, data_of, page_of, plain, text_of

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

DAY_s = 86400.0
WIDEST = 60  # [letters] of a column
LONGEST = 31  # [letters] of the name of a leaf
COLOURS = {"red": "FFA3182B", "undecided": "FF8A6100", "amber": "FF8A6100"}
FORBIDDEN = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")  # characters that no workbook holds
NAMELESS = re.compile(r"[\\/*?:\[\]\x00-\x1f]")  # and no name of a leaf


def workbook_of(sheet: Sheet) -> bytes:
    """Return a sheet as the bytes of an .xlsx file; raises RecordingError if openpyxl is not installed."""
    missing = "a workbook needs openpyxl: pip install 'heavylift[xlsx]'; or write the report as .html"
    book = extra("openpyxl", RecordingError(missing)).Workbook()
    book.remove(book.active)
    for i, table in enumerate(sheet.tables):
        leaf = book.create_sheet(_named(table.title, book.sheetnames))
        for row, line in enumerate((sheet.title, sheet.lead) if i == 0 else (), 1):
            _write(leaf.cell(row, 1), line)
        _fill(leaf, table.numbers or table, 1 if i else 4)
    out = io.BytesIO()
    book.save(out)
    with ZipFile(out, "a") as archive:
        archive.comment = GENERATOR.encode()
    return out.getvalue()


def _named(title: str, taken: list[str]) -> str:
    name = NAMELESS.sub(" ", title)[:LONGEST] or "Table"
    others = (f"{name[: LONGEST - 4]} {n}" for n in count(2))
    return name if name not in taken else next(x for x in others if x not in taken)


def _fill(leaf: "Worksheet", table: Table, first: int) -> None:
    """Write the column heads, rows and notes of a table into a worksheet, from row `first` on."""
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
    """Write a number into a cell, or a text that is never interpreted as a formula."""
    if value is not None:
        place.value = FORBIDDEN.sub(" ", value) if isinstance(value, str) else value
        place.data_type = "s" if isinstance(value, str) else "n"


BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
PATIENCE = 60.0  # [s]


def print_page(page: str, out: Path) -> bytes:
    """Print a self-contained HTML page as PDF bytes; raises RecordingError without a suitable browser."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        raise RecordingError(
            f"{out}: no Chromium or Chrome is installed to print a PDF; write {out.with_suffix('.html')} and "
            "print that from any browser"
        )
    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
        source, printed = Path(folder) / "report.html", Path(folder) / "report.pdf"
        source.write_text(page, encoding="utf-8")
        flags = ["--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer", "--no-sandbox"]  # our page
        target = [f"--user-data-dir={folder}/profile", f"--print-to-pdf={printed}", source.as_uri()]
        try:
            subprocess.run([found, *flags, *target], capture_output=True, timeout=PATIENCE, check=True)
            return printed.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise RecordingError(
                f"{out}: {Path(found).name} could not print the PDF ({type(error).__name__}); write "
                f"{out.with_suffix('.html')} and print that from any browser"
            ) from None


FORMATS = (".html", ".pdf", ".xlsx", ".json", ".txt")
PRINTED = f"% {GENERATOR}\n".encode()  # a comment behind the end of a PDF


def write(sheet: Sheet, out: str | Path, what: str, force: bool = False) -> Path:
    """Write a sheet to a file and return its path; raises RecordingError if the file cannot be written.

    `what`: name of the sheet in errors, such as "a report".
    """
    path = output_path(out, what, FORMATS)
    return written(printed(sheet, path), path, what, FORMATS, force)


def printed(sheet: Sheet, out: Path) -> str | bytes:
    """Return a sheet as text or bytes in the format that the suffix of `out` names."""
    match out.suffix.lower():
        case ".pdf":
            return print_page(page_of(sheet), out) + PRINTED
        case ".xlsx":
            return workbook_of(sheet)
        case ".json":
            return msgspec.json.format(msgspec.json.encode(data_of(sheet)), indent=1) + b"\n"
        case ".txt":
            return text_of(sheet)
    return page_of(sheet)
