"""Tables beside a scene: a block's row, its lugs, and its modes.

    block: {from: blocks.csv#B17, lugs from: lugs.csv#B17, at: [40 m, 70 m, 4 m]}

and so each of `blocks`.

The head names keys with their units, `mass [t]`, `com x [m]`; a column without a unit is a remark, if it is no axis.
The first column names the row; in a table of lugs it names the block, the second one the lug, and without `#B17` the
first one the lug.  `modes from` alike names a table of block, mode, place (lug or stool), its displacement x, y, z and
in some row of each mode the frequency, mass and damping.  What the same file writes wins over the row, and so do
files and settings laid over it; the row wins over what that file extends.  An empty cell is as if nothing were written.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath

from heavylift.kernel.errors import SceneError

from .faults import closest, raise_faults
from .files import content, within
from .source import Data, Mark, Path, Source
from .units import NUMBER

BLOCK = "block"
ROW, LUGS, MODES = "from", "lugs from", "modes from"
AXES = ("x", "y", "z")
HEAD = re.compile(r"(?P<key>[^\[\]]*?)(?:[ .](?P<axis>[xyz]))?\s*(?:\[(?P<unit>[^\[\]]*)\])?")
CELL = re.compile(rf"({NUMBER}(?:,\d+)*)(.*)")
MOST_ROWS, MOST_COLUMNS = 5000, 100
UNPACKED = 1 << 26  # of a workbook [bytes]


@dataclass(frozen=True)
class Cell:
    """What stands in a table, and where."""

    text: str
    mark: Mark


@dataclass(frozen=True)
class Column:
    """A head: the key that it names, the axis of a place, the unit of what stands below."""

    key: str
    axis: str
    unit: str
    mark: Mark


def tabled(source: Source) -> None:
    """Put the rows that `from`, `lugs from` and `modes from` of each block name in their place, out of tables in the
    scene's folder.

    Raises SceneError with all faults of the scene so far where a table or row cannot be had.
    """
    several = source.data.get("blocks")
    for base in ((BLOCK,), *(("blocks", name) for name in (several if isinstance(several, dict) else ()))):
        _tabled(source, base)


def _tabled(source: Source, base: Path) -> None:
    block = source.at(base)
    if not isinstance(block, dict):
        return
    for word in (ROW, LUGS, MODES):
        if word not in block:
            continue
        at = (*base, word)
        named, mark = block.pop(word), source.mark(at)
        try:
            if not isinstance(named, str):
                raise SceneError(f"write the table and the row, such as '{word}: blocks.csv#B17'")
            file, _, row = (part.strip() for part in named.partition("#"))
            head, rows = _table(source.root, file)
            if word == ROW:
                _lay(source, base, block, _block(source, base, head, _only(rows, row, file)), mark)
            else:
                key, reader = ("lugs", _lugs) if word == LUGS else ("modes", _modes)
                into = block.setdefault(key, {})
                source.keys.setdefault((*base, key), source.keys.get(at, mark))
                if isinstance(into, dict):
                    _lay(source, (*base, key), into, reader(source, base, head, rows, row, file), mark)
        except (SceneError, ValueError) as error:
            source.fault(at, str(error), mark=mark)
            raise_faults(source, source.faults)


Found = dict[str, tuple[Data, Mark, dict[Path, Mark]]]  # by key: value, the mark of its head, the marks of its cells


def _lay(source: Source, path: Path, into: dict[str, Data], found: Found, named: Mark) -> None:
    for key, (value, head, cells) in found.items():
        if key in into and source.layer(source.mark((*path, key), on_key=True)) >= source.layer(named):
            continue
        into[key] = value
        source.keys[(*path, key)] = head
        source.values.update({(*path, key, *below): mark for below, mark in cells.items()})


def _block(source: Source, base: Path, head: list[Column], row: list[Cell]) -> Found:
    """The keys of a row."""
    found: Found = {}
    for column, cell in zip(head[1:], row[1:], strict=False):
        if not cell.text or not (column.unit or column.axis):
            continue
        text = _with_unit(cell.text, column.unit)
        known = found.get(column.key)
        taken = known[0][AXES.index(column.axis)] if known and column.axis and isinstance(known[0], list) else known
        if taken is not None:
            source.fault((*base, column.key), f"the row gives '{column.key}' twice", mark=column.mark)
        elif not column.axis:
            found[column.key] = (text, column.mark, {(): cell.mark})
        else:
            value, mark, cells = found.setdefault(column.key, ([None] * 3, column.mark, {(): cell.mark}))
            assert isinstance(value, list)
            value[AXES.index(column.axis)] = text
            cells[(AXES.index(column.axis),)] = cell.mark
    for key, (value, mark, _) in found.items():
        if isinstance(value, list) and None in value:
            lacking = ", ".join(f"'{key} {x}'" for x, y in zip(AXES, value, strict=True) if y is None)
            source.fault((*base, key), f"the row has no {lacking}", mark=mark)
    return found


def _lugs(source: Source, base: Path, head: list[Column], rows: list[list[Cell]], block: str, file: str) -> Found:
    """The lugs of a block by name."""
    if others := [c.key for c in head if c.unit and (c.axis or c.key) not in AXES]:
        raise SceneError(f"{file}: a lug has a place x, y, z and no '{others[0]}'; a remark has no unit")
    chosen, places = _chosen(head, rows, block, file, " [m]")
    found: Found = {}
    for row in chosen:
        name = row[1 if block else 0]
        cells = [row[places[x]] for x in AXES]
        if name.text in found:
            source.fault((*base, "lugs", name.text), f"the lug '{name.text}' is given twice", mark=name.mark)
        value: list[Data] = [_with_unit(cell.text, head[places[x]].unit) for x, cell in zip(AXES, cells, strict=True)]
        found[name.text] = (value, name.mark, {(): name.mark, **{(i,): cell.mark for i, cell in enumerate(cells)}})
    return found


def _modes(source: Source, base: Path, head: list[Column], rows: list[list[Cell]], block: str, file: str) -> Found:
    """The modes of a block by name, each of as many rows as places have a displacement in it."""
    chosen, places = _chosen(head, rows, block, file, "")
    first = 1 if block else 0
    numbers = [i for i, column in enumerate(head) if i > first + 1 and i not in places.values() and column.unit]
    found: Found = {}
    for row in chosen:
        name, place = row[first], row[first + 1]
        value, _, marks = found.setdefault(name.text, ({"shape": {}}, name.mark, {(): name.mark}))
        assert isinstance(value, dict)
        shape = value["shape"]
        assert isinstance(shape, dict)
        if place.text in shape:
            source.fault((*base, "modes", name.text), f"the place '{place.text}' is given twice", mark=place.mark)
        shape[place.text] = [row[places[x]].text for x in AXES]
        marks |= {("shape", place.text, i): row[places[x]].mark for i, x in enumerate(AXES)}
        for i in (i for i in numbers if row[i].text):
            text = _with_unit(row[i].text, head[i].unit)
            if value.setdefault(head[i].key, text) != text:
                told = f"a mode has one {head[i].key}, and '{name.text}' has {value[head[i].key]}, too"
                source.fault((*base, "modes", name.text), told, mark=row[i].mark)
            marks[head[i].key,] = row[i].mark
    return found


def _chosen(
    head: list[Column], rows: list[list[Cell]], block: str, file: str, unit: str
) -> tuple[list[list[Cell]], dict[str, int]]:
    """The rows of a block, and which columns are x, y and z."""
    chosen = [row for row in rows if not block or row[0].text == block]
    if not chosen:
        raise SceneError(f"{file} has no row '{block}': {closest(block, dict.fromkeys(row[0].text for row in rows))}")
    places = {column.axis or column.key: i for i, column in enumerate(head)}
    if lacking := [x for x in AXES if x not in places]:
        raise SceneError(f"{file} has no column {', '.join(f'{x}{unit}' for x in lacking)}")
    return chosen, {x: places[x] for x in AXES}


def _with_unit(text: str, unit: str) -> str:
    """`480 +- 3 %` under `[t]` is `480 t +- 3 %`."""
    found = CELL.fullmatch(text)
    return f"{found[1]} {unit} {found[2].strip()}".strip() if found and unit else text


def _only(rows: list[list[Cell]], name: str, file: str) -> list[Cell]:
    found = [row for row in rows if row[0].text == name]
    if not name or not found:
        raise SceneError(f"{file} has no row '{name}': {closest(name, dict.fromkeys(row[0].text for row in rows))}")
    if len(found) > 1:
        lines = " and ".join(str(row[0].mark.line) for row in found[:2])
        raise SceneError(f"{file} has the row '{name}' {len(found)} times, in lines {lines}")
    return found[0]


def row_names(root: FilePath, file: str) -> list[str]:
    """The names of the rows of a table, in their order, each once; raises SceneError where it cannot be had."""
    return list(dict.fromkeys(row[0].text for row in _table(root, file)[1]))


def _table(root: FilePath, file: str) -> tuple[list[Column], list[list[Cell]]]:
    """Head and rows of a table in the scene's folder."""
    read = {".csv": _separated, ".tsv": _separated, ".xlsx": _workbook}.get(FilePath(file).suffix.lower())
    if read is None:
        raise SceneError(f"'{file}' is no table: name a .csv, .tsv or .xlsx file beside the scene, then # and a row")
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
            raise SceneError(f"{where}: has more cells than the head; write decimal points, or ';' between cells")
    return head, [row[:width] + [Cell("", row[0].mark)] * (width - len(row)) for row in rows[1:]]


