"""Typed values from a yard file and its tables: errors are reported at their places.

Readers of dates, shifts, predecessors, durations and units raise ValueError for invalid text.
"""

import re
from collections.abc import Callable, Iterator
from datetime import date, datetime, timedelta
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any, TypeVar, cast

from heavylift.kernel.errors import HeavyliftError, SceneError, closest
from heavylift.nodes.queueing.distributions import (
    Distribution,
    Empirical,
    Erlang,
    Exponential,
    Fixed,
    LogNormal,
    Pert,
    Triangular,
    Uniform,
)
from heavylift.nodes.scene.text.source import Data, Mark, Path, SourceText
from heavylift.nodes.scene.text.spelling import NUMBER
from heavylift.nodes.scene.text.table_files import TableCell, TableColumn, table
from heavylift.nodes.scene.text.units import TIME

from .calendars import DAY, MINUTE, WEEK, Shift

NAME = r"[A-Za-z0-9_-]+"
T = TypeVar("T")
QUANTITY = re.compile(rf"{NUMBER}\s*[A-Za-z]+")
CLOCK = re.compile(r"([01]?\d|2[0-4]):([0-5]\d)-([01]?\d|2[0-4]):([0-5]\d)")
BEFORE = re.compile(rf"([^\s,;+]+)(?:\s*\+\s*({NUMBER}\s*[A-Za-z]+))?[\s,;]*")
KINDS = {  # the words of each, and how many times
    "fixed": ("fixed 4 h", 1),
    "uniform": ("uniform 4 h 6 h", 2),
    "exponential": ("exponential 4 h", 1),
    "triangular": ("triangular 4 h 6 h 12 h", 3),
    "pert": ("pert 4 h 6 h 12 h", 3),
    "lognormal": ("lognormal mean 30 h sd 10 h", 2),
    "erlang": ("erlang 3 phases mean 30 h", 1),
    "table": ("table 4 h 5 h 5 h 9 h", 0),
}


@lru_cache(4096)  # blocks share what their steps take
def duration(text: str) -> Distribution:
    """Read a distribution of durations [s], such as `6 h` or `triangular 4 h 6 h 12 h`."""
    word, _, rest = text.strip().partition(" ")
    if QUANTITY.match(text.strip()):
        word, rest = "fixed", text
    if word not in KINDS:
        raise ValueError(
            f"'{text}' is not a valid duration, such as '6 h' or '{KINDS['triangular'][0]}'; {closest(word, KINDS)}"
        )
    example, count = KINDS[word]
    phases = re.fullmatch(r"(\d+) phases (.*)", rest) if word == "erlang" else None
    body = re.sub(r"\b(mean|sd)\b", " ", phases[2] if phases else rest)
    times = [TIME.read(found) for found in QUANTITY.findall(body)]
    if QUANTITY.sub("", body).strip(" ,") or not times or (count and len(times) != count):
        raise ValueError(f"'{text}': write it as '{example}'")
    try:
        match word:
            case "fixed":
                return Fixed(*times)
            case "uniform":
                return Uniform(*times)
            case "exponential":
                return Exponential(*times)
            case "triangular":
                return Triangular(*times)
            case "pert":
                return Pert(*times)
            case "lognormal":
                return LogNormal(*times)
            case "erlang" if phases:
                return Erlang(int(phases[1]), *times)
            case "table":
                return Empirical(times)
    except HeavyliftError as error:
        raise ValueError(f"'{text}': {error}") from None
    raise ValueError(f"'{text}': write it as '{example}'")


def variance(takes: Distribution) -> float:
    """Return the variance of a duration [s2]; for PERT it is ((b - a) / 6)^2, as published by Malcolm et al. 1959."""
    match takes:
        case Uniform():
            return square(takes.high - takes.low) / 12
        case Exponential():
            return square(takes.mean)
        case Erlang():
            return square(takes.mean) / takes.phases
        case Triangular():
            a, m, b = takes.low, takes.mode, takes.high
            return (a * a + m * m + b * b - a * m - a * b - m * b) / 18
        case Pert():
            return square((takes.high - takes.low) / 6)
        case LogNormal():
            return square(takes.deviation)
        case Empirical():
            return sum(square(x - takes.mean) for x in takes.times) / len(takes.times)
    return 0.0


def square(x: float) -> float:
    """Return the square of x."""
    return x * x


def day(text: object) -> date:
    """Read a date such as `2027-05-01`."""
    try:
        found = date.fromisoformat(str(text).removesuffix(" 00:00:00"))
        if not 1900 <= found.year < 2200:
            raise ValueError
        return found
    except ValueError:
        raise ValueError(f"'{text}' is not a valid date: write year, month and day, such as 2027-05-01") from None


def days_off(text: object) -> Iterator[date]:
    """Read a date, or all dates of a range including both ends, such as `2027-02-06..2027-02-10`."""
    first, _, last = (part.strip() for part in str(text).partition(".."))
    begin, end = day(first), day(last or first)
    if end < begin:
        raise ValueError(f"the range of dates '{text}' ends before it begins; exchange its ends")
    return (begin + timedelta(n) for n in range((end - begin).days + 1))


