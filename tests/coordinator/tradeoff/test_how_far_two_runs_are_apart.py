"""The error of each quantity, of motions that are known."""

from math import inf

import pytest
from heavylift.coordinator.tradeoff import askable, default_limit, errors, farthest
from heavylift.nodes.scene import load
from measured_rows import swinging

TRUE = swinging(0.1, 0.5)
FIT = 1e-6  # a sinusoid found in samples of 0.1 s
ALL = ("rope tension", "swing", "position", "lift-off time")


def test_a_run_is_right_beside_itself():
    assert errors(TRUE, TRUE, ALL) == dict.fromkeys(ALL, 0.0)
    assert farthest(TRUE, TRUE) == 0.0


def test_a_peak_counts_relative_to_the_true_one():
    assert errors(swinging(0.1, 0.5, peak=2.1e5), TRUE, ("rope tension",)) == {"rope tension": pytest.approx(0.05)}


def test_a_sample_above_the_true_peak_is_an_error_though_the_peak_is_right():
    overshooting = swinging(0.1, 0.5)
    overshooting.tension[100] = 2.5e5
    assert errors(overshooting, TRUE, ("rope tension",)) == {"rope tension": pytest.approx(0.25)}


def test_a_swing_is_judged_by_its_frequency_and_by_its_amplitude():
    assert errors(swinging(0.102, 0.5), TRUE, ("swing",))["swing"] == pytest.approx(0.02, rel=1e-3)
    assert errors(swinging(0.1, 0.4), TRUE, ("swing",))["swing"] == pytest.approx(0.2, abs=FIT)


def test_a_later_start_is_no_error_of_the_swing_but_one_of_the_lift_off():
    late = errors(swinging(0.1, 0.5, lift_off=12.0), TRUE, ("swing", "lift-off time"))
    assert late["lift-off time"] == pytest.approx(0.2)
    assert late["swing"] < FIT


def test_a_stage_that_begins_lifted_counts_as_half_a_second_long():
    error = errors(swinging(0.1, 0.5, lift_off=0.01), swinging(0.1, 0.5, lift_off=0.0), ("lift-off time",))
    assert error["lift-off time"] == pytest.approx(0.02)


def test_places_are_compared_since_each_stage_began_and_relative_to_the_way():
    assert errors(swinging(0.1, 0.45), TRUE, ("position",))["position"] == pytest.approx(0.1, rel=1e-3)
    assert farthest(swinging(0.1, 0.45), TRUE) == pytest.approx(0.05, rel=1e-3)


def test_a_run_that_never_lifts_off_is_infinitely_wrong_about_it():
    stuck = swinging(0.1, 0.5)
    stuck.spans.clear()
    assert errors(stuck, TRUE, ("lift-off time",)) == {"lift-off time": inf}


@pytest.mark.parametrize(
    ("settings", "limit"),
    [(["ask=[swing]", "accuracy=0.3 %"], 3e-3), (["ask=[swing]", "accuracy=null"], 1e-2), (["accuracy=0.3 %"], 1e-2)],
)
def test_the_limit_is_what_the_scene_asks_for(settings, limit):
    assert default_limit(load("pendulum", settings)) == limit


def test_a_scene_that_stands_still_cannot_be_asked_for_swing():
    known = askable(swinging(0.1, 0.0))
    assert known["rope tension"] == known["lift-off time"] == ""
    assert "nothing swings" in known["swing"]
    assert "nothing in the scene moves" in known["position"]
