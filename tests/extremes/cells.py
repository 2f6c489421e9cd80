"""One cell of the table of extremes: the result of an integrator for a scene against an independent one."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from heavylift.kernel import KernelError
from heavylift.kernel.description import System
from heavylift.kernel.simulation import Simulation
from scipy_peers import PEERS as SCIPY
from small_scenes import SECOND

CONTROLLED, FIXED, FIRST_ORDER = 2e-3, 2e-2, 0.25  # bounds of an error relative to its scale, see STABILITY.md
MULTISTEP = 1e-2  # of peers whose errors add up over many small steps: 5e-3 were seen at the same tolerance


@dataclass(frozen=True)
class Integrator:
    """A method with its tolerance or step, and the error that a result of it may have."""

    name: str
    options: dict
    bound: float


INTEGRATORS = (
    Integrator("dopri5", {"method": "dopri5", "tolerance": 1e-9}, CONTROLLED),
    Integrator("dop853", {"method": "dop853", "tolerance": 1e-9}, CONTROLLED),
    Integrator("radau5", {"method": "radau5", "tolerance": 1e-8}, CONTROLLED),
    Integrator("rk4 5 ms", {"method": "rk4", "step": 5e-3}, FIXED),
    Integrator("radau5 5 ms", {"method": "radau5", "step": 5e-3}, FIXED),
    Integrator("euler 1 ms", {"method": "semi-implicit-euler", "step": 1e-3}, FIRST_ORDER),
)
PEERS = tuple(
    Integrator(
        name, {"method": name, "tolerance": 1e-8}, MULTISTEP if name in ("scipy-bdf", "scipy-lsoda") else CONTROLLED
    )
    for name in SCIPY
)
LEAN = tuple(x for x in INTEGRATORS if x.name in ("dopri5", "radau5", "rk4 5 ms"))


@dataclass(frozen=True)
class Extreme:
    """`run(options)` gives (error relative to its scale, the simulation)."""

    name: str
    run: Callable[[dict], tuple[float, Simulation]]


@dataclass(frozen=True)
class Cell:
    """What came out: the error of a result, what was said of it, or the sentence of a refusal."""

    error: float
    notes: tuple[str, ...]
    refusal: str

    def right(self, bound: float) -> bool:
        """No finite wrong answer without a word."""
        return bool(self.refusal) or self.error <= bound or bool(self.notes)

    def __str__(self) -> str:
        if self.refusal:
            return f"refused: {self.refusal}"
        text = f", and says: {'; '.join(self.notes)}" if self.notes else ""
        return f"error {self.error:.1e}{text}"


def cell(extreme: Extreme, integrator: Integrator) -> Cell:
    try:
        error, s = extreme.run(integrator.options)
    except KernelError as e:
        return Cell(inf, (), str(e))
    return Cell(error if np.isfinite(error) else inf, tuple(note.sentence for note in s.notes), "")


def go(s: Simulation, t_ns: int) -> Simulation:
    """Up to t_ns."""
    s.run(t_ns)
    s.interrupt(t_ns)
    s.settle()
    return s


def started(system: System, options: dict, **more) -> Simulation:
    s = Simulation(system, **{"sample_ns": SECOND // 20, "h_max": 0.05} | options | more)
    s.start()
    return s
