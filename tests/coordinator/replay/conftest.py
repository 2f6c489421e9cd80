"""One small lift, recorded once for all stories of a file."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load


@pytest.fixture(scope="module")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of the bundled scene `lift`, of its first 20 seconds."""
    path = tmp_path_factory.mktemp("lift") / "lift.mcap"
    run(load("lift", ["end=20 s"]), path, in_process=True)
    return path


@pytest.fixture
def recorded(lift: Path) -> RecordedRun:
    """The same as what it was made of."""
    return RecordedRun(lift)
