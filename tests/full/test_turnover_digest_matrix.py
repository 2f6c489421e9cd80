"""Digests of `turnover`: ten repeats, start orders, hash seeds, one process and twelve, split time grants."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from random import Random

import heavylift.coordinator.run.scene as runner
import pytest
from heavylift.coordinator.run import conversation
from heavylift.nodes.scene import load

sys.path.append(str(Path(__file__).parents[1] / "turnover"))

from cut_short import CutShort
from stock_reader import Reading
from test_one_digest import SEEDED

NODES = ["commander", "west", "east", *(f"loader-{i}" for i in range(1, 7)), "block", "kernel"]


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> str:
    return runner.run(load("turnover"), tmp_path_factory.mktemp("truth") / "turnover.mcap", in_process=True).digest


@pytest.mark.parametrize("repeat", range(10))
def test_ten_repeated_runs_of_the_scene_turnover_in_random_order_have_one_digest(
    truth: str, tmp_path: Path, repeat: int
) -> None:
    order = Random(repeat).sample(NODES, len(NODES))
    run = runner.run(load("turnover"), tmp_path / "turnover.mcap", in_process=repeat % 2 == 1, order=order)
    assert run.digest == truth


@pytest.mark.parametrize("where", [[], ["--in-process"]])
@pytest.mark.parametrize("seed", ["0", "1", "4711"])
def test_the_digest_of_the_scene_turnover_does_not_depend_on_the_hash_seed_of_python(
    truth: str, tmp_path: Path, seed: str, where: list[str]
) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    command = [*SEEDED, "run", "turnover", *where]
    subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, timeout=120)
    assert Reading(tmp_path / "turnover.mcap").metadata["result"]["digest"].strip('"') == truth


@pytest.mark.parametrize("seed", range(3))
def test_cutting_time_grants_short_at_random_does_not_change_the_digest_of_the_scene_turnover(
    truth: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setattr(conversation, "OpenCoordinator", CutShort)
    CutShort.random, CutShort.cuts = Random(seed), 0
    assert runner.run(load("turnover"), tmp_path / "turnover.mcap", in_process=True).digest == truth
    assert CutShort.cuts > 10_000
