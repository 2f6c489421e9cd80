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
SEEDS = {3: FEW, 1001: FEW, 5: MANY, 40: MANY}  # two hooks in a plane, one, five lifted by a way, four
PART = 20.0  # of the accuracy, it may be wrong by
TIGHTER, LUMPS = 10.0, 4  # than its tolerance; in place of two


@pytest.mark.parametrize(("seed", "finest"), SEEDS.items())
def test_it_is_twenty_times_as_exact_as_the_finest_accuracy(seed, finest):
    errors = apart(reference(seed), reference(seed, rtol=RTOL / TIGHTER, lumps=LUMPS))
    assert max(errors.values()) <= finest / PART, errors
