"""Thousands of corrupted descriptions: one error sentence, or a run with finite numbers."""

import sys
from pathlib import Path
from random import Random

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from every_law import yard
from goliath import scene
from random_trees import random_system
from spoiled import outcome, spoiled

CASES = 3000


@pytest.mark.parametrize("seed", range(CASES))
def test_a_corrupted_scene_runs_or_is_refused_in_one_sentence(seed):
    random = Random(10_000 + seed)
    system = random_system(seed, 6) if seed % 3 == 0 else scene() if seed % 30 == 1 else yard()
    for _ in range(random.choice((1, 1, 2, 4))):
        system = spoiled(system, random)
    assert "\n" not in outcome(system)
