"""Which solver: steps, evaluations and time of every method at equal error, SciPy's in the same run.

    python tests/bench/methods.py [--json] [--seconds 10]

`reference`: the 24-degree-of-freedom two-crane scene; `light`: a swinging load whose loader has 1e-6 of its mass;
`stiff`: the same with a rope of 1e6 times its stiffness.  Errors are of rope tensions, relative to the largest (of the
load's place [m] in the swinging scenes), against a run of dop853 or radau5 at a tight tolerance.  Times are thread
times of one run after the code is compiled.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
from goliath import scene
from heavylift.kernel.describe import System
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, column, hand_over
from test_the_stiffness_of_ropes import swing

OWN = ("dopri5", "dop853", "ros34pw2", "radau5")
PEERS = ("scipy-dop853", "scipy-radau", "scipy-bdf", "scipy-lsoda")
SCENES: dict[str, tuple[System, str, tuple[float, ...], tuple[str, ...]]] = {
    "reference": (scene(), "dop853", (1e-5, 1e-7, 1e-9), (*OWN, *PEERS)),
    "light": (swing(1.0, 1e-6), "radau5", (1e-4, 1e-6), ("ros34pw2", "radau5")),
    "stiff": (swing(1e6, 1.0), "radau5", (1e-4, 1e-6), ("dopri5", "ros34pw2", "radau5")),
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


def measure(seconds: int) -> list[dict[str, Any]]:
    rows = []
    for name, (system, reference, tolerances, methods) in SCENES.items():
        exact = result(name, run(system, seconds, reference, TIGHT[reference])[0])
        for method in methods:
            for tolerance in tolerances:
                simulation, spent = run(system, seconds, method, tolerance)
                rows.append(
                    {
                        "scene": name,
                        "method": method,
                        "tolerance": tolerance,
                        "steps": int(simulation["accepted"]),
                        "rejected": int(simulation["rejected"]),
                        "ms": 1e3 * spent,
                        "error": float(np.abs(result(name, simulation) - exact).max()),
                    }
                )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seconds", type=int, default=10)
    options = parser.parse_args()
    rows = measure(options.seconds)
    if options.json:
        print(json.dumps(rows, indent=1))
        return
    print(f"{'scene':10} {'method':14} {'tolerance':>9} {'steps':>7} {'rejected':>8} {'ms':>9} {'error':>9}")
    for r in rows:
        print(
            f"{r['scene']:10} {r['method']:14} {r['tolerance']:9.0e} {r['steps']:7} {r['rejected']:8} "
            f"{r['ms']:9.1f} {r['error']:9.1e}"
        )


if __name__ == "__main__":
    main()
