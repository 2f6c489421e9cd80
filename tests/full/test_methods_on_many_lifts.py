"""Method and tolerance on lifts at random: the chosen one is the cheapest or nearly so, costs what was predicted, and
adds no more to the error of what is asked than was predicted."""

import sys
from functools import cache
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from steps_down import RESOLUTION
from steps_taken import taken

SEEDS = range(101, 113)
ACCURACIES = (0.05, 0.01)
NEARLY = 1.5  # times the cheapest
MOST, ALMOST = 0.9, 0.95
FACTOR = 3.0  # between predicted and measured cost: durations of stages that wait for an event are known to that
LOOSE = 15.0  # bound over error in the median, of errors that can be seen: bounds are those of lifts of all kinds


@cache
def runs():
    return [taken(seed, accuracy) for seed in SEEDS for accuracy in ACCURACIES]


def test_the_chosen_method_is_nearly_the_cheapest():
    several = [scene for scene in runs() if len(scene) > 1]
    good = [scene for scene in several if scene[0].cost <= NEARLY * min(run.cost for run in scene)]
    assert len(good) >= MOST * len(several)


def test_costs_are_what_was_predicted():
    ratios = [run.predicted.cost.product / run.cost for scene in runs() for run in scene]
    assert all(1.0 / FACTOR < ratio < FACTOR for ratio in ratios), (min(ratios), max(ratios))


def test_errors_are_at_most_what_was_predicted_and_not_much_less():
    seen = [
        (run.errors[q], run.predicted.errors[q], RESOLUTION[q]) for scene in runs() for run in scene for q in run.ask
    ]
    kept = [error <= bound + resolution for error, bound, resolution in seen]
    assert sum(kept) >= ALMOST * len(kept)
    assert median(bound / error for error, bound, resolution in seen if error > resolution) <= LOOSE
