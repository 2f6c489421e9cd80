"""Rigid ropes: tension as a multiplier, slack and taut as events, impulses, shares of indeterminate groups."""

import json
from dataclasses import replace
from math import cos, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import WORLD, Body, Joint, Line, Point, RigidRope, System
from small_scenes import MASS, SECOND, G, X, Z, column, cube, events, hand_over, imbalance, started, times

EXACT = 1e-7  # against closed forms, at tolerance 1e-10
LOCATED = 2e-7  # [s] events: a nanosecond of slack in length, at the speed that it is used up with
CLOSES = 1e-8
FINE = {"tolerance": 1e-10, "sample_ns": 10_000_000, "h_max": 0.02}


def point(x=0.0, z=0.0, vx=0.0, vz=0.0, mass=MASS):
    """A point mass in the x-z plane."""
    slides = (
        Joint("x", "prismatic", WORLD, "carrier", axis=X, q0=(x,), v0=(vx,)),
        Joint("z", "prismatic", "carrier", "load", axis=Z, q0=(z,), v0=(vz,)),
    )
    return System((Body("carrier", 0.0), Body("load", mass)), slides, gravity=G)


def on_rope(system, L0, **rope):
    line = Line(Point(WORLD), Point("load"))
    return replace(system, rigid_ropes=(RigidRope("rope", (line,), L0, **rope),))


def test_the_tension_of_a_rope_at_rest_equals_the_weight_of_its_load():
    s = started(on_rope(point(z=-20.0), 20.0))
    _, T = column(s, "rope/tension")
    assert T[0, 0] == pytest.approx(MASS * G, rel=1e-12)


def test_a_load_that_falls_into_a_rigid_rope_stops_at_once():
    """It falls 2 m, the rope takes its momentum, and the heat is the energy of the fall."""
    s = started(on_rope(point(z=-18.0), 20.0), **FINE)
    s.run(3 * SECOND)
    assert events(s) == [("rope", "taut")]
    assert times(s, "rope", "taut")[0] == pytest.approx(2.0 / sqrt(G), abs=LOCATED)
    assert s.log[0][1].value == pytest.approx(MASS * sqrt(4.0 * G), rel=EXACT), "its impulse [N s]"
    names = [f"{name}.{what}" for what, name in s.program.accounts]
    _, accounts = column(s, "account")
    assert accounts[-1, names.index("rope.heat")] == pytest.approx(2.0 * MASS * G, rel=EXACT)
    _, T = column(s, "rope/tension")
    assert T[-1, 0] == pytest.approx(MASS * G, rel=EXACT)
    assert imbalance(s) < CLOSES


def test_a_load_thrown_up_leaves_its_rigid_rope_slack_and_returns_at_the_exact_time():
    s = started(on_rope(point(z=-20.0, vz=3.0), 20.0), **FINE)
    s.run(2 * SECOND)
    assert events(s) == [("rope", "taut")]
    assert times(s, "rope", "taut")[0] == pytest.approx(6.0 / G, abs=LOCATED)
    assert imbalance(s) < CLOSES


def test_a_rope_pendulum_too_slow_for_a_full_circle_goes_slack_where_its_tension_becomes_zero():
    """Started at the bottom with v0^2 = 3.5 g L, T = 0 at height angle a above the horizontal, sin a = 1/2."""
    L = 10.0
    s = started(on_rope(point(z=-L, vx=sqrt(3.5 * G * L)), L), **FINE)
    s.run(5 * SECOND)
    assert events(s)[:2] == [("rope", "slack"), ("rope", "taut")]
    slack, taut = (times(s, "rope", what)[0] for what in ("slack", "taut"))
    t, q = column(s, "joint/position")
    _, v = column(s, "joint/velocity")
    k = int(np.argmin(np.abs(t - slack)))
    assert q[k] == pytest.approx([L * cos(pi / 6), L * sin(pi / 6)], abs=1e-6)
    assert np.hypot(*v[k]) == pytest.approx(sqrt(0.5 * G * L), rel=1e-6)
    assert taut - slack == pytest.approx(4.0 * sqrt(0.5 * L / G) * cos(pi / 6), abs=1e-6), "a parabola's chord"
    assert imbalance(s) < CLOSES


