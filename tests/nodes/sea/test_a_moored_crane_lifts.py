"""The bundled scene `moored`: a crane on a barge on four catenary lines in an irregular sea; and its energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import RunResult, run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording

LINES = [f"{f}-{p}" for f in ("fore", "aft") for p in ("port", "starboard")]
UNKNOWN = ("sea state", "slow drift")  # of one seed, of these data
BALANCE = 0.01  # of the energy turned over, at the tolerance of the scene; it falls with that


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunResult, Recording]:
    path = tmp_path_factory.mktemp("moored") / "moored.mcap"
    return run(load("moored"), path, in_process=True), Recording(path)


def test_all_checks_of_the_moored_lift_are_green_except_those_of_sea_state_and_slow_drift(
    ran: tuple[RunResult, Recording],
) -> None:
    """One seed is no verdict on a sea, and its data have no drift; all else is green, with a row for each line."""
    checks = [x for x in ran[0].verdict.checks if x.state != "none"]
    assert {(x.quantity, x.state) for x in checks if x.state != "green"} == {(x, "amber") for x in UNKNOWN}
    lines = [x for x in checks if x.quantity == "rope tension" and x.subject in LINES]
    assert len(lines) == 4
    assert all(0.1 < x.use < 0.2 for x in lines)


def test_the_moored_barge_moves_in_waves_and_its_lines_hold_it(ran: tuple[RunResult, Recording]) -> None:
    pose = ran[1].signal("pose/barge")
    late = pose.t > 30.0
    assert 1e-3 < np.ptp(pose["z"][late]) < 0.5
    assert max(np.abs(pose[axis]).max() for axis in "xy") < 1.0


def test_the_energy_balance_of_a_system_with_waves_and_water_and_mooring_lines_closes(
    ran: tuple[RunResult, Recording],
) -> None:
    """What waves and winches bring in is in motion, heights, strain and water, or went away as waves."""
    assert 0.0 < ran[0].energy_error < BALANCE


@pytest.mark.parametrize("tolerance", ["1e-5", "1e-8"])
def test_the_energy_balance_in_waves_improves_with_the_tolerance(tolerance: str, tmp_path: Path) -> None:
    """In waves of two metres, of which the barge takes and loses hundreds of kilojoules."""
    given = ["waves.seas.wind.Hs=2 m", "waves.seas.wind.Tp=8 s", "end=60 s", "method=dopri5", "fidelity={}"]
    scene = load("moored", [*given, f"tolerance={tolerance}"])
    result = run(scene, tmp_path / "rough.mcap", in_process=True)
    assert result.energy_turned_over > 1e5
    assert result.energy_error < 10.0 * float(tolerance)
