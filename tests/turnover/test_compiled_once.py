"""Twelve processes, an hour of lift, hundreds of switches: the equations become machine code exactly once."""

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from the_run import Lift


def test_the_whole_lift_leaves_one_object_file(lift: Lift) -> None:
    assert [path.suffix for path in lift.code.iterdir()] == [".o"]


@pytest.mark.parametrize("change", ["accuracy=0.001 %", "block.mass=899 t", "rig.slack=51 mm"])
def test_other_numbers_need_no_other_code(
    lift: Lift, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    (code,) = lift.code.iterdir()
    written = code.stat().st_mtime_ns
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(lift.code))
    run(load("turnover", ["end=2 s", change]), tmp_path / "start.mcap", in_process=True)
    assert list(lift.code.iterdir()) == [code]
    assert code.stat().st_mtime_ns == written
