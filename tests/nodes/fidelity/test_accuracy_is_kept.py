"""`accuracy:` is kept: lifts at random on the rungs that are chosen for them, against the richest in other code."""

import pytest
from kept import judged, reference

SEEDS = (3,)  # two hooks in a plane
LOOSE, FINE = 0.05, 0.01
MUCH = 10  # times less than the richest rung costs


@pytest.mark.large
@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_asked_is_as_accurate_as_asked_and_costs_less_the_less_is_asked(seed):
    true = reference(seed)
    loose, fine = (judged(seed, accuracy, true) for accuracy in (LOOSE, FINE))
    assert max(loose.worst, fine.worst) <= 1.0, (loose, fine)
    assert loose.cost <= fine.cost
    assert MUCH * loose.cost <= loose.richest
