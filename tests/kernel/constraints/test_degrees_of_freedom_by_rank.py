"""Degrees of freedom of mechanisms: published linkages for which counting fails, random ones, singular poses."""

from dataclasses import replace
from math import atan, cos, pi, sin, tan

import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import mobility
from heavylift.kernel.description import WORLD, Beam, Body, Drive, Flexible, Joint, Line, Lock, Point, RigidRope, System
from heavylift.kernel.model import Program
from linkages import looped, windows
from random_trees import pinocchio_model, random_system
from scipy.spatial.transform import Rotation
from small_scenes import X, Y, Z, cube, started
from test_loops_close import _frames, doubled

EXTENT = 1e-7  # singular value, relative, that NumPy counts as zero beside the kernel's 1e-6


def link(name, mass=1.0):
    return Body(name, mass, inertia=cube(mass))


def turn_x(a):
    return ((1.0, 0.0, 0.0), (0.0, cos(a), -sin(a)), (0.0, sin(a), cos(a)))


def found(system):
    return mobility(Program(system))


def four_bar(crossed=False):
    """A crank-rocker with sides 1, 2.2, 1.7 on a base of 2 whose hinges are parallel, in space."""
    crank, d = 1.1, 2.0
    x, z = cos(crank), sin(crank)
    dx, dz = d - x, -z
    span = (dx * dx + dz * dz) ** 0.5
    along = (2.2**2 - 1.7**2 + span**2) / (2.0 * span)
    up = (2.2**2 - along**2) ** 0.5 * (-1.0 if crossed else 1.0)
    px, pz = x + (along * dx - up * dz) / span, z + (along * dz + up * dx) / span
    coupler, rocker = np.arctan2(pz - z, px - x), np.arctan2(pz, px - d)
    down = (0.0, -1.0, 0.0)
    joints = (
        Joint("a", "revolute", WORLD, "crank", axis=down, q0=(crank,)),
        Joint("b", "revolute", "crank", "coupler", X, axis=down, q0=(float(coupler) - crank,)),
        Joint("d", "revolute", WORLD, "rocker", (d, 0.0, 0.0), axis=down, q0=(float(rocker),)),
        Joint("c", "revolute", "coupler", "rocker", (2.2, 0.0, 0.0), axis=down, p_CJ=(1.7, 0.0, 0.0)),
    )
    return System((link("crank"), link("coupler"), link("rocker")), joints)


def three_cranks():
    """One bar on three parallel cranks: the third is one too many, and the bar moves nevertheless."""
    at = [(float(i), 0.0, 0.0) for i in range(3)]
    crank = [Joint(f"foot{i}", "revolute", WORLD, f"crank{i}", p, axis=Y, q0=(0.4,)) for i, p in enumerate(at)]
    pins = [Joint(f"pin{i}", "revolute", f"crank{i}", "bar", Z, axis=Y, p_CJ=p) for i, p in enumerate(at)]
    pins[0] = replace(pins[0], q0=(-0.4,))
    return System((*(link(f"crank{i}") for i in range(3)), link("bar")), (*crank, *pins))


def bennett(theta=1.0, alpha=0.6, beta=1.1, a=1.0):
    """Bennett 1903: four hinges in space, opposite sides equal, a / sin(alpha) = b / sin(beta)."""
    b = a * sin(beta) / sin(alpha)
    other = 2.0 * atan(sin((beta + alpha) / 2.0) / sin((beta - alpha) / 2.0) / tan(theta / 2.0))
    back = {"p_CJ": (-b, 0.0, 0.0), "R_CJ": turn_x(-beta)}
    return System(
        (link("first"), link("second"), link("third")),
        (
            Joint("h1", "revolute", WORLD, "first", q0=(theta,)),
            Joint("h2", "revolute", "first", "second", (a, 0.0, 0.0), turn_x(alpha), q0=(other,)),
            Joint("h3", "revolute", "second", "third", (b, 0.0, 0.0), turn_x(beta), q0=(-theta,)),
            Joint("h4", "revolute", "third", WORLD, (a, 0.0, 0.0), turn_x(alpha), **back),
        ),
    )  # fmt: skip


