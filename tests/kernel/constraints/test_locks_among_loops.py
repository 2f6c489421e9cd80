"""Joints locked in motion beside loops, dampers and rigid ropes: the lost energy is accounted for."""

import numpy as np
import pytest
from heavylift.kernel.description import WORLD, Body, Joint, JointSpring, Line, Lock, Point, RigidRope, System
from linkages import rod
from small_scenes import SECOND, Y, Z, column, events, hand_over, imbalance, started

BALANCED = 1e-8  # of the energy turned over, at tolerance 1e-11
BOOKED = 1e-9


def five_bar(**parts):
    """Two cranks, 1.2 m apart, and two couplers that meet: two freedoms; a damper at the left foot, a lock at both."""
    bodies = tuple(rod(name, mass=4.0) for name in ("left", "right", "bar", "rest"))
    joints = (
        Joint("left foot", "revolute", WORLD, "left", axis=Y, q0=(-0.4,), v0=(1.5,)),
        Joint("right foot", "revolute", WORLD, "right", (1.2, 0.0, 0.0), axis=Y, q0=(0.5,), v0=(-1.0,)),
        Joint("knee", "revolute", "left", "bar", Z, axis=Y, q0=(1.2,), v0=(-0.5,)),
        Joint("other knee", "revolute", "right", "rest", Z, axis=Y, q0=(-1.3,), v0=(0.5,)),
        Joint("meet", "revolute", "bar", "rest", Z, axis=Y, p_CJ=Z),
    )
    springs = (JointSpring("damper", "left foot", k=5.0, d=0.4),)
    locks = (Lock("bolt", "left foot"), Lock("pin", "right foot"))
    return System(bodies, joints, springs, locks=locks, **parts)


def test_a_five_bar_linkage_with_one_locked_crank_can_still_move():
    s = started(five_bar(), tolerance=1e-11, sample_ns=SECOND // 20)
    assert [j.name for j in s.program.graph.loops] == ["meet"]
    hand_over(s, SECOND // 2)
    before = s.row().kinetic
    event = s.set_lock("bolt", True)
    after = s.row()
    assert 0.01 * before < event.value < 0.99 * before
    assert event.value == pytest.approx(before - after.kinetic, rel=BOOKED)
    assert after.v[s.program.graph.joint("left foot").v] == 0.0
    assert np.abs(after.v[s.program.graph.joint("right foot").v]) > 0.01
    s.settle()
    hand_over(s, SECOND)
    s.set_lock("pin", True)  # nothing is left to move
    s.settle()
    hand_over(s, 2 * SECOND)
    s.set_lock("bolt", False)
    s.set_lock("pin", False)
    s.settle()
    hand_over(s, 3 * SECOND)
    s.settle()
    assert s.row().kinetic > 0.1
    assert imbalance(s) < BALANCED


def test_a_locked_carriage_lets_the_load_swing_on_its_rigid_rope():
    """The carriage that it stops carries a load on a taut rope, whose swing goes on."""
    bodies = (Body("carriage", 100.0), Body("sheave", 0.0), Body("load", 40.0))
    joints = (
        Joint("rail", "prismatic", WORLD, "carriage", axis=(1.0, 0.0, 0.0), v0=(2.0,)),
        Joint("x", "prismatic", WORLD, "sheave", axis=(1.0, 0.0, 0.0), v0=(2.0,)),
        Joint("z", "prismatic", "sheave", "load", axis=Z, q0=(-5.0,)),
    )
    rope = RigidRope("rope", (Line(Point("carriage"), Point("load")),), 5.0)
    system = System(bodies, joints, locks=(Lock("bolt", "rail"),), rigid_ropes=(rope,))
    s = started(system, tolerance=1e-11, sample_ns=SECOND // 20)
    hand_over(s, SECOND // 2)
    event = s.set_lock("bolt", True)
    assert event.value == pytest.approx(0.5 * 100.0 * 2.0**2, rel=BOOKED), "the load hangs plumb and goes on"
    s.settle()
    hand_over(s, 2 * SECOND)
    s.set_lock("bolt", False)
    s.settle()
    hand_over(s, 3 * SECOND)
    s.settle()
    assert events(s) == [("bolt", "locked"), ("bolt", "freed")]
    assert np.ptp(column(s, "joint/position")[1][:, 2]) > 0.1
    assert imbalance(s) < BALANCED
