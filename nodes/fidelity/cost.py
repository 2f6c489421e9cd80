"""What a rung costs before it is run: states, stiffest frequency from the scene's numbers, evaluations of an explicit
method of order 5 whose steps that frequency bounds (Hairer and Wanner II, figure IV.2.4).

    loader between rope and slings   w^2 = (k_rope + k_slings) / m_loader       hardly damped: w h < 1
    chain of n lumps                 w < 2 n sqrt(k_rope / m_rope), Gershgorin  damped: w h < 3.3
    servo of a drive, if all ropes are rigid   w^2 = k / m                      hardly damped: w h < 1
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from heavylift.nodes.scene.plan import Fidelity

from .case import Case

__all__ = ["Cost", "cost"]

STAGES = 6  # of a step of DOPRI5
UNDAMPED, DAMPED = 1.0, 3.3  # w h at which a step becomes unstable, on the imaginary and on the real axis


@dataclass(frozen=True)
class Cost:
    """Of a run on one rung: states, stiffest frequency [rad/s], evaluations."""

    states: int
    omega: float
    evaluations: float

    @property
    def product(self) -> float:
        """Evaluations times states."""
        return self.evaluations * self.states


def cost(case: Case, at: Fidelity) -> Cost:
    """Predicted for an explicit method."""
    lumps, cranes, hooks = at.lumps if at.ropes == "massive" else 0, len(case.drives) // 3, len(case.hinges)
    planar = at.motion != "spatial"
    locked = {*at.locked, *(case.hinges if at.motion == "across" else ())}
    locked |= {j for j in case.drives if planar and j.endswith(".gantry") == (at.motion == "across")}
    freedom = (3 if planar else 6) * (hooks + 1) + len(case.drives) + hooks - len(locked)
    freedom += lumps * hooks * (2 if planar else 4) + cranes * (at.girder == "elastic")
    swift = max(_bounds(case, at))
    return Cost(2 * freedom, swift, STAGES * case.lasts * swift)


def _bounds(case: Case, at: Fidelity) -> list[float]:
    """Steps per second that each mode asks for."""
    bounds = [sqrt(k / m) / UNDAMPED for joint, (k, m) in case.drives.items() if m and joint not in at.locked]
    for h in case.hooks:
        if at.ropes != "rigid" or at.slings != "rigid":
            bounds.append(sqrt((1.0 / h.soft_rope + 1.0 / h.soft_slings) / (h.load - h.share)) / UNDAMPED)
        if at.ropes == "massive":
            bounds.append(2.0 * at.lumps / sqrt(h.soft_rope * h.rope_mass) / DAMPED)
    return bounds or [1.0]
