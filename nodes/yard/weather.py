"""Wind and sea in a yard: measured series, or random ones with Weibull distributions by month.

A random series is a first-order Gaussian process (a Markov chain, ARMA(1, 0)) whose values are mapped to the Weibull
distribution of the month (translation process; Brown, Katz and Murphy 1984, J. Climate Appl. Meteor. 23).
"""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime, timedelta
from itertools import pairwise
from math import erfc, isfinite, log, sqrt
from random import Random
from typing import Any

from heavylift.nodes.devs import NEVER, Atomic, Bag, In, Message, Out, stream
from heavylift.nodes.scene.text.table_files import TableCell, with_unit
from heavylift.nodes.scene.text.units import ANGLE, LENGTH, RATIO, SPEED, TIME

from .calendars import DAY, YEARS
from .fields import Taking
from .waves import WaveLimit

HOUR = DAY // 24
COLUMNS, MONTHLY = {"wind": ("wind", SPEED), "sea": ("Hs", LENGTH)}, ("month", "scale", "shape")  # of a series
OF_WAVES = {"Tp": TIME, "from": ANGLE}  # columns that a series of the sea may have
CALM = "none"  # in place of a yard's weather
YEAR = 8760  # hours; also how far ahead a calm is looked for


@dataclass(frozen=True)
class HourlySeries:
    """Hourly wind speed [m/s] or significant wave height [m], either measured or random.

    A measured `series` is repeated from one of the hours `begins` on; a random series has Weibull distributions (scale
    and shape for each month) and a correlation from hour to hour. Random wind and sea are independent of each other;
    measured wind and sea begin in the same year."""

    start: date
    series: tuple[float, ...] = ()
    begins: tuple[int, ...] = (0,)
    since: int = 0  # hours from its first one to the start of the yard
    scales: tuple[float, ...] = ()
    shapes: tuple[float, ...] = ()
    persistence: float = 0.0
    periods: tuple[float, ...] = ()  # Tp [s] of a measured sea, if known
    directions: tuple[float, ...] = ()  # [rad] from which it comes, if known

    @property
    def drawn(self) -> bool:
        """Whether the weather of the series differs between replications."""
        return not self.series or len(self.begins) > 1

    def begin(self, random: Random, drawn: bool) -> float:
        """Return the state of an hourly series before its first hour; if `drawn`, a measured series begins in a random
        year."""
        if self.series:
            return self.begins[random.randrange(len(self.begins)) if drawn and len(self.begins) > 1 else 0]
        return random.gauss(0.0, 1.0)

    def waves(self, n: int) -> tuple[float | None, float | None]:
        """Return peak period [s] and direction [rad] of the waves in hour n of a measured series; None where not
        known."""
        periods, directions = self.periods, self.directions
        return (
            periods[n % len(periods)] if periods else None, directions[n % len(directions)] if directions else None
        )  # fmt: skip

    def hours(self, day: int, state: float, random: Random) -> tuple[list[float], float]:
        """Return the values of the series in all 24 hours of a day, and the state with which the next day begins."""
        if self.series:
            n, count = int(state), len(self.series)
            return [self.series[(n + k) % count] for k in range(24)], n + 24
        month, keep = (self.start + timedelta(day)).month - 1, self.persistence
        scale, power, renew = self.scales[month], 1.0 / self.shapes[month], sqrt(1.0 - keep * keep)
        found = list[float]()
        for _ in range(24):
            found.append(scale * (-log(max(0.5 * erfc(state / sqrt(2.0)), 1e-300))) ** power)
            state = keep * state + renew * random.gauss(0.0, 1.0)
        return found, state


class WindChange(Message):
    """Message that the wind speed [m/s] or wave height [m] has crossed a limit.

    It has the time [ns] until which the value stays within each limit (-1 for limits that it exceeds now), and a flag
    for the last change."""

    speed: float
    calm: tuple[int, ...]
    last: bool


class YardDone(Message):
    """Message that all work in the yard is done."""


