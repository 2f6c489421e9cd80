"""The protocol on thousands of random models, in several orders and placements each (by default there are 100).

pytest -n auto tests/full/test_protocol_matrix.py        10 600 runs, ten minutes of CPU time
"""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "coordinator/protocol"))

from one_wave import wave
from random_models import build, build_deep, build_ring, distributed, flat, told

ORDERS = 4


@pytest.mark.parametrize("block", range(14))
def test_thousands_of_distributed_random_models_give_the_same_log_as_the_flat_simulator(block: int) -> None:
    waves = 0
    for seed in range(1000 + 100 * block, 1100 + 100 * block):
        truth = flat(seed)
        runs = [
            distributed(seed, order, cut=order > 1, ahead=order == 3, tight=order % 2 == 1) for order in range(ORDERS)
        ]
        assert [run.logs == truth for run in runs] == [True] * ORDERS, seed
        assert all(run.events == runs[0].events == sorted(run.events) for run in runs), seed
        waves += wave(seed) != truth
    assert waves > 30


@pytest.mark.parametrize("block", range(50))
def test_thousands_of_random_models_on_random_processes_give_the_same_log_as_the_flat_simulator(block: int) -> None:
    for seed in range(5000 + 100 * block, 5100 + 100 * block):
        made = (build, build_deep, build_ring)[seed % 3]
        truth = flat(seed, build=made)
        run = distributed(seed, seed, cut=seed % 2 > 0, tight=seed % 5 < 2, build=made, together=seed // 3)
        assert run.logs == truth, seed
        assert run.results == told(seed, build=made), seed
        assert run.events == sorted(run.events), seed
        if block == 0:
            assert run.events == distributed(seed, build=made).events, seed
