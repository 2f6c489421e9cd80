"""Activities of a yard, forward and backward pass, priority rules, serial schedule generation, and PERT.

The critical path method follows Kelley and Walker (1959). The priority rules are those of Kolisch (1996), European
Journal of Operational Research 90: each rule sorts activities by a number, the lowest first; ties are resolved by the
number of the activity. The serial scheme takes one activity after the other and starts each as early as its
predecessors and resources allow; the dispatcher is the parallel scheme, which never lets an activity wait that could
start.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from graphlib import TopologicalSorter

from heavylift.kernel.errors import closest
from heavylift.nodes.devs import seconds
from heavylift.nodes.queueing.distributions import Distribution

from .calendars import Calendar
from .fields import variance
from .lifts import Lift, LiftOrder
from .waves import WaveLimit
from .weather import NONE, YardWeather

RULES = {
    "earliest start": "EST", "latest start": "LST", "latest finish": "LFT", "minimum slack": "MSLK",
    "most successors": "MTS",
}  # fmt: skip

Span = tuple[int, int]  # [ns] start and finish


@dataclass(frozen=True)
class Need:
    """Units of a resource that an activity occupies from its beginning until the end of activity number `until`."""

    resource: str
    units: int
    until: int


@dataclass(frozen=True)
class Activity:
    """A step of a block: duration, needed resources, predecessors, calendar, its lift and its sea limit.

    The duration [s] is without its lift; predecessors have lags [ns]; further the time at which the block is ready
    [ns], and the waves that the activity allows."""

    block: str
    step: str
    takes: Distribution
    needs: tuple[Need, ...]
    after: tuple[tuple[int, int], ...]
    ready: int
    works: Calendar
    lift: Lift | None = None
    order: LiftOrder | None = None
    sea: WaveLimit | None = None

    @property
    def name(self) -> str:
        """Name of the activity: name of the block followed by the name of the step."""
        return f"{self.block} {self.step}"

    @property
    def expected(self) -> int:
        """Expected duration of the activity, including its lift [ns]."""
        return seconds(self.takes.mean + (self.lift.seconds if self.lift else 0.0))


@dataclass(frozen=True)
class Yard:
    """Data of a yard: numbered activities, resources, priority rule, and contract dates.

    Activities count from 0; number of units of each resource; priority rule, or order of blocks; contract dates of
    blocks or of the `delivery`, and the probability with which these dates must be met."""

    name: str
    start: date
    activities: tuple[Activity, ...]
    capacities: dict[str, int]
    rule: str
    order: tuple[str, ...]
    contract: dict[str, date]
    quantile: float
    sources: dict[str, str]  # of the durations of each step
    weather: YardWeather = NONE
    plan: tuple[int, ...] = ()  # [ns] starts of an existing schedule, -1 where it has none; before them nothing begins

    @property
    def holding(self) -> bool:
        """Whether any activity keeps a resource beyond its own end."""
        return any(need.until != n for n, one in enumerate(self.activities) for need in one.needs)


@dataclass(frozen=True)
class Dates:
    """Earliest and latest start and finish of each activity [ns] for unlimited resources."""

    early_start: list[int]
    early_finish: list[int]
    late_start: list[int]
    late_finish: list[int]

    def critical(self, n: int) -> bool:
        """Return whether activity n is critical, that is without slack."""
        return self.late_start[n] <= self.early_start[n]


def successors(yard: Yard) -> list[list[tuple[int, int]]]:
    """Return the successors of each activity, with their lags [ns]."""
    found: list[list[tuple[int, int]]] = [[] for _ in yard.activities]
    for n, one in enumerate(yard.activities):
        for m, lag in one.after:
            found[m].append((n, lag))
    return found


def dates(yard: Yard) -> Dates:
    """Return early and late dates of all activities by the critical path method, for unlimited resources."""
    all_ = yard.activities
    order = sequence(yard)
    early, finish = [0] * len(all_), [0] * len(all_)
    for n in order:
        one = all_[n]
        early[n] = one.works.open(max([one.ready, *(finish[m] + lag for m, lag in one.after)]))
        finish[n] = one.works.add(early[n], one.expected)
    late, end = [max(finish, default=0)] * len(all_), [max(finish, default=0)] * len(all_)
    after = successors(yard)
    for n in reversed(order):
        end[n] = min([end[n], *(late[m] - lag for m, lag in after[n])])
        late[n] = all_[n].works.back(end[n], all_[n].expected)
    return Dates(early, finish, late, end)


def sequence(yard: Yard) -> list[int]:
    """Return the activities in topological order, so that each activity follows its predecessors."""
    return [*TopologicalSorter({n: [m for m, _ in one.after] for n, one in enumerate(yard.activities)}).static_order()]


def ranks(yard: Yard, rule: str = "") -> list[int]:
    """Return the rank of each activity by a priority rule (default: the rule of the yard)."""
    numbers = range(len(yard.activities))
    known, values = dates(yard), list[int]()
    if not rule and yard.plan:
        values = [start if start >= 0 else early for start, early in zip(yard.plan, known.early_start, strict=True)]
    elif not rule and yard.order:
        places = {block: n for n, block in enumerate(yard.order)}
        values = [places[one.block] for one in yard.activities]
    else:
        match RULES.get(rule or yard.rule, rule):
            case "EST":
                values = known.early_start
            case "LST":
                values = known.late_start
            case "LFT":
                values = known.late_finish
            case "MSLK":
                values = [late - early for late, early in zip(known.late_start, known.early_start, strict=True)]
            case "MTS":
                values = [-count for count in _followers(yard)]
    found = [0] * len(numbers)
    for place, n in enumerate(sorted(numbers, key=lambda n: (values[n], n))):
        found[n] = place
    return found


def _followers(yard: Yard) -> Sequence[int]:
    """Return, for each activity, the number of activities that depend on it directly or indirectly."""
    after, sets = successors(yard), [0] * len(yard.activities)  # bits of a whole number
    for n in reversed(sequence(yard)):
        for m, _ in after[n]:
            sets[n] |= sets[m] | 1 << m
    return [x.bit_count() for x in sets]


def rule_named(value: object) -> str:
    """Return the full name of a priority rule, given its name or abbreviation."""
    text, short = str(value), {letters: name for name, letters in RULES.items()}
    if text not in RULES and text not in short:
        raise ValueError(f"there is no rule '{text}': {closest(text, RULES)}")
    return short.get(text, text)


def serial(yard: Yard, rule: str = "") -> list[Span]:
    """Return the start and finish of each activity [ns] by the serial generation scheme, with expected durations.

    Not for yards in which an activity keeps a resource beyond its own end."""
    rank, done = ranks(yard, rule), dict[int, Span]()
    used: dict[str, list[tuple[int, int, int]]] = {name: [] for name in yard.capacities}
    todo = sorted(range(len(yard.activities)), key=rank.__getitem__)
    while todo:
        n = next(n for n in todo if all(m in done for m, _ in yard.activities[n].after))
        todo.remove(n)
        one = yard.activities[n]
        earliest = max([one.ready, *(done[m][1] + lag for m, lag in one.after)])
        done[n] = _first(one, earliest, yard.capacities, used)
        for need in one.needs:
            used[need.resource].append((*done[n], need.units))
    return [done[n] for n in range(len(yard.activities))]


def _first(
    one: Activity, earliest: int, capacities: dict[str, int], used: dict[str, list[tuple[int, int, int]]]
) -> Span:
    """Return the first start and finish at which all units that an activity needs are free."""
    ends = {end for need in one.needs for _, end, _ in used[need.resource] if end > earliest}
    for t in [earliest, *sorted(ends)]:
        start = one.works.open(t)
        finish = one.works.add(start, one.expected)
        if all(
            _peak(used[need.resource], start, finish) + need.units <= capacities[need.resource] for need in one.needs
        ):
            return start, finish
    raise AssertionError("all resources must be free after the last activity")


def _peak(spans: list[tuple[int, int, int]], start: int, finish: int) -> int:
    """Return the largest number of units that are in use at the same time between two times."""
    overlapping = [(a, b, units) for a, b, units in spans if a < finish and b > start]
    times = [start, *(a for a, _, _ in overlapping if a > start)]
    return max(sum(units for a, b, units in overlapping if a <= t < b) for t in times)


def chain(yard: Yard) -> tuple[list[int], float, float]:
    """Return a critical path, its expected length [s] in working time, and the variance of this length [s2]."""
    known = dates(yard)
    end = max(known.early_finish)
    path = [next(n for n, t in enumerate(known.early_finish) if t == end and known.critical(n))]
    while True:
        one = yard.activities[path[0]]
        before = [
            m for m, lag in one.after if known.critical(m) and known.late_finish[m] + lag == known.late_start[path[0]]
        ]
        if not before or one.ready >= known.early_start[path[0]] > 0:
            break
        path.insert(0, before[0])
    on_it = [yard.activities[n].takes for n in path]
    return path, sum(x.mean for x in on_it), sum(variance(x) for x in on_it)