class Weather(Atomic):
    """Atomic model that reports the wind speed or wave height whenever it crosses one of the `limits`."""

    over, wind = In(YardDone), Out(WindChange)

    def __init__(self, name: str, wind: HourlySeries, limits: Sequence[float], seed: int) -> None:
        super().__init__(name)
        self.given, self.limits, self.seed, self.count = wind, tuple(limits), seed, len(limits)

    def start(self) -> None:
        """Schedule the weather report on the first hour."""
        self.random, self.known = stream(self.seed, self.path), list[float]()
        year = stream(self.seed, "year")  # one for all series, which belong together
        self.state = self.given.begin(year if self.given.series else self.random, self.seed > 0)
        self.begun, self.hour = int(self.state), 0  # the hour of which it tells next
        self.above = [0] * self.count  # next hour above each limit
        self.look()
        self.hold_in(0)

    def external(self, e: int, x: Bag) -> None:
        """Stop all weather reports, because the work in the yard is done."""
        self.passivate()

    def output(self) -> None:
        """Send the wind speed or wave height now, and the time until which it stays within each limit."""
        self.wind.send(self.change)

    def internal(self) -> None:
        """Wait for the next time at which the wind speed or wave height crosses a limit."""
        last, self.hour = self.hour, self.next
        if self.next < 0:
            self.passivate()
        else:
            self.look()
            self.hold_in((self.hour - last) * HOUR)

    def look(self) -> None:
        """Find the next crossing of a limit by the wind speed or wave height, and store its time."""
        class_, n = self.place(self.hour), self.hour + 1
        most = n + (len(self.given.series) or YEARS * YEAR)
        while n < most and self.place(n) == class_:
            n += 1
        self.next = n if n < most else -1
        ends = [self.exceeded(k, n) for k in range(self.count)]
        calm = tuple((NEVER if self.next < 0 else n * HOUR) if n > self.hour else -1 for n in ends)
        self.change = WindChange(self.at(self.hour), calm, self.next < 0)

    def exceeded(self, k: int, change: int) -> int:
        """Return the first hour, from now on, in which the wind speed or wave height exceeds the k-th limit.

        The search ends after one year, or at the hour `change` if that is later."""
        n = max(self.above[k], self.hour)
        while n < max(self.hour + YEAR, change) and self.within(n, k):
            n += 1
        self.above[k] = n
        return n

    def place(self, hour: int) -> Any:
        """Return the number of limits that the wind speed or wave height exceeds in this hour."""
        return bisect_left(self.limits, self.at(hour))

    def within(self, hour: int, k: int) -> bool:
        """Return whether the wind speed or wave height in this hour is within the k-th limit."""
        return self.at(hour) <= self.limits[k]

    def at(self, hour: int) -> float:
        """Return the wind speed or wave height in the hour with this number, counted from the start."""
        while len(self.known) <= hour:
            day, self.state = self.given.hours(len(self.known) // 24, self.state, self.random)
            self.known += day
        return self.known[hour]


class SeaWeather(Weather):
    """Atomic model that reports the wave height whenever it crosses a limit, which depends on period and direction."""

    def __init__(self, name: str, sea: HourlySeries, limits: Sequence[WaveLimit], seed: int) -> None:
        super().__init__(name, sea, (), seed)
        self.waves, self.count = tuple(limits), len(limits)

    def place(self, hour: int) -> Any:
        return [self.within(hour, k) for k in range(self.count)]

    def within(self, hour: int, k: int) -> bool:
        return self.waves[k].allows(self.at(hour), *self.given.waves(self.begun + hour))


@dataclass(frozen=True)
class YardWeather:
    """Wind and sea of a yard, the length of the wind forecast [ns], and the alpha factors of the sea.

    `alpha`: pairs of window length [ns], in ascending order, and factor by which operational limits are reduced."""

    wind: HourlySeries | None = None
    sea: HourlySeries | None = None
    forecast: int = 0
    alpha: tuple[tuple[int, float], ...] = ()

    def factor(self, window: int) -> float:
        """Return the alpha factor for a weather window [ns]; 0 if it is longer than all windows with a factor."""
        return next((x for length, x in self.alpha if window <= length), 0.0) if self.alpha else 1.0


NONE = YardWeather()


def weather_of(given: Taking, start: date) -> YardWeather:
    """Return the weather that a yard file gives; `weather: none` means always calm."""
    if given.source.at(("weather",)) == CALM:
        return NONE
    given.mapping(("weather",), {"wind", "sea", "forecast", "alpha"})
    forecast = given.take(("weather", "forecast"), lambda x: round(TIME.read(str(x)) * 1e9), 0)
    alpha = list[tuple[int, float]]()
    listed = given.source.at(("weather", "alpha"))
    if listed is not None and not isinstance(listed, dict):
        given.source.fault(("weather", "alpha"), "write a factor for each length of window: {12 h: 0.93, 24 h: 0.89}")
    for length in listed if isinstance(listed, dict) else ():
        at = ("weather", "alpha", length)
        factor = given.take(at, RATIO.read, 1.0)
        if not 0.0 < factor <= 1.0:
            given.source.fault(at, "an alpha factor is above 0 and at most 1, as in DNV-ST-N001")
        alpha.append((given.take(at, lambda x: round(TIME.read(x) * 1e9), 0, value=length), factor))
    alpha.sort()
    if any(b > a for (_, a), (_, b) in pairwise(alpha)):
        given.source.fault(("weather", "alpha"), "the factor of a longer window is not above that of a shorter one")
    wind, sea = (_hourly(given, start, what) for what in COLUMNS)
    calm = given.source.at(("weather", "sea")) is None
    if listed and calm:
        given.source.fault(("weather", "alpha"), "alpha factors are of the sea: give 'sea' beside them")
    for step in given.mapping(("steps",)):
        path = ("steps", step, "limits")
        if given.source.at((*path, "Hs")) is not None and calm:
            given.source.fault(path, "the yard has no sea for it: give 'weather: {sea: ...}', or 'weather: none'")
        if given.source.at((*path, "from")) is not None and not (sea and sea.directions):
            given.source.fault((*path, "from"), "the sea has no directions: give its series a column 'from [deg]'")
    # measured series of a year or more begin in a calendar year that they have in common
    long = [x for x in (wind, sea) if x and len(x.series) >= YEAR]
    years = sorted(set[int].intersection(*({n - x.since for n in x.begins} for x in long))) if long else []
    if long and not years:
        given.source.fault(("weather",), "the series of wind and sea have no year in common")
    wind, sea = (replace(x, begins=tuple(n + x.since for n in years)) if x in long and x else x for x in (wind, sea))
    return YardWeather(wind, sea, forecast, tuple(alpha))


def _hourly(given: Taking, start: date, what: str) -> HourlySeries | None:
    """Return the wind or the sea of a yard."""
    found = given.mapping(("weather", what), {"series", "monthly", "persistence"})
    if not found:
        return None
    kind, (column, dimension) = "series" if "series" in found else "monthly", COLUMNS[what]
    path, names = ("weather", what, kind), ("time", column) if kind == "series" else MONTHLY
    head, rows = given.table(path)
    keys = [x.key for x in head]
    others = {x for x, _ in COLUMNS.values()} | {*OF_WAVES} if kind == "series" else set[str]()  # of the other series
    if head and sorted({*keys} - others | {*names} & {*keys}) != sorted(names):
        given.source.fault(path, f"the columns are {', '.join(names)}, not {', '.join(keys)}", mark=head[0].mark)
    if not head or given.source.faults:
        return None
    units = dict(zip(keys, (column.unit for column in head), strict=True))

    def number(cells: dict[str, TableCell], name: str) -> float:
        def read(text: str) -> float:
            plain, of = name in ("shape", "month"), OF_WAVES.get(name, dimension)
            x = float(text) if plain else of.read(with_unit(text, units[name]))
            if not (isfinite(x) and (x > 0 or (name in (column, "from") and x == 0))):
                raise ValueError(f"'{text}' is not a valid {name} of the {what}: write a positive number")
            return x

        return given.take(path, read, 1.0, cells[name].mark, cells[name].text)

    table = [dict(zip(keys, row, strict=True)) for row in rows]
    if kind == "series":
        speeds = tuple(number(cells, column) for cells in table)
        times = [given.take(path, _time, datetime(2000, 1, 1), c["time"].mark, c["time"].text) for c in table]
        for cells, a, b in zip(table[1:], times, times[1:], strict=False):
            if (b - a).total_seconds() != 3600 and not given.source.faults:
                text = "this row does not follow an hour after the one before"
                given.source.fault(path, text, mark=cells["time"].mark)
        if len(table) < 24:
            given.source.fault(path, f"a series has the {what} of a day at least, hour by hour")
            return None
        hours = round((datetime(start.year, start.month, start.day) - times[0]).total_seconds()) // 3600
        years = len(speeds) // YEAR
        first = hours % (YEAR if years else len(speeds))
        begins = tuple(first + n * YEAR for n in range(max(1, years)))
        more = (tuple(number(c, x) for c in table) if what == "sea" and x in keys else () for x in OF_WAVES)
        periods, directions = more
        return HourlySeries(start, speeds, begins, hours, periods=periods, directions=directions)
    months = {int(number(cells, "month")): cells for cells in table}
    if sorted(months) != [*range(1, 13)]:
        given.source.fault(path, "give each month once, from 1 to 12", mark=head[0].mark)
        return None
    keep = given.take(("weather", what, "persistence"), RATIO.read, 0.9)
    if not 0 <= keep < 1:
        given.source.fault(("weather", what, "persistence"), "the correlation of two hours is from 0 to below 1")
    scales, shapes = (tuple(number(months[n], key) for n in range(1, 13)) for key in ("scale", "shape"))
    return HourlySeries(start, scales=scales, shapes=shapes, persistence=min(keep, 0.999))


def _time(text: str) -> datetime:
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        raise ValueError(f"'{text}' is not a valid time: write it as 2026-01-31 13:00") from None
