"""A run depends on its scene only: processes, start order, hash seeds, repeats and time grants change no byte.

The digest is SHA-256 over all events and sample rows.  `lift` stands for all combinations; `turnover` is run once
more, in one process.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from random import Random

import heavylift.coordinator.run.scene as runner
import pytest
from cut_short import CutShort
from heavylift.coordinator.run import conversation
from heavylift.nodes.scene import load
from stock_reader import Reading
from the_run import Lift

SEEDED = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()"]  # keeps the hash seed it is given
NODES = ["commander", "crane", "loader-1", "loader-2", "loader-3", "block", "kernel"]


@pytest.fixture(scope="session")
def truth(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Digest of `lift` in one process."""
    return runner.run(load("lift"), tmp_path_factory.mktemp("truth") / "lift.mcap", in_process=True).digest


def test_the_scene_turnover_has_one_digest_in_one_process_and_in_twelve(lift: Lift, tmp_path: Path) -> None:
    alone = runner.run(load("turnover"), tmp_path / "turnover.mcap", in_process=True)
    assert alone.digest == lift.result.digest
    assert alone.peaks == lift.result.peaks
    assert alone.energy_error == lift.result.energy_error


def test_a_recording_of_the_scene_turnover_has_the_digest_of_the_run(lift: Lift, reading: Reading) -> None:
    assert reading.metadata["result"]["digest"] == lift.result.digest


@pytest.mark.large
def test_ten_repeated_runs_of_the_scene_turnover_have_one_digest(truth: str, tmp_path: Path) -> None:
    digests = [runner.run(load("lift"), tmp_path / f"{i}.mcap", in_process=True).digest for i in range(10)]
    assert set(digests) == {truth}


@pytest.mark.parametrize("seed", [None, 1, 2])
@pytest.mark.large(beyond=1)
def test_the_digest_of_the_scene_turnover_does_not_depend_on_the_start_order_of_processes(
    truth: str, tmp_path: Path, seed: int | None
) -> None:
    order = NODES if seed is None else Random(seed).sample(NODES, len(NODES))
    assert runner.run(load("lift"), tmp_path / "lift.mcap", order=order).digest == truth


@pytest.mark.parametrize("seed", [3, 4])
def test_the_digest_of_the_scene_turnover_does_not_depend_on_the_order_of_nodes_in_one_process(
    truth: str, tmp_path: Path, seed: int
) -> None:
    order = Random(seed).sample(NODES, len(NODES))
    assert runner.run(load("lift"), tmp_path / "lift.mcap", in_process=True, order=order).digest == truth


@pytest.mark.parametrize(("seed", "where"), [("0", []), ("1", []), ("4711", ["--in-process"])])
@pytest.mark.large
def test_the_digest_of_the_scene_turnover_does_not_depend_on_hash_seeds(
    truth: str, tmp_path: Path, seed: str, where: list[str]
) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    subprocess.run(
        [*SEEDED, "run", "lift", *where], cwd=tmp_path, env=environment, check=True, capture_output=True, timeout=60
    )
    digest = Reading(tmp_path / "lift.mcap").metadata["result"]["digest"]
    assert digest.strip('"') == truth


def test_another_scene_has_a_digest_that_differs_from_that_of_the_scene_turnover(truth: str, tmp_path: Path) -> None:
    other = runner.run(load("lift", ["rig.slack=51 mm"]), tmp_path / "lift.mcap", in_process=True)
    assert other.digest != truth


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.large(beyond=2)
def test_cutting_time_grants_short_at_random_does_not_change_the_digest_of_a_run(
    truth: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setattr(conversation, "OpenCoordinator", CutShort)
    CutShort.random, CutShort.cuts = Random(seed), 0
    run = runner.run(load("lift"), tmp_path / "lift.mcap", in_process=True)
    assert CutShort.cuts > 100, CutShort.cuts
    assert run.digest == truth


def test_cutting_time_grants_short_at_random_does_not_change_the_first_100_s_of_the_scene_turnover(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first 100 s with two cranes and twelve slings: the slings chatter as they come taut."""
    scene = load("turnover", ["end=100 s"])
    whole = runner.run(scene, tmp_path / "whole.mcap", in_process=True)
    monkeypatch.setattr(conversation, "OpenCoordinator", CutShort)
    CutShort.random, CutShort.cuts = Random(7), 0
    cut = runner.run(scene, tmp_path / "cut.mcap", in_process=True)
    assert CutShort.cuts > 100, CutShort.cuts
    assert cut.grants > whole.grants
    assert cut.digest == whole.digest
