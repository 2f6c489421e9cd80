"""The reference that accuracies are judged by, against itself: tighter steps and more lumps change a twentieth at most.

On more than three hooks the shares of a block that comes off its stools hang on little: it is that exact for 1 % only.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

from kept import RTOL, reference
from measuring import apart

FEW, MANY = 0.003, 0.01  # the finest accuracy that it judges, by the number of hooks
PART = 20.0  # of the accuracy, it may be wrong by
CASES = [
    (3, FEW, {"rtol": RTOL / 10.0, "lumps": 4}),  # two hooks in a plane
    (1001, FEW, {"rtol": RTOL / 10.0, "lumps": 4}),  # one
    (5, MANY, {"rtol": RTOL / 100.0}),  # five, lifted by a way
]


@pytest.mark.parametrize(("seed", "finest", "finer"), CASES, ids=str)
def test_it_is_twenty_times_as_exact_as_the_finest_accuracy(seed, finest, finer):
    errors = apart(reference(seed), reference(seed, **finer))
    assert max(errors.values()) <= finest / PART, errors
