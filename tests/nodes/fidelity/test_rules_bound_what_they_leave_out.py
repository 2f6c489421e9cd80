"""Each rule against the rung above it, on lifts at random: what it predicts bounds what is measured, and not by far."""

import pytest
from heavylift.nodes.fidelity import lumps
from steps_down import RESOLUTION, STEPS, measured

SEEDS = (1, 40)  # two hooks of one crane, four of two
QUICK = [rule for rule in STEPS if rule is not lumps]  # four lumps are many: see tests/full


@pytest.mark.parametrize("rule", QUICK, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.large(beyond=7)
def test_a_rule_predicts_at_least_what_is_measured(seed, rule):
    found = measured(seed, rule)
    if found is None:
        pytest.skip("this lift does not allow the rule")
    predicted, errors = found
    for quantity, error in errors.items():
        assert error <= predicted.get(quantity, 0.0) + RESOLUTION[quantity], quantity
