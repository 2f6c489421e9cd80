"""Lifts by other crane types: SciPy's DOP853 on the same equations finds the same peaks and times.

Each of twenty random lifts, at least two by each other type of the library, once by the kernel's own method of its
ladder, once by SciPy at a tolerance of 1e-10 (`tests/kernel/scipy_peers.py`): all peaks, all stages, the last places.
"""

from __future__ import annotations

import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

import scipy_peers  # noqa: F401  registers its methods
from heavylift.coordinator.ladder import Ladder, at_level
from heavylift.coordinator.record import Played, play
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import parse
from lifts_of_the_world import CRANES, lift_of_the_world

TYPES = (*CRANES, "twin-hook-600", "mobile-gantry-600")
SEEDS = (  # of lifts by each type in turn
    60017, 60001, 60175, 60045, 60035, 60009, 60011, 60073, 60013, 60259,
    60049, 60075, 60015, 60125, 60081, 60023, 60265, 60057, 60169, 60021,
)  # fmt: skip
OURS, THEIRS = 1e-8, 1e-10  # tolerances of steps
TENSION = 1e-6  # of the largest peak
INSTANT, PLACE = 1e-6, 1e-6  # [s], [m]


def run(seed: int, method: str, tolerance: float) -> Played:
    plan = parse(lift_of_the_world(seed).text, passing=True, followed=False).plan
    own = method or Ladder(plan).own
    at = at_level(plan, Fidelity(girder="elastic", rope_mass="lumped"))
    return play(msgspec.structs.replace(at, method=own, tolerance=tolerance))


@pytest.mark.parametrize("number", range(len(SEEDS)))
@pytest.mark.large(beyond=2)
def test_scipy_finds_the_peaks_and_stage_times_of_lifts_by_other_crane_types(number: int) -> None:
    seed = SEEDS[number]
    assert lift_of_the_world(seed).kinds[0] == TYPES[number % len(TYPES)]
    ours, theirs = run(seed, "", OURS), run(seed, "scipy-dop853", THEIRS)
    most = max(peak.tension for peak in theirs.peaks.values())
    assert ours.peaks.keys() == theirs.peaks.keys()
    for name, peak in theirs.peaks.items():
        assert ours.peaks[name].tension == pytest.approx(peak.tension, abs=TENSION * most), name
    assert [x[1:] for x in ours.conduct.stages] == [x[1:] for x in theirs.conduct.stages]
    for (t, _, name), (other, _, _) in zip(ours.conduct.stages, theirs.conduct.stages, strict=True):
        assert t == pytest.approx(other, abs=INSTANT), name
    block = ours.layout.find("pose/block")
    assert block is not None
    at = slice(block.start, block.start + 3)
    assert np.abs(ours.rows[-1, at] - theirs.rows[-1, at]).max() < PLACE
