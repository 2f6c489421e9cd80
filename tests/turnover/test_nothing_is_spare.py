"""Without any one process or action the lift ends with an error sentence or another result."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import HeavyliftError
from heavylift.nodes.scene import bundled, parse
from stock_reader import Reading

PATIENCE_s = 30.0
NODES = 11
ONE_OF_EACH_KIND = ["commander", "west", "loader-1", "block", "kernel"]


@pytest.mark.parametrize("node", ONE_OF_EACH_KIND)
@pytest.mark.large(beyond=1)
def test_a_killed_node_ends_the_run_with_an_error_that_names_the_node(tmp_path: Path, node: str) -> None:
    command = [sys.executable, Path(__file__).with_name("killer.py"), node, "run", "turnover"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_s)
    *_, sentence = done.stderr.strip().splitlines()
    assert done.returncode == 1
    assert sentence.startswith(f"heavylift: node {node} is gone at t = ")
    assert "its process was ended by signal 9 (SIGKILL)" in sentence
    assert "Traceback" not in done.stderr
    pids = [int(pid) for pid in done.stdout.splitlines()[0].split()]
    assert len(pids) == NODES
    deadline = time.monotonic() + PATIENCE_s
    while any(_lives(pid) for pid in pids):
        assert time.monotonic() < deadline, "a process is left"
        time.sleep(0.02)
    assert Reading(tmp_path / "turnover.mcap").metadata["result"]["status"] == "failed"


def test_without_the_action_to_take_up_slack_the_block_is_never_loaded(tmp_path: Path) -> None:
    with pytest.raises(HeavyliftError, match="still waiting for all slings taut"):
        _run_without("take up slack", tmp_path, end="")


def test_without_the_loading_action_hoisting_begins_on_the_supports(tmp_path: Path) -> None:
    """The block still lifts off, but at full speed: earlier, and with a jerk."""
    whole, other = _run_without("", tmp_path), _run_without("load", tmp_path)
    assert whole.said("block", "report", "Lifted")[0]["t_ns"] > other.said("block", "report", "Lifted")[0]["t_ns"]
    assert other.values["/rope/peak"].max() > 1.01 * whole.values["/rope/peak"].max()


@pytest.mark.parametrize("stage", ["unhook B", "hook C", "re-rig, pass beneath"])
def test_an_action_list_of_the_scene_turnover_with_any_re_rigging_step_left_out_cannot_run(
    tmp_path: Path, stage: str
) -> None:
    with pytest.raises(HeavyliftError) as message:
        _run_without(stage, tmp_path, end="")
    assert "turnover.yaml:" in str(message.value)


def _run_without(stage: str, folder: Path, end: str = "95 s") -> Reading:
    """The beginning of the lift without the action of this stage."""
    scene = parse(without(stage), "turnover.yaml", [f"end={end}"] if end else [])
    path = folder / f"{stage or 'whole'}.mcap"
    run(scene, path, in_process=True)
    return Reading(path)


def without(stage: str) -> str:
    """The text of the scene less one action ("": all of it)."""
    head, *actions = bundled()["turnover"].read_text().split("\n  - ")
    kept = [a for a in actions if a.partition("\n")[0].partition("#")[0].strip() != f"stage: {stage}"]
    assert len(kept) == len(actions) - bool(stage)
    return "\n  - ".join([head, *kept])


def _lives(pid: int) -> bool:
    """Whether the process runs; one that has ended and waits to be collected does not."""
    try:
        os.kill(pid, 0)
        status = Path(f"/proc/{pid}/stat")
        return not (status.exists() and status.read_text().rpartition(")")[2].split()[0] == "Z")
    except (ProcessLookupError, FileNotFoundError):
        return False
