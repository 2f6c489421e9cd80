"""Text for people: tables, time spans, which names were perhaps meant."""

from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

from heavylift.kernel.errors import SPACES, printable

GENERATOR = "heavylift"  # by which a file says who made it
T = TypeVar("T")
FORMULAS = tuple("=+-@\t\r\uff1d\uff0b\uff0d\uff20")  # how they begin, in wide letters, too
MOST = 30  # names in a sentence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool] = ()) -> str:
    """Columns side by side, `numeric` ones (default: columns of digits) right-aligned, cells printable; empty without
    rows."""
    if not rows:
        return ""
    head, rows = shown(head), shown(rows)
    widths = [max(len(line[i]) for line in (head, *rows)) for i in range(len(head))]
    right = numeric or [all(not row[i] or row[i][0].isdigit() for row in rows) for i in range(len(head))]
    lines = [
        "  ".join(
            cell.rjust(width) if flush else cell.ljust(width)
            for cell, width, flush in zip(line, widths, right, strict=True)
        ).rstrip()
        for line in (head, *rows)
    ]
    return "\n".join(f"  {line}" for line in lines)


def shown(data: T) -> T:
    """Foreign data with every text as a printable line."""
    made: Any = data
    if isinstance(data, str):
        made = printable(data, keep=SPACES)
    elif isinstance(data, dict):
        made = {shown(key): shown(value) for key, value in data.items()}
    elif isinstance(data, list | tuple):
        made = [shown(each) for each in data]
    return made  # type: ignore[no-any-return]


def cell(value: object) -> object:
    """A CSV cell: one line, with an apostrophe before text that a spreadsheet would evaluate."""
    if not isinstance(value, str):
        return value
    return f"'{shown(value)}" if value.lstrip()[:1] in FORMULAS else shown(value)


def meant(name: str, names: Sequence[str]) -> str:
    """The names most similar to the given one, or a list of names."""
    lower = {x.lower(): x for x in names}
    near = [lower[x] for x in get_close_matches(name.lower(), lower, n=3, cutoff=0.7)]
    if near:
        return f"did you mean {' or '.join(near)}?"
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return f"there are {', '.join(names[:MOST]) or 'none'}{more}"


def duration(seconds: float) -> str:
    """A time span for people: 3.2 s, 4 min 05 s, 1 h 06 min 04 s."""
    if seconds < 60:
        return f"{seconds:.3g} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min {rest:02} s" if hours else f"{minutes} min {rest:02} s"
