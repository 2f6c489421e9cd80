"""Working time in ns since 00:00 of the first day: shifts, possibly across midnight, on days that are not holidays."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date, timedelta
from functools import lru_cache
from itertools import accumulate

from heavylift.kernel.errors import SceneError
from heavylift.nodes.devs import NEVER

MINUTE = 60 * 10**9
DAY = 24 * 60 * MINUTE
YEARS = 10  # that a calendar covers
WEEK = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")

Shift = tuple[int, int]  # [min after midnight]; the end of one across midnight is above 1440


Windows = tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]  # begins, ends, time worked before each


@dataclass(frozen=True)
class Calendar:
    """Working time of shifts, days and holidays, described by a short text.

    An empty text means that all time is working time."""

    key: str = ""

    def open(self, t: int) -> int:
        """Return the earliest working time [ns] at or after the time t [ns]."""
        if not self.key:
            return t
        begins, ends, _ = windows(self.key)
        return max(t, begins[_within(bisect_right(ends, t), begins)])

    def after(self, t: int) -> int:
        """Return the time [ns] at which the next working interval after t begins; NEVER if there is none."""
        begins = windows(self.key)[0] if self.key else ()
        n = bisect_right(begins, t)
        return begins[n] if n < len(begins) else NEVER

    def shortest(self, work: int) -> int:
        """Return the shortest time [ns] in which `work` [ns] of working time can pass, over all possible beginnings."""
        return _shortest(self.key, work) if self.key else work

    def add(self, t: int, work: int) -> int:
        """Return the end [ns] of an activity that begins at the time t and needs `work` [ns] of working time."""
        if not self.key or not work:
            return t + work
        begins, ends, worked = windows(self.key)
        total = self._until(t) + work
        n = bisect_left(worked, total) - 1
        _within(n + (total > worked[n] + ends[n] - begins[n]), begins)
        return begins[n] + total - worked[n]

    def back(self, t: int, work: int) -> int:
        """Return the latest beginning [ns] of an activity that needs `work` [ns] of working time and must end at t."""
        if not self.key or not work:
            return t - work
        begins, _, worked = windows(self.key)
        total = self._until(t) - work
        n = bisect_right(worked, total) - 1
        return begins[n] + total - worked[n]

    def between(self, a: int, b: int) -> int:
        """Return the working time [ns] between the times a and b."""
        return self._until(b) - self._until(a) if self.key else b - a

    def _until(self, t: int) -> int:
        """Return the working time from the first day until t."""
        begins, ends, worked = windows(self.key)
        n = bisect_right(begins, t) - 1
        return worked[n] + min(t, ends[n]) - begins[n] if n >= 0 else 0


@lru_cache(4096)
def _shortest(key: str, work: int) -> int:
    of, (begins, ends, worked) = Calendar(key), windows(key)
    whole = worked[-1] + ends[-1] - begins[-1]
    fits = (t for t, done in zip(begins, worked, strict=True) if done + work <= whole)
    return min((of.add(t, work) - t for t in fits), default=work)


def _within(n: int, begins: Sequence[int]) -> int:
    if n >= len(begins):
        raise SceneError(f"the work is not done {YEARS} years after the yard's start, where its calendar ends")
    return n


def working(start: date, days: Sequence[int], shifts: Sequence[Shift], off: Iterable[date]) -> Calendar:
    """Return the calendar of shifts on these weekdays (0 is Monday), without the days `off`.

    A shift belongs to the day on which it begins. Raises SceneError if no working time remains."""
    parts = [str(start)], map(str, days), (f"{a}-{b}" for a, b in shifts), map(str, sorted(off))
    key = "/".join(" ".join(part) for part in parts)
    if not windows(key)[0]:
        raise SceneError("the calendar has no working time; give it a weekday with a shift that is not off")
    return Calendar(key)


@lru_cache
def windows(key: str) -> Windows:
    """Return the working intervals [ns] of the calendar that a text describes."""
    first, days, shifts, off = (part.split() for part in key.split("/"))
    start, free = date.fromisoformat(first[0]), {date.fromisoformat(x) for x in off}
    found = list[Shift]()
    for n in range(-1, 365 * YEARS):
        day = start + timedelta(n)
        if str(day.weekday()) in days and day not in free:
            minutes = ([int(x) for x in shift.split("-")] for shift in shifts)
            found += ((n * DAY + a * MINUTE, n * DAY + b * MINUTE) for a, b in minutes)
    whole = merged((max(0, a), b) for a, b in sorted(found) if b > 0)
    begins, ends = tuple(a for a, _ in whole), tuple(b for _, b in whole)
    return begins, ends, (0, *accumulate(b - a for a, b in whole[:-1]))


def merged(windows: Iterable[Shift]) -> list[Shift]:
    """Return working intervals [ns] sorted, with overlapping ones merged."""
    found = list[Shift]()
    for a, b in windows:
        if found and a <= found[-1][1]:
            found[-1] = found[-1][0], max(b, found[-1][1])
        else:
            found.append((a, b))
    return found


@lru_cache
def public_holidays(country: str, start: date) -> frozenset[date]:
    """Return the public holidays of a country or region such as `DE-HH`; raises ValueError if the code is unknown."""
    try:
        from holidays import country_holidays
    except ImportError:
        raise ValueError("public holidays need the package holidays: pip install 'heavylift[yard]'") from None
    where, _, part = country.partition("-")
    try:
        return frozenset(country_holidays(where, part or None, years=range(start.year, start.year + YEARS + 1)))
    except NotImplementedError:
        raise ValueError(f"no holidays of '{country}' are known; write a code such as KR, or DE-HH") from None
