"""Stiff ropes and light hooks cost an implicit method few steps."""

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from small_scenes import SECOND, G, Y, hand_over, started

MASS, LENGTH, ANGLE = 3.0e5, 20.0, 0.3
COARSE, FINE = 1e-5, 1e-7  # tolerances
CLOSE = 0.01  # [m] after 4 s, on a way of 10 m


def diagonal(i):
    return ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))


def swing(stiffer: float, lighter: float) -> System:
    """A load that swings on a rope of `stiffer` times the stiffness of steel, a loader of `lighter` times the mass of
    a real one between rope and load; all three in line and at rest at the start."""
    EA, reach = 6.0e8 * stiffer, (np.sin(ANGLE), 0.0, -np.cos(ANGLE))
    bodies = (
        Body("loader", 5.0e3 * lighter, (0.0, 0.0, 0.5), diagonal(1.0e3 * lighter)),
        Body("load", MASS, (0.0, 0.0, -5.0), diagonal(1.0e6)),
    )
    half = (0.0, -np.sin(ANGLE / 2.0), 0.0, np.cos(ANGLE / 2.0))
    joints = (
        Joint("fly", "free", "world", "load", q0=(*(LENGTH * x for x in reach), *half), v0=(0.0,) * 6),
        Joint("hinge", "revolute", "load", "loader", axis=Y),
    )
    span, pull = LENGTH - 1.0, (MASS + bodies[0].mass) * G * np.cos(ANGLE)
    rope = Rope("rope", (Line(Point("world"), Point("loader", (0.0, 0.0, 1.0))),), EA, EA * span / (EA + pull))
    return System(bodies, joints, ropes=(rope,), gravity=G)


def swung(method, tolerance, stiffer=1.0, lighter=1.0):
    s = started(swing(stiffer, lighter), method=method, tolerance=tolerance)
    hand_over(s, 4 * SECOND)
    return s, s.state[:3].copy()


@pytest.mark.parametrize(
    ("method", "stiffer", "lighter", "most"),
    [
        ("radau5", 1.0, 1e-6, 200),  # explicit: 4 s at 7.7e4 rad/s, 1e5 steps
        ("radau5", 1e6, 1.0, 800),  # explicit: 4 s at 1e4 rad/s for the load, 8e7 rad/s for the loader
        ("radau5", 9e5, 1e-6, 6000),
        ("radau5", 1e6, 1e-6, 6000),
    ],
)
def test_stiff_ropes_and_light_lifting_beams_need_few_steps(method, stiffer, lighter, most):
    s, place = swung(method, COARSE, stiffer, lighter)
    _, exact = swung("radau5", FINE, stiffer, lighter)
    assert place == pytest.approx(exact, abs=CLOSE)
    assert s["accepted"] + s["rejected"] < most