def reference(name):
    return json.loads((Path(__file__).parents[2] / "data" / "linkages.json").read_text())[name]


def test_a_load_reeled_in_at_constant_speed_swings_as_in_the_reference_solution():
    theta = 0.1
    system = on_rope(point(20.0 * sin(theta), -20.0 * cos(theta), -sin(theta), cos(theta)), 20.0, winch=True)
    s = started(replace(system, gravity=9.81), **FINE)
    s.references.set_profile("rope", 0, -1.0, 1e6, None)
    s.settle()
    hand_over(s, 10 * SECOND)
    t, q = column(s, "joint/position")
    _, T = column(s, "rope/tension")
    for at, (angle, rate) in reference("hoist pendulum").items():
        k = int(np.argmin(np.abs(t - float(at))))
        assert np.arctan2(q[k, 0], -q[k, 1]) == pytest.approx(angle, abs=3e-6)
        length = 20.0 - float(at)
        assert T[k, 0] / MASS == pytest.approx(9.81 * cos(angle) + length * rate**2, rel=3e-6)
    assert imbalance(s) < 1e-6


def six(lugs, com):
    """A block on six vertical rigid ropes (C08b)."""
    W = 8825985.0
    block = Body("block", W / G, (*com, 0.0), cube(W / G, 10.0))
    lines = [Line(Point(WORLD, (x, y, 30.0)), Point("block", (x, y, 0.0))) for x, y in lugs]
    ropes = tuple(RigidRope(f"r{i}", (line,), 30.0) for i, line in enumerate(lines))
    return System((block,), (Joint("block-joint", "free", WORLD, "block"),), rigid_ropes=ropes, gravity=G)


def test_an_indeterminate_group_of_rigid_ropes_shares_its_load_by_least_norm():
    case = reference("C08b")
    s = started(six(case["lugs"], case["cg"]))
    _, T = column(s, "rope/tension")
    assert T[0] == pytest.approx(case["T"], rel=1e-6)


def test_a_rigid_rope_that_would_have_to_push_goes_slack():
    """With the load outside the lugs' middle some ropes carry nothing; the others carry the weight and its moment."""
    case = reference("C08b")
    s = started(six(case["lugs"], (9.0, 0.0)))
    _, T = column(s, "rope/tension")
    carried = T[0]
    x, y = np.array(case["lugs"]).T
    assert carried.min() >= 0.0
    assert (carried == 0.0).any()
    W = 8825985.0
    assert [carried.sum(), carried @ x, carried @ y] == pytest.approx([W, 9.0 * W, 0.0], rel=1e-6, abs=1e-3 * W)


def test_machine_code_and_interpreted_python_agree_on_rigid_ropes():
    system = on_rope(point(z=-18.0, vx=2.0), 20.0)
    native, floats = (started(system, native=x) for x in (True, False))
    for s in (native, floats):
        hand_over(s, SECOND)
    assert events(native) == events(floats) == [("rope", "taut")]
    assert native.state == pytest.approx(floats.state, rel=1e-12, abs=1e-12)


def test_a_rigid_rope_that_is_too_short_at_the_start_is_refused():
    with pytest.raises(KernelError) as e:
        started(on_rope(point(z=-20.2), 20.0))
    assert str(e.value) == (
        "rope 'rope': it is rigid and 200 mm too short for its ends; make it longer or bring them closer"
    )


def test_a_rigid_rope_is_unhooked_and_hooked_again():
    s = started(on_rope(point(z=-20.0), 20.0), **FINE)
    hand_over(s, SECOND)
    s.unhook("rope")
    s.settle()
    hand_over(s, 2 * SECOND)
    _, q = column(s, "joint/position")
    assert q[-1, 1] == pytest.approx(-20.0 - G / 2.0, rel=EXACT)
    with pytest.raises(KernelError) as e:
        s.hook("rope")
    assert str(e.value) == "rope 'rope' at 2.000 s: it is 4903 mm too short to be hooked there; bring the hook closer"
    s.hook("rope", L0=26.0)
    s.settle()
    s.run(4 * SECOND)
    assert events(s)[-1] == ("rope", "taut")
