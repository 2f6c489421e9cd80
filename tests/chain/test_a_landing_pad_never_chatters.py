"""Near lift-off the friction of a pad falls faster than its tangential spring relaxes; sticking and slipping must not
follow each other without end, whatever the accuracy."""

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load


@pytest.mark.parametrize("accuracy", ["0.1 %", "0.005071 %", "0.02 %"])
def test_lift_off_comes_to_its_end_at_any_accuracy(tmp_path, accuracy):
    result = run(load("lift", [f"accuracy={accuracy}"]), tmp_path / "lift.mcap", in_process=True)
    assert result.sim_s > 59.9
    assert result.energy_error < 1e-4  # the loosest of them integrates to 1e-5 per step
