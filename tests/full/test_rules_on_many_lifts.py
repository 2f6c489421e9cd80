"""Each rule on forty lifts: it bounds every one, and is at most ten times too careful in the
median; of positions twenty times, of lift-off thirty: sag and droop are counted in full where most of them cancels."""

import sys
from pathlib import Path
from statistics import median

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

from steps_down import RESOLUTION, STEPS, measured

SEEDS = range(100, 140)
CAREFUL = {"rope tension": 10.0, "swing": 10.0, "position": 20.0, "lift-off time": 30.0}
MANY = 10  # scenes from which a median tells something


SHORT = pytest.mark.xfail(reason="seed 101: of five hooks the last lifts at once; its stage is shorter than predicted")
KNOWN = ("rope_mass", "hinges")
CASES = [pytest.param(rule, id=rule.__name__, marks=SHORT if rule.__name__ in KNOWN else ()) for rule in STEPS]


@pytest.mark.parametrize("rule", CASES)
def test_a_rule_is_a_bound_and_a_close_one(rule):
    found = [(seed, m) for seed in SEEDS if (m := measured(seed, rule))]
    assert found
    for quantity, least in RESOLUTION.items():
        pairs = [(seed, p.get(quantity, 0.0), e[quantity]) for seed, (p, e) in found]
        assert [(seed, p, e) for seed, p, e in pairs if e > p + least] == [], quantity
        seen = [p / e for _, p, e in pairs if e > least]
        assert len(seen) < MANY or median(seen) <= CAREFUL[quantity], quantity
