"""Angles go on beyond half a turn: thresholds, measured angles, torsion springs, bushings; in motion and in statics."""

from dataclasses import replace
from math import degrees, pi, radians, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import (
    Body,
    Bushing,
    Drive,
    Joint,
    Line,
    Load,
    Measured,
    Point,
    Rope,
    System,
    Threshold,
    Torsion,
)
from heavylift.kernel.islands import simulate
from small_scenes import SECOND, X, Y, Z, column, cube, hand_over, imbalance, started

ROUNDING = 1.01  # [ns] events are rounded up to the next nanosecond
EXACT = 1e-6  # [rad] of swings integrated at 1e-9
ONE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
K = 10.0  # [N m/rad] of a spring on a body of 1 kg m2
W = sqrt(K)
STIFF = tuple(tuple(K * (i == j) for j in range(6)) for i in range(6))
NONE = ((0.0,) * 6,) * 6
AXES = {0: (-1.0, 0.0, 0.0), 1: Y}  # that attitudes turn about


def wheel(axis=Z, q0=0.0, v0=0.0, kind="revolute", **parts) -> System:
    """A body that turns about an axis through its centre of mass."""
    if kind == "free":
        joint = Joint("axle", "free", "world", "wheel", v0=(0.0, 0.0, 0.0, *(v0 * np.array(axis)).tolist()))
    else:
        joint = Joint("axle", "revolute", "world", "wheel", axis=axis, q0=(q0,), v0=(v0,))
    return System((Body("wheel", 1.0, inertia=ONE),), (joint,), gravity=0.0, **parts)


@pytest.mark.parametrize("kind", ["revolute", "free"])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("goal", [150.0, 181.0, 200.0, 359.0, 725.0, -190.0, -1000.0])
def test_a_threshold_on_an_angle_beyond_a_full_turn_fires_at_that_angle(kind, axis, goal):
    """A free body turns by many radians within one step: nothing holds it, so nothing makes the steps shorter."""
    speed = 3.0 if goal > 0.0 else -3.0
    scene = wheel(AXES[axis], v0=speed, kind=kind, thresholds=(Threshold("there", "angle", of="wheel", axis=axis),))
    s = started(scene, tolerance=1e-10)
    s.watch("there", radians(goal), goal > 0.0)
    s.settle()
    hand_over(s, 10 * SECOND)
    ((t, event),) = s.log
    assert event.what == "reached"
    assert t == pytest.approx(radians(goal) / speed * 1e9, abs=ROUNDING + 1.0)


def test_a_threshold_below_the_start_angle_fires_at_once_and_a_threshold_above_it_fires_later():
    parts = tuple(Threshold(name, "angle", of="wheel", axis=1) for name in ("behind", "ahead"))
    s = started(wheel(Y, q0=radians(400.0), v0=1.0, thresholds=parts))
    s.watch("behind", radians(390.0), True)
    s.watch("ahead", radians(410.0), True)
    s.settle()
    hand_over(s, SECOND)
    assert [(e.name, round(t * 1e-9, 6)) for t, e in s.log] == [("behind", 0.0), ("ahead", round(radians(10.0), 6))]


@pytest.mark.parametrize("turns", [0.4, 0.6, 1.2, 3.7])
def test_a_drive_follows_a_measured_angle_that_exceeds_half_a_turn(turns):
    """Its reference is k times the angle, without a jump of 2 pi k; a snapshot in mid-turn changes nothing."""
    k, speed = 0.25, 2.0 * pi * turns
    slide = Joint("slide", "prismatic", "world", "slide", axis=X)
    scene = wheel(Y, v0=speed, measured=(Measured("angle", "angle", "wheel", axis=1),))
    drives = (Drive("push", "slide", "servo", kp=4e4, kv=4e2),)
    bodies = (*scene.bodies, Body("slide", 1.0))
    scene = replace(scene, bodies=bodies, joints=(*scene.joints, slide), drives=drives)

    def begun():
        s = started(scene, tolerance=1e-10)
        s.set_follow("push", "angle", (k, 0.0, 0.0))
        s.settle()
        return s

    s = begun()
    s.run(round(0.7 * SECOND))
    again = begun()
    again.restore(s.snapshot())
    for run in (s, again):
        hand_over(run, SECOND)
        run.settle()
    assert np.array_equal(s.state, again.state)
    place = float(s.row().q[s.program.graph.joint("slide").q.start])
    lag = 1e-2 * abs(k * speed)  # 100 periods of the servo have passed
    assert place == pytest.approx(k * speed, abs=lag)
    s.set_follow("push", "angle", (k, 0.0, 0.0))  # anew, from an angle of several turns
    s.settle()
    assert float(s.row().q[s.program.graph.joint("slide").q.start]) == place
    assert s.commands.masters_now() == pytest.approx([speed], abs=EXACT)


