"""A recording read with stock tools satisfies Newton's laws.

`stock_reader` and `independent_mechanics` use mcap, protobuf, json and NumPy and nothing of heavylift: tensions come
out of poses, velocities and unstretched lengths, forces out of tensions, accelerations out of both forces and places.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from independent_mechanics import Mechanics
from stock_reader import Array, Reading
from the_run import Stage

TENSION = 1e-9  # of the largest tension
EDGE = 1e-11  # [m] stretch of a rope that snaps taut at this nanosecond; its damper pulls at once
STILL = 1e-4  # of the weight
NEWTON = 5e-4  # of the largest acceleration, where finite differences resolve the motion
SWING = 3e-4  # [m/s2] of the pendulum motion, whose finite differences take half a second


def test_the_independent_reader_imports_nothing_of_heavylift() -> None:
    folder = str(Path(__file__).parent)
    code = "import sys; sys.path.insert(0, sys.argv[1]); import stock_reader, independent_mechanics; "
    code += "sys.exit(any(name.startswith('heavylift') for name in sys.modules))"
    subprocess.run([sys.executable, "-c", code, folder], check=True, timeout=30)


def test_recorded_tensions_follow_from_poses_lengths_and_rates(reading: Reading, mechanics: Mechanics) -> None:
    largest = reading.values["/rope/tension"].max()
    for name in (*mechanics.hook_ropes, *mechanics.slings):
        message, pull = reading.column("/rope/tension", name), mechanics.pulls[name]
        expected = np.where((np.abs(pull.stretch) < EDGE) & (message > 0.0), pull.if_taut, pull.tension)
        assert np.max(np.abs(expected - message)) < TENSION * largest, name


def test_recorded_tensions_are_not_reproduced_without_rope_damping(mechanics: Mechanics) -> None:
    """Without the rates the same recomputation would be wrong by far more than its tolerance."""
    heating = max(pull.heating.max() for pull in mechanics.pulls.values())
    assert heating > 1.0


@pytest.mark.parametrize("stage", ["settle", "settle on A", "rigging", "settle on A and C", "settle 2", "rest"])
def test_vertical_forces_on_the_resting_block_equal_its_weight(
    mechanics: Mechanics, stages: dict[str, Stage], stage: str
) -> None:
    weight = mechanics.bodies["block"].mass * mechanics.g
    assert np.abs(mechanics.on_block[stages[stage].last(5.0), 2] / weight - 1.0).max() < STILL


def test_the_common_centre_of_mass_accelerates_by_the_sum_of_forces_over_mass(fine: Mechanics) -> None:
    """From the instant of lift-off on, fifty samples a second; twice: from velocities and from places."""
    _, p, v = fine.common
    a, air = fine.acceleration, fine.reading.said("block", "report", "Lifted")[0]["t_ns"] * 1e-9
    k, h = _even(fine.reading, 0.02, air)
    largest = np.abs(a[k]).max()
    assert largest > 0.08  # the hoists ramp up
    from_velocity = (v[k + 1] - v[k - 1]) / (2 * h) - (a[k - 1] + 4 * a[k] + a[k + 1]) / 6  # Simpson
    from_place = (p[k + 1] - 2 * p[k] + p[k - 1]) / h**2 - (a[k - 1] + 10 * a[k] + a[k + 1]) / 12  # Numerov
    assert np.abs(from_velocity).max() < NEWTON * largest
    assert np.abs(from_place).max() < NEWTON * largest


def test_the_common_centre_of_mass_also_accelerates_sideways_by_the_forces(
    mechanics: Mechanics, stages: dict[str, Stage]
) -> None:
    """Two samples a second resolve the swing along rails and girders, from the travel to the lowering."""
    _, p, _ = mechanics.common
    a = mechanics.acceleration
    k, h = _even(mechanics.reading, 0.5, stages["travel"].start, stages["lower"].end)
    from_place = (p[k + 1] - 2 * p[k] + p[k - 1]) / h**2 - (a[k - 1] + 10 * a[k] + a[k + 1]) / 12
    assert np.abs(a[k, 0]).max() > 0.05
    assert np.abs(from_place[:, :2]).max() < SWING


def _even(reading: Reading, h: float, start: float, end: float = np.inf) -> tuple[Array, float]:
    """Samples with a neighbour h [s] before and after."""
    t, k = reading.t, np.arange(1, len(reading.t) - 1)
    even = (np.abs(t[k + 1] - t[k] - h) < 1e-7) & (np.abs(t[k] - t[k - 1] - h) < 1e-7)
    return k[even & (t[k - 1] > start) & (t[k + 1] < end)], h
