"""Serial schedule generation, and the critical path with its variance by PERT.

The serial scheme takes one activity after the other and starts each as early as its predecessors and resources allow.
The dispatcher in `models` is the parallel scheme, which never lets an activity wait that could start (Kolisch 1996).
"""

from .fields import variance
from .network import Activity, Yard, dates, ranks

Span = tuple[int, int]  # [ns] start and finish


def serial(yard: Yard, rule: str = "") -> list[Span]:
    """Return the start and finish [ns] of each activity by the serial generation scheme, with expected durations; only
    for yards in which no activity keeps a resource beyond its own end."""
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
    raise AssertionError("after the last end everything is free")


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
