"""Sheets: content of a verdict, a report, a study or a trade-off, before it is printed.

A column holds one quantity in one unit, which its heading names; a cell is a number in that unit, a time of the run in
a `CLOCK` column [s], a text, or empty. `Marked` colours a cell by a state.

Sheets and tables as text: columns side by side, numbers right-aligned.

A sheet as one page without scripts that loads nothing; all contents are escaped; it prints on A4.

Figures on pages: drawn in placeholder colours, which the page replaces by those of the reader's theme.
"""

import base64
import csv
import io
import re
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from html import escape
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import msgspec
from heavylift.kernel.description.findings import clock
from heavylift.recordings.format.text import GENERATOR, cell, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLOCK = "h:min:s"
Value: TypeAlias = str | float | None


class Marked(NamedTuple):
    """The value of a table cell with the state that gives its colour: red, amber, undecided, green, or recommended."""

    value: Value
    state: str = "red"


Cell: TypeAlias = Value | Marked


class Column(msgspec.Struct, frozen=True, omit_defaults=True):
    """A column of a table: name, unit and number of decimals (`digits`; None: as many as needed).

    Columns of text have no unit and no decimals.
    """

    name: str
    unit: str = ""
    digits: int | None = None

    @property
    def heading(self) -> str:
        """The heading of the column: its name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def numeric(self) -> bool:
        """Whether the cells of the column are numbers."""
        return bool(self.unit) or self.digits is not None

    def text(self, cell: Cell) -> str:
        """Return a cell of this column as the text to print."""
        value = plain(cell)
        if value is None or isinstance(value, str):
            return value or ""
        if self.unit == CLOCK:
            return clock(value, 1 if self.digits is None else self.digits)
        if not isfinite(value):
            return "beyond any" if value > 0 else ""
        return f"{value:.6g}" if self.digits is None else f"{value:z.{self.digits}f}"


def columns(*headings: str) -> tuple[Column, ...]:
    """Return columns from headings such as `stage`, `peak [kN] .1`, `at [h:min:s]`; the number after the unit is the
    number of decimals."""
    found = []
    for heading in headings:
        message, _, digits = heading.partition(" .")
        name, _, unit = message.removesuffix("]").partition(" [")
        found.append(Column(name, unit, int(digits) if digits else None))
    return tuple(found)


class Table(msgspec.Struct, frozen=True, omit_defaults=True):
    """A table with notes, printed only if it has rows.

    `blank`: a form to be filled in by hand; `numbers`: what a workbook holds instead of a table of text.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...] = ()
    notes: tuple[str, ...] = ()
    blank: bool = False
    numbers: "Table | None" = None


class Chart(msgspec.Struct, frozen=True):
    """A picture with a caption, as <svg> text or PNG bytes."""

    title: str
    image: str | bytes
    notes: tuple[str, ...] = ()


class Notes(msgspec.Struct, frozen=True):
    """A heading with sentences below it."""

    title: str
    lines: tuple[str, ...]


Part: TypeAlias = Table | Chart | Notes


class Sheet(msgspec.Struct, frozen=True):
    """A sheet of tables, charts and notes: title, summary that begins with the state, state (colour), and parts."""

    title: str
    lead: str
    state: str
    parts: tuple[Part, ...]

    @property
    def tables(self) -> tuple[Table, ...]:
        """The tables of the sheet that have rows."""
        return tuple(part for part in self.parts if isinstance(part, Table) and part.rows)


def stated(state: str, *leads: str) -> str:
    """Return the summary of a sheet, beginning with its state in capitals, such as GREEN."""
    return f"{state.upper()}: {'; '.join(filter(None, leads))}"


def plain(cell: Cell) -> Value:
    """Return the value of a table cell, without the state that gives the cell its colour."""
    return cell.value if isinstance(cell, Marked) else cell


def words(title: str, heads: Iterable[str], rows: Iterable[Iterable[Cell]], *notes: str) -> Table:
    """Return a table of text columns with this title, these headings and rows."""
    return Table(title, tuple(map(Column, heads)), tuple(map(tuple, rows)), notes)


def trimmed(table: Table) -> Table:
    """Return a table without its empty columns."""
    kept = [i for i in range(len(table.columns)) if any(plain(row[i]) not in ("", None) for row in table.rows)]
    columns, rows = table.columns, table.rows
    picked = tuple(tuple(row[i] for i in kept) for row in rows)
    return msgspec.structs.replace(table, columns=tuple(columns[i] for i in kept), rows=picked)


def data_of(sheet: Sheet) -> dict[str, Any]:
    """Return a sheet as plain data, without charts and with times in seconds."""
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


def table_text(made: Table) -> str:
    """Return a table as text with aligned columns, numbers right-aligned; "" if the table has no rows."""
    if not made.rows:
        return ""
    rows = [[x.text(cell) for x, cell in zip(made.columns, row, strict=True)] for row in made.rows]
    lines = shown([[x.heading for x in made.columns], *rows])
    columns = [*zip(*lines, strict=True)]
    widths = [max(map(len, cells)) for cells in columns]
    right = [
        x.numeric or all(not cell or cell[0].isdigit() for cell in cells)
        for x, (_, *cells) in zip(made.columns, columns, strict=True)
    ]
    texts = (
        "  ".join(x.rjust(w) if flush else x.ljust(w) for x, w, flush in zip(line, widths, right, strict=True))
        for line in lines
    )
    return "\n".join(f"  {text.rstrip()}" for text in texts)


