"""The references that accuracies are judged by, against themselves: tighter steps, more lumps change little."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from heavylift.nodes.scene import parse
from kept import RTOL, reference
from lifted import lifted
from lifts_of_kinds import lift_of_kinds
from measuring import Seen, apart
from promised import STEPS, asked_of, richest, truth
from random_lifts import random_lift

FINEST = 0.003  # accuracy that it judges
PART = 20.0  # of the accuracy, it may be wrong by
KINDS = range(9200, 9220)  # lifts of every kind
CONVERGED, MOST = 5e-4, 18  # a sixth of the finest accuracy; but for what rings undamped, or recoils with a light hook
OTHERS = range(200, 220)  # lifts that the independent code knows
AGREE, ALMOST, NEVER = 1e-3, 19, 2e-3  # with it, whose own steps are relative to 1e-3 and whose ropes have two lumps
SEEDS = {3: "two hooks in a plane", 1001: "one", 5: "five, lifted by a way"}


@pytest.mark.parametrize("seed", SEEDS, ids=SEEDS.get)
def test_it_is_twenty_times_as_exact_as_the_finest_accuracy(seed):
    errors = apart(reference(seed), reference(seed, rtol=RTOL / 10.0, lumps=4))
    assert max(errors.values()) <= FINEST / PART, errors


def test_eight_lumps_say_what_four_do_of_what_is_asked():
    """In steps of radau5 at 1e-7, and not of dop853 at 1e-9."""
    found = {}
    for seed in KINDS:
        errors = apart(truth(seed), truth(seed, 8))
        found[seed] = max(errors[quantity] for quantity in asked_of(seed, lift_of_kinds(seed)))
    assert sum(e <= CONVERGED for e in found.values()) >= MOST, found


def test_independent_code_says_the_same():
    """Maximal coordinates in NumPy, SciPy's Radau."""
    found = {}
    for seed in OTHERS:
        scene = parse(random_lift(seed), overrides=[richest(4), *STEPS])
        found[seed] = max(apart(Seen.of(scene, lifted(scene)), reference(seed)).values())
    assert sum(e <= AGREE for e in found.values()) >= ALMOST, found
    assert max(found.values()) <= NEVER, found
