"""Nested by the book = flattened = 2 to 5 nodes, log for log, for 1000 random coupled models."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "nodes/devs"))

from nested_flat_cut import three_ways


@pytest.mark.parametrize("block", range(10))
def test_a_thousand_coupled_models_give_the_same_log_as_the_flat_simulator(block: int) -> None:
    for seed in range(1000 + 100 * block, 1100 + 100 * block):
        by_the_book, flattened, cut = three_ways(seed)
        assert flattened == by_the_book, seed
        assert cut == by_the_book, seed
