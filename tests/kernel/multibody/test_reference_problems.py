"""Published and own reference problems that are trees, by every method that fits, to the digits that it can give.

IFToMM A01 (simple pendulum), the heavy top of Geradin and Cardona, case 2 of NASA/TM-2015-218675 (tumbling brick), a
pendulum reeled in at constant speed, and a load dropped on a slack rope; values computed with 113 bits.
"""

import json
from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import Body, Drive, Joint, Line, Point, Rope, System
from small_scenes import SECOND, Y, hand_over, slider, started, times

PROBLEMS = json.loads((Path(__file__).parents[2] / "data" / "tree_problems.json").read_text())["problems"]
# method, tolerance, error that it may make (relative to 1)
METHODS = [("dopri5", 1e-13, 1e-10), ("dop853", 1e-13, 1e-10), ("radau5", 1e-10, 1e-7)]
every = pytest.mark.parametrize(("method", "tolerance", "error"), METHODS)


def follow(system, method, tolerance, until):
    s = started(system, method=method, tolerance=tolerance, sample_ns=SECOND)
    for t in until:
        hand_over(s, round(t * SECOND))
        yield s
        s.settle()


@every
def test_the_simple_pendulum_agrees_with_its_elliptic_integral(method, tolerance, error):
    joint = Joint("pin", "revolute", "world", "bob", axis=Y, q0=(radians(90.0),))
    system = System((Body("bob", 1.0, (0.0, 0.0, -1.0)),), (joint,), gravity=9.81)
    reference = PROBLEMS["A01_simple_pendulum"]["own_reference"]
    for s, t in zip(follow(system, method, tolerance, (1, 5, 10)), ("1", "5", "10"), strict=True):
        (q, w), want = s.state[:2], reference[t]
        got = [-sin(q), -cos(q), -w * cos(q), w * sin(q)]
        assert got == pytest.approx([want[k] for k in ("x", "y", "vx", "vy")], abs=error)


@every
def test_the_heavy_top_agrees_with_its_published_solution(method, tolerance, error):
    p = PROBLEMS["heavy_top"]
    I = p["parameters"]["J_com"]
    body = Body("top", 15.0, (0.0, 1.0, 0.0), tuple(tuple(I[i] * (i == j) for j in range(3)) for i in range(3)))
    joint = Joint("tip", "spherical", "world", "top", v0=(0.0, 150.0, -4.61538))
    for s, t in zip(follow(System((body,), (joint,), gravity=9.81), method, tolerance, (1, 2)), "12", strict=True):
        want = p["own_reference"][t]
        quaternion = np.roll(want["quaternion_wxyz"], -1)
        q = s.state[:4]
        assert abs(q @ quaternion) == pytest.approx(1.0, abs=10.0 * error)
        assert s.state[4:7] == pytest.approx(want["omega_body"], abs=300.0 * error)  # it spins at 150 rad/s


@every
def test_the_tumbling_brick_agrees_with_its_published_solution(method, tolerance, error):
    p = PROBLEMS["nesc_case2_tumbling_brick"]
    I = [p["parameters"][k] * 1.3558179483 for k in ("Ixx", "Iyy", "Izz")]
    body = Body("brick", 2.26796, inertia=tuple(tuple(I[i] * (i == j) for j in range(3)) for i in range(3)))
    joint = Joint("free", "spherical", "world", "brick", v0=tuple(radians(x) for x in (10.0, 20.0, 30.0)))
    ends = follow(System((body,), (joint,), gravity=0.0), method, tolerance, (10, 20, 30))
    for s, t in zip(ends, ("10", "20", "30"), strict=True):
        want = p["own_reference"][t]
        assert abs(s.state[:4] @ np.roll(want["quaternion_wxyz"], -1)) == pytest.approx(1.0, abs=error)
        assert s.state[4:7] == pytest.approx(want["omega_body_rad_s"], abs=10.0 * error)


@every
def test_a_pendulum_that_is_reeled_in_agrees_with_its_reference(method, tolerance, error):
    """A revolute joint, then a driven prismatic one: the length is prescribed."""
    joints = (
        Joint("pivot", "revolute", "world", "boom", axis=Y, q0=(-0.1,)),
        Joint("reel", "prismatic", "boom", "load", axis=(0.0, 0.0, -1.0), q0=(20.0,)),
    )
    bodies = (Body("boom", 0.0), Body("load", 1.0))
    system = System(bodies, joints, drives=(Drive("winch", "reel", "prescribed"),), gravity=9.81)
    s = started(system, method=method, tolerance=tolerance, sample_ns=SECOND)
    s.references.set_profile("winch", 0, -1.0, 1e9, None)
    s.settle()
    for t in ("5", "10"):
        hand_over(s, int(t) * SECOND)
        want = PROBLEMS["hoist_pendulum"]["own_reference"][t]
        i, k = s.program.graph.joint("pivot").q.start, s.program.nq + s.program.graph.joint("pivot").v.start
        assert [-s.state[i], -s.state[k]] == pytest.approx([want["theta"], want["omega"]], abs=10.0 * error)
        s.settle()


@every
def test_a_load_dropped_into_a_slack_rope_agrees_with_its_reference_solution(method, tolerance, error):
    """The n-th catch, and the rest at the height of the drop after each period."""
    p = PROBLEMS["snap_load"]["own_reference"]
    EA = 1.2e7 * 20.0
    rope = Rope("rope", (Line(Point("world"), Point("load")),), EA, 20.0)
    system = replace(slider(mass=3.0e5, q0=-19.95), ropes=(rope,), gravity=9.81)
    s = started(system, method=method, tolerance=tolerance, sample_ns=SECOND)
    hand_over(s, round(5.0 * p["period"] * SECOND))
    caught, slack = times(s, "rope", "taut"), times(s, "rope", "slack")
    periods = p["period"] * np.arange(5)
    rounded = 2e-8  # ten events, each on the next nanosecond
    assert caught == pytest.approx(p["t_taut"] + periods, abs=10.0 * error + rounded)
    assert slack == pytest.approx(p["t_taut"] + p["taut_duration"] + periods, abs=10.0 * error + rounded)
    assert s.state[0] == pytest.approx(-19.95, abs=10.0 * error + rounded)
