"""Tables of text for people."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["table"]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns side by side, numbers to the right; nothing if there are no rows."""
    if not rows:
        return ""
    widths = [max(len(line[i]) for line in (head, *rows)) for i in range(len(head))]
    right = [all(not row[i] or row[i][0].isdigit() for row in rows) for i in range(len(head))]
    lines = [
        "  ".join(
            cell.rjust(width) if flush else cell.ljust(width)
            for cell, width, flush in zip(line, widths, right, strict=True)
        ).rstrip()
        for line in (head, *rows)
    ]
    return "\n".join(f"  {line}" for line in lines)
