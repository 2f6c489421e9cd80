"""Checks as a table of numbers for workbooks: a column for each unit, where the printed table has text."""

from collections.abc import Sequence
from math import isfinite, pi

from heavylift.kernel.description.findings import Check
from heavylift.recordings.sheets.sheet import Marked, Table, Value, columns, trimmed

UNITS = {  # of values in SI units: the unit of planners, its size, and decimals
    "kg": ("t", 1e-3, 2),
    "N": ("kN", 1e-3, 2),
    "N m": ("kN m", 1e-3, 1),
    "Pa": ("kPa", 1e-3, 1),
    "rad": ("deg", 180.0 / pi, 3),
    "m": ("m", 1.0, 3),
    "m/s": ("m/min", 60.0, 3),
    "": ("", 1.0, 3),
}


def numbers_of(title: str, checks: Sequence[Check]) -> Table:
    """Return the table of all checks: state, value and limit (a column per unit), utilisation [%], and time."""
    units = [unit for unit in UNITS if any(check.unit == unit for check in checks)]
    heads = [
        f"{what}{f' [{UNITS[unit][0]}]' if unit else ''} .{UNITS[unit][2]}"
        for unit in units
        for what in ("value", "limit")
    ]
    rows = []
    for check in checks:
        each = [
            _finite(x, UNITS[unit][1]) if check.unit == unit else None
            for unit in units
            for x in (check.value, check.limit)
        ]
        used, state = _finite(check.use, 100.0), Marked(check.word, check.state)
        rows.append((state, check.quantity, check.subject, *each, used, check.t, check.stage, check.basis))
    named = columns("state", "check", "of", *heads, "used [%] .1", "at [h:min:s]", "stage", "basis")
    return trimmed(Table(title, named, tuple(rows)))


def _finite(value: float | None, scale: float) -> Value:
    return None if value is None or not isfinite(value) else value * scale
