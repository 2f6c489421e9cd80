"""Two goliaths turn their blocks side by side: each block moves as it does alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording

TEXT = """\
heavylift: 1
name: two
samples: 1 Hz
lifts:
  a: {extends: single-turn}
  b: {extends: single-turn, at: [-20 m, 400 m], start: 7 s}
"""


def test_blocks_turned_side_by_side_have_the_peaks_of_single_lifts(tmp_path: Path) -> None:
    run(parse(TEXT), tmp_path / "two.mcap", in_process=True)
    run(load("single-turn", ["samples=1 Hz"]), tmp_path / "one.mcap", in_process=True)
    both, alone = (Recording(tmp_path / f"{name}.mcap").fact("peaks", {}) for name in ("two", "one"))
    assert len(both) == 2 * len(alone) == 18
    for name, peak in alone.items():
        for lift in "ab":
            assert both[f"{lift}-{name}"]["tension"] == pytest.approx(peak["tension"], rel=1e-4)
    turned = Recording(tmp_path / "two.mcap")["pose/b-block"].values[-1, 3:]
    assert abs(turned[0]) == pytest.approx(1.0, abs=1e-3), "half a turn about x"