def sarrus(q=0.7):
    """Sarrus 1853: two pairs of hinged plates at a right angle guide a plate along a straight line."""
    joints = (
        Joint("x1", "revolute", WORLD, "a", X, axis=Y, q0=(q,)),
        Joint("x2", "revolute", "a", "b", Z, axis=Y, q0=(-2.0 * q,)),
        Joint("x3", "revolute", "b", "top", Z, axis=Y, p_CJ=X, q0=(q,)),
        Joint("y1", "revolute", WORLD, "c", Y, axis=X, q0=(-q,)),
        Joint("y2", "revolute", "c", "d", Z, axis=X, q0=(2.0 * q,)),
        Joint("y3", "revolute", "d", "top", Z, axis=X, p_CJ=Y),
    )
    return System(tuple(link(n) for n in ("a", "b", "top", "c", "d")), joints)


def ball_rod():
    """RSSR: Kutzbach counts two, one of which is the idle spin of the rod."""
    joints = (
        Joint("in", "revolute", WORLD, "crank", axis=Z, q0=(0.3,)),
        Joint("ball1", "spherical", "crank", "rod", X),
        Joint("out", "revolute", WORLD, "rocker", (3.0, 0.5, 0.2), axis=X, q0=(0.2,)),
        Joint("ball2", "spherical", "rod", "rocker", (2.2, 0.4, 0.1), p_CJ=(0.0, 1.0, 0.5)),
    )
    return System((link("crank"), link("rod"), link("rocker")), joints)


def hexapod(driven=0):
    """Gough and Stewart's platform on six legs with universal feet; `driven` of the legs are prescribed."""
    bodies, joints, drives = [link("platform")], [], []
    centre = (0.02, 0.01, 2.0)
    for i in range(6):
        at, on = 2.0 * pi * i / 6.0 + 0.3 * (-1) ** i, 2.0 * pi * i / 6.0 - 0.2 * (-1) ** i
        foot, head = (1.5 * cos(at), 1.5 * sin(at), 0.0), (cos(on), sin(on), 0.0)
        leg = np.array(head) + centre - foot
        length = float(np.linalg.norm(leg))
        angles = float(np.arctan2(-leg[1], leg[2])), float(np.arcsin(leg[0] / length))  # turn the leg's z onto it
        level = Rotation.from_euler("XY", angles).inv().as_quat()
        bodies += [link(f"lower{i}"), link(f"upper{i}")]
        joints += [
            Joint(f"foot{i}", "universal", WORLD, f"lower{i}", foot, axis=X, second=Y, q0=angles),
            Joint(f"leg{i}", "prismatic", f"lower{i}", f"upper{i}", axis=Z, q0=(length,)),
            Joint(f"head{i}", "spherical", f"upper{i}", "platform", p_CJ=head, q0=tuple(map(float, level))),
        ]
        drives += [Drive(f"jack{i}", f"leg{i}", "prescribed")] if i < driven else []
    return System(tuple(bodies), tuple(joints), drives=tuple(drives))


def hinges(n):
    at = [(0.0, 0.0, float(i)) for i in range(n)]
    joints = [Joint(f"h{i}", "revolute", WORLD, "door", p, p_CJ=p) for i, p in enumerate(at)]
    return System((link("door"),), tuple(joints))


