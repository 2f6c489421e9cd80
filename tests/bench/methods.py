"""Steps, evaluations and time of every integration method at equal error, beside SciPy's.

    python tests/bench/methods.py [--json] [--short] [--seconds 10]

`reference`: the 24-degree-of-freedom two-crane scene; `light`: a swinging load whose loader has 1e-6 of its mass;
`stiff`: the same with a rope of 1e6 times its stiffness.  Errors are of rope tensions, relative to the largest (of the
load's place [m] in the swinging scenes), against a run of dop853 or radau5 at a tight tolerance.  Times are thread
times of one run after the code is compiled; beside them stands the fastest of SciPy's methods that is as exact.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel/forces/ropes"))
from goliath import scene
from heavylift.kernel.description import System
from heavylift.kernel.simulation import Simulation
from scipy_peers import PEERS
from shared.rows import SHORT, options, row
from small_scenes import SECOND, column, hand_over
from test_the_stiffness_of_ropes import swing

OWN = ("dopri5", "dop853", "radau5")
SCENES: dict[str, tuple[System, str, tuple[float, ...], tuple[str, ...]]] = {
    "reference": (scene(), "dop853", (1e-5, 1e-7, 1e-9), (*OWN, *PEERS)),
    "light": (swing(1.0, 1e-6), "radau5", (1e-4, 1e-6), ("radau5",)),
    "stiff": (swing(1e6, 1.0), "radau5", (1e-4, 1e-6), ("dopri5", "radau5")),
}
TIGHT = {"dop853": 1e-12, "radau5": 1e-9}


def run(system: System, seconds: int, method: str, tolerance: float) -> tuple[Simulation, float]:
    simulation = Simulation(system, tolerance, SECOND // 10, method=method)
    simulation.start()
    before = time.thread_time()
    hand_over(simulation, seconds * SECOND)
    return simulation, time.thread_time() - before


def result(name: str, simulation: Simulation) -> np.ndarray:
    """What errors are measured in."""
    if name == "reference":
        tension = column(simulation, "rope/tension")[1]
        return tension / tension.max()
    return simulation.state[:3].copy()


class Measured(NamedTuple):
    """What one method did with one scene at one tolerance."""

    method: str
    tolerance: float
    ms: float
    error: float
    steps: float
    rejected: float


def measure(name: str, seconds: int) -> list[Measured]:
    """All methods at all tolerances; `--short`: at the first."""
    system, reference, tolerances, methods = SCENES[name]
    exact, found = result(name, run(system, seconds, reference, TIGHT[reference])[0]), []
    for method in methods:
        for tolerance in tolerances[:1] if SHORT else tolerances:
            simulation, spent = run(system, seconds, method, tolerance)
            error = float(np.abs(result(name, simulation) - exact).max())
            steps = simulation["accepted"], simulation["rejected"]
            found.append(Measured(method, tolerance, 1e3 * spent, error, *steps))
    return found


def main() -> None:
    given = options(__doc__ or "", {"--seconds": {"type": int, "default": 1 if SHORT else 10}})
    for scene_name in SCENES:
        found = measure(scene_name, given.seconds)
        for x in found:
            as_exact = [(y.ms, y.method) for y in found if y.method in PEERS and y.error <= x.error]
            ms, peer = min(as_exact, default=(None, None)) if x.method not in PEERS else (None, None)
            name = f"{scene_name}, {x.method} at {x.tolerance:.0e}"
            row(f"{name}: time", x.ms, "ms", peer, ms)
            for what in ("error", "steps", "rejected"):
                row(f"{name}: {what}", getattr(x, what))


if __name__ == "__main__":
    main()
