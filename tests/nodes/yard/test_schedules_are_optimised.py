"""Schedules by CP-SAT: published optima, optima by exhaustive search, and bounds that hold with calendars."""

import random
from itertools import permutations
from pathlib import Path

import pytest
from heavylift.nodes.yard import MINUTE, RULES, AnyWork, expected, load, optimised, working
from test_schedules_agree_with_theory import random_yard, written

pytest.importorskip("ortools")
HERE = Path(__file__).parent
DAY = 86400 * 10**9
EFFORT = 4.0


@pytest.mark.parametrize(("name", "optimum"), [("pat1", 19), ("j301_1", 43)])
def test_published_scheduling_problems_are_solved_to_their_known_optimum(name, optimum):
    found = optimised(load(HERE / f"{name}.yaml"), EFFORT)
    assert (found.end, found.bound, found.gap) == (optimum * DAY, optimum * DAY, 0.0)


def all_orders(yard):
    """The earliest end of serial generation over all orders, one of which is optimal (Sprecher et al. 1995)."""
    from dataclasses import replace

    from heavylift.nodes.yard import serial

    n = len(yard.activities)
    return min(max(end for _, end in serial(replace(yard, plan=order))) for order in permutations(range(n)))


@pytest.mark.parametrize("seed", range(3))
def test_optimised_small_yards_end_as_early_as_the_best_of_all_activity_orders(tmp_path, seed):
    draw = random.Random(seed)
    rows = ["block,after,work [h],work r"]
    for n in range(6):
        before = " ".join(f"B{m}" for m in range(n) if draw.random() < 0.25)
        rows.append(f"B{n},{before},{draw.randint(1, 9)},{draw.randint(1, 3)}")
    yard = written(tmp_path, rows, "resources: {r: 4}\nsteps: {work: {}}")
    found = optimised(yard, EFFORT)
    assert found.end == found.bound == all_orders(yard)


@pytest.mark.parametrize("seed", range(2))
def test_an_optimised_schedule_ends_no_later_than_those_of_all_rules_and_not_before_its_bound(tmp_path, seed):
    yard = random_yard(tmp_path, seed)
    found = optimised(yard, EFFORT)
    assert found.bound <= found.end <= min(round(expected(yard, rule).delivery * 1e9) for rule in RULES)
    for (start, end), one in zip(found.spans, yard.activities, strict=True):
        assert start >= max([one.ready, *(found.spans[m][1] + lag for m, lag in one.after)])
        assert end - start == one.expected
        for resource, most in yard.capacities.items():
            at_work = [n for n, (a, b) in enumerate(found.spans) if a <= start < b]
            assert sum(x.units for n in at_work for x in yard.activities[n].needs if x.resource == resource) <= most


def test_the_optimised_schedule_respects_its_bound_with_shifts_and_a_crane_held_over_two_steps(tmp_path):
    text = """
calendar: {days: mon-fri, shifts: {day: 08:00-16:00, night: 20:00-04:00}}
resources: {crane: 1, crew: 2}
steps:
  erect: {takes: 5 h, needs: {crane: 1}, until: {crane: fit}, works: day}
  fit: {takes: 3 h, needs: {crew: 1}, after: erect, works: day}
  weld: {takes: 9 h, needs: {crew: 1}, after: fit, works: [day, night]}
"""
    yard = written(tmp_path, ["block,after", "A,", "B,A", "C,A", "D,B"], text)
    found = optimised(yard, EFFORT)
    assert 0 < found.bound <= found.end
    assert found.gap < 0.5
    for (start, end), one in zip(found.spans, yard.activities, strict=True):
        assert one.works.open(start) == start
        assert one.works.add(start, one.expected) == end


def test_times_in_combined_working_calendars_convert_to_instants_and_back():
    from datetime import date

    keys = [working(date(2027, 1, 4), (0, 1, 2, 3, 4), (shift,), ()).key for shift in ((480, 960), (900, 1740))]
    time = AnyWork(keys)
    assert time.until(DAY) == 16 * 60 * MINUTE  # 08:00 to midnight; the rest belongs to the next day
    for worked in range(0, 3 * DAY, 7 * 60 * MINUTE):
        assert time.until(time.instant(worked)) == worked