@pytest.mark.parametrize(
    ("system", "dof", "redundant"),
    [
        (four_bar(), 1, 3),  # in space: Kutzbach counts -2
        (four_bar(crossed=True), 1, 3),
        (windows(1, 0.3), 1, 3),
        (windows(5, 0.3), 1, 15),
        (three_cranks(), 1, 7),
        (bennett(), 1, 3),
        (bennett(2.0, 0.3, 0.9, 12.0), 1, 3),
        (sarrus(), 1, 1),
        (ball_rod(), 2, 0),
        (hexapod(), 6, 0),
        (hexapod(driven=4), 2, 0),
        (hexapod(driven=6), 0, 0),
        (hinges(1), 1, 0),
        (hinges(2), 1, 5),
        (hinges(3), 1, 10),
    ],
    ids=["four-bar", "crossed", "parallelogram", "windows", "three-cranks", "bennett", "long-bennett", "sarrus", "rssr",
         "hexapod", "half-driven", "driven", "hinge", "two-hinges", "three-hinges"],
)  # fmt: skip
def test_published_linkages_have_their_known_degrees_of_freedom(system, dof, redundant):
    m = found(system)
    assert (m.dof, m.at_start, m.conditions - m.rank, m.open) == (dof, dof, redundant, ())


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_degrees_of_freedom_do_not_depend_on_size_or_mass(size):
    """Bennett's linkage of a millimetre and of a kilometre, with masses from a gram to a million tons."""
    small = bennett(a=size)
    masses = zip(small.bodies, (1e-3, 1.0, 1e9), strict=True)
    m = found(replace(small, bodies=tuple(replace(b, mass=x, inertia=cube(x * size * size)) for b, x in masses)))
    assert (m.dof, m.conditions - m.rank) == (1, 3)


def test_rounding_a_start_pose_to_printed_digits_does_not_change_its_degrees_of_freedom():
    """Bennett's linkage with angles to four digits: its loop is closed first, then counted."""
    rounded = bennett()
    rounded = replace(rounded, joints=tuple(replace(j, q0=tuple(round(x, 4) for x in j.q0)) for j in rounded.joints))
    assert found(rounded).dof == 1


def test_a_folded_parallelogram_has_two_degrees_of_freedom_at_the_start_and_one_in_motion():
    m = found(windows(1, pi / 2))
    assert (m.at_start, m.dof) == (2, 1)
    assert "the start pose is singular: 2 degrees of freedom at that instant, 1 in motion" in m.lines


def test_three_folded_four_bar_linkages_have_four_degrees_of_freedom_at_the_start_and_one_in_motion():
    m = found(windows(3, pi / 2))
    assert (m.at_start, m.dof) == (4, 1)


def test_a_fully_stretched_pair_of_bars_has_no_degree_of_freedom():
    """Two bars in line between two pins: infinitesimally movable, and rigid."""
    bars = (
        Joint("left", "revolute", WORLD, "a", axis=Y),
        Joint("middle", "revolute", "a", "b", X, axis=Y),
        Joint("right", "revolute", WORLD, "b", (2.0, 0.0, 0.0), axis=Y, p_CJ=X),
    )
    m = found(System((link("a"), link("b")), bars))
    assert (m.at_start, m.dof) == (1, 0)


@pytest.mark.parametrize("seed", range(8))
def test_random_trees_have_as_many_degrees_of_freedom_as_their_joints(seed):
    system = random_system(seed, 12, 1.0)
    m, model = found(system), pinocchio_model(Program(system).graph)
    assert (m.bodies, m.dof, m.at_start, m.conditions) == (12, model.nv, model.nv, 0)


@pytest.mark.parametrize("seed", [2, 12, 24, 34, 39, 55])
def test_random_loops_have_the_jacobian_rank_that_pinocchio_finds(seed):
    system, q, _ = looped(seed, ("spherical",) * (1 + seed % 3))
    graph = Program(system).graph
    model = pinocchio_model(graph)
    frames = {name: (on, place) for name, on, place in _frames(model, graph)}
    loops = []
    for j in graph.loops:
        (ja, Ma), (jb, Mb) = frames[j.parent], frames[j.child]
        at_a, at_b = Ma * pin.SE3(np.array(j.R_PJ), np.array(j.p_PJ)), Mb * pin.SE3(np.array(j.R_CJ), np.array(j.p_CJ))
        loops.append((ja, at_a, jb, at_b))
    data = model.createData()
    pin.computeJointJacobians(model, data, q[: model.nq])
    rows = []
    for ja, at_a, jb, at_b in loops:
        a, b = data.oMi[ja] * at_a, data.oMi[jb] * at_b
        at = pin.SE3(np.eye(3), b.translation)
        assert np.abs(a.translation - b.translation).max() < 1e-9, "closed in this pose"
        rows.append(sum(
            sign * at.toActionMatrixInverse()[:3] @ pin.getJointJacobian(model, data, j, pin.ReferenceFrame.WORLD)
            for sign, j in ((1.0, jb), (-1.0, ja)) if j
        ))  # fmt: skip
    rank = int(np.linalg.matrix_rank(np.vstack(rows), tol=EXTENT))
    m = found(system)
    assert (m.rank, m.at_start) == (rank, model.nv - rank)


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "universal", "planar", "spherical", "screw"])
def test_adding_a_second_equal_joint_removes_no_degree_of_freedom(kind):
    once, twice = map(found, doubled(kind))
    assert once.dof == twice.dof
    assert twice.conditions == twice.conditions - twice.rank, "every row of the second one is redundant"


