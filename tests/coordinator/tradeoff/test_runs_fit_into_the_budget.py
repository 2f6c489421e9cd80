"""The cheapest run is next, its time is predicted from what was measured, and nothing is begun that does not fit."""

import re

import pytest
from heavylift.coordinator.tradeoff import Planner, Rung, too_small

RUNG = Rung("as written", None)
LIMIT = 0.01


def test_steps_cost_in_proportion_and_tolerances_by_the_order():
    fixed, adaptive = (Planner([RUNG], [method], LIMIT) for method in ("rk4", "dopri5"))
    for planner in (fixed, adaptive):
        first, _ = planner.next(1.0)
        planner.tell(first, prepared=0.5, seconds=2.0, worst=0.5)
    following, predicted = fixed.next(100.0)
    assert (following.how, predicted) == ("20 ms", 0.5 + 2.0 * 2.5)
    following, predicted = adaptive.next(100.0)
    assert (following.how, predicted) == ("1e-4", 0.5 + 2.0 * 10.0**0.2)


def test_what_does_not_fit_is_left_out_and_counted():
    planner = Planner([RUNG], ["rk4"], LIMIT)
    first, _ = planner.next(1.0)
    planner.tell(first, prepared=0.0, seconds=2.0, worst=0.5)
    assert planner.next(4.9) is None
    assert planner.left == 5


def test_the_cheapest_of_all_chains_is_next():
    planner = Planner([RUNG], ["rk4", "dopri5"], LIMIT)
    for seconds in (3.0, 1.0):
        setting, _ = planner.next(100.0)
        planner.tell(setting, prepared=0.0, seconds=seconds, worst=0.5)
    assert planner.next(100.0)[0].method == "dopri5"


def test_a_method_whose_error_no_longer_changes_is_not_run_tighter():
    planner = Planner([RUNG], ["dopri5"], LIMIT)
    for worst in (0.30, 0.301):
        planner.tell(planner.next(100.0)[0], 0.0, 1.0, worst)
    assert planner.next(100.0) is None
    assert (planner.left, planner.settled) == (0, 4)


def test_a_method_that_fails_at_two_tolerances_is_given_up():
    planner = Planner([RUNG], ["dop853"], LIMIT)
    for how in ("1e-3", "1e-4"):
        setting, _ = planner.next(100.0)
        assert setting.how == how
        planner.tell(setting, 0.0, 0.1, None)
    assert planner.next(100.0) is None


def test_an_unstable_step_is_followed_by_a_shorter_one_and_a_run_that_was_cut_is_not():
    planner = Planner([RUNG], ["rk4"], LIMIT)
    planner.tell(planner.next(100.0)[0], 0.0, 0.1, None)
    assert planner.next(100.0)[0].how == "20 ms"
    planner.tell(planner.next(100.0)[0], 0.0, 10.0, None, cut=True)
    assert planner.next(100.0) is None


@pytest.mark.parametrize(
    ("needed", "asked"), [(0.31, "0.35"), (1.0, "1.1"), (60.4, "67"), (99.5, "110"), (123.0, "140")]
)
def test_a_budget_that_is_asked_for_is_more_than_is_needed(needed, asked):
    found = re.search(r"give it (\S+) s or more", str(too_small(0.1, "so it is", needed)))
    assert found is not None
    assert found[1] == asked
