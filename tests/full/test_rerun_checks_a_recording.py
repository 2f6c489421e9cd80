"""`rerun mcap check`, an independent checker, finds no fault in the recording of a whole run."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load

RERUN = shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")


@pytest.mark.skipif(
    RERUN is None, reason="rerun is not installed (pip install rerun-sdk): the recording is not checked"
)
def test_the_viewer_of_the_project_rerun_opens_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "lift.mcap"
    run(load("lift"), path, in_process=True)
    done = subprocess.run([str(RERUN), "mcap", "check", str(path)], capture_output=True, text=True, timeout=300)
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    assert "/samples" in text
    states = [line.split()[0] for line in text.splitlines() if " /" in line and not line.startswith("/")]
    assert set(states) == {"ok"}, text
