"""Tables in the folder of a scene, CSV or XLSX: column heads with units, cells with their places, and insertion of
their values into a scene."""

import csv
import io
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import NamedTuple

from heavylift.kernel.errors import SPACES, SceneError, closest, printable

from .files import content, within
from .source import Data, Mark, Path, SourceText
from .spelling import NUMBER

AXES = ("x", "y", "z")
HEAD = re.compile(r"(?P<key>[^\[\]]*?)(?:[ .](?P<axis>[xyz]))?\s*(?:\[(?P<unit>[^\[\]]*)\])?")
CELL = re.compile(rf"({NUMBER}(?:,\d+)*)(.*)")
MOST_ROWS, MOST_COLUMNS, MOST_PARTS = 5000, 100, 1000
UNPACKED = 1 << 26  # of a workbook [bytes]
MARKS = {"xl/worksheets/": 2_000_000, "xl/sharedStrings": 500_000, "": 50_000}  # most that begin in such a part, "<"


@dataclass(frozen=True)
class TableCell:
    """Text of a table cell, and its place in the file."""

    text: str
    mark: Mark

    @classmethod
    def of(cls, text: str, mark: Mark) -> "TableCell":
        """Return a table cell, with unprintable characters in its text replaced."""
        return cls(printable(text.strip(), keep=SPACES), mark)


@dataclass(frozen=True)
class TableColumn:
    """The head of a table column: key, unit and, for one coordinate of a point, the axis (x, y or z)."""

    key: str
    axis: str
    unit: str
    mark: Mark


class SceneTable(NamedTuple):
    """A table in the folder of a scene: file, column heads, and rows of equal width, each named by its first cell."""

    file: str
    head: list[TableColumn]
    rows: list[list[TableCell]]

    def text(self, row: list[TableCell], column: int) -> str:
        """Return the text of a cell with the unit of its column."""
        return with_unit(row[column].text, self.head[column].unit)

    def named(self, name: str) -> list[list[TableCell]]:
        """Return the rows with this name; raises SceneError if there is no such row."""
        if found := [row for row in self.rows if name and row[0].text == name]:
            return found
        near = closest(name, dict.fromkeys(row[0].text for row in self.rows))
        raise SceneError(f"{self.file} has no row '{name}': {near}")

    def only(self, name: str) -> list[TableCell]:
        """Return the row with this name; raises SceneError if there is no such row or more than one."""
        found = self.named(name)
        if len(found) > 1:
            lines = " and ".join(str(row[0].mark.line) for row in found[:2])
            raise SceneError(f"{self.file} has the row '{name}' {len(found)} times, in lines {lines}")
        return found[0]


Found = dict[str, tuple[Data, Mark, dict[Path, Mark]]]  # by key: value, the mark of its head, the marks of its cells


def lay(source: SourceText, path: Path, into: dict[str, Data], found: Found, named: Mark) -> None:
    """Insert the values of a table under a path, unless a file or setting of higher precedence gives them. `named`:
    place of the reference to the table."""
    for key, (value, head, cells) in found.items():
        if key in into and source.layer(source.mark((*path, key), on_key=True)) >= source.layer(named):
            continue
        into[key] = value
        source.keys[(*path, key)] = head
        source.values.update({(*path, key, *below): mark for below, mark in cells.items()})


def with_unit(text: str, unit: str) -> str:
    """Return the text of a cell with the unit of its column: `480 +- 3 %` under `[t]` becomes `480 t +- 3 %`."""
    found = CELL.fullmatch(text)
    return f"{found[1]} {unit} {found[2].strip()}".strip() if found and unit else text


def row_names(root: FilePath, file: str) -> list[str]:
    """Return the names of all rows of a table, each once, in order; raises SceneError if the table is unreadable."""
    return list(dict.fromkeys(row[0].text for row in table(root, file).rows))


