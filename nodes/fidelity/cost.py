"""What a rung costs before it is run: states, attempted steps that its stiffest mode allows an explicit method of order
5 (Hairer and Wanner II, figure IV.2.4), evaluations, and linear algebra in the same unit.

    loader between rope and slings   w^2 = (k_rope + k_slings) / m_loader       hardly damped: w h < 1.5
    chain of n lumps                 w = f(n) sqrt(k_rope / m_rope), zeta = w d / 2 k   damped: s h < 2.75,
                                     s = w, or w (zeta + sqrt(zeta^2 - 1)) if overdamped; f(2) = 4.0, f(4) = 10.4
    if all ropes are rigid           nothing is stiff: steps as long as the kernel takes them

Both limits are measured on lifts at random, per attempted step: rejected ones count.  An evaluation takes a time in
proportion to the states, about 20 ns each; so factors and solutions of n x n systems count as evaluations, measured
from 22 to 170 states to within 25 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import sqrt

from heavylift.kernel.algebra.dense import eigenvalues
from heavylift.nodes.models.levels.lumps import gauss
from heavylift.nodes.plan.plan import Fidelity

from .case import Case

STAGES = 6  # of a step of DOPRI5
UNDAMPED, DAMPED = 1.5, 2.75  # w h of a step, near the imaginary and near the real axis
LONGEST = 0.1  # step of the kernel [s]


@dataclass(frozen=True)
class Cost:
    """Of a run on one rung: states, steps per second that its stiffest mode asks of an explicit method, evaluations,
    and how many more the linear algebra of an implicit one is worth."""

    states: int
    omega: float
    evaluations: float
    algebra: float = 0.0

    @property
    def product(self) -> float:
        """Evaluations, with what counts as such, times states."""
        return (self.evaluations + self.algebra) * self.states


def cost(case: Case, at: Fidelity) -> Cost:
    """Predicted for DOPRI5 at loose tolerances."""
    swift = attempts(case, at)
    return Cost(states(case, at), swift, STAGES * duration(case) * swift)


def duration(case: Case) -> float:
    """Of the run, about: the action list, and what its ropes need to take up the load [s]."""
    return case.lasts + max(h.stretch(case.gravity, girder=True) / h.picks for h in case.hooks)


def attempts(case: Case, at: Fidelity) -> float:
    """Steps per second of simulated time that DOPRI5 attempts for stability's sake."""
    return max([1.0 / LONGEST, *_bounds(case, at)])


def radau_algebra(n: int, factorisations: float, iterations: float, attempted: float) -> float:
    """Evaluations of n states that take as long as the linear algebra of Radau IIA, of half as many velocities."""
    return 0.002 * factorisations * n * n + 0.013 * iterations * n + 3.3 * attempted


def states(case: Case, at: Fidelity) -> int:
    """Coordinates and velocities."""
    lumps, cranes, hooks = at.lumps if at.ropes == "massive" else 0, len(case.drives) // 3, len(case.hinges)
    planar = at.motion != "spatial"
    locked = {*at.locked, *(case.hinges if at.motion == "across" else ())}
    locked |= {j for j in case.drives if planar and j.endswith(".gantry") == (at.motion == "across")}
    freedom = (3 if planar else 6) * (hooks + 1) + len(case.drives) + hooks - len(locked)
    freedom += lumps * hooks * (2 if planar else 4) + cranes * (at.girder == "elastic")
    return 2 * freedom


@cache
def stiffest(lumps: int) -> float:
    """Frequency of the fastest mode of a chain between two walls, times sqrt(m / k) of the rope."""
    places, weights = zip(*gauss(lumps), strict=True)
    k = [1.0 / (b - a) for a, b in pairwise([0.0, *places, 1.0])]
    K = [[0.0] * lumps for _ in weights]
    for i, m in enumerate(weights):
        K[i][i] = (k[i] + k[i + 1]) / m
        for j in range(i):
            K[i][j] = K[j][i] = -k[i] / sqrt(m * weights[j]) if j == i - 1 else 0.0
    return sqrt(eigenvalues(K)[-1])


def _bounds(case: Case, at: Fidelity) -> list[float]:
    """Steps per second that each mode asks for."""
    bounds = []
    for h in case.hooks:
        if at.ropes != "rigid" or at.slings != "rigid":
            bounds.append(sqrt((1.0 / h.soft_rope + 1.0 / h.soft_slings) / (h.load - h.share)) / UNDAMPED)
        if at.ropes == "massive":
            w = stiffest(at.lumps) / sqrt(h.soft_rope * h.rope_mass)
            zeta = max(1.0, w * h.rubs / 2.0)
            bounds.append(w * (zeta + sqrt(zeta * zeta - 1.0)) / DAMPED)
    return bounds
