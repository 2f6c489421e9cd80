"""The reference that accuracies are judged by, against itself: finer steps, more lumps."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

from kept import reference
from measuring import apart

SEEDS = (3, 1001)  # two hooks in a plane, one
FINEST = 0.003  # accuracy that it judges
PART = 20.0  # of that, it may be wrong by


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("finer", [{"rtol": 1e-5}, {"lumps": 4}], ids=str)
def test_it_is_twenty_times_as_exact_as_the_finest_accuracy(seed, finer):
    errors = apart(reference(seed), reference(seed, **finer))
    assert max(errors.values()) <= FINEST / PART, errors
