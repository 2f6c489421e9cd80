"""Steps of SciPy's integrators are bounded so that fast bodies do not miss thin ones."""

import pytest
from contact_scenes import STILL, ball, brick
from heavylift.kernel.description import Ball, Box, Contact, Joint, System
from scipy_peers import PEERS
from small_scenes import SECOND, hand_over, started, times

NANOSECOND = 2e-9  # [s] event times are rounded up


@pytest.mark.parametrize("method", sorted(PEERS))
@pytest.mark.parametrize(("speed", "thickness"), [(4.0, 0.02), (60.0, 0.05), (120.0, 0.01)])
@pytest.mark.large(beyond=4)
def test_scipy_steps_are_bounded_so_that_a_ball_does_not_pass_through_a_plate(method, speed, thickness):
    """With the longest steps of 0.1 s it would be behind the plate before anything is looked at."""
    size = (thickness, 2.0, 2.0)
    thrown, joint = ball("ball", 0.1, 1.0, (-3.0, 0.1, 0.2), (speed, *STILL[1:]))
    post = Joint("post", "fixed", "world", "plate")
    pair = Contact("pair", Ball("ball", radius=0.1), Box("plate", size), 0.0, 0.5)
    bodies = (brick("plate", size, 1.0), thrown)
    s = started(System(bodies, (post, joint), contacts=(pair,), gravity=0.0), method=method)
    hand_over(s, round(3.2 / speed * SECOND))
    assert times(s, "pair", "impact") == pytest.approx([(3.0 - 0.1 - thickness / 2) / speed], abs=NANOSECOND)
    assert s.state[0] < -0.1
