"""An optimised schedule by CP-SAT (Perron and Furnon, OR-Tools), with expected durations, and a bound that no schedule
can beat.

The solver counts only the time in which some step can work. On this time scale the work of each single step takes as
long or longer, so the bound is also valid with calendars. With calendars, both schedule generation schemes turn the
solver's order of activities into a schedule, and the one that ends earliest is used; without calendars, the solver's
own schedule is one of them.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any

from heavylift.kernel.errors import SceneError, extra

from .calendars import MINUTE, merged, windows
from .models import expected
from .network import RULES, Span, Yard, sequence, serial
from .weather import NONE

SEED = 1


@dataclass(frozen=True)
class Optimised:
    """An optimised schedule: start and end of each activity, delivery time, and a lower bound of that time [ns].

    `how`: how the schedule was found."""

    spans: tuple[Span, ...]
    end: int
    bound: int
    how: str

    @property
    def gap(self) -> float:
        """Relative difference between the delivery time and its lower bound."""
        return self.end / self.bound - 1.0 if self.bound else 0.0


class AnyWork:
    """Time scale [ns] that counts only the time in which at least one of several calendars is working."""

    def __init__(self, keys: Sequence[str]) -> None:
        always = not all(keys)
        found = [] if always else merged(sorted(w for key in keys for w in zip(*windows(key)[:2], strict=True)))
        self.begins, self.ends = [a for a, _ in found], [b for _, b in found]
        self.worked = [0, *accumulate(b - a for a, b in found)]

    def until(self, t: int) -> int:
        """Return the working time [ns] from the first day until the time t [ns]."""
        n = bisect_right(self.begins, t) - 1
        if not self.begins:
            return t
        return self.worked[n] + min(t, self.ends[n]) - self.begins[n] if n >= 0 else 0

    def least(self, lag: int) -> int:
        """Return the smallest working time [ns] in any interval of the length `lag` [ns]."""
        return min((self.until(end + lag) - self.until(end) for end in self.ends[:400]), default=lag) if lag else 0

    def instant(self, worked: int) -> int:
        """Return the time [ns] at which the working time since the first day reaches `worked` [ns]."""
        if not self.begins:
            return worked
        n = min(max(bisect_right(self.worked, worked - 1) - 1, 0), len(self.begins) - 1)
        return self.begins[n] + worked - self.worked[n]


def optimised(yard: Yard, effort: float = 60.0) -> Optimised:
    """Return the schedule with the earliest delivery that OR-Tools finds; raises SceneError if it is not installed.

    The effort of the solver is limited in deterministic time, which is the same on every machine."""
    cp = extra("ortools.sat.python.cp_model", SceneError("plan needs OR-Tools: pip install 'heavylift[schedule]'"))
    bare = replace(yard, weather=NONE)
    schedules = {rule: _spans(bare, rule) for rule in RULES}
    if yard.plan:
        schedules["the given plan"] = _spans(bare, "")
    time = AnyWork([*dict.fromkeys(one.works.key for one in yard.activities)])
    hint = min(schedules.values(), key=_end)
    most = -(-time.until(_end(hint)) // MINUTE) + len(yard.activities)  # durations are rounded
    starts, bound = _solved(cp, yard, time, most, hint, effort)
    order = replace(bare, plan=tuple(starts))
    schedules |= {"CP-SAT": _spans(order, "")}
    if not yard.holding:
        schedules |= {f"{rule}, serial": tuple(serial(bare, rule)) for rule in RULES}
        schedules |= {"CP-SAT, serial": tuple(serial(order))}
    how = min(schedules, key=lambda name: _end(schedules[name]))
    return Optimised(schedules[how], _end(schedules[how]), min(time.instant(bound), _end(schedules[how])), how)


def _solved(
    cp: Any, yard: Yard, time: AnyWork, most: int, hint: Sequence[Span], effort: float
) -> tuple[list[int], int]:
    """Return the starts [ns] in the solver's best schedule, and a lower bound for its end in working time [ns]."""
    model, starts, ends = cp.CpModel(), list[Any](), list[Any]()
    spans = list[Any]()
    for n, one in enumerate(yard.activities):
        lasts = one.expected // MINUTE
        starts.append(model.new_int_var(time.until(one.ready) // MINUTE, most, f"start {n}"))
        ends.append(starts[n] + lasts)
        spans.append(model.new_fixed_size_interval_var(starts[n], lasts, f"work {n}"))
        model.add_hint(starts[n], time.until(hint[n][0]) // MINUTE)
    for n in sequence(yard):
        for m, lag in yard.activities[n].after:
            model.add(starts[n] >= ends[m] + time.least(lag) // MINUTE)
    for resource, units in yard.capacities.items():
        held, taken = list[Any](), list[int]()
        for n, one in enumerate(yard.activities):
            for need in (need for need in one.needs if need.resource == resource):
                taken.append(need.units)
                if need.until == n:
                    held.append(spans[n])
                else:
                    size = model.new_int_var(0, most, f"kept {n} {resource}")
                    held.append(model.new_interval_var(starts[n], size, ends[need.until], f"kept {n} {resource}"))
        model.add_cumulative(held, taken, units)
    last = model.new_int_var(0, most, "end")
    model.add_max_equality(last, ends)
    model.minimize(last)
    solver = cp.CpSolver()
    solver.parameters.random_seed, solver.parameters.num_workers = SEED, 1
    solver.parameters.max_deterministic_time = effort
    status = solver.solve(model)
    if status not in (cp.OPTIMAL, cp.FEASIBLE):
        return [start for start, _ in hint], int(solver.best_objective_bound) * MINUTE
    found = [time.instant(solver.value(start) * MINUTE) for start in starts]
    return found, int(solver.best_objective_bound) * MINUTE


def _spans(yard: Yard, rule: str) -> tuple[Span, ...]:
    """Return the schedule of a run with a priority rule, as start and end [ns] of each activity."""
    schedule = expected(yard, rule)
    return tuple((round(a * 1e9), round(b * 1e9)) for a, b in zip(schedule.starts, schedule.ends, strict=True))


def _end(spans: Sequence[Span]) -> int:
    return max(end for _, end in spans)