def table(root: FilePath, file: str) -> SceneTable:
    """Return a table in the scene's folder; raises SceneError if the table cannot be read."""
    read = {".csv": _separated, ".tsv": _separated, ".xlsx": _workbook}.get(FilePath(file).suffix.lower())
    if read is None:
        raise SceneError(f"'{file}' is not a table: name a .csv, .tsv or .xlsx file beside the scene, then # and a row")
    try:
        data = content(within(root, root / file))
    except FileNotFoundError:
        raise SceneError(f"there is no table '{file}' beside the scene") from None
    except OSError as error:
        raise SceneError(f"the table '{file}' cannot be read: {error.strerror}") from None
    rows = [row for row in read(data, file) if any(cell.text for cell in row)]
    if not rows:
        raise SceneError(f"the table '{file}' is empty")
    head = [_column(cell) for cell in rows[0][:MOST_COLUMNS]]
    width = len(head)
    for row in rows[1:]:
        if any(cell.text for cell in row[width:]):
            where = f"{file}:{row[0].mark.line}"
            raise SceneError(
                f"{where}: this row has more cells than the header; if it has decimal commas, write points, "
                "or separate cells by ';'"
            )
    return SceneTable(file, head, [row[:width] + [TableCell("", row[0].mark)] * (width - len(row)) for row in rows[1:]])


def _column(cell: TableCell) -> TableColumn:
    found = HEAD.fullmatch(cell.text)
    key, axis, unit = ((found[x] or "").strip() for x in ("key", "axis", "unit")) if found else (cell.text, "", "")
    return TableColumn(key, axis, unit, cell.mark)


def _separated(data: bytes, file: str) -> Iterator[list[TableCell]]:
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except ValueError:
        raise SceneError(f"the table '{file}' is not UTF-8 text") from None
    first = next((line for line in lines if line.strip()), "")
    separator = max(";\t,", key=first.count)
    for number, line in enumerate(lines, 1):
        try:
            texts = next(csv.reader([line], delimiter=separator, strict=True), [])
        except csv.Error as error:
            raise SceneError(f"{file}:{number}: this is not a row of a table: {error}") from None
        at, row = 0, []
        for text in texts:
            at = max(at, line.find(text, at))
            row.append(TableCell.of(text, Mark(file, number, at + 1, line)))
            at += len(text) + 1
        yield row


def _weigh(workbook: zipfile.ZipFile, file: str) -> None:
    """Raise SceneError if a workbook has too many bytes, parts, cells or texts."""
    parts = workbook.infolist()
    if sum(part.file_size for part in parts) > UNPACKED or len(parts) > MOST_PARTS:
        message = f"unpacks to more than {UNPACKED} bytes or {MOST_PARTS} files"
        raise SceneError(f"the workbook '{file}' {message}; save the sheet of the table alone, or as .csv")
    for part in parts:
        most = next(count for begin, count in MARKS.items() if part.filename.lstrip("/").startswith(begin))
        if workbook.read(part).count(b"<") > most:
            raise SceneError(
                f"the table '{file}' is larger than {MOST_ROWS} rows and {MOST_COLUMNS} columns; divide it"
            )


def _workbook(data: bytes, file: str) -> Iterator[list[TableCell]]:
    """Yield the rows of the first sheet in a workbook."""
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise SceneError("a table .xlsx needs openpyxl: pip install 'heavylift[xlsx]'; or save it as .csv") from None
    try:
        _weigh(zipfile.ZipFile(io.BytesIO(data)), file)
        sheet = load_workbook(io.BytesIO(data), read_only=True, data_only=True).worksheets[0]
        found = list(sheet.iter_rows(max_row=MOST_ROWS, max_col=MOST_COLUMNS, values_only=True))
    except SceneError:
        raise
    except Exception as error:  # whatever a broken workbook makes of the library
        raise SceneError(f"the table '{file}' cannot be read as a workbook: {error}") from None
    for number, values in enumerate(found, 1):
        texts = ["" if value is None else str(value).strip() for value in values]
        line, row = " | ".join(texts), []
        at = 0
        for text in texts:
            row.append(TableCell.of(text, Mark(file, number, at + 1, line)))
            at += len(text) + 3
        yield row
