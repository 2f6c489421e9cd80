"""Its systems have the velocities alone, its steps no limit but their error; accounts of work decide neither."""

from random import Random

import numpy as np
import pytest
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.multibody.motion import rates, speeds
from small_scenes import column, imbalance
from test_long_steps_follow_the_path import driven, lever

ROUNDED = 1e-12
TOLERANCE = 1e-4


@pytest.mark.parametrize("kind", [kind for kind, joint in JOINTS.items() if joint.n_v])
def test_velocities_come_back_from_the_rates_of_coordinates(kind):
    r, joint = Random(kind), JOINTS[kind]
    q, v = (np.array([r.uniform(-1.0, 1.0) for _ in range(n)]) for n in (joint.n_q, joint.n_v))
    assert np.abs(speeds(kind, q, rates(kind, q, v)) - v).max() < ROUNDED


def test_a_trolley_crosses_a_hanging_beam():
    """All is followed to the tolerance, the swing of the beam, too; the work of the drive, which grows by kilojoules in
    a step, says nothing against the iterations."""
    s = driven("radau5", tolerance=TOLERANCE)
    t, tensions = column(s, "rope/tension")
    assert np.abs(tensions - lever(t, s))[t > 100.0].max() < 10.0 * TOLERANCE * tensions.max()
    assert s["rejected"] < 0.1 * s["accepted"]
    assert s["accepted"] < 1000  # 4000 at steps of 0.1 s
    assert s["differences"] <= 0.1 * s["accepted"] * 2 * s.program.nv
    assert imbalance(s) < 1e-3
