"""Each rule on forty lifts: it bounds every one, and is at most ten times too careful in the median."""

import sys
from functools import cache
from pathlib import Path
from statistics import median

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from steps_down import RESOLUTION, STEPS, measured

SEEDS = range(100, 140)
CAREFUL = 10.0
MANY = 10  # scenes from which a median tells something


@cache
def family(rule):
    """What a rule predicts on each lift, and what the rung above shows."""
    return {seed: m for seed in SEEDS if (m := measured(seed, rule))}


@pytest.mark.parametrize("rule", STEPS, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("quantity", RESOLUTION)
def test_a_rule_is_a_bound_and_a_close_one(rule, quantity):
    least, found = RESOLUTION[quantity], family(rule)
    assert found
    pairs = {seed: (predicted[quantity], error[quantity]) for seed, (predicted, error) in found.items()}
    assert {seed: (p, e) for seed, (p, e) in pairs.items() if e > p + least} == {}
    seen = [p / e for p, e in pairs.values() if e > least]
    assert len(seen) < MANY or median(seen) <= CAREFUL
