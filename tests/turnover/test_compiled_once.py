"""A lift of one hour in twelve processes compiles its equations once, and its static equations once."""

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from the_run import Lift


def test_statics_and_run_of_the_scene_turnover_share_one_compiled_code(lift: Lift) -> None:
    assert sorted(path.suffix for path in lift.code.iterdir()) == [".o", ".o", ".path", ".scene"]


@pytest.mark.parametrize("change", ["accuracy=0.001 %", "block.mass=899 t", "rig.slack=51 mm"])
def test_changing_numbers_of_the_scene_turnover_compiles_no_new_machine_code(
    lift: Lift, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    before = {path: path.stat().st_ino for path in lift.code.glob("*.o")}  # new code is another file
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(lift.code))
    run(load("turnover", ["end=2 s", change]), tmp_path / "start.mcap", in_process=True)
    assert {path: path.stat().st_ino for path in lift.code.glob("*.o")} == before
