"""Assembly of a linkage at the start: given values are kept, small corrections reported, other branches refused."""

from dataclasses import replace
from math import acos, cos, degrees, sin

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import WORLD, Body, Drive, Joint, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.scene import parse
from linkages import windows
from small_scenes import G, X, Y, cube, started

KEPT = 1e-12  # [rad] what was asked is not touched
CLOSED = 1e-9  # [m]
DOWN = (0.0, -1.0, 0.0)


def rod(name, length, mass=1.0):
    i = mass * length**2 / 12.0
    return Body(name, mass, (length / 2.0, 0.0, 0.0), ((0.01, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))


def parallelogram(crank=(0.9,), coupler=(), rocker=(), speeds=((), (), ())):
    """Cranks of 1 m on a base of 2 m, joined by a rod of 2 m; the joint 'x' closes the loop."""
    bodies = (rod("crank", 1.0), rod("coupler", 2.0, 2.0), rod("rocker", 1.0))
    joints = (
        Joint("a", "revolute", WORLD, "crank", axis=DOWN, q0=crank, v0=speeds[0]),
        Joint("b", "revolute", "crank", "coupler", X, axis=DOWN, q0=coupler, v0=speeds[1]),
        Joint("d", "revolute", WORLD, "rocker", (2.0, 0.0, 0.0), axis=DOWN, q0=rocker, v0=speeds[2]),
        Joint("x", "revolute", "coupler", "rocker", (2.0, 0.0, 0.0), axis=DOWN, p_CJ=X),
    )
    return System(bodies, joints, gravity=G)


def begun(system):
    """Coordinates, velocities and notes at the start."""
    s = started(system, native=False)
    nq = s.program.nq
    message = [n.sentence for n in s.notes if n.sentence.startswith("the start")]
    return s.state[:nq], s.state[nq : nq + s.program.nv], message


def gap(q):
    tip = np.array([cos(q[0]) + 2.0 * cos(q[0] + q[1]), sin(q[0]) + 2.0 * sin(q[0] + q[1])])
    return float(np.abs(tip - [2.0 + cos(q[2]), sin(q[2])]).max())


@pytest.mark.parametrize("crank", [0.2, 0.9, 2.0, 3.0, -0.7])
def test_unspecified_start_coordinates_of_a_loop_are_computed_from_the_given_ones(crank):
    """The coupler and the rocker find a place for any angle of the crank; nothing asked has changed."""
    q, v, message = begun(parallelogram((crank,), speeds=((4.0,), (), ())))
    assert q[0] == pytest.approx(crank, abs=KEPT)
    assert v[0] == pytest.approx(4.0, rel=1e-9)
    assert gap(q) < CLOSED
    assert message == []


def test_a_loop_is_assembled_from_the_given_coordinate_of_its_middle_joint():
    q, v, message = begun(parallelogram((), (-1.2,), (), speeds=((), (0.5,), ())))
    assert (q[1], v[1]) == pytest.approx((-1.2, 0.5), abs=1e-9)
    assert gap(q) < CLOSED
    assert message == []


def test_a_start_pose_with_closed_loops_is_kept_bit_for_bit():
    q, _, message = begun(windows(1, 0.3))
    assert q.tolist() == [0.3, np.pi / 2 - 0.3, 0.3]
    assert message == []


def test_a_start_pose_whose_digits_are_rounded_gives_no_note():
    """Angles to a hundredth of a degree."""
    off = np.radians(0.005)
    q, _, message = begun(parallelogram((0.9,), (-0.9 + off,), (0.9 - off,)))
    assert gap(q) < CLOSED
    assert message == []


@pytest.mark.parametrize("off", [0.01, -0.05, 0.1])
def test_a_small_correction_of_the_start_pose_is_reported_with_the_joint_and_both_values(off):
    q, _, (message,) = begun(parallelogram((0.9,), (-0.9 + off,), (0.9,)))
    assert gap(q) < CLOSED
    begins = "the start pose was changed so that the loops of joint 'x' close: joint 'a' from 51.5662 degrees"
    assert message.startswith(begins)
    assert f"joint 'b' from {degrees(-0.9 + off):.6g} degrees to {degrees(q[1]):.6g} degrees" in message
    assert abs(q[1] + q[0]) < 1e-9, "still the branch in which the coupler stays level"


def test_closing_the_loops_of_a_start_pose_reports_only_the_joints_that_had_to_move():
    """The rocker may follow: crank and coupler stay as asked where the rocker can reach."""
    bar = 1.0  # the coupler's tip on a circle of 1 m about the rocker's foot
    crank = 0.9
    tip = lambda b: np.hypot(cos(crank) + 2.0 * cos(crank + b) - 2.0, sin(crank) + 2.0 * sin(crank + b))  # noqa: E731
    assert tip(-0.9) == pytest.approx(bar)
    q, _, (message,) = begun(parallelogram((crank,), (-0.88,), ()))
    assert "joint 'd'" not in message
    assert "joint 'b'" in message or "joint 'a'" in message
    assert abs(tip(q[1]) - bar) < 0.05


@pytest.mark.parametrize(
    "asked", [((0.9,), (2.1,), (0.9,)), ((0.9,), (-0.9,), (-2.0,)), ((0.9,), (1.5,), (2.5,))], ids=str
)
def test_a_start_pose_far_from_closing_is_refused(asked):
    with pytest.raises(KernelError) as e:
        begun(parallelogram(*asked))
    message = str(e.value)
    assert message.startswith("joint '")
    assert "asked to start at" in message
    assert "the loop of joint 'x' is" in message
    assert "another branch or too far away to be meant" in message


def test_assembly_refuses_or_reports_every_change_to_another_assembly_mode_of_a_linkage():
    """Random start values: closed near them and told, or refused; where the crank is, the branch is the asked one."""
    random = np.random.default_rng(5)
    kept, refusals = 0, []
    for _ in range(12):
        crank = float(random.uniform(0.5, 2.5))
        off = random.normal(scale=0.3, size=3)
        try:
            q, _, message = begun(parallelogram((crank + off[0],), (-crank + off[1],), (crank + off[2],)))
        except KernelError as error:
            refusals.append(str(error))
            continue
        assert gap(q) < CLOSED
        assert len(message) == 1
        assert abs(q[0] + q[1]) < 1e-6, "the coupler is level: the branch of the asked pose"
        kept += 1
    assert kept > 3
    assert all("another branch or too far away" in message for message in refusals)


def test_closing_the_loops_of_a_start_pose_does_not_move_a_prescribed_crank():
    driven = replace(parallelogram((0.9,), (-0.8,), (0.9,)), drives=(Drive("motor", "a", "prescribed"),))
    q, _, (message,) = begun(driven)
    assert q[0] == 0.9
    assert "joint 'a'" not in message
    assert "joint 'b' from -45.8366 degrees to -51.5662 degrees" in message


@pytest.mark.parametrize("asked", [0.9, 0.9 + 2.0 * np.pi, 0.5])
def test_the_given_start_value_of_a_loop_closing_joint_is_checked(asked):
    """Level coupler: the rocker stands at the crank's angle from it."""
    level = parallelogram((0.9,), (-0.9,), (0.9,))
    closing = replace(level.joints[3], q0=(asked,))
    _, _, message = begun(replace(level, joints=(*level.joints[:3], closing)))
    if asked == 0.5:
        (sentence,) = message
        assert "joint 'x' from 28.6479 degrees to 51.5662 degrees" in sentence
    else:
        assert message == []


def test_a_start_pose_that_cannot_close_is_refused():
    short = parallelogram()
    short = replace(short, joints=(*short.joints[:3], replace(short.joints[3], p_CJ=(9.0, 0.0, 0.0))))
    with pytest.raises(KernelError, match=r"joint 'x': its loop does not close; .* is left"):
        begun(short)


# ---- speeds ------------------------------------------------------------------------------------------------------


def test_the_stated_start_speed_of_one_joint_in_a_loop_is_kept_and_the_other_speeds_follow():
    """Level coupler: both cranks turn alike, the coupler turns back."""
    _, v, message = begun(parallelogram((0.9,), (-0.9,), (0.9,), ((4.0,), (), ())))
    assert v == pytest.approx([4.0, -4.0, 4.0], rel=1e-9)
    assert message == []


def test_contradictory_start_speeds_are_reported_with_their_loop():
    _, v, (message,) = begun(parallelogram((0.9,), (-0.9,), (0.9,), ((4.0,), (-3.0,), (4.0,))))
    assert v == pytest.approx([v[0], -v[0], v[0]], rel=1e-9)
    assert message.startswith(
        "the start speeds were changed to what the loops of joint 'x' allow: joint 'a' from 4 to "
    )
    assert f"joint 'b' from -3 to {v[1]:.6g} rad/s" in message


def test_a_correction_of_the_start_pose_of_a_slider_is_reported_in_metres():
    """Slider-crank: the crank of 1 m, the rod of 2 m, the slider on the x axis."""
    theta = 0.8
    rod_angle = -acos((1.0 - (sin(theta) / 2.0) ** 2) ** 0.5)
    x = cos(theta) + 2.0 * cos(rod_angle)
    bodies = (rod("crank", 1.0), rod("rod", 2.0), Body("slider", 3.0, inertia=cube(3.0)))
    joints = (
        Joint("a", "revolute", WORLD, "crank", axis=DOWN, q0=(theta,)),
        Joint("b", "revolute", "crank", "rod", X, axis=DOWN, q0=(rod_angle - theta,)),
        Joint("s", "prismatic", WORLD, "slider", axis=X, q0=(x + 0.05,)),
        Joint("x", "revolute", "rod", "slider", (2.0, 0.0, 0.0), axis=DOWN),
    )
    q, _, (message,) = begun(System(bodies, joints, gravity=G))
    assert f"joint 's' from {x + 0.05:.6g} m to {q[2]:.6g} m" in message


# ---- scenes ------------------------------------------------------------------------------------------------------

SCENE = """\
heavylift: 1
name: loop
end: 1 s
mechanism:
  bodies:
    crank: {mass: 1 kg, com: [0.5 m, 0, 0], inertia: [0.01 kg m2, 0.1 kg m2, 0.1 kg m2]}
    coupler: {mass: 1 kg, com: [1 m, 0, 0], inertia: [0.01 kg m2, 0.1 kg m2, 0.1 kg m2]}
    rocker: {mass: 1 kg, com: [0.5 m, 0, 0], inertia: [0.01 kg m2, 0.1 kg m2, 0.1 kg m2]}
  joints:
    a: {type: revolute, child: crank, axis: [0, -1, 0], start: 50 deg, speed: 90 deg/s}
    b: {type: revolute, parent: crank, child: coupler, at: [1 m, 0, 0], axis: [0, -1, 0]}
    d: {type: revolute, child: rocker, at: [2 m, 0, 0], axis: [0, -1, 0]}
    x: {type: revolute, parent: coupler, child: rocker, at: [2 m, 0, 0], axis: [0, -1, 0], at child: [1 m, 0, 0]}
"""


def test_only_start_coordinates_that_a_scene_states_are_kept_and_the_others_are_computed():
    (mechanism,) = parse(SCENE).plan.machines
    s = Simulation(mechanism.system, native=False)
    s.start()
    assert degrees(s.state[0]) == pytest.approx(50.0, abs=1e-9)
    assert degrees(s.state[s.program.nq]) == pytest.approx(90.0, abs=1e-6)
    assert not [n for n in s.notes if "changed" in n.sentence]


def test_a_start_coordinate_stated_as_zero_is_kept_and_not_computed():
    rocker = "at: [2 m, 0, 0], axis: [0, -1, 0]"
    (mechanism,) = parse(SCENE.replace(f"{rocker}}}", f"{rocker}, start: 0 deg}}")).plan.machines
    assert [j.q0 for j in mechanism.system.joints] == [(pytest.approx(0.8726646),), (), (0.0,), ()]


def test_a_tree_without_loops_needs_no_assembly():
    pendulum = System((Body("bob", 1.0, (0.0, 0.0, -1.0)),), (Joint("p", "revolute", WORLD, "bob", axis=Y, q0=(9.0,)),))
    q, _, message = begun(replace(pendulum, gravity=G))
    assert q.tolist() == [9.0]
    assert message == []
