"""Published and own reference problems with closed loops, to the digits that double precision gives.

IFToMM A03 (Andrews' squeezer), the car axis of the IVP Test Set, and the heavy top of Geradin and Cardona whose point a
loop holds; values computed with 113 bits.  IFToMM A02 with N = 2 is among the loops, with N = 40 among the full tests.
"""

import json
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import WORLD, Body, Drive, Joint, Lock, Master, Point, Spring, System
from small_scenes import SECOND, X, Y, Z, cube, hand_over, started
from squeezer import squeezer

DATA = Path(__file__).parents[2] / "data"
LINKAGES = json.loads((DATA / "linkages.json").read_text())
TOP = json.loads((DATA / "tree_problems.json").read_text())["problems"]["heavy_top"]
methods = pytest.mark.parametrize(("method", "tolerance"), [("dopri5", 1e-12), ("dop853", 1e-12), ("radau5", 1e-10)])
SQUEEZED = 1e-11  # relative to 1 + |y|: a crank that has turned five times at up to 1300 rad/s
DRIVEN = 1e-9  # what the published values of the car axis agree with
BUMP, RUN_UP = 0.1, -5.0  # [m], [rad] over one second in which the wheel's motion begins
SPUN = 1e-7  # at 150 rad/s for 2 s


def coordinates(s, names):
    """Coordinates, then velocities, of joints with one freedom."""
    links = [s.program.graph.joint(name) for name in names]
    return s.state[[k.q.start for k in links] + [s.program.nq + k.v.start for k in links]]


@methods
@pytest.mark.large(beyond=1)
def test_the_squeezing_mechanism_agrees_with_its_published_solution(method, tolerance):
    """Seven bodies, three loops: nine redundant rows of fifteen, since everything stays in one plane."""
    reference = LINKAGES["A03"]
    s = started(squeezer(tuple(reference["start"])), method=method, tolerance=tolerance, sample_ns=SECOND)
    assert len(s.program.graph.loops) == 3
    hand_over(s, SECOND // 20)
    want = np.array(reference["0.05"])
    assert np.abs((coordinates(s, [f"K{i}" for i in range(1, 8)]) - want) / (1.0 + np.abs(want))).max() < SQUEEZED


@methods
def test_the_heavy_top_held_by_a_loop_agrees_with_its_published_solution(method, tolerance):
    """The top floats as a free body (a lock that nobody uses wants its joint in the tree); a ball holds its point."""
    I = TOP["parameters"]["J_com"]
    body = Body("top", 15.0, (0.0, 1.0, 0.0), tuple(tuple(I[i] * (i == j) for j in range(3)) for i in range(3)))
    floats = Joint("floats", "free", WORLD, "top", v0=(0.0, 0.0, 0.0, 0.0, 150.0, -4.61538))
    system = System(
        (body,), (floats, Joint("point", "spherical", WORLD, "top")), locks=(Lock("held", "floats"),), gravity=9.81
    )
    s = started(system, method=method, tolerance=tolerance, sample_ns=SECOND)
    assert [j.name for j in s.program.graph.loops] == ["point"]
    for t in (1, 2):
        hand_over(s, t * SECOND)
        want = TOP["own_reference"][str(t)]
        assert abs(s.state[3:7] @ np.roll(want["quaternion_wxyz"], -1)) == pytest.approx(1.0, abs=SPUN)
        assert s.state[10:13] == pytest.approx(want["omega_body"], abs=SPUN)
        s.settle()


def car_axis():
    """A rod from the origin to the right wheel, which a drive moves up and down and which slides in x.

    The left mount slides on the rod's normal through the origin; an axle joins it to the right mount.  How rod and
    wheel move is given, so that their masses, which the problem does not have, change nothing.
    """
    m = 0.0005
    bodies = (
        Body("lift", 0.0), Body("wheel", m), Body("rod", m, inertia=cube(m)), Body("left", m), Body("axle", m, X),
    )  # fmt: skip
    joints = (
        Joint("road", "prismatic", WORLD, "lift", axis=Z, q0=(BUMP * sin(RUN_UP),)),
        Joint("slide", "prismatic", "lift", "wheel", axis=X, q0=(1.0,)),
        Joint("pin", "revolute", "wheel", "rod", axis=Y, p_CJ=X, q0=(0.0,)),
        Joint("normal", "prismatic", "rod", "left", axis=Z, q0=(0.5,)),
        Joint("mount", "revolute", "left", "axle", axis=Y),
        Joint("origin", "revolute", WORLD, "rod", axis=Y),
    )
    springs = (
        Spring("left spring", Point(WORLD), Point("left"), 0.5, 1.0),
        Spring("right spring", Point("wheel"), Point("axle", X), 0.5, 1.0),
    )
    masters, drives = (Master("phase", RUN_UP),), (Drive("bumps", "road", "prescribed"),)
    return System(bodies, joints, drives=drives, forces=springs, masters=masters, gravity=1.0)


@methods
def test_the_car_axis_agrees_with_its_published_solution(method, tolerance):
    s = started(car_axis(), method=method, tolerance=tolerance, sample_ns=SECOND)
    s.set_follow("bumps", "phase", (0.0, 0.0, BUMP))
    s.references.set_profile("phase", 0, 10.0, 10.0, None)
    s.settle()
    hand_over(s, SECOND)  # the master turns at 10 rad/s and is at 0: now the problem's initial values
    names = ["slide", "pin", "normal", "mount"]
    graph, nq = s.program.graph, s.program.nq
    q, v = ([getattr(graph.joint(n), x).start for n in names] for x in "qv")
    s.state[q] = 1.0, 0.0, 0.5, 0.0
    # the rod turns at y' / L = 1 rad/s about -Y, the left mount with it at 0.5 m/s to the left, the axle not at all
    s.state[[nq + i for i in v]] = 0.0, -1.0, 0.0, 1.0
    s.settle()
    hand_over(s, 4 * SECOND)
    _, angle, travel, turn = s.state[q]
    _, rate, speed, turning = s.state[[nq + i for i in v]]
    left = np.array([sin(angle), cos(angle)]) * travel
    left_speed = np.array([sin(angle), cos(angle)]) * speed + np.array([cos(angle), -sin(angle)]) * travel * rate
    a = angle + turn
    along = np.array([cos(a), -sin(a)])
    right_speed = left_speed + (rate + turning) * np.array([-sin(a), -cos(a)])
    got = [*left, *(left + along), *left_speed, *right_speed]
    assert got == pytest.approx(LINKAGES["car axis"]["3"], rel=0.0, abs=DRIVEN)
