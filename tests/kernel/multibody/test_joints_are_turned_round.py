"""Joints whose direction points towards the world are reversed without any other change."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import WORLD, Body, Drive, Joint, JointSpring, Stop, System
from linkages import poses
from random_trees import rotation
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, cube, hand_over, started

SAME = 1e-11  # relative: the same motion, written otherwise
KINDS = {"revolute": ((0.3,), (0.5,)), "prismatic": ((0.3,), (0.5,)), "cylindrical": ((0.3, -0.4), (0.5, 0.7))}
KINDS |= {"screw": ((0.3,), (0.5,)), "fixed": ((), ())}


def nested(x):
    return tuple(tuple(map(float, row)) for row in x)


def hung(kind, turned):
    """A load on an arm by a joint of general places and axis, written from the arm or from the load."""
    random = np.random.default_rng(7)
    axis = random.normal(size=3)
    axis /= np.linalg.norm(axis)
    places = {"p_PJ": (0.3, 0.1, -0.9), "R_PJ": nested(rotation(random)), "p_CJ": (0.1, -0.2, 0.4)}
    places["R_CJ"] = nested(rotation(random))
    q0, v0 = KINDS[kind]
    shoulder = Joint("shoulder", "revolute", WORLD, "arm", axis=(0.0, 1.0, 0.0), q0=(0.4,), v0=(1.0,))
    pitch = 0.2 if kind == "screw" else 0.0
    joint = Joint("j", kind, "arm", "load", axis=tuple(axis), pitch=pitch, q0=q0, v0=v0, **places)
    if turned:
        back = {"p_PJ": joint.p_CJ, "R_PJ": joint.R_CJ, "p_CJ": joint.p_PJ, "R_CJ": joint.R_PJ}
        joint = replace(joint, parent="load", child="arm", axis=tuple(-axis), **back)
    name = "travel" if kind == "cylindrical" else ""
    laws = (JointSpring("spring", "j", 30.0, 1.0, 0.2, name),) if kind != "fixed" else ()
    bodies = (Body("arm", 5.0, (0.1, 0.0, -0.5), cube(5.0)), Body("load", 2.0, (0.0, 0.2, -0.3), cube(2.0)))
    return System(bodies, (shoulder, joint), laws)


@pytest.mark.parametrize("kind", KINDS)
def test_a_joint_written_from_child_to_parent_moves_like_one_from_parent_to_child(kind):
    one, other = (started(hung(kind, turned), tolerance=1e-11) for turned in (False, True))
    assert [k.body.name for k in other.program.graph.links] == ["arm", "load"]
    for s in (one, other):
        hand_over(s, SECOND)
    assert other.state == pytest.approx(one.state, rel=SAME, abs=SAME)
    (p, R), (p_, R_) = (poses(hung(kind, turned))["load"] for turned in (False, True))
    assert p_ == pytest.approx(p, abs=SAME)
    assert Rotation.from_matrix(R_.T @ R).magnitude() < SAME


def test_a_drive_moves_a_joint_whose_child_is_the_world():
    joint = Joint("rail", "prismatic", "load", WORLD, axis=(-1.0, 0.0, 0.0), q0=(1.0,))
    system = System((Body("load", 3.0),), (joint,), stops=(Stop("end", "rail", 0.0, 5.0, 1e4, 10.0),))
    s = started(replace(system, drives=(Drive("motor", "rail", "prescribed"),)))
    s.references.set_profile("motor", 0, 0.5, 1.0, 2.0)
    s.settle()
    hand_over(s, 6 * SECOND)
    assert s.row().poses[:3] == pytest.approx([3.0, 0.0, 0.0], abs=1e-12)


def test_a_joint_whose_reversal_would_change_its_coordinates_is_refused():
    load = Body("load", 3.0, inertia=cube(3.0))
    with pytest.raises(KernelError) as e:
        started(System((load,), (Joint("ball", "spherical", "load", WORLD),)))
    assert str(e.value) == (
        "joint 'ball': no other joint carries its parent 'load', so the child must carry the parent; "
        "swap parent and child"
    )
