"""The reference that accuracies are judged by, against itself: tighter steps, more lumps change a twentieth at most."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from kept import RTOL, reference
from measuring import apart

FINEST = 0.003  # accuracy that it judges
PART = 20.0  # of the accuracy, it may be wrong by
SEEDS = {3: "two hooks in a plane", 1001: "one", 5: "five, lifted by a way"}


@pytest.mark.parametrize("seed", SEEDS, ids=SEEDS.get)
def test_it_is_twenty_times_as_exact_as_the_finest_accuracy(seed):
    errors = apart(reference(seed), reference(seed, rtol=RTOL / 10.0, lumps=4))
    assert max(errors.values()) <= FINEST / PART, errors
