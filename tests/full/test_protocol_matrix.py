"""The protocol on thousands of random models, in several orders each, and its mutants (by default there are 100).

pytest -n auto tests/full/test_protocol_matrix.py        5600 runs, two minutes of CPU time
"""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "coordinator/protocol"))

from random_models import distributed, flat, wave

ORDERS = 4


@pytest.mark.parametrize("block", range(14))
def test_thousands_of_models_log_for_log(block: int) -> None:
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