def spring(kind: str, axis=Z) -> Bushing | Torsion:
    return Torsion("spring", "world", "wheel", axis, K) if kind == "torsion" else Bushing(
        "spring", Point("world"), Point("wheel"), STIFF, NONE
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["torsion", "bushing"])
@pytest.mark.parametrize(
    ("start", "speed"), [(0.0, 4.0), (0.0, 9.0), (3.0, 30.0), (pi, 0.0), (-8.0, 2.0), (40.0, -3.0)]
)
@pytest.mark.parametrize("axis", [Z, (0.6, 0.0, -0.8)])
def test_a_torsion_spring_is_wound_up_by_any_number_of_turns(kind, start, speed, axis):
    """q'' = -w^2 q from any angle of the hinge, and all energy stays in the accounts."""
    scene = wheel(axis, q0=start, v0=speed * W, forces=(spring(kind, axis),))
    s = started(scene, tolerance=1e-9, sample_ns=SECOND // 50)
    hand_over(s, 3 * SECOND)
    s.settle()
    t, q = column(s, "joint/position")
    size = abs(start) + abs(speed)
    assert q[:, 0] == pytest.approx(start * np.cos(W * t) + speed * np.sin(W * t), abs=EXACT * size)
    assert imbalance(s) < EXACT
    shown = column(s, "torsion/angle" if kind == "torsion" else "bushing/displacement")[1]
    angle = shown[:, 0] if kind == "torsion" else shown[:, 3:] @ np.array(axis)
    assert angle == pytest.approx(q[:, 0], abs=1e-9)


def test_a_shaft_between_two_turning_bodies_counts_the_rotation_of_both_joints():
    """Two discs on one axis, the second carried by the first: the spring sees their difference."""
    other = Joint("neck", "revolute", "wheel", "disc", axis=(0.0, 0.0, -1.0), q0=(7.0,))
    shaft = Torsion("shaft", "disc", "wheel", Z, K)
    scene = wheel(q0=20.0, forces=(shaft,))
    scene = replace(scene, bodies=(*scene.bodies, Body("disc", 1.0, inertia=ONE)), joints=(*scene.joints, other))
    s = started(scene)
    assert column(s, "torsion/angle")[1][0, 0] == pytest.approx(7.0, abs=1e-12)


@pytest.mark.parametrize("turns", [0.3, 0.8, 1.4])
def test_static_equilibrium_is_found_with_a_spring_wound_beyond_half_a_turn(turns):
    moment = K * 2.0 * pi * turns
    push = Load("push", Point("wheel"), moment=(0.0, 0.0, moment))
    s = started(wheel(forces=(spring("torsion"), push)))
    assert equilibrium(s).q[0] == pytest.approx(2.0 * pi * turns, abs=EXACT)


@pytest.mark.parametrize("seed", range(4))
def test_a_body_tumbling_in_a_bushing_ends_the_run_before_the_rotation_vector_is_singular(seed):
    random = np.random.default_rng(seed)
    distance = random.normal(size=3)
    distance *= 12.0 / np.linalg.norm(distance)
    soft = Bushing("rubber", Point("world"), Point("wheel"), STIFF, NONE)
    joint = Joint("axle", "free", "world", "wheel", v0=(0.0, 0.0, 0.0, *distance.tolist()))
    s = started(replace(wheel(), joints=(joint,), forces=(soft,)), tolerance=1e-9, sample_ns=SECOND // 1000)
    with pytest.raises(KernelError, match=r"bushing 'rubber' at \d\.\d+ s: 'wheel' is turned by 175 degrees") as ended:
        hand_over(s, 3 * SECOND)
    assert "\n" not in str(ended.value)
    turned = np.linalg.norm(column(s, "bushing/displacement")[1][:, 3:], axis=1)
    assert degrees(turned.max()) < 175.0
    t = column(s, "bushing/displacement")[0]
    assert turned == pytest.approx(12.0 / W * np.abs(np.sin(W * t)), abs=1e-5), "about one axis, as a hinge would"


def test_a_body_that_stays_below_half_a_turn_in_a_bushing_is_accepted():
    soft = Bushing("rubber", Point("world"), Point("wheel"), STIFF, NONE)
    joint = Joint("axle", "free", "world", "wheel", v0=(0.0, 0.0, 0.0, 0.0, 0.0, 3.0 * W))
    s = started(replace(wheel(), joints=(joint,), forces=(soft,)), tolerance=1e-9)
    hand_over(s, SECOND)
    s.settle()
    rz = column(s, "bushing/displacement")[1][-1, 5]
    assert rz == pytest.approx(3.0 * sin(W), abs=EXACT)


def test_a_wheel_that_turns_five_radians_per_fixed_step_has_its_exact_angle():
    """100 rad/s in steps of 50 ms: five radians each."""
    scene = System((Body("wheel", 1.0, inertia=cube(1.0)),), wheel(Y, v0=100.0).joints, gravity=0.0)
    scene = replace(scene, measured=(Measured("angle", "angle", "wheel", axis=1),))
    s = started(scene, method="rk4", step=0.05)
    hand_over(s, SECOND)
    s.settle()
    assert s.commands.masters_now() == pytest.approx([100.0], abs=EXACT)


def test_turn_counts_of_drums_and_joints_are_kept_when_islands_merge():
    """A wheel that has turned one and a half times is tied to a block by a slack rope; its threshold comes at two."""
    tie = Rope("tie", (Line(Point("wheel", (0.0, 0.5, 0.0)), Point("block")),), 1e5, 100.0, hooked=False)
    scene = wheel(Y, v0=2.0 * pi, thresholds=(Threshold("two", "angle", of="wheel", axis=1),))
    block = Joint("rail", "prismatic", "world", "block", (5.0, 0.0, 0.0), axis=X, v0=(0.1,))
    scene = replace(scene, bodies=(*scene.bodies, Body("block", 1.0)), joints=(*scene.joints, block), ropes=(tie,))
    s = simulate(scene, 1e-9, SECOND // 10, frozenset(), "dopri5", None)
    s.start()
    s.watch("two", 4.0 * pi, True)
    s.settle()
    assert len(s.parts) == 2
    hand_over(s, 3 * SECOND // 2)
    s.hook("tie")
    s.settle()
    assert len(s.parts) == 1
    hand_over(s, 3 * SECOND)
    (t,) = [t for t, e in s.log if e.what == "reached"]
    assert t == pytest.approx(2 * SECOND, abs=2.0)
