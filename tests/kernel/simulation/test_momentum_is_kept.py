"""Bodies without external forces conserve linear and angular momentum."""

import numpy as np
import pytest
from heavylift.kernel.analysis import momentum
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from small_scenes import SECOND, G, X, Y, Z, cube, hand_over, started

KEPT = 1e-9  # relative, over ten seconds at a tolerance of 1e-11


def satellite() -> System:
    """A hub with an arm of two hinges, a ball joint and a slider, all of it in motion."""
    bodies = (
        Body("hub", 100.0, (0.1, 0.0, 0.0), cube(100.0)),
        Body("arm", 20.0, (1.0, 0.1, 0.0), cube(20.0)),
        Body("hand", 5.0, (0.0, 0.2, 0.1), cube(5.0)),
        Body("antenna", 8.0, (0.0, 0.0, 1.0), cube(8.0)),
        Body("weight", 3.0),
    )
    joints = (
        Joint("drift", "free", "world", "hub", v0=(0.1, 0.2, -0.1, 0.2, -0.3, 0.1)),
        Joint("shoulder", "revolute", "hub", "arm", (1.0, 0.0, 0.0), axis=Y, v0=(0.5,)),
        Joint("wrist", "revolute", "arm", "hand", (2.0, 0.0, 0.0), axis=X, v0=(-1.0,)),
        Joint("ball", "spherical", "hub", "antenna", (0.0, 1.0, 0.0), v0=(0.3, -0.2, 0.4)),
        Joint("slide", "prismatic", "hub", "weight", (0.0, -1.0, 0.0), axis=Z, v0=(0.05,)),
    )
    return System(bodies, joints, gravity=0.0)


def test_a_floating_mechanism_conserves_linear_and_angular_momentum():
    simulation = started(satellite(), tolerance=1e-11)
    before = momentum(simulation)
    hand_over(simulation, 10 * SECOND)
    after = momentum(simulation)
    assert after.linear == pytest.approx(before.linear, abs=KEPT * np.linalg.norm(before.linear))
    assert after.angular == pytest.approx(before.angular, abs=KEPT * np.linalg.norm(before.angular))
    assert after.centre == pytest.approx(before.centre + 10.0 * before.linear / before.mass, rel=1e-8, abs=1e-8)
    assert after.spin == pytest.approx(before.spin, abs=10 * KEPT * np.linalg.norm(before.angular))


def test_two_bodies_on_a_rope_conserve_their_common_momentum():
    bodies = tuple(Body(name, m, inertia=cube(m)) for name, m in (("a", 100.0), ("b", 300.0)))
    joints = (
        Joint("a-free", "free", "world", "a", v0=(0.0, 1.0, 0.0, 0.0, 0.0, 0.5)),
        Joint("b-free", "free", "world", "b", (10.0, 0.0, 0.0), v0=(0.5, 0.0, 0.0, 0.0, 0.2, 0.0)),
    )
    rope = Rope("rope", (Line(Point("a", (1.0, 0.0, 0.5)), Point("b", (-1.0, 0.0, 0.0))),), 1e4, 8.0)
    simulation = started(System(bodies, joints, ropes=(rope,), gravity=0.0), tolerance=1e-11)
    before = momentum(simulation)
    hand_over(simulation, 20 * SECOND)
    after = momentum(simulation)
    assert [e.what for _, e in simulation.log]  # it has been taut and slack
    assert after.linear == pytest.approx(before.linear, abs=KEPT * np.linalg.norm(before.linear))
    assert after.angular == pytest.approx(before.angular, abs=KEPT * np.linalg.norm(before.angular))


def test_a_pendulum_on_a_free_trolley_conserves_momentum_along_the_rail():
    bodies = (Body("trolley", 4e5), Body("load", 4.5e5, (0.0, 0.0, -50.0)))
    joints = (
        Joint("rail", "prismatic", "world", "trolley", axis=X, v0=(0.2,)),
        Joint("pivot", "revolute", "trolley", "load", axis=Y, q0=(0.3,), v0=(-0.05,)),
    )
    simulation = started(System(bodies, joints, gravity=G), tolerance=1e-11)
    before = momentum(simulation)
    hand_over(simulation, 10 * SECOND)
    after = momentum(simulation)
    assert after.linear[0] == pytest.approx(before.linear[0], rel=KEPT)
    assert abs(after.linear[2] - before.linear[2]) > 1e-3 * abs(before.linear[0])  # the rail does push upwards