def listed(heads: Iterable[str], rows: Iterable[Iterable[Cell]]) -> str:
    """Return rows of texts as lines with aligned columns."""
    return table_text(words("", heads, rows))


def text_of(sheet: Sheet) -> str:
    """Return a sheet as text, without charts."""
    parts = [f"{sheet.title}\n{sheet.lead}", *filter(None, map(part_text, sheet.parts))]
    return "\n\n".join([*parts, f"made by {GENERATOR}\n"])


def part_text(part: Part) -> str:
    """Return a table or notes as text, with the title; "" for a table without rows."""
    lines: Sequence[str] = part.lines if isinstance(part, Notes) else part.notes
    body = table_text(part) if isinstance(part, Table) else ""
    message = body or (lines and not isinstance(part, Table))
    title = f"{part.title}:" if part.title and body else part.title
    return "\n".join(filter(None, (title, body, *(f"  {line}" for line in lines)))) if message else ""


def table_csv(made: Table) -> str:
    """Return a table as comma-separated lines with full precision."""
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(cell(column.heading) for column in made.columns)
    lines.writerows([cell(plain(x)) for x in row] for row in made.rows)
    return out.getvalue()


STYLE = (Path(__file__).parents[1] / "page" / "report.css").read_text(encoding="utf-8")
SHORT = 14  # [letters] of a cell that stays on one line
NAME = 24  # letters of a name, which does not wrap at its hyphens
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def page_of(sheet: Sheet) -> str:
    """Return a sheet as an HTML page."""
    body = "\n".join(filter(None, map(_part, sheet.parts)))
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="{GENERATOR}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<title>{escape(sheet.title)}</title>
<style>{STYLE}</style>
</head>
<body>
<h1>{escape(sheet.title)}</h1>
<p class="verdict {escape(sheet.state)}">{escape(sheet.lead)}</p>
{body}
</body>
</html>
"""


def _part(part: Part) -> str:
    if isinstance(part, Table):
        return f"<section>{table_html(part)}{_notes(part.notes)}</section>" if part.rows else ""
    head = f"<h2>{escape(part.title)}</h2>"
    if not isinstance(part, Chart):
        return f"<section>{head}{_notes(part.lines)}</section>" if part.lines else ""
    image = part.image
    if isinstance(image, bytes):
        source = f"data:image/png;base64,{base64.b64encode(image).decode()}"
        image = f'<img src="{source}" alt="{escape(part.title)}">'
    return f"<figure>{head}{image}{_notes(part.notes)}</figure>"


def table_html(table: Table) -> str:
    """Return a table as HTML, with the title; "" if the table has no rows."""
    if not table.rows:
        return ""
    head = "".join(f"<th{_kind(column)}>{escape(column.heading)}</th>" for column in table.columns)
    top = f"<thead><tr>{head}</tr></thead>" if any(column.heading for column in table.columns) else ""
    rows = (zip(table.columns, row, strict=True) for row in table.rows)
    body = "".join(f"<tr>{''.join(_cell(column, cell) for column, cell in row)}</tr>" for row in rows)
    title = f"<h2>{escape(table.title)}</h2>" if table.title else ""
    kind = ' class="blank"' if table.blank else ""
    return f"{title}<table{kind}>{top}<tbody>{body}</tbody></table>"


def _cell(column: Column, cell: Cell) -> str:
    text, state = column.text(cell), cell.state if isinstance(cell, Marked) else ""
    short = len(text) <= (SHORT if " " in text else NAME)
    return f"<td{_kind(column, state, short=short)}>{escape(text)}</td>"


def _kind(column: Column, state: str = "", short: bool = False) -> str:
    kinds = " ".join(filter(None, ("n" if column.numeric else "s" if short else "", state)))
    return f' class="{escape(kinds)}"' if kinds else ""


def _notes(lines: Iterable[str]) -> str:
    return "".join(f'<p class="quiet">{escape(line)}</p>' for line in lines)


COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#56B4E9", "#7a6fd0", "#6b7682", "#8c3b1b",
           "#17a589", "#c2185b")  # fmt: skip
INK, QUIET, BAND, PAPER, LIMIT = "#1d2733", "#6b7683", "#e6f2ea", "#ffffff", "#a3182b"
THEME = {INK: "var(--ink)", QUIET: "var(--quiet)", BAND: "var(--band)", PAPER: "var(--paper)", LIMIT: "var(--limit)"}


def in_page(figure: "Figure") -> str:
    """Return a figure as an <svg> element in the font and colours of the HTML page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
    svg = text.getvalue()
    for colour, variable in THEME.items():
        svg = re.sub(colour, variable, svg, flags=re.IGNORECASE)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'<svg ([^>]*?)height="[^"]*"([^>]*?)width="[^"]*"', r'<svg role="img" \1\2', svg, count=1)


def styled(fonts: str) -> AbstractContextManager[None]:
    """Return a context in which figures are drawn in colours that `in_page` replaces.

    `fonts`: "none" writes text as SVG text, "path" as outlines.
    """
    from matplotlib import rc_context

    style: dict[Any, Any] = {"svg.hashsalt": "heavylift", "svg.fonttype": fonts,
             "font.size": 9.5, "axes.linewidth": 0.8,
             "text.color": INK, "axes.edgecolor": QUIET, "axes.labelcolor": INK, "xtick.color": QUIET,
             "ytick.color": QUIET, "legend.labelcolor": INK, "axes.facecolor": "none", "path.simplify": True,
             "font.family": ["DejaVu Sans", "sans-serif"]}  # fmt: skip
    return rc_context(style)
