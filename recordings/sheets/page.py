"""A sheet as one page without scripts that loads nothing; all contents are escaped; it prints on A4."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape
from pathlib import Path

from heavylift.recordings.format.text import GENERATOR

from .sheet import Cell, Chart, Column, Marked, Part, Sheet, Table

STYLE = (Path(__file__).parents[1] / "page" / "report.css").read_text(encoding="utf-8")
SHORT = 14  # [letters] of a cell that stays on one line
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def page_of(sheet: Sheet) -> str:
    """Return the page of a sheet."""
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
    """Return a table as HTML with its title; empty without rows."""
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
    return f"<td{_kind(column, state, short=len(text) <= SHORT)}>{escape(text)}</td>"


def _kind(column: Column, state: str = "", short: bool = False) -> str:
    kinds = " ".join(filter(None, ("n" if column.numeric else "s" if short else "", state)))
    return f' class="{escape(kinds)}"' if kinds else ""


def _notes(lines: Iterable[str]) -> str:
    return "".join(f'<p class="quiet">{escape(line)}</p>' for line in lines)
