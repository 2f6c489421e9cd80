"""Actuators that follow a commanded or a measured master: f(s) sent once, no jump at any command."""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest
from heavylift.kernel.description import Body, Drive, Joint, JointSpring, Line, Master, Measured, Point, Rope, System
from small_scenes import EA, SECOND, G, X, cube, hand_over, hung, slider, started

FINE = {"tolerance": 1e-11, "h_max": 0.01}
SAME = 1e-12  # [m]


def turn(t):
    """The master's profile: up to 10 degrees per second within two seconds, then on."""
    return radians(5.0) * t * t / 2 if t < 2.0 else radians(10.0) * (t - 1.0)


def test_a_winch_and_a_trolley_follow_the_ordered_angle_of_a_block():
    scene = replace(
        hung(60.1, winch=True, damping=1e6),
        bodies=(Body("load", 4.5e5), Body("trolley", 1e5)),
        joints=(*hung(60.1).joints, Joint("rail", "prismatic", "world", "trolley", axis=X)),
        drives=(Drive("drive", "rail", "prescribed"),),
        masters=(Master("theta", 0.3),),
    )
    s = started(scene, **FINE)
    hand_over(s, SECOND)
    s.set_follow("rope", "theta", (0.5, 2.0, -3.0))
    s.set_follow("drive", "theta", (0.0, 14.6, 12.0))
    s.settle()
    row = s.row()
    assert (row.length[0], row.q[1]) == pytest.approx((60.0, 0.0), abs=SAME), "no jump when it is sent"
    s.references.set_profile("theta", SECOND, radians(10.0), radians(5.0), None)
    s.settle()
    for t in (1.5, 3.0, 4.25):
        hand_over(s, round(t * SECOND))
        s.settle()
        row, a = s.row(), 0.3 + turn(t - 1.0)
        assert row.length[0] == pytest.approx(
            60.0 + 0.5 * (a - 0.3) + 2.0 * (cos(a) - cos(0.3)) - 3.0 * (sin(a) - sin(0.3)), abs=SAME
        )
        assert row.q[1] == pytest.approx(14.6 * (cos(a) - cos(0.3)) + 12.0 * (sin(a) - sin(0.3)), abs=SAME)
        rate = min(t - 1.0, 2.0) * radians(5.0)
        assert row.v[1] == pytest.approx((-14.6 * sin(a) + 12.0 * cos(a)) * rate, abs=SAME)
        assert row.length_rate[0] == pytest.approx((0.5 - 2.0 * sin(a) - 3.0 * cos(a)) * rate, abs=SAME)


def test_a_trolley_that_follows_a_turn_accelerates_by_the_second_derivative_of_its_law():
    """A pendulum below it feels the acceleration: compared with central differences of the speed."""
    scene = System(
        (Body("trolley", 1e5), Body("bob", 1e4, (0.0, 0.0, -30.0), cube(1e4))),
        (
            Joint("rail", "prismatic", "world", "trolley", axis=X),
            Joint("hinge", "revolute", "trolley", "bob", axis=(0.0, 1.0, 0.0)),
        ),
        drives=(Drive("drive", "rail", "prescribed"),),
        masters=(Master("theta", 0.2),),
        gravity=G,
    )
    s = started(scene, **FINE)
    s.set_follow("drive", "theta", (1.0, 14.6, 12.0))
    s.references.set_profile("theta", 0, 0.2, 0.1, 3.0)
    s.settle()
    speeds, accelerations = [], []
    for i in range(-1, 2):
        hand_over(s, SECOND + i * 1_000_000)
        s.settle()
        speeds.append(float(s.row().v[0]))
        accelerations.append(float(s.X[s.method.layout.at["f"]][s.program.nq]))
    assert accelerations[1] == pytest.approx((speeds[2] - speeds[0]) / 2e-3, rel=1e-6)


def test_commands_to_an_actuator_that_follows_a_master_cause_no_jump():
    """New coefficients, an own move on top, another law, release: the length never jumps and holds at the end."""
    s = started(replace(hung(60.1, winch=True, damping=1e6), masters=(Master("a"), Master("b", 0.5))), **FINE)
    s.references.set_profile("a", 0, 0.1, 0.05, None)
    s.references.set_profile("b", 0, -0.2, 0.05, None)
    s.settle()
    commands = [
        (1, lambda: s.set_follow("rope", "a", (1.0, 0.0, 0.0))),
        (2, lambda: s.references.set_profile("rope", s.epoch, 0.3, 0.1, 1.0)),
        (3, lambda: s.set_follow("rope", "b", (0.2, 1.0, 1.0))),
        (4, lambda: s.references.set_profile("rope", s.epoch, 0.0, 0.2, None)),
        (5, lambda: s.set_follow("rope", "a", (-1.0, 2.0, 0.0))),
        (6, lambda: s.set_follow("rope", "", (0.0, 0.0, 0.0))),
    ]
    for t, command in commands:
        hand_over(s, t * SECOND)
        before = float(s.row().length[0])
        command()
        s.settle()
        assert float(s.row().length[0]) == pytest.approx(before, abs=SAME)
    held = float(s.row().length[0])
    hand_over(s, 9 * SECOND)
    assert float(s.row().length[0]) == held


def measuring(kind):
    """A wheel turns; a winch elsewhere follows its measured angle."""
    measured = Measured("angle", kind, "axle" if kind == "joint" else "wheel")
    lower = hung(60.1, winch=True, damping=1e6)
    wheel = Joint("axle", "revolute", "world", "wheel", axis=(-1.0, 0.0, 0.0), q0=(0.4,), v0=(0.05,))
    return replace(
        lower,
        bodies=(*lower.bodies, Body("wheel", 0.0, inertia=cube(6.0))),
        joints=(*lower.joints, wheel),
        springs=(JointSpring("spring", "axle", 0.5),),
        measured=(measured,),
    )


@pytest.mark.parametrize("kind", ["joint", "angle"])
def test_a_winch_follows_a_measured_angle(kind):
    s = started(measuring(kind), **FINE)
    hand_over(s, SECOND)
    angle = float(s.row().q[1])
    s.set_follow("rope", "angle", (0.2, 1.5, -0.7))
    s.settle()
    assert float(s.row().length[0]) == pytest.approx(60.0, abs=SAME)
    f = lambda a: 0.2 * a + 1.5 * cos(a) - 0.7 * sin(a)  # noqa: E731
    for t in (2, 5, 8):
        hand_over(s, t * SECOND)
        s.settle()
        row = s.row()
        a, w = float(row.q[1]), float(row.v[1])
        assert float(row.length[0]) == pytest.approx(60.0 + f(a) - f(angle), abs=SAME)
        assert float(row.length_rate[0]) == pytest.approx((0.2 - 1.5 * sin(a) - 0.7 * cos(a)) * w, abs=SAME)
    assert abs(a - angle) > 0.05, "the wheel has turned"


def test_a_sling_hooked_with_a_new_length_no_longer_follows_its_former_master_drive():
    scene = replace(slider(q0=-10.0), masters=(Master("m", 1.0),))
    line = Line(Point("world"), Point("load"))
    scene = replace(scene, ropes=(Rope("sling", (line,), EA, 20.0, winch=True, hooked=False),))
    s = started(scene, **FINE)
    s.set_follow("sling", "m", (3.0, 0.0, 0.0))
    s.hook("sling", L0=12.0)
    s.references.set_profile("m", 0, 1.0, 1.0, 2.0)
    s.settle()
    s.run(SECOND // 2)
    hand_over(s, SECOND // 2)
    assert float(s.row().length[0]) == 12.0
    assert np.isfinite(s.state).all()
