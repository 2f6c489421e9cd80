"""A load leaves the ground when the rope tension equals its weight, and bounces by a known factor."""

import pytest
from chain import CLOSED_FORMS, channel, happenings, near, play, the_only
from heavylift.recordings import Recording
from load_on_a_rope import SETTLED, WEIGHT, Rope, winding_time

FORM = CLOSED_FORMS["C07a"]["expected"]
LIFT_OFF = 1e-6  # [s] of the winch law
TAUT = 2e-9  # [s] events are reported on the next nanosecond
CONSTANT_STIFFNESS = 3e-3  # of the time that a rope of constant stiffness takes
FACTOR = 1e-3  # of the dynamic factor

ROPE = Rope()
SLACK, SPEED, RAMP = 0.01, 0.05, 1.0


@pytest.fixture(scope="module")
def pick_up(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A load on its pad, a rope with 10 mm of slack, and six seconds of hoisting."""
    scene = ROPE.scene(samples=500, end=6, z=-SETTLED, length=ROPE.height + SLACK, ramp=RAMP)
    return play(tmp_path_factory.mktemp("pick-up"), scene + "actions:\n  - rope: hoist 0.05 m/s by 5 m\n")


def test_a_load_lifts_off_when_its_rope_tension_equals_its_weight(pick_up: Recording) -> None:
    taut = winding_time(SLACK, SPEED, RAMP)
    assert the_only(happenings(pick_up, "taut")).t == pytest.approx(taut - SETTLED / SPEED, abs=TAUT)

    stretched = (ROPE.height - ROPE.carrying) / SPEED
    assert the_only(happenings(pick_up, "open", "ground")).t == pytest.approx(taut + stretched, abs=LIFT_OFF)
    assert near(stretched, FORM["t_lift"], CONSTANT_STIFFNESS)


def test_the_peak_tension_of_a_fast_lift_off_follows_the_closed_form_of_the_hoisting_factor(pick_up: Recording) -> None:
    _, tension = channel(pick_up, "rope/tension")
    _, peak = channel(pick_up, "rope/peak")

    assert near(tension.max() / WEIGHT, FORM["phi"], FACTOR)
    assert near(peak.max() / WEIGHT, FORM["phi"], FACTOR)
    assert tension.min() == 0.0
    assert happenings(pick_up, "slack") == []
