"""Tables and pages of HTML; whatever stands in them is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from .text import GENERATOR

STYLE = (Path(__file__).parents[1] / "page" / "report.css").read_text(encoding="utf-8")
Cell = str | tuple[str, bool]  # text, and whether it is beyond what it should be


def table(
    head: Sequence[str], rows: Sequence[Sequence[Cell]], kind: str = "", title: str = "", marks: Sequence[str] = ()
) -> str:
    """A table below its title; nothing without rows.  `kind`: its class; `marks`: one class per row."""
    if not rows:
        return ""
    top = f"<thead><tr>{''.join(f'<th>{escape(name)}</th>' for name in head)}</tr></thead>" if any(head) else ""
    lines = [f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows]
    for i, mark in enumerate(marks):
        lines[i] = lines[i].replace("<tr>", f'<tr class="{mark}">', 1) if mark else lines[i]
    opened = f'<table class="{kind}">' if kind else "<table>"
    return (f"<h2>{escape(title)}</h2>" if title else "") + f"{opened}{top}<tbody>{''.join(lines)}</tbody></table>"


def _cell(cell: Cell) -> str:
    text, bad = cell if isinstance(cell, tuple) else (cell, False)
    return f'<td class="bad">{escape(text)}</td>' if bad else f"<td>{escape(text)}</td>"


def bullets(lines: Iterable[str], kind: str = "") -> str:
    """A list; nothing without lines."""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<ul class="{kind}">{items}</ul>' if items else ""


def document(title: str, style: str, body: Iterable[str]) -> str:
    """A page without scripts that loads nothing, in the style of all such pages and what it has of its own."""
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="{GENERATOR}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{escape(title)}</title>
<style>{STYLE}{style}</style>
</head>
<body>
{chr(10).join(part for part in body if part)}
</body>
</html>
"""
