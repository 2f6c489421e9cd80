"""Hundreds of random mechanisms give a finite run with a closed energy balance, or one error sentence."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from random_mechanisms import CLOSES, has_loops, mechanism, outcome
from small_scenes import SECOND

CASES = 300


@pytest.mark.parametrize("seed", range(CASES))
def test_random_mechanisms_with_masses_over_two_decades_run_and_balance_their_energy(seed):
    sentence, error = outcome(mechanism(seed, 2.0))
    assert "\n" not in sentence
    assert not sentence.startswith(":")
    assert error < CLOSES


@pytest.mark.parametrize("seed", range(CASES))
def test_random_mechanisms_with_masses_over_twelve_decades_run_or_end_in_an_error(seed):
    system = mechanism(seed, 12.0)
    sentence, error = outcome(system, SECOND // 50)
    assert "\n" not in sentence
    assert not sentence.startswith(":")
    assert error < CLOSES or has_loops(system)
