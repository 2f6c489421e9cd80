"""The protocol on thousands of random models, in several orders each (CI runs 300 of them)."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "coordination"))

from random_models import distributed, flat, wave


@pytest.mark.parametrize("block", range(10))
def test_thousands_of_models_log_for_log(block: int) -> None:
    waves = 0
    for seed in range(1000 + 400 * block, 1400 + 400 * block):
        truth = flat(seed)
        for order in range(4):
            run = distributed(seed, order, cut=order > 1, ahead=order == 3)
            assert run.logs == truth, (seed, order)
        waves += wave(seed) != truth
    assert waves > 150
