"""Near lift-off a pad's friction falls faster than its spring relaxes: slip and stick do not alternate."""

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load

BALANCE = 0.1  # of the tolerance of a step: five times what the worst of them, 0.1 %, leaves


@pytest.mark.parametrize("accuracy", ["0.1 %", "0.005071 %", "0.02 %"])
def test_a_support_opens_exactly_once_at_lift_off_at_any_integration_tolerance(tmp_path, accuracy):
    scene = load("lift", [f"accuracy={accuracy}"])
    result = run(scene, tmp_path / "lift.mcap", in_process=True)
    assert result.sim_s > 59.9
    assert result.energy_error < BALANCE * scene.plan.tolerance
