"""Along the equilibrium path of a slow drive the steps of an implicit method are as long as the tensions allow."""

import numpy as np
from heavylift.kernel.description.mechanics import Body, Drive, Joint, Line, Point, Rope, System
from small_scenes import SECOND, G, X, column, cube, hand_over, started

BEAM, TROLLEY, LONG = 2.0e4, 4.0e4, 20.0  # [kg], [kg], distance of the ropes [m]
ASKED = 0.01  # of the tensions
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


def test_a_trolley_crosses_a_hanging_beam_in_long_steps():
    s = driven(tolerance=1e-3)
    t, tensions = column(s, "rope/tension")
    wrong = np.abs(tensions - lever(t, s)) / tensions.max()
    assert wrong[t > 5.0].max() < ASKED
    assert s["accepted"] < 200  # the swing of the beam alone is 50 periods
