"""Sheets and tables as text: columns side by side, numbers right-aligned."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from heavylift.recordings.format.text import GENERATOR, cell, table

from .sheet import Notes, Part, Sheet, Table, plain


def table_text(made: Table) -> str:
    """Return a table as lines with printable cells; empty without rows."""
    rows = [[column.text(cell) for column, cell in zip(made.columns, row, strict=True)] for row in made.rows]
    numeric = [column.numeric for column in made.columns]
    return table([column.heading for column in made.columns], rows, numeric)


def text_of(sheet: Sheet) -> str:
    """Return a sheet as text, without charts."""
    parts = [f"{sheet.title}\n{sheet.lead}", *filter(None, map(part_text, sheet.parts))]
    return "\n\n".join([*parts, f"made by {GENERATOR}\n"])


def part_text(part: Part) -> str:
    """Return a table or notes as text with their title; empty for a table without rows."""
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
