"""The steps are of fifth order, also across events and across the pieces of a speed profile."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.describe import Body, Drive, Joint, System
from small_scenes import SECOND, G, X, cube, hand_over, hung, started

STEPS = (0.005, 0.0025)  # [s]: errors of 1e-9 and 1e-11
LOOSE = 0.9  # a tolerance that accepts every step, so that h is h_max
ORDER = (4.8, 5.2)


def end(scene, h, until, command=lambda s: None):
    """Kinematic state at `until`; steps of h from the first on."""
    s = started(scene, tolerance=LOOSE if h > 1e-3 else 1e-13, h_max=h)
    s.X[s.method.layout.at["h"]] = h
    command(s)
    s.settle()
    hand_over(s, round(until * SECOND))
    assert s["rejected"] == 0 or h < 1e-3
    n = s.program.nq + s.program.nv
    return s.state[:n].copy()


def orders(scene, until, command=lambda s: None, steps=STEPS):
    exact = end(scene, 5e-4, until, command)
    errors = [np.abs(end(scene, h, until, command) - exact).max() for h in steps]
    return np.log2(np.array(errors[:-1]) / errors[1:])


def pendulum(**drive):
    joints = (
        Joint("rail", "prismatic", "world", "trolley", axis=X),
        Joint("hinge", "revolute", "trolley", "bob", axis=(0.0, 1.0, 0.0), q0=(1.5,)),
        Joint("wrist", "revolute", "bob", "hand", (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0), v0=(6.0,)),
    )
    bodies = (
        Body("trolley", 3.0e3),
        Body("bob", 1.0e3, (0.0, 0.0, -1.0), cube(1.0e3)),
        Body("hand", 5.0e2, (0.0, 0.0, -1.0), cube(5.0e2)),
    )
    return System(bodies, joints, gravity=G, **drive)


def test_a_double_pendulum_on_a_free_trolley():
    found = orders(pendulum(), 1.6)
    assert all(ORDER[0] < p < ORDER[1] for p in found), found


def test_a_pendulum_below_a_trolley_that_is_moved_through_all_pieces_of_a_profile():
    """Accelerations jump at 0, 0.56, 0.96 and 1.52 s; a step that ends there must not see the next piece."""

    def move(s):
        s.references.set_profile("drive", 0, 1.12, 2.0, 1.12 * 0.96)

    found = orders(pendulum(drives=(Drive("drive", "rail", "prescribed"),)), 1.92, move)
    assert all(ORDER[0] < p < ORDER[1] for p in found), found


def test_a_load_that_is_caught_by_its_rope():
    """The step before the catch is cut at the located event and the next one starts there."""
    scene = replace(hung(59.9), ropes=(replace(hung(59.9).ropes[0], EA=2.0e8),))
    found = orders(scene, 0.8, steps=(0.04, 0.02, 0.01))
    assert all(ORDER[0] < p < ORDER[1] for p in found), found


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7, 1e-9])
def test_the_error_is_proportional_to_the_tolerance(tolerance):
    exact = end(pendulum(), 5e-4, 1.6)
    s = started(pendulum(), tolerance=tolerance)
    hand_over(s, round(1.6 * SECOND))
    error = np.abs(s.state[: len(exact)] - exact).max()
    assert 1e-3 * tolerance < error < 100 * tolerance
