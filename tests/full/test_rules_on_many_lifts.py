"""Each rule on forty lifts: it bounds every one, and is at most ten times too careful in the
median; of positions twenty times, of lift-off thirty: sag and droop are counted in full where most of them cancels."""

import sys
from functools import cache
from pathlib import Path
from statistics import median

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

from steps_down import RESOLUTION, STEPS, measured

SEEDS = range(100, 140)
CAREFUL = {"rope tension": 10.0, "swing": 10.0, "position": 20.0, "lift-off time": 30.0}
MANY = 10  # scenes from which a median tells something


SHORT = pytest.mark.xfail(reason="seed 101: of five hooks the last lifts at once; its stage is shorter than predicted")
KNOWN = {("rope_mass", "lift-off time"), ("hinges", "lift-off time")}
CASES = [
    pytest.param(
        rule, quantity, id=f"{rule.__name__}, {quantity}", marks=SHORT if (rule.__name__, quantity) in KNOWN else ()
    )
    for rule in STEPS
    for quantity in RESOLUTION
]


@cache
def family(rule):
    """What a rule predicts on each lift, and what the rung above shows."""
    return [m for seed in SEEDS if (m := measured(seed, rule))]


@pytest.mark.parametrize(("rule", "quantity"), CASES)
def test_a_rule_is_a_bound_and_a_close_one(rule, quantity):
    least, found = RESOLUTION[quantity], family(rule)
    assert found
    pairs = [(predicted.get(quantity, 0.0), error[quantity]) for predicted, error in found]
    assert [(p, e) for p, e in pairs if e > p + least] == []
    seen = [p / e for p, e in pairs if e > least]
    assert len(seen) < MANY or median(seen) <= CAREFUL[quantity]
