"""Kinetic energy of a scene by bodies and by joint velocities, at one pose, for any velocities there."""

import numpy as np
from heavylift.kernel.multibody.formulations.augmented import velocity_transformation
from heavylift.kernel.multibody.graph import coordinate_names
from heavylift.kernel.multibody.kinematics import body_inertia, elastic, kinematics
from heavylift.kernel.multibody.trees import with_numbers

from .program import Program


class KineticShares:
    """Kinetic energy by bodies and by joint velocities, at one pose."""

    def __init__(self, program: Program, P: np.ndarray, q: np.ndarray) -> None:
        self._parts = []
        self._momenta = []
        for i, (tree, _) in enumerate(program.instances):
            numbered = with_numbers(tree, P[program.parameters.at["tree", str(i)]])
            still = np.zeros(tree.v.stop - tree.v.start)
            K = kinematics(numbered, q[tree.q], still, 0.0, [0.0] * len(tree.prescribed_dofs))
            for n, V in enumerate(velocity_transformation(tree, K)):
                b, J = numbered.bodies[n], body_inertia(numbered, K, n)
                H = np.array(V.T @ J @ V, dtype=float)
                if b.elastic is not None:
                    own = elastic(numbered, K, n)
                    H += np.array(V.T @ own.I @ V, dtype=float)
                    coupled = np.array([c @ V for c in own.C], dtype=float).reshape(b.n_modes, len(H))
                    H[b.v_modes] += coupled
                    H[:, b.v_modes] += coupled.T
                    H[b.v_modes, b.v_modes] += np.diag(np.array(own.mass, dtype=float))
                self._parts.append((b.name, tree.v, H))
                self._momenta.append((b.name, tree.v, np.array((J @ V)[3:], dtype=float)))
        self._velocities = coordinate_names(program.graph)[1]

    def energy(self, shape: np.ndarray) -> float:
        """Kinetic energy of an oscillation with complex velocities, or twice that of real ones [J]."""
        return float(sum((shape[at].conj() @ H @ shape[at]).real for _, at, H in self._parts))

    def momenta(self, shape: np.ndarray) -> dict[str, np.ndarray]:
        """Linear momentum (3,) of each rigid body, for complex velocities [kg m/s]."""
        return {name: G @ shape[at] for name, at, G in self._momenta}

    def shares(self, shape: np.ndarray) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[str, float], ...]]:
        """Shares of bodies and of joint velocities, largest first."""
        bodies: dict[str, float] = {}
        joints = np.zeros(len(shape))
        for name, at, H in self._parts:
            x = shape[at]
            bodies[name] = float((x.conj() @ H @ x).real)
            joints[at] += np.diag(H) * np.abs(x) ** 2
        return _ranked(bodies), _ranked(dict(zip(self._velocities, map(float, joints), strict=True)))


def _ranked(parts: dict[str, float]) -> tuple[tuple[str, float], ...]:
    total = sum(parts.values()) or 1.0
    return tuple(sorted(((name, x / total) for name, x in parts.items()), key=lambda e: (-e[1], e[0])))