def _column(cell: Cell) -> Column:
    found = HEAD.fullmatch(cell.text)
    key, axis, unit = ((found[x] or "").strip() for x in ("key", "axis", "unit")) if found else (cell.text, "", "")
    return Column(key, axis, unit, cell.mark)


def _separated(data: bytes, file: str) -> Iterator[list[Cell]]:
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
            raise SceneError(f"{file}:{number}: this is no row of a table: {error}") from None
        at, row = 0, []
        for text in texts:
            at = max(at, line.find(text, at))
            row.append(Cell(text.strip(), Mark(file, number, at + 1, line)))
            at += len(text)
        yield row


def _workbook(data: bytes, file: str) -> Iterator[list[Cell]]:
    """The first sheet."""
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise SceneError("a table .xlsx needs openpyxl: pip install 'heavylift[xlsx]'; or save it as .csv") from None
    try:
        if sum(part.file_size for part in zipfile.ZipFile(io.BytesIO(data)).infolist()) > UNPACKED:
            raise SceneError(f"the table '{file}' has more than {UNPACKED} bytes unpacked")
        sheet = load_workbook(io.BytesIO(data), read_only=True, data_only=True).worksheets[0]
        found = list(sheet.iter_rows(max_row=MOST_ROWS, max_col=MOST_COLUMNS, values_only=True))
    except SceneError:
        raise
    except Exception as error:  # whatever a broken workbook makes of the library
        raise SceneError(f"the table '{file}' is no workbook that can be read: {error}") from None
    for number, values in enumerate(found, 1):
        texts = ["" if value is None else str(value).strip() for value in values]
        line, row = " | ".join(texts), []
        at = 0
        for text in texts:
            row.append(Cell(text, Mark(file, number, at + 1, line)))
            at += len(text) + 3
        yield row
