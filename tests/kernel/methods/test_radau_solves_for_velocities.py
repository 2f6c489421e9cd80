"""The linear systems of Radau contain velocities only, and only the error of the state limits its steps."""

from random import Random

import numpy as np
import pytest
from heavylift.kernel.description import JOINTS, Body, Drive, Joint, Line, Point, Rope, System
from heavylift.kernel.multibody import rates, speeds
from small_scenes import SECOND, G, X, column, cube, hand_over, imbalance, started

ROUNDED = 1e-12
TOLERANCE = 1e-4
BEAM, TROLLEY, LONG = 2.0e4, 4.0e4, 20.0  # [kg], [kg], distance of the ropes [m]
SLOW = 0.05  # [m/s]


def carried() -> System:
    """A beam hung by two ropes, along which a trolley is driven."""
    ropes = tuple(
        Rope(name, (Line(Point("world", (x, 0.0, 0.0)), Point("beam", (x, 0.0, 0.5))),), 4e8, 15.0, damping=5e5)
        for name, x in (("left", -LONG / 2), ("right", LONG / 2))
    )
    bodies = (Body("beam", BEAM, inertia=cube(BEAM, LONG)), Body("trolley", TROLLEY, inertia=cube(TROLLEY)))
    joints = (
        Joint("free", "free", "world", "beam", q0=(0.0, 0.0, -15.52, 0.0, 0.0, 0.0, 1.0)),
        Joint("rail", "prismatic", "beam", "trolley", axis=X, q0=(-8.0,)),
    )
    return System(bodies, joints, ropes=ropes, drives=(Drive("drive", "rail", "prescribed"),), gravity=G)


def driven(**options):
    s = started(carried(), method="radau5", sample_ns=SECOND // 2, **options)
    s.references.set_profile("drive", 0, SLOW, 0.01, 16.0)
    s.settle()
    hand_over(s, 400 * SECOND)
    return s


def lever(t: np.ndarray, s) -> np.ndarray:
    """(n, 2) tensions of both ropes by the lever rule, with the trolley where the drive has it [N]."""
    x = column(s, "joint/position")[1][:, -1:]
    return 0.5 * BEAM * G + TROLLEY * G * (0.5 + np.hstack([-x, x]) / LONG)


@pytest.mark.parametrize("kind", [kind for kind, joint in JOINTS.items() if joint.n_v])
def test_radau_recovers_velocities_from_the_rates_of_coordinates(kind):
    r, joint = Random(kind), JOINTS[kind]
    q, v = (np.array([r.uniform(-1.0, 1.0) for _ in range(n)]) for n in (joint.n_q, joint.n_v))
    assert np.abs(speeds(kind, q, rates(kind, q, v)) - v).max() < ROUNDED


def test_a_trolley_crosses_a_hanging_beam_with_radau():
    """All is followed to the tolerance, the swing of the beam, too; the work of the drive, which grows by kilojoules in
    a step, says nothing against the iterations."""
    s = driven(tolerance=TOLERANCE)
    t, tensions = column(s, "rope/tension")
    assert np.abs(tensions - lever(t, s))[t > 100.0].max() < 10.0 * TOLERANCE * tensions.max()
    assert s["rejected"] < 0.1 * s["accepted"]
    assert s["accepted"] < 1000  # 4000 at steps of 0.1 s
    assert s["differences"] <= 0.1 * s["accepted"] * 2 * s.program.nv
    assert imbalance(s) < 1e-3
