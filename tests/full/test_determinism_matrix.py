"""All combinations of all disturbances: 20 runs of a random model in each, a scene in each, turnover in all pairs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "determinism"))

from disturbances import Case, digests, full, pairwise

RUNS = 20


def alike(cases: list[Case]) -> None:
    found = digests(cases)
    truth = found[cases[0]]
    assert not [case for case in cases if found[case] != truth]


@pytest.mark.parametrize("seed", [9])
def test_twenty_runs_of_a_random_model_have_one_digest_under_all_combinations_of_processes_and_grants(
    seed: int,
) -> None:
    alike(full(f"random_models:build({seed}) 60", RUNS))


def test_a_lift_has_one_digest_under_all_combinations_of_processes_and_grants() -> None:
    alike(full("scene lift end=25s", 2))


def test_the_scene_turnover_has_one_digest_under_all_pairs_of_execution_conditions() -> None:
    alike(pairwise("scene turnover end=100s"))
