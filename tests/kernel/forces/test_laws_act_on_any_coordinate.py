"""Springs, stops, brakes, drives and thresholds act on each coordinate of a joint by its name."""

import numpy as np
import pytest
from heavylift.kernel.description import (  # fmt: skip
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Master,
    Measured,
    Stop,
    System,
    Threshold,
)
from small_scenes import SECOND, G, X, Z, column, events, hand_over, imbalance, started, times

M, I = 200.0, 50.0
BODY = Body("a", M, inertia=((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
NANOSECOND = 1e-9  # [s] to which an event is located
INTEGRATED = 1e-7  # relative, at a step tolerance of 1e-9


def one(kind, v0, gravity=0.0, **laws):
    """A body on one joint about and along z."""
    joint = Joint("j", kind, "world", "a", axis=Z, second=X, v0=v0, pitch=0.2 if kind == "screw" else 0.0)
    return System((BODY,), (joint,), gravity=gravity, **laws)


def run(system, seconds=2, **options):
    s = started(system, tolerance=1e-9, sample_ns=SECOND // 50, **options)
    hand_over(s, seconds * SECOND)
    s.settle()
    return s


def test_each_coordinate_of_a_cylindrical_joint_has_its_own_force_laws():
    """Sliding decays under viscous damping while turning meets dry friction: v exp(-d t/m); stops after w I/M."""
    system = one(
        "cylindrical",
        (0.5, 2.0),
        springs=(JointSpring("oil", "j", d=100.0, coordinate="travel"),),
        brakes=(Brake("lining", "j", 80.0, 1e7, 4e4, engaged=True, coordinate="angle"),),
        thresholds=(Threshold("half-turn", "joint", of="j", coordinate="angle"),),
    )
    s = run(system)
    v = column(s, "joint/velocity")[1][-1]
    assert v[0] == pytest.approx(0.5 * np.exp(-100.0 * 2.0 / M), rel=INTEGRATED)
    assert times(s, "lining", "stick") == [pytest.approx(2.0 * I / 80.0, abs=2e-3)]  # and the spring's own swing
    assert v[1] == pytest.approx(0.0, abs=1e-6)
    assert imbalance(s) < INTEGRATED


def test_an_end_stop_and_a_threshold_act_on_one_coordinate_of_a_planar_joint():
    system = one(
        "planar",
        (1.0, -0.5, 0.7),
        stops=(Stop("fence", "j", -9.0, 0.25, 1e6, 0.0, coordinate="x"),),
        thresholds=(Threshold("line", "joint", of="j", coordinate="y"),),
    )
    s = started(system, tolerance=1e-9)
    s.switches.watch("line", -0.75, rising=False)
    s.settle()
    hand_over(s, 2 * SECOND)
    s.settle()
    assert events(s) == [("fence", "closed"), ("fence", "open"), ("line", "reached")]
    assert times(s, "fence", "closed") == [pytest.approx(0.25, abs=2 * NANOSECOND)]
    assert times(s, "fence", "open") == [pytest.approx(0.25 + np.pi * np.sqrt(M / 1e6), abs=1e-8)]
    assert times(s, "line", "reached") == [pytest.approx(1.5, abs=2 * NANOSECOND)]
    assert column(s, "joint/velocity")[1][-1] == pytest.approx([-1.0, -0.5, 0.7], rel=INTEGRATED)


@pytest.mark.parametrize(("kind", "coordinate"), [("screw", "angle"), ("planar", "angle"), ("cylindrical", "angle")])
def test_any_joint_coordinate_can_be_prescribed(kind, coordinate):
    """Rheonomic: turned by 90 deg; the other freedoms keep their motion, the drive's work closes the balance."""
    n = {"screw": 1, "planar": 3, "cylindrical": 2}[kind]
    v0 = (0.3,) * (n - 1) + (0.0,)
    s = started(
        one(kind, v0, gravity=G, drives=(Drive("motor", "j", "prescribed", coordinate=coordinate),)),
        tolerance=1e-9,
        sample_ns=SECOND // 50,
    )
    s.references.set_profile("motor", 0, 1.0, 2.0, np.pi / 2)
    s.settle()
    hand_over(s, 3 * SECOND)
    s.settle()
    q, v = column(s, "joint/position")[1][-1], column(s, "joint/velocity")[1][-1]
    assert q[-1] == pytest.approx(np.pi / 2, rel=1e-12)
    assert v[-1] == pytest.approx(0.0, abs=1e-12)
    assert imbalance(s) < INTEGRATED
    if kind == "planar":
        assert q[:2] == pytest.approx([0.9, 0.9], rel=1e-12)
    if kind == "screw":  # the motor lifts the weight
        work = column(s, "account")[1][-1, -1]
        assert work == pytest.approx(M * G * 0.2 * np.pi / 2, rel=INTEGRATED)


def test_a_servo_follows_a_measured_coordinate_of_another_joint():
    """One coordinate of a universal joint is measured; a servo turns the other one by minus twice as much."""
    joint = Joint("j", "universal", "world", "a", axis=Z, second=X, v0=(0.2, 0.0))
    system = System(
        (BODY,),
        (joint,),
        drives=(Drive("servo", "j", "servo", 1e6, 2e4, coordinate="angle2"),),
        measured=(Measured("first", "joint", "j", coordinate="angle1"),),
        masters=(Master("unused"),),
        gravity=0.0,
    )
    s = started(system, tolerance=1e-9)
    s.set_follow("servo", "first", (-2.0, 0.0, 0.0))
    s.settle()
    hand_over(s, SECOND)
    s.settle()
    q = column(s, "joint/position")[1][-1]
    assert q[0] > 0.1
    assert q[1] == pytest.approx(-2.0 * q[0], rel=2e-2)
