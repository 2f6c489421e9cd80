"""A simulation seen as a function of its pose: accelerations and guards with all speeds zero and all drives stopped.

Poses are compared in the tangent space, one number per free degree of freedom, so that quaternions need no care.
Where loops close, `basis` spans what they leave, and every pose is put back onto them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..simulation import Simulation

__all__ = ["Poses"]

CLOSINGS = 3  # Newton steps onto the loops, from a pose that is near
HALF = 0.5


class Poses:
    """Evaluates one simulation at poses near its own; its drives, winches and masters are stopped where they are."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        p = simulation.program
        simulation._admit("statics or modes")
        simulation.references.stop(simulation.epoch)
        simulation.references.write(simulation.epoch)
        fixed = {tree.v.start + k for tree, _ in p.instances for k in tree.prescribed_dofs}
        self.free = [k for k in range(p.nv) if k not in fixed]
        self._at = simulation.method.layout.at
        self._accounts = simulation.state[p.nq + p.nv :].copy()

    @property
    def q(self) -> np.ndarray:
        """(nq,) where the simulation stands."""
        return self.simulation.state[: self.simulation.program.nq].copy()

    def accelerations(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """(n_free,) at pose q (nq,) and, unless they vanish, at velocities v (n_free,)."""
        p = self.simulation.program
        dv: np.ndarray = self._rates(q, v)[p.nq : p.nq + p.nv][self.free]
        return dv

    def guards(self) -> np.ndarray:
        """Of the pose evaluated last."""
        G: np.ndarray = self.simulation.X[self._at["G"]].copy()
        return G

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """(nq,) the pose a step (n_free,) [m, rad] away."""
        p = self.simulation.program
        new: np.ndarray = q + self._rates(q, step)[: p.nq]
        if len(p.constraints):
            y = self._state(new)
            for _ in range(CLOSINGS):
                y = self.simulation._close(y)[0]
            new = y[: p.nq]
        for i in p.quaternions:
            new[i : i + 4] /= np.linalg.norm(new[i : i + 4])
        return new

    def basis(self, q: np.ndarray) -> np.ndarray:
        """(n_free, n) orthonormal motions that the loops allow at pose q; without loops all."""
        n, p = len(self.free), self.simulation.program
        if not len(p.constraints):
            return np.eye(n)
        allowed = []
        for e in np.eye(n):
            y, *_ = self.simulation._close(self._state(q, e))
            allowed.append(y[p.nq : p.nq + p.nv][self.free])
        U, sizes, _ = np.linalg.svd(np.array(allowed).T)
        basis: np.ndarray = U[:, : int(np.sum(sizes > HALF))]  # a projection's are 0, or at least 1
        return basis

    def _rates(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        s = self.simulation
        s.X[self._at["y"]] = self._state(q, v)
        s._call("refresh")
        f: np.ndarray = s.X[self._at["f"]].copy()
        return f

    def _state(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        p = self.simulation.program
        y = np.zeros(p.ny)
        y[: p.nq], y[p.nq + p.nv :] = q, self._accounts
        if v is not None:
            y[p.nq + np.array(self.free, dtype=int)] = v
        return y
