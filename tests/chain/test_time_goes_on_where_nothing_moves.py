"""A scene at rest is recorded to its end time, and a swing without drives has its own energy balance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from chain import channel, play
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load

AT_REST = """\
heavylift: 1
name: parked
end: 5 s
mechanism:
  name: cart
  bodies:
    cart: {mass: 4 t}
  joints:
    rail: {type: prismatic, child: cart, axis: [1, 0, 0], start: 3 m}
"""


def test_a_scene_at_rest_is_recorded_up_to_its_end_time(tmp_path: Path) -> None:
    t, place = channel(play(tmp_path, AT_REST), "joint/position", "rail.travel")
    assert list(np.unique(t)) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0 - 1e-9]
    assert (place == 3.0).all()


def test_the_energy_error_of_a_swinging_pendulum_is_relative_to_its_kinetic_energy(tmp_path: Path) -> None:
    result = run(load("pendulum", ["end=20 s"]), tmp_path / "swing.mcap", in_process=True)
    drop = 60.0 * (1.0 - np.cos(np.radians(10.0)))
    assert abs(result.energy_turned_over / (450e3 * 9.80665 * drop) - 1.0) < 1e-3, "a sample lies near the bottom"
    assert result.energy_error < 1e-8
