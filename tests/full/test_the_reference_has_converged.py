"""The finest model level agrees with independent code: maximal coordinates in NumPy, SciPy's Radau."""

import sys
from pathlib import Path

import msgspec

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from heavylift.coordinator.ladder import Ladder
from heavylift.coordinator.record import play
from heavylift.nodes.scene import parse
from rail_lifts import lift_of
from random_lifts import random_lift
from richest_lift import richest

LIFTS = range(200, 220)
RTOL = 1e-3  # of the steps of that code, whose ropes have two lumps
AGREE, ALMOST, NEVER = 1e-3, 19, 2e-3


def test_independent_code_gives_the_peaks_and_stage_ends_of_random_lifts():
    found = {}
    for seed in LIFTS:
        plan = parse(random_lift(seed)).plan
        run = play(msgspec.structs.replace(Ladder(plan).candidates(Ladder(plan).full[-1])[0].plan, tolerance=1e-6))
        true = richest(plan, rtol=RTOL)
        peaks = [
            abs(run.peaks[rope.name].tension / peak - 1.0)
            for rope, peak in zip(lift_of(plan).rig.hook_ropes, true.peaks, strict=True)
        ]
        ends = [t for t, _, _ in run.conduct.stages[1:]] + [run.end_ns * 1e-9]
        found[seed] = max(*peaks, *(abs(a / b - 1.0) for a, b in zip(ends, true.ended, strict=True)))
    assert sum(e <= AGREE for e in found.values()) >= ALMOST, found
    assert max(found.values()) <= NEVER, found
