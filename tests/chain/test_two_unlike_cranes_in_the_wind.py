"""Two cranes, one 5 % slower, carry a block through gusts: the distance of their hooks."""

import numpy as np
import pytest
from heavylift import simulate
from heavylift.nodes.scene import load

WAY, EAST, WEST = 12.0, 20 / 60, 19 / 60  # [m], [m/s]
SERVO = 5e-3  # of the parting: how far the drives give way under the ropes that lean
MEAN, DEVIATION = 10.0, 1.5  # [m/s]
SHORT = 0.5  # of the deviation: how far the mean of 200 s may be off


def test_the_distance_between_cranes_of_different_travel_speeds_follows_their_speed_profiles() -> None:
    """Both start with ramps of one time T; while the faster one stops with T / 2 behind it, the slower one catches up:
    d = (v - w) (s / v - T / 2) + (v - w)² T / 2 v."""
    scene = load("wind-tandem")
    T = EAST / next(o.accel for a in scene.plan.actions for o in a.orders if getattr(o, "verb", "") == "travel")
    result = simulate(scene, every=0.2)
    travel = result["joint/position"]
    parted = np.abs(travel["east.gantry.travel"] - travel["west.gantry.travel"])
    parted -= parted[0]
    apart = EAST - WEST
    assert parted.max() == pytest.approx(apart * (WAY / EAST - T / 2) + apart**2 * T / (2 * EAST), rel=SERVO)
    assert parted[-1] == pytest.approx(0.0, abs=SERVO * parted.max())
    speed = result["wind/speed"]["wind.block"]
    assert abs(speed.mean() - MEAN) < SHORT * DEVIATION
    assert speed.max() < 15.0, "what the scene allows"
    assert result.verdict is not None
    assert not result.verdict.red
