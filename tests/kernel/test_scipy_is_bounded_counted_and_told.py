"""SciPy's methods see thin things, count what they evaluate, and say in one sentence that they give up."""

from math import cos, sin

import pytest
from contact_scenes import STILL, ball, brick
from heavylift.kernel.description.contacts import Ball, Box, Contact
from heavylift.kernel.description.forces import Spring
from heavylift.kernel.description.mechanics import Body, Joint, Point, System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.peers import PEERS
from small_scenes import SECOND, G, X, Y, cube, hand_over, hung, started, times

NANOSECOND = 2e-9  # [s] event times are rounded up


@pytest.mark.parametrize("method", sorted(PEERS))
@pytest.mark.parametrize(("speed", "thickness"), [(4.0, 0.02), (60.0, 0.05), (120.0, 0.01)])
def test_a_ball_does_not_pass_through_a_plate(method, speed, thickness):
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


@pytest.mark.parametrize("method", sorted(PEERS))
def test_as_many_evaluations_are_counted_as_are_made(method):
    """On floats every evaluation is a call of the function that the native code calls."""
    s = started(hung(60.2), method=method, tolerance=1e-5, native=False)
    rate, made = s.method.f_rate, [0]
    evaluate = rate.body

    def evaluated(**given):
        made[0] += 1
        return evaluate(**given)

    rate.body = evaluated
    calls = s._code.call

    def located(name, *blocks):  # searches for events are not counted
        before = made[0]
        calls(name, *blocks)
        if name not in ("advance", "step"):
            made[0] = before

    s._code.call = located
    before = s.evaluations
    s.run(SECOND // 4)
    assert made[0] == s.evaluations - before > 20


@pytest.mark.parametrize("angle", [0.3, 1.1])
def test_a_spring_that_is_too_stiff_is_refused_by_name(angle):
    """A bob on a spring of 1e12 N/m: Radau's matrix is no longer finite."""
    spring = Spring("rod", Point("world"), Point("bob"), 1.0, 1e12)
    joint = Joint("plane", "planar", "world", "bob", axis=Y, second=X, q0=(sin(angle), cos(angle), 0.0))
    system = System((Body("bob", 1.0, inertia=cube(1.0)),), (joint,), forces=(spring,), gravity=G)
    s = started(system, method="scipy-radau", tolerance=1e-7)
    with pytest.raises(KernelError, match=r"^run at \d\.\d+ s: method 'scipy-radau' gives up \(.*\); 'bob' on 'rod'"):
        hand_over(s, SECOND)
