"""Small motions about a pose: frequencies, damping and shapes of the linearised scene (Shabana 2005, chapter 3).

With x = (small displacement, velocity) in the tangent space, x' = [[0, 1], [da/dq, da/dv]] x; its eigenvalues are
s = -zeta w +- i w sqrt(1 - zeta^2).  Taut, closed and sticking laws stay as they are.
"""

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.model.kinetic_energy import KineticShares

from .poses import Poses

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

GROWS = 0.1  # [1/s] below which growth is rounding, too: a mast of a kilometre falls faster
SPEED_STEP = 1e-3  # [m/s, rad/s]
FREE = 1e-2  # [rad/s] below which a motion has no frequency but only rounding


@dataclass(frozen=True)
class NaturalMode:
    """An oscillation: natural frequency w/2 pi [Hz] and damping ratio zeta (negative: growing).

    shape: (n_v,) complex velocities, the largest 1; bodies, joints: share of the kinetic energy, largest first;
    momenta: complex (3,) of each body, over the root of twice the kinetic energy [kg^0.5].
    """

    frequency: float
    damping: float
    shape: np.ndarray
    bodies: tuple[tuple[str, float], ...]
    joints: tuple[tuple[str, float], ...]
    momenta: dict[str, np.ndarray]


@dataclass(frozen=True)
class Modes:
    """All small motions: oscillations by frequency, decay rates [1/s] of overdamped ones (negative: growing), number of
    degrees of freedom without stiffness."""

    oscillations: tuple[NaturalMode, ...]
    decays: tuple[float, ...]
    free: int

    @property
    def growth(self) -> float:
        """Growth rate [1/s] of the fastest unstable motion; 0 if the pose is stable."""
        rates = [-x for x in self.decays] + [-2.0 * pi * m.frequency * m.damping for m in self.oscillations]
        return max([x for x in rates if x > GROWS], default=0.0)


def modes(simulation: "Simulation") -> Modes:
    """Modes of a simulation about its pose, which should be at rest (see `equilibrium`); drives are stopped, speeds
    zero."""
    poses = Poses.stopped(simulation)
    return modes_at(poses, poses.q)


def modes_at(poses: Poses, q: np.ndarray) -> Modes:
    """Modes about a pose q (nq,)."""
    simulation = poses.simulation
    allowed = poses.basis(q)
    basis = np.eye(len(poses.free)) if allowed is None else allowed
    n = basis.shape[1]
    A = np.block([[np.zeros((n, n)), np.eye(n)], [basis.T @ poses.stiffness(q) @ basis, _damping(poses, q, basis)]])
    s, vectors = np.linalg.eig(A)
    poses.accelerations(q)  # leaves the simulation at its own pose
    energy = KineticShares(simulation.program, simulation.P, q)
    found, decays = [], []
    for k in np.argsort(np.abs(s), kind="stable"):
        if abs(s[k]) < FREE:
            continue
        if abs(s[k].imag) <= 1e-9 * abs(s[k]):
            decays.append(-float(s[k].real))
        elif s[k].imag > 0.0:
            shape = np.zeros(simulation.program.nv, dtype=complex)
            shape[poses.free] = basis @ vectors[n:, k]
            shape /= shape[np.argmax(np.abs(shape))]
            w = abs(s[k])
            root = energy.energy(shape) ** 0.5
            momenta = {name: p / root for name, p in energy.momenta(shape).items()}
            found.append(NaturalMode(w / (2.0 * pi), -float(s[k].real / w), shape, *energy.shares(shape), momenta))
    return Modes(tuple(found), tuple(sorted(decays)), (int(np.sum(np.abs(s) < FREE)) + 1) // 2)


def _damping(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """(n, n) da/dv [1/s] of the motions `basis` at pose q, at rest, to fourth order."""
    h = SPEED_STEP

    def along(e: np.ndarray) -> np.ndarray:
        a = [poses.accelerations(q, x * h * e) for x in (1.0, -1.0, 2.0, -2.0)]
        difference: np.ndarray = 8.0 * (a[0] - a[1]) - (a[2] - a[3])
        return difference / (12.0 * h)

    n = basis.shape[1]
    matrix: np.ndarray = basis.T @ np.array([along(e) for e in basis.T]).reshape(n, len(basis)).T
    return matrix
