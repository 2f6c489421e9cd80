"""Mass, centre of mass, linear and angular momentum of a scene; only external forces change the momentum.

Sums of I V over the bodies of each tree (Featherstone 2008, section 2.9), moved from the tree's point to the world's
origin.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.spatial import cross, spatial_inertia
from heavylift.kernel.multibody.kinematics import elastic, kinematics
from heavylift.kernel.multibody.trees import with_numbers

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation


@dataclass(frozen=True)
class Momentum:
    """The momentum of a scene: mass [kg], centre of mass (3,) [m], linear momentum (3,) [kg m/s], and angular momentum
    (3,) about the world's origin [kg m2/s]."""

    mass: float
    centre: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    @property
    def spin(self) -> np.ndarray:
        """Angular momentum (3,) about the common centre of mass [kg m2/s]."""
        spin: np.ndarray = self.angular - np.cross(self.centre, self.linear)
        return spin


def momentum(simulation: "Simulation") -> Momentum:
    """Return the momentum of all bodies together at the present time of a simulation."""
    program, x = simulation.program, simulation.instant()
    mass, moment, linear, angular = 0.0, np.zeros(3), np.zeros(3), np.zeros(3)
    for i, (tree, _) in enumerate(program.instances):
        numbered = with_numbers(tree, simulation.P[program.parameters.at["tree", str(i)]])
        still = [0.0] * len(tree.prescribed_dofs)
        K = kinematics(numbered, np.array(x.q[tree.q]), np.array(x.v[tree.v]), 0.0, still)
        for n, b in enumerate(numbered.bodies):
            c = K.r[n] + K.R[n] @ b.com
            h = spatial_inertia(b.mass, c, K.R[n] @ b.inertia @ K.R[n].T) @ K.V[n]
            mass, moment = mass + float(b.mass), moment + b.mass * (K.o + c)
            if b.elastic is not None:
                own = elastic(numbered, K, n)
                h = h + own.momentum
                mass, moment = mass + float(b.elastic.J0[3, 3]), moment + b.elastic.J0[3, 3] * K.o + own.moment
            linear, angular = linear + h[3:], angular + h[:3] + cross(K.o, h[3:])
    centre = moment / mass if mass > 0.0 else np.zeros(3)
    return Momentum(mass, *(np.array(a, dtype=float) for a in (centre, linear, angular)))
