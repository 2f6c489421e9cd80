"""Rigid ropes and contacts in one scene: a hanging crate swings against a wall, is set down and lifted again."""

from dataclasses import replace
from math import cos, radians, sin, sqrt, tan

import pytest
from contact_scenes import brick, floating
from heavylift.kernel.description import (
    WORLD,
    Ball,
    Body,
    Box,
    Contact,
    Joint,
    Line,
    Lock,
    Plane,
    Point,
    RigidRope,
    System,
)
from small_scenes import SECOND, G, X, Z, column, events, hand_over, imbalance, started, times

FINE = {"tolerance": 1e-10, "sample_ns": 20_000_000}
EXACT = 1e-7  # against closed forms, at tolerance 1e-10
BALANCE = 1e-6  # places are brought back to the surface at a touch, by what a nanosecond of motion is
MASS, L, RADIUS, LEFT = 50.0, 4.0, 0.5, radians(60)


def against_a_wall(angle, restitution):
    """A ball on a rope of 4 m, let go 60 degrees to the left; a wall meets it at `angle` from the plumb line."""
    x, z = -L * sin(LEFT), -L * cos(LEFT)
    slides = (
        Joint("x", "prismatic", WORLD, "carrier", axis=X, q0=(x,)),
        Joint("z", "prismatic", "carrier", "load", axis=Z, q0=(z,)),
    )
    at = (L * sin(angle) + RADIUS, 0.0, 0.0)
    wall = Contact("wall", Ball("load", radius=RADIUS), Plane(p=at, normal=(-1.0, 0.0, 0.0)), 0.0, restitution)
    rope = RigidRope("rope", (Line(Point(WORLD), Point("load")),), L)
    return System((Body("carrier", 0.0), Body("load", MASS)), slides, rigid_ropes=(rope,), contacts=(wall,), gravity=G)


def speed_at(angle):
    return sqrt(2.0 * G * L * (cos(angle) - cos(LEFT)))


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_load_falling_past_a_wall_is_stopped_by_rope_and_wall_together(e):
    """Both directions end the motion together: p_wall = (1 + e) m v / cos, p_rope = (1 + e) m v tan; back with e v."""
    angle = -radians(30)
    s = started(against_a_wall(angle, e), **FINE)
    s.run(SECOND)
    hit = s.log[0][1]
    v = speed_at(angle)
    assert (hit.name, hit.what) == ("wall", "impact")
    assert hit.value == pytest.approx((1.0 + e) * MASS * v / cos(angle), rel=EXACT)
    assert "rope" not in {name for name, _ in events(s)}, "taut throughout"
    hand_over(s, SECOND + SECOND // 10)
    assert imbalance(s) < BALANCE
    if e == 0.0:
        assert events(s) == [("wall", "impact"), ("wall", "closed")]
        assert column(s, "contact/force")[1][-1, 0] == pytest.approx(MASS * G * tan(-angle), rel=EXACT)
        assert column(s, "rope/tension")[1][-1, 0] == pytest.approx(MASS * G / cos(angle), rel=EXACT)


def test_a_load_rising_into_a_wall_is_stopped_by_the_wall_and_its_rope_goes_slack():
    angle = radians(30)
    s = started(against_a_wall(angle, 0.0), **FINE)
    s.run(11 * SECOND // 5)
    v = speed_at(angle)
    hit, slack = s.log[0][1], s.log[1][1]
    assert (hit.name, hit.what, hit.value) == ("wall", "impact", pytest.approx(MASS * v * cos(angle), rel=EXACT))
    assert (slack.name, slack.what) == ("rope", "slack")
    taut = times(s, "rope", "taut")[0]
    assert taut - s.log[1][0] * 1e-9 == pytest.approx(2.0 * v * sin(angle) / G, abs=1e-6), "up along the wall, and back"
    assert imbalance(s) < BALANCE


def crate(height, **rope):
    """A crate on a plumb winch rope, its underside so high above the ground."""
    size = (1.0, 1.0, 1.0)
    ground = Contact("ground", Box("crate", size), Plane(), 0.3)
    line = Line(Point(WORLD, (0.0, 0.0, 5.0)), Point("crate", (0.0, 0.0, 0.5)))
    up = floating("crate", (0.0, 0.0, 0.5 + height))
    rope = RigidRope("rope", (line,), 4.0 - height, **rope)
    return System((brick("crate", size, MASS),), (up,), rigid_ropes=(rope,), contacts=(ground,), gravity=G)


def test_a_crate_is_set_down_and_lifted_again():
    """The ground takes m v and the rope falls slack; reeled in again, the rope takes m v and the ground opens."""
    v = 0.1
    s = started(crate(0.05, winch=True), **FINE)
    s.references.set_profile("rope", 0, v, 1e6, None)
    s.settle()
    hand_over(s, SECOND)
    assert column(s, "contact/force")[1][-1, 0] == pytest.approx(MASS * G, rel=EXACT)
    s.references.set_profile("rope", s.epoch, -v, 1e6, None)
    s.settle()
    hand_over(s, 2 * SECOND)
    message = {(e.name, e.what): e.value for _, e in s.log}
    names = [("ground", "impact"), ("rope", "slack"), ("ground", "closed"), ("rope", "taut"), ("ground", "open")]
    assert [x for x in events(s)[events(s).index(names[0]) :] if x in names] == names
    assert message["ground", "impact"] == pytest.approx(MASS * v, rel=1e-5)
    assert message["rope", "taut"] == pytest.approx(MASS * v, rel=1e-5)
    assert column(s, "rope/tension")[1][-1, 0] == pytest.approx(MASS * G, rel=EXACT)
    assert imbalance(s) < BALANCE


def test_a_crate_on_the_ground_below_a_straight_rope_is_carried_by_the_ground_or_by_the_rope():
    """The forces are not unique; they hold the weight, none of them pushes or pulls the wrong way, and all is quiet."""
    s = started(crate(0.0), **FINE)
    s.run(SECOND)
    T, n = column(s, "rope/tension")[1][-1, 0], column(s, "contact/force")[1][-1, 0]
    assert T + n == pytest.approx(MASS * G, rel=1e-6)
    assert min(T, n) >= 0.0
    assert len(s.log) <= 2


def test_a_joint_lock_stops_a_load_that_swings_on_a_rope_beside_a_wall():
    """The rope lets the load go up where its guide stops it; no wall has a part in that."""
    system = against_a_wall(radians(30), 0.0)
    system = replace(system, locks=(Lock("stop", "x"),))
    s = started(system, **FINE)
    hand_over(s, SECOND // 2)
    before = s.state.copy()
    s.set_lock("stop", True)
    s.settle()
    s.run(SECOND)
    assert before[2] > 1.0 > abs(s.state[2])
    assert s.state[2] == 0.0
    assert imbalance(s) < BALANCE
