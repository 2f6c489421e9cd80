"""Hinges in line, welds and parallel ropes: indeterminate reactions are named, determinate ones keep their values."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium, reactions, statics_data, statics_text
from heavylift.kernel.description import WORLD, Ball, Body, Contact, Joint, Line, Plane, Point, RigidRope, Rope, System
from small_scenes import SECOND, G, X, Y, cube, hand_over, started
from test_degrees_of_freedom_by_rank import four_bar, link, sarrus

EXACT = 1e-9  # relative: two ways of solving the same linear equations
SOLVED = 1e-6  # relative: redundant rows are solved by proximal passes
MASS = 10e3
WEIGHT = MASS * G
LEVERS = (1.0, 0.0, -1.0)  # [m] heights of the hinges
OUT = 0.5  # [m] of the door's centre from their axis


def door(heights=LEVERS, kinds=("revolute",) * 3, mass=MASS):
    at = [(0.0, 0.0, z) for z in heights]
    pairs = enumerate(zip(at, kinds, strict=False))
    joints = [Joint(f"h{i}", kind, WORLD, "door", p, p_CJ=p) for i, (p, kind) in pairs]
    joints[0] = replace(joints[0], q0=(0.0,) if kinds[0] == "revolute" else ())  # a start value: it carries the door
    return System((Body("door", mass, (OUT, 0.0, 0.0), cube(1e3)),), tuple(joints), gravity=G)


def asked(system):
    return reactions(started(system, native=False))


def named(carried):
    return {name: set(r.indeterminate) for name, r in carried.items()}


def test_each_of_three_equal_hinges_carries_a_third_and_is_marked_as_indeterminate():
    carried = asked(door())
    for hinge in carried.values():
        assert hinge.force[2] == pytest.approx(WEIGHT / 3.0, rel=SOLVED)
        assert set(hinge.indeterminate) == {"force x", "force y", "force z", "moment x", "moment y"}
    total = sum(r.moment[1] for r in carried.values())
    total += sum(z * r.force[0] for z, r in zip(LEVERS, carried.values(), strict=True))
    assert total == pytest.approx(-OUT * WEIGHT, rel=SOLVED), "together they carry the moment of the weight"


def test_indeterminate_reactions_are_the_least_norm_solution_of_numpy():
    """Equilibrium of the door as a linear system in its fifteen components, moments over the lever that is reported."""
    carried = asked(door())
    rows, want = np.zeros((5, 15)), np.array([0.0, 0.0, WEIGHT, 0.0, -OUT * WEIGHT])
    for i, z in enumerate(LEVERS):  # components: fx, fy, fz, mx / L, my / L
        rows[:3, 5 * i : 5 * i + 3] = np.eye(3)
        rows[3, 5 * i + 1], rows[3, 5 * i + 3] = -z, carried.lever
        rows[4, 5 * i], rows[4, 5 * i + 4] = z, carried.lever
    least = np.linalg.pinv(rows) @ want
    got = np.array([[*r.force, *(r.moment[:2] / carried.lever)] for r in carried.values()]).ravel()
    assert got == pytest.approx(least, abs=SOLVED * WEIGHT)


def test_a_hinge_alone_or_with_a_ball_on_rollers_has_determinate_reactions():
    assert named(asked(door((0.0,)))) == {"h0": set()}
    guided = asked(door((1.0, -1.0), ("spherical", "cylindrical")))
    assert named(guided) == {"h0": {"force x", "force y"}, "h1": {"force x", "force y", "moment x", "moment y"}}
    assert guided["h0"].force[2] == pytest.approx(WEIGHT, rel=SOLVED), "the ball alone carries the weight"


@pytest.mark.parametrize("elastic", [False, True])
def test_a_body_with_two_welds_has_indeterminate_reactions_and_a_body_with_weld_and_spring_has_not(elastic):
    load = Body("load", MASS, inertia=cube(MASS))
    slide = Joint("slide", "prismatic", WORLD, "carriage", axis=X)
    weld = [Joint(f"weld{i}", "fixed", "carriage", "load", p, p_CJ=p) for i, p in enumerate((X, Y))]
    rope = Rope("rope", (Line(Point(WORLD, (0.0, 0.0, 10.0)), Point("load")),), 1e6, 10.0)
    system = System((Body("carriage", 1.0), load), (slide, weld[0], *([] if elastic else weld[1:])), gravity=G)
    carried = asked(replace(system, ropes=(rope,)) if elastic else system)
    if elastic:
        assert not carried.shared, "an elastic rope is no constraint"
        return
    assert len(carried["weld0"].indeterminate) == len(carried["weld1"].indeterminate) == 6
    assert carried["slide"].indeterminate == (), "below the welds all is certain"
    assert carried["slide"].force[2] == pytest.approx(WEIGHT + G, rel=EXACT)


def test_a_planar_linkage_in_space_has_determinate_reactions_only_in_its_plane():
    carried = asked(replace(four_bar(), gravity=G))
    assert set(map(frozenset, named(carried).values())) == {frozenset({"force y", "moment x", "moment z"})}
    free = asked(replace(_with_balls(four_bar()), gravity=G))
    assert not free.shared
    for name in "abcd":
        assert np.array(carried[name].force)[[0, 2]] == pytest.approx(np.array(free[name].force)[[0, 2]], rel=1e-5)


def _with_balls(system):
    """The same linkage without redundancy: a ball at one end of the coupler, a cylinder at the other."""
    kinds = {"c": "spherical", "b": "cylindrical"}
    joints = []
    for j in system.joints:
        kind = kinds.get(j.name, j.kind)
        q0 = (0.0, *j.q0) if kind == "cylindrical" else j.q0
        joints.append(replace(j, kind=kind, q0=q0))
    return replace(system, joints=tuple(joints))


def test_the_indeterminate_twists_of_a_sarrus_linkage_are_named():
    """One redundancy: all hinges in a chain share one pattern, and nothing else is uncertain."""
    carried = asked(replace(sarrus(), gravity=G))
    assert all("force z" not in r.indeterminate for r in carried.values())
    assert any("moment z" in r.indeterminate for r in carried.values())


def ropes_at(*places):
    lines = ((Line(Point(WORLD, (x, y, 3.0)), Point("load", (x, y, 0.0))),) for x, y in places)
    return tuple(RigidRope(f"r{i}", line, 3.0) for i, line in enumerate(lines))


def hung(*places):
    return System((link("load", MASS),), (Joint("f", "free", WORLD, "load"),), rigid_ropes=ropes_at(*places), gravity=G)


def test_three_ropes_in_a_plane_share_the_load_by_the_least_norm_and_three_in_a_triangle_are_determinate():
    simulation = started(hung((-1.0, 0.0), (1.0, 0.0), (0.5, 0.0)), native=False)
    carried = reactions(simulation)
    places = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 0.5]])
    want = np.linalg.pinv(places) @ np.array([WEIGHT, 0.0])
    assert [carried.tensions[f"r{i}"] for i in range(3)] == pytest.approx(want, rel=SOLVED)
    triangle = asked(hung((1.0, 0.0), (-0.5, 1.0), (-0.5, -1.0)))
    assert not triangle.shared


def test_only_ropes_that_share_an_indeterminate_load_are_named_in_the_note():
    """Two ropes at one end of a beam, one at the other: the lone one carries its half for certain."""
    carried = asked(hung((-1.0, 0.0), (-1.0, 0.0), (1.0, 0.0)))
    assert carried.tensions == pytest.approx({"r0": WEIGHT / 4.0, "r1": WEIGHT / 4.0}, rel=SOLVED)


def test_no_rope_is_reported_with_a_negative_tension():
    """The least norm of six would push with one of them: that one is slack, and the others share."""
    carried = asked(hung((-0.1, 0.0), (2.0, 0.0), (0.9, 0.0), (-0.1, 0.0), (-0.1, 0.0), (-0.11, 0.0)))
    assert min(carried.tensions.values()) >= 0.0
    assert sum(carried.tensions.values()) == pytest.approx(WEIGHT, rel=SOLVED)


def test_rigid_feet_share_an_indeterminate_load_and_the_contacts_are_named():
    feet = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
    contacts = tuple(
        Contact(f"foot{i}", Ball("table", (x, y, 0.0), 0.1), Plane(), 0.0) for i, (x, y) in enumerate(feet)
    )
    table = Joint("f", "free", WORLD, "table", q0=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0))
    four = asked(System((link("table", MASS),), (table,), contacts=contacts, gravity=G))
    assert set(four.contacts) == {"foot0", "foot1", "foot2", "foot3"}
    three = asked(System((link("table", MASS),), (table,), contacts=contacts[:3], gravity=G))
    assert three.contacts == ()


def test_the_printed_table_of_reactions_marks_statically_indeterminate_reactions():
    simulation = started(door(), native=False)
    found = equilibrium(simulation)
    text = statics_text(found, reactions(simulation), 0.0)
    assert "h1      ~0.000  ~0.000  ~32.689" in text
    assert "~ not determined by rigid bodies" in text
    assert "smallest sum of squared forces and of squared moments over 1 m" in text
    data = statics_data(found, reactions(simulation), 0.0)
    assert data["indeterminate"]["joints"] == ["h0", "h1", "h2"]
    assert data["reactions"]["h0"]["indeterminate"][0] == "force x"
    plain = statics_text(found, asked(door((0.0,))), 0.0)
    assert "~" not in plain


def notes(system, **options):
    simulation = started(system, native=False, **options)
    hand_over(simulation, SECOND // 100)
    return [note.sentence for note in simulation.notes]


def test_a_run_notes_its_indeterminate_loads_once():
    (message,) = notes(door())
    assert message.startswith(
        "joint 'h0', joint 'h1', joint 'h2' at 0.000 s: how they share their load is not determined"
    )
    (message,) = notes(hung((-1.0, 0.0), (-1.0, 0.0), (1.0, 0.0)))
    assert message.startswith("rope 'r0', rope 'r1' at 0.000 s: how they share their load")


@pytest.mark.parametrize(
    "system",
    [replace(four_bar(), gravity=G), door((0.0,)), hung((1.0, 0.0), (-0.5, 1.0), (-0.5, -1.0)), door(mass=MASS)],
    ids=["planar", "one-hinge", "tripod", "no-gravity"],
)
def test_a_run_whose_rope_loads_are_all_determinate_gives_no_note_about_loads(system):
    """A planar linkage in its plane leaves its redundant rows without load."""
    if len(system.joints) == 3:
        system = replace(system, gravity=0.0)
    assert notes(system) == []


def test_indeterminate_reactions_of_a_tilted_four_bar_linkage_are_named():
    tilted = replace(four_bar(), gravity=G)
    c, s = np.cos(pi / 6.0), np.sin(pi / 6.0)
    R = ((1.0, 0.0, 0.0), (0.0, float(c), float(-s)), (0.0, float(s), float(c)))

    def turned(j):
        return replace(j, R_PJ=R, p_PJ=tuple((np.array(R) @ j.p_PJ).tolist())) if j.parent == WORLD else j

    (message,) = notes(replace(tilted, joints=tuple(map(turned, tilted.joints))))
    assert "is not determined by rigid bodies" in message
