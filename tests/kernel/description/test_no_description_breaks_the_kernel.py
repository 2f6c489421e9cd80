"""A corrupted scene ends in one sentence or in a run with finite numbers; tests/full runs thousands of cases."""

from random import Random

import pytest
from every_law import yard
from random_trees import random_system
from spoiled import misfit, outcome, spoiled

CASES = 40


@pytest.mark.parametrize("seed", range(CASES))
@pytest.mark.large(beyond=20)
def test_a_corrupted_scene_runs_or_is_refused_in_one_sentence(seed):
    random = Random(seed)
    system = random_system(seed, 4) if seed % 4 == 0 else yard()
    for _ in range(random.choice((1, 1, 2, 4))):
        system = spoiled(system, random)
    text = outcome(system)
    assert text
    assert "\n" not in text


@pytest.mark.parametrize("seed", range(CASES))
@pytest.mark.large(beyond=20)
def test_a_scene_with_values_of_wrong_types_runs_or_is_refused_in_one_sentence(seed):
    random = Random(seed)
    text = outcome(misfit(yard(), random))
    assert text
    assert "\n" not in text
