"""What a lift costs among thirty: build time and seconds of a run, against a yard of one.

    python tests/bench/yard.py [--json] [--short]

Lifts of the scene `hall` side by side, 1.3 s after one another, each in a run in this process until its list is done.
Seconds are those of the processor, least of three, with machine code from the cache.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from heavylift.coordinator.run import run
from heavylift.nodes.scene import parse
from heavylift.nodes.scene.loaded_scene import LoadedScene

sys.path.insert(0, str(Path(__file__).parent))
from shared.rows import SHORT, options, row

MANY, TIMES, APART = (2, 1, 1.3) if SHORT else (30, 3, 1.3)
BUILD, COST = 2.0, 1.5  # [s] more than one; times the cost of one


def text(lifts: int) -> str:
    """A yard of so many lifts."""
    rows = [f"  l{i}: {{extends: hall, at: [0 m, {40 * i} m], start: {1.0 + APART * i} s}}\n" for i in range(lifts)]
    return "heavylift: 1\nname: yard\naccuracy: 0.1 %\nsamples: 5 Hz\nlifts:\n" + "".join(rows)


def built(lifts: int) -> tuple[float, LoadedScene]:
    """Seconds until a yard could run, and the yard."""
    began = time.process_time()
    scene = parse(text(lifts))
    return time.process_time() - began, scene


def ran(scene: LoadedScene) -> float:
    """Seconds of its run."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        run(scene, Path(folder) / "yard.mcap", in_process=True)
        return time.process_time() - began


def main() -> None:
    """Both figures."""
    options(__doc__ or "")
    took = {lifts: min(built(lifts)[0] for _ in range(TIMES + 1)) for lifts in (1, MANY)}
    row(f"{MANY} lifts are built, more than one", took[MANY] - took[1], "s", at_most=BUILD)
    cost = {}
    for lifts in (1, MANY):
        scene = built(lifts)[1]
        ran(scene)  # compiles
        cost[lifts] = min(ran(scene) for _ in range(TIMES)) / lifts
    row(f"a lift among {MANY}", cost[MANY], "s", "alone", cost[1], at_most=COST)


if __name__ == "__main__":
    main()