def test_driven_and_locked_coordinates_do_not_count_as_degrees_of_freedom():
    joints = tuple(Joint(f"j{i}", "revolute", "b0" if i else WORLD, f"b{i}", axis=Y) for i in range(3))
    system = System(
        tuple(link(f"b{i}") for i in range(3)), joints, drives=(Drive("d", "j0", "prescribed"),),
        locks=(Lock("l", "j1", engaged=True),),
    )  # fmt: skip
    m = found(system)
    assert (m.joint_freedoms, m.driven, m.locked, m.dof) == (3, 1, 1, 1)
    assert m.lines == ["degrees of freedom: 3 of joints, less 1 prescribed by drives, less 1 locked"]


def test_a_loop_with_one_driven_joint_has_no_degree_of_freedom_and_follows_its_drive():
    m = found(replace(four_bar(), drives=(Drive("d", "a", "prescribed"),)))
    assert (m.dof, m.driven, m.rank) == (0, 1, 2)


def test_taut_rigid_ropes_remove_degrees_of_freedom_and_slack_ones_do_not():
    ropes = tuple(
        RigidRope(f"r{i}", (Line(Point(WORLD, (x, 0.0, 3.0)), Point("load", (x, 0.0, 0.0))),), length)
        for i, (x, length) in enumerate(((-1.0, 3.0), (1.0, 3.0), (0.0, 3.0), (0.0, 3.5)))
    )
    m = found(System((link("load"),), (Joint("f", "free", WORLD, "load"),), rigid_ropes=ropes))
    assert (m.conditions, m.rank, m.dof) == (3, 2, 4), "the third shares what the other two hold"
    assert m.redundant[0].names == ("rope 'r0'", "rope 'r1'", "rope 'r2'")


def test_remaining_degrees_of_freedom_are_reported_by_body():
    bodies = (
        link("load"), Body("carrier", 0.0), link("plate"),
        Body("beam", 0.0, flexible=Flexible(2, Beam(10.0, 100.0, EI_y=1e6), loads=(10.0,))), link("tip"),
    )  # fmt: skip
    joints = (
        Joint("x", "prismatic", WORLD, "carrier", axis=X),
        Joint("y", "revolute", "carrier", "load", axis=Y),
        Joint("weld", "fixed", "load", "plate", Z),
        Joint("root", "fixed", WORLD, "beam"),
        Joint("hinge", "revolute", "beam", "tip", (5.0, 0.0, 0.0), axis=Y),
    )
    m = found(System(bodies, joints))
    assert (m.flexible, m.massless, m.fixed, m.stations, m.modes) == (1, 1, 1, m.bodies - 5, m.dof - 3)


def test_a_linkage_that_cannot_close_is_reported():
    apart = replace(four_bar(), joints=(*four_bar().joints[:3], replace(four_bar().joints[3], p_CJ=(9.0, 0.0, 0.0))))
    m = found(apart)
    assert m.open == ("joint 'c'",)
    assert m.lines[-1] == "joint 'c': loops do not close near the start pose; counted as they stand"
    with pytest.raises(KernelError, match="does not close"):
        started(apart, native=False)