def weekdays(text: object) -> tuple[int, ...]:
    """Read weekdays such as `mon-fri` or `mon wed sat`; 0 is Monday."""
    found = list[int]()
    for part in str(text).lower().replace(",", " ").split():
        first, _, last = part.partition("-")
        for word in (first, last or first):
            if word not in WEEK:
                raise ValueError(f"'{word}' is not a day of the week: write them as 'mon-fri' or 'mon wed sat'")
        a, b = WEEK.index(first), WEEK.index(last or first)
        found += [n % 7 for n in range(a, b + 1 if b >= a else b + 8)]
    return tuple(sorted({*found}))


def shift(text: object) -> tuple[Shift, ...]:
    """Read the working intervals of a shift, such as `08:00-12:00 13:00-17:00`; `22:00-06:00` ends the next day."""
    found = list[Shift]()
    for part in str(text).replace(",", " ").split():
        clock = CLOCK.fullmatch(part)
        a, b = (int(clock[n]) * 60 + int(clock[n + 1]) for n in (1, 3)) if clock else (0, 0)
        if not clock or max(a, b) > 1440:
            raise ValueError(
                f"'{part}' is not a valid shift: write it as '08:00-17:00', with breaks '08:00-12:00 13:00-17:00'"
            )
        found.append((a, b if b > a else b + 1440))
    return tuple(found)


def before(text: str) -> list[tuple[str, int]]:
    """Read predecessors with their lags [ns], such as `B1, B2 + 2 days`."""
    found, at = list[tuple[str, int]](), 0
    while at < len(text):
        one = BEFORE.match(text, at)
        if one is None:
            raise ValueError(f"'{text}' is not a list of blocks: write it as 'B1, B2 + 2 days'")
        found.append((one[1], round(TIME.read(one[2]) * 1e9) if one[2] else 0))
        at = one.end()
    return found


def instant(start: date, when: date) -> int:
    """Return the time [ns] from the start of the yard to the beginning of a day."""
    return (when - start).days * DAY


def at(start: date, t: float) -> datetime:
    """Return the date and time of day, to the minute, at t [s] after the start of the yard."""
    return datetime(start.year, start.month, start.day) + timedelta(minutes=round(t * 1e9 / MINUTE))


def words(data: object) -> list[str]:
    """Return a word, or a list of words, as a list of words."""
    return [] if data is None else [str(x) for x in (data if isinstance(data, list) else [data])]


def units(value: object) -> int:
    """Read the number of units of a resource."""
    if isinstance(value, bool) or not re.fullmatch(r"\d+", str(value)):
        raise ValueError(f"'{value}' is not a valid number of units: write a whole number, such as 1")
    return int(str(value))


class Taking:
    """Parser of typed values from the data of a file; it collects the errors."""

    def __init__(self, source: SourceText) -> None:
        self.source = source

    def take(self, path: Path, of: Callable[[Any], T], usual: Any, mark: Mark | None = None, value: Data = None) -> T:
        """Return the value at a path, converted by `of`; if it is missing or invalid, return the default `usual`."""
        value = self.source.at(path) if value is None else value
        if value is None:
            return cast(T, usual)
        try:
            return of(value)
        except (ValueError, SceneError) as error:
            self.source.fault(path, str(error), mark=mark)
            return cast(T, usual)

    def cell(self, cells: dict[str, TableCell], column: str, at: Path, of: Callable[[str], T], usual: Any) -> T:
        """Return the cell in a column, converted by `of`; if it is missing or invalid, return the default `usual`."""
        found = cells.get(column)
        return self.take((*at, column), of, usual, found.mark, found.text) if found else cast(T, usual)

    def mapping(self, path: Path, known: set[str] | None = None) -> dict[str, Data]:
        """Return the mapping at a path; add errors for keys that are not in `known`."""
        found = self.source.at(path)
        if found is not None and not isinstance(found, dict):
            self.source.fault(path, "write a mapping of keys here")
        given = found if isinstance(found, dict) else {}
        for key in given:
            if known is not None and key not in known:
                self.source.fault((*path, key), "this key is not known here", closest(key, sorted(known)), on_key=True)
            elif known is None and not re.fullmatch(NAME, key):
                self.source.fault((*path, key), "a name has letters, digits, _ and - only", on_key=True)
        return given

    def known(self, path: Path, word: Data, among: Any, what: str) -> None:
        """Add an error unless a word is one of the known names."""
        if word not in among:
            self.source.fault(path, f"there is no {what} '{word}'", closest(str(word), [x for x in among if x]))

    def table(self, path: Path, root: FilePath | None = None) -> tuple[list[TableColumn], list[list[TableCell]]]:
        """Return the column heads and rows of the table file that a value of the data names; empty after an error.

        `root`: its folder (default: that of the yard file)."""
        try:
            found = table(root or self.source.root, str(self.source.at(path)))
            return found.head, found.rows
        except (SceneError, ValueError) as error:
            self.source.fault(path, str(error))
            return [], []
