"""Three lifts in one process, in three, and in one for each of their models: the same run to the last byte."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Placement
from heavylift.nodes.models import KERNEL, build
from heavylift.nodes.scene import load


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Digest of `yard` in the coordinator's process."""
    return run(load("yard"), tmp_path_factory.mktemp("truth") / "yard.mcap", in_process=True).digest


@pytest.mark.parametrize("count", [1, 3, 8])
def test_the_placement_of_models_on_processes_changes_no_byte_of_the_recording(
    truth: str, tmp_path: Path, count: int
) -> None:
    scene = load("yard")
    placement = Placement.spread([*build(scene.plan), KERNEL], count)
    found = run(scene, tmp_path / "yard.mcap", processes=Processes(), placement=placement)
    assert found.digest == truth
