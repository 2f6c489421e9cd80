"""Accelerations of bodies that turn, against the textbook's formula in polar coordinates.

At radius r and angle w t the acceleration is (r'' - r w^2) along the arm and r w' + 2 r' w across it.
"""

import numpy as np
import pytest
from heavylift.kernel.description import Beam, Body, Drive, Flexible, Joint, System
from heavylift.kernel.model import Program
from heavylift.kernel.multibody import axial_loads, cut
from heavylift.kernel.multibody.kinematics import kinematics

EXACT = 1e-12  # relative: a few roundings
RANDOM = np.random.default_rng(7).uniform(0.5, 2.0, (20, 6))


def tree_of(system, prescribed=()):  # numbers of velocities
    (tree,) = cut(Program(system).graph, set(prescribed))
    return tree


@pytest.mark.parametrize("numbers", RANDOM[:10])
def test_a_prescribed_slide_on_a_turning_arm_has_its_exact_acceleration(numbers):
    angle, w, r, dr, ddr, _ = numbers
    bodies = Body("arm", 1.0), Body("trolley", 1.0)
    joints = (
        Joint("pivot", "revolute", "world", "arm", axis=(0.0, 0.0, 1.0)),
        Joint("rail", "prismatic", "arm", "trolley", axis=(1.0, 0.0, 0.0)),
    )
    tree = tree_of(System(bodies, joints, drives=(Drive("winch", "rail", "prescribed"),)), {1})
    K = kinematics(tree, np.array([angle, r]), np.array([w, dr]), 0.0, [ddr])
    R, p, V, A = K.R[1], K.r[1], K.V[1], K.A[1]
    found = A[3:] + np.cross(A[:3], p) + np.cross(V[:3], V[3:] + np.cross(V[:3], p))
    assert R.T @ found == pytest.approx([ddr - r * w * w, 2.0 * dr * w, 0.0], rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("numbers", RANDOM[10:])
def test_a_rotating_beam_carries_the_centrifugal_load_of_its_tip(numbers):
    angle, w, dw, arm, length, mass = numbers
    beam = Flexible(2, Beam(length, 10.0, EI_y=1e6, EI_z=1e6), damping=0.1)
    bodies = Body("arm", 1.0), Body("boom", 0.0, flexible=beam), Body("load", mass)
    joints = (
        Joint("pivot", "revolute", "world", "arm", axis=(0.0, 0.0, 1.0)),
        Joint("foot", "fixed", "arm", "boom", p_PJ=(arm, 0.0, 0.0)),
        Joint("head", "fixed", "boom", "load", p_PJ=(length, 0.0, 0.0)),
    )
    tree = tree_of(System(bodies, joints))
    dofs = tree.v.stop - tree.v.start
    q, v, dv = (np.concatenate([[x], np.zeros(dofs - 1)]) for x in (angle, w, dw))
    g = 9.81
    force, frame, turning = np.asarray(axial_loads(tree, q, v, dv, [np.zeros(6)] * len(tree.bodies), g)).reshape(3, 3)
    reach = arm + length
    assert force == pytest.approx([mass * reach * w * w, -mass * reach * dw, -mass * g], rel=EXACT)
    assert frame == pytest.approx([-arm * w * w, arm * dw, g], rel=EXACT)
    assert turning == pytest.approx([0.0, 0.0, w], abs=EXACT)
