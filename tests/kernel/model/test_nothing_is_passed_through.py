"""Fast and thin things touch at the default step control instead of passing through each other."""

from math import sqrt

import pytest
from contact_scenes import STILL, ball, brick, floating
from heavylift.kernel.description import Ball, Box, Contact, Joint, System
from small_scenes import SECOND, G, started, times

NANOSECOND = 2e-9  # [s] event times are rounded up


def bar(size):
    return brick("bar", size, 1.0), Joint("post", "fixed", "world", "bar")


@pytest.mark.parametrize("height", [0.3, 1.0, 1.7, 5.0])
@pytest.mark.large
def test_a_falling_rod_does_not_pass_through_a_crossing_bar(height):
    along, across = (0.1, 4.0, 0.1), (4.0, 0.1, 0.1)
    body, post = bar(across)
    pair = Contact("pair", Box("rod", along), Box("bar", across), 0.3)
    rod = floating("rod", (0.0, 0.0, height + 0.1))
    s = started(System((body, brick("rod", along, 5.0)), (post, rod), contacts=(pair,), gravity=G))
    s.interrupt(2 * SECOND)
    assert times(s, "pair", "impact")[0] == pytest.approx(sqrt(2.0 * height / G), abs=NANOSECOND)
    assert s.state[2] == pytest.approx(0.1, abs=1e-8)


@pytest.mark.parametrize("speed", [2.0, 8.0, 50.0])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_fast_ball_does_not_pass_through_a_thin_wall(speed, method):
    size = (0.05, 2.0, 2.0)
    body, post = bar(size)
    thrown, joint = ball("ball", 0.1, 1.0, (-3.0, 0.1, 0.2), (speed, *STILL[1:]))
    pair = Contact("pair", Ball("ball", radius=0.1), Box("bar", size), 0.0, 0.5)
    s = started(System((body, thrown), (post, joint), contacts=(pair,), gravity=0.0), method=method)
    s.interrupt(3 * SECOND)
    assert times(s, "pair", "impact") == pytest.approx([(3.0 - 0.125) / speed], abs=NANOSECOND)
    assert s.state[0] < -0.125


def test_two_fast_balls_do_not_pass_through_each_other():
    balls = [ball(n, 0.05, 1.0, (x, 0.0, 0.0), (v, *STILL[1:])) for n, x, v in (("a", -4.0, 9.0), ("b", 3.0, -9.0))]
    pair = Contact("pair", Ball("a", radius=0.05), Ball("b", radius=0.05), 0.0, 1.0)
    s = started(System(tuple(b for b, _ in balls), tuple(j for _, j in balls), contacts=(pair,), gravity=0.0))
    s.interrupt(SECOND)
    assert times(s, "pair", "impact") == pytest.approx([6.9 / 18.0], abs=NANOSECOND)


@pytest.mark.parametrize("method", ["rk4", "semi-implicit-euler", "radau5"])
@pytest.mark.parametrize(("speed", "blind"), [(0.5, False), (50.0, True)])
def test_a_fixed_step_reports_the_speed_at_which_a_body_could_pass_through_a_wall(method, speed, blind):
    """Half extents of 0.125 m in steps of 0.02 s: 6.25 m/s, and more while the wall is far."""
    size = (0.05, 2.0, 2.0)
    body, post = bar(size)
    thrown, joint = ball("ball", 0.1, 1.0, (-3.0, 0.1, 0.2), (speed, *STILL[1:]))
    pair = Contact("pair", Ball("ball", radius=0.1), Box("bar", size), 0.0, 0.5)
    system = System((body, thrown), (post, joint), contacts=(pair,), gravity=0.0)
    whole, cut = (started(system, method=method, step=0.02) for _ in range(2))
    whole.run(SECOND // 10)
    for n in range(1, 11):
        cut.run(n * SECOND // 100)
    assert whole.notes == cut.notes
    assert len(whole.notes) == blind
    for note in whole.notes:
        assert note.sentence.startswith(f"step 0.02 s at {note.t_ns * 1e-9:.3f} s: what moves so fast can pass through")
        assert note.t_ns * 1e-9 < 3.0 / speed, "before it gets there"
