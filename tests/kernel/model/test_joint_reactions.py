"""Each joint reports all six reaction components: the four-link arm (C19b) and textbook structures."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.analysis import momentum, reactions
from heavylift.kernel.description import Body, Brake, Drive, Joint, JointSpring, System
from small_scenes import G, X, Y, Z, cube, hung, started
from test_the_four_link_arm import GIVEN, WANT, arm

FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
PRECISE = 1e-9  # relative, as the closed form asks
EXACT = 1e-12


def test_reactions_of_a_falling_arm_agree_with_the_closed_form():
    carried = reactions(started(arm(), native=False))
    angle = [0.0, GIVEN["q"][0], GIVEN["q"][0], GIVEN["q"][0] + GIVEN["q"][2]]  # of each joint's parent
    for i in range(4):
        x, y, z = carried[f"hinge{i}"].force
        c, s = np.cos(angle[i]), np.sin(angle[i])
        assert (x * c - z * s, x * s + z * c) == pytest.approx(WANT["F_c"][i], rel=PRECISE)
        assert y == pytest.approx(0.0, abs=EXACT)
        assert carried[f"hinge{i}"].moment[1] == pytest.approx(0.0, abs=1e-8)  # the hinge is free


def test_the_base_of_a_resting_arm_carries_its_weight_and_moment():
    simulation = started(arm(at_rest=True), native=False)
    base = reactions(simulation)["hinge0"]
    assert base.force == pytest.approx([0.0, 0.0, WANT["total_weight"]], abs=1e-9)
    centre = momentum(simulation).centre
    assert base.moment == pytest.approx([0.0, -centre[0] * WANT["total_weight"], 0.0], rel=EXACT, abs=1e-8)


def test_a_cantilever_of_fixed_joints_carries_weight_shear_and_moment():
    bodies = (Body("root", 100.0, (1.0, 0.0, 0.0)), Body("tip", 50.0, (0.5, 0.3, 0.0)))
    joints = (
        Joint("wall", "fixed", "world", "root"),
        Joint("weld", "fixed", "root", "tip", (2.0, 0.0, 0.0)),
        Joint("other", "revolute", "world", "wheel"),
    )
    system = System((*bodies, Body("wheel", 1.0, inertia=cube(1.0))), joints, gravity=G)
    carried = reactions(started(system, native=False))
    assert carried["weld"].force == pytest.approx([0.0, 0.0, 50.0 * G], rel=EXACT)
    assert carried["weld"].moment == pytest.approx([0.3 * 50.0 * G, -0.5 * 50.0 * G, 0.0], rel=EXACT)
    assert carried["wall"].force == pytest.approx([0.0, 0.0, 150.0 * G], rel=EXACT)
    assert carried["wall"].moment == pytest.approx([0.3 * 50.0 * G, -(100.0 + 2.5 * 50.0) * G, 0.0], rel=EXACT)


def test_joint_reactions_are_given_in_the_axes_of_the_joint():
    turned = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))  # the joint's y axis points up
    joint = Joint("weld", "prismatic", "world", "load", R_PJ=turned, axis=X)
    carried = reactions(started(System((Body("load", 10.0),), (joint,), gravity=G), native=False))
    assert carried["weld"].force == pytest.approx([0.0, 10.0 * G, 0.0], abs=1e-12)


def test_along_a_free_axis_a_joint_transmits_only_the_force_of_its_laws():
    spring = JointSpring("spring", "load-guide", k=1e5, d=0.0, q_rest=0.01)
    system = replace(System((Body("load", 10.0),), (Joint("load-guide", "prismatic", "world", "load", axis=Z),)))
    system = replace(system, springs=(spring,), gravity=G)
    assert reactions(started(system, native=False))["load-guide"].force[2] == pytest.approx(1e3, rel=EXACT)


def test_a_load_on_a_vertical_rope_exerts_no_force_on_its_guide():
    simulation = started(hung(60.01), native=False)
    assert reactions(simulation)["load-guide"].force == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_the_joint_of_a_driven_trolley_carries_the_swing_of_its_pendulum():
    """Prescribed and braked axes: the drive's force is the reaction along it, C11b at the end of a swing."""
    form = next(f for f in FORMS if f["id"] == "C11b")
    m, L, start = form["given"]["m"], form["given"]["L"], np.radians(form["given"]["th0_deg"])
    bodies = (Body("trolley", 1e4), Body("load", m, (0.0, 0.0, -L)))
    joints = (
        Joint("rail", "prismatic", "world", "trolley", axis=X),
        Joint("pivot", "revolute", "trolley", "load", axis=Y, q0=(start,)),
    )
    hold = Drive("hold", "rail", "prescribed")
    simulation = started(System(bodies, joints, drives=(hold,), gravity=G), native=False)
    end = reactions(simulation)["pivot"].force
    assert np.linalg.norm(end) == pytest.approx(form["expected"]["T_end"], rel=PRECISE)
    assert reactions(simulation)["rail"].force[0] == pytest.approx(end[0], rel=EXACT)
    braked = System(bodies, joints, brakes=(Brake("brake", "rail", 1e9, 1e9, 0.0, True),), gravity=G)
    assert reactions(started(braked, native=False))["rail"].force[0] == pytest.approx(0.0, abs=1e-6)  # not yet moved
