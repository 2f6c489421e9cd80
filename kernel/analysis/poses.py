"""A simulation as a function of its pose: accelerations, guards and tangent stiffness at zero speed.

Poses are compared in the tangent space, one number per free degree of freedom, so that quaternions need no care. With
closed loops, `basis` spans the motions that they allow, and every pose is projected back onto the closed loops.
"""

from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.model.newton_step import REACHED
from heavylift.kernel.model.tangent_stiffness import FOURTH

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

CLOSINGS = 3  # Newton steps onto the loops, from a pose that is near
HALF = 0.5
WATER = 1e3  # [J^0.5] of a state of radiation
STEP, SMALLEST = 1e-4, 1e-7  # [m, rad] between poses of differences; smaller where a guard falls


class Poses:
    """Evaluates a simulation at poses near its own, with its drives, winches and master signals stopped."""

    def __init__(self, simulation: "Simulation") -> None:
        self.simulation = simulation
        p = simulation.program
        self._tangent = simulation.method.tangent
        self.free = [*self._tangent.free]
        self._rest = np.zeros(p.ny)  # the last pose of `newton_step`, and what was integrated before
        self._accounts = self._rest[p.nq + p.nv :]
        self._accounts[:] = simulation.state[p.nq + p.nv :]
        self._rows = np.ix_(self.free, self.free)
        self._velocities = p.nq + np.array(self.free, dtype=int)
        self._quaternions = np.array(p.quaternions, dtype=int)[:, None] + np.arange(4)
        self._M = np.zeros(self._tangent.factors.stop)
        n = len(self.free)
        self._given, self._tail, self._found = np.zeros(n), np.zeros(1), np.zeros(n)  # of `solve`
        self._factorise = simulation.native.bound("factorise_tangent", self._M)
        self._solve = simulation.native.bound("solve_tangent", self._M, self._given, self._tail, self._found)
        self._y, self._f, self._G = (simulation.native.part(name) for name in ("y", "f", "G"))
        self._parts = self._y[: p.nq], self._y[p.nq : p.nq + p.nv], self._y[p.nq + p.nv :]
        self._evaluate = simulation.native.bound("refresh", simulation.native.X, simulation.native.P)
        self._closed = len(p.constraints) > 0
        self._known: tuple[object, np.ndarray] = None, self._M  # the last stiffness, and of what
        self._asked, self._eye = np.array(self.free, int), np.eye(n)
        nv = p.nv
        self._columns, self._J = np.zeros((nv, 4)), np.zeros((nv, nv + 1))  # see `tangent_stiffness`
        self._now, self._order, self._work = np.zeros(2), np.zeros(len(FOURTH)), np.zeros(self._tangent.work)
        self._stands, self._guards = np.zeros(p.ny), np.zeros(len(self.guards()))
        self._stiffen = simulation.native.bound(
            "tangent", self._now, self._stands, simulation.P, self._guards, self._order, self._columns,
            self._work, self._J,
        )  # fmt: skip
        self._reached = np.zeros(REACHED + p.nq)
        self._step = simulation.native.bound(
            "newton_step", self._now, self._rest, simulation.P, self._M, self._work, self._reached
        )
        for link in p.graph.links:
            for k in range(link.v.start, link.v.stop):
                self._columns[k, 1:] = k - link.v.start, link.q.start, link.q.stop
            for n in range(link.n_modes):
                i = link.q_modes.start + n
                self._columns[link.v_modes.start + n, 1:] = 0, i, i + 1

    @staticmethod
    def stopped(simulation: "Simulation") -> "Poses":
        """Stop all drives, winches and master signals of a simulation permanently; return its `Poses` evaluator."""
        simulation.commands.admit("statics or modes")
        simulation.references.stop(simulation.epoch)
        simulation.references.write(simulation.epoch)
        return Poses(simulation)

    @property
    def q(self) -> np.ndarray:
        """The pose (nq,) of the simulation."""
        return self.simulation.state[: self.simulation.program.nq].copy()

    def accelerations(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """Return the accelerations (n_free,) at pose q (nq,) and velocities v (n_free,); by default v is zero."""
        self._refresh(q, v)
        dv: np.ndarray = self._f[self._velocities]
        return dv

    def water(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of accelerations and of memory states of wave radiation at pose q (nq,), by differences.

        da/dz (n_free, m) and dz'/d(v, z) (m, n_free + m); a: accelerations, v: velocities, z: memory states.
        """
        p, n = self.simulation.program, len(self.free)
        places = [*p.memory.values()]
        a, rates = np.zeros((n, len(places))), np.zeros((len(places), n + len(places)))
        for k, place in enumerate(places):
            held = self._accounts[place - p.nq - p.nv]
            for step in (WATER, -WATER):
                self._accounts[place - p.nq - p.nv] = held + step
                a[:, k] += self.accelerations(q) / (2.0 * step)
                rates[:, n + k] += self._f[places] / (2.0 * step)
            self._accounts[place - p.nq - p.nv] = held
        for k, e in enumerate(self._eye if places else ()):
            for sign in (1.0, -1.0):
                self._refresh(q, sign * e)
                rates[:, k] += 0.5 * sign * self._f[places]
        return a, rates

    def guards(self) -> np.ndarray:
        """Return the guards (event functions) of all laws at the last pose that was evaluated."""
        G: np.ndarray = self._G.copy()
        return G

    def stiffness(self, q: np.ndarray, order: tuple[float, float] = FOURTH, h: float = STEP) -> np.ndarray:
        """Return the derivative da/dq (n_free, n_free) [1/s2] of the accelerations at rest in pose q (nq,).

        Discrete states are frozen; `h`: largest difference step [m, rad].
        """
        self.accelerations(q)
        native, nv = self.simulation.native, len(self._columns)
        self._now[:], self._order[:] = (native["t"], native.among()), order
        key = q.tobytes(), self._accounts.tobytes(), self.simulation.P.tobytes(), self._now.tobytes(), order, h
        if key == self._known[0]:  # as after a command that changes no force
            return self._known[1]
        self._stands[:], self._guards[:] = self._y, self._G
        self._J[:] = 0.0
        asked = self._asked
        while True:
            self._columns[:, 0] = 0.0
            self._columns[asked, 0] = h
            self._stiffen()
            asked = asked[self._J[asked, nv] > 0.0]
            if not len(asked) or h <= SMALLEST:
                break
            h *= 0.1
        found: np.ndarray = self._J[:, :nv].T[self._rows].copy()
        found.flags.writeable = False
        self._known = key, found
        return found

    def factorise(self, K: np.ndarray, h: float, basis: np.ndarray | None) -> None:
        """Factorise the matrix 1/h^2 - K of Newton steps; K (n_free, n_free): stiffness.

        `basis`: the allowed motions, as the method `basis` returns them.
        """
        self._B = basis
        K = K if basis is None else basis.T @ K @ basis
        whole, n = self._eye.copy(), len(K)
        whole[:n, :n] = whole[:n, :n] / h**2 - K
        self._tangent.factors.write(self._M, whole)
        self._factorise()

    def solve(self, a: np.ndarray) -> np.ndarray:
        """Return the Newton step (n_free,) for accelerations a (n_free,), with the matrix factorised last."""
        x = self._found
        if self._B is None:
            self._given[:] = a
        else:
            self._given[:] = 0.0
            self._given[: self._B.shape[1]] = self._B.T @ a
        self._solve()
        return x.copy() if self._B is None else self._B @ x[: self._B.shape[1]]

    def newton_step(self, q: np.ndarray) -> tuple[float, float, np.ndarray]:
        """Return the largest acceleration at pose q (nq,), the largest component of the Newton step [m, rad], and the
        pose that it reaches."""
        if self._closed:
            a = self.accelerations(q)
            step = self.solve(a)
            return float(np.abs(a).max(initial=0.0)), float(np.abs(step).max(initial=0.0)), self.moved(q, step)
        native = self.simulation.native
        self._now[:], self._rest[: len(q)] = (native["t"], native.among()), q
        self._step()
        return self._reached.item(0), self._reached.item(1), self._reached[REACHED:].copy()

    def sign(self) -> float:
        """Return the sign of the determinant of the matrix factorised by the last call of `factorise`."""
        f, n = self._tangent.factors, len(self.free)
        exchanges = self._M[f.exchanges : f.exchanges + n] != np.arange(n)
        negative = self._M[f.inverses[0] : f.inverses[0] + n] < 0.0
        return -1.0 if (int(exchanges.sum()) + int(negative.sum())) % 2 else 1.0

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return the pose (nq,) reached from q by a step (n_free,) [m, rad], with loops closed again."""
        self._refresh(q, step)
        new: np.ndarray = q + self._f[: len(q)]
        if self._closed:
            y = self._state(new)
            for _ in range(CLOSINGS):
                y = self.simulation.native.close(y)[0]
            new = y[: len(q)]
        return self.unit(new)

    def unit(self, q: np.ndarray) -> np.ndarray:
        """Normalise the quaternions of a pose (nq,) in place, and return it."""
        if not len(self._quaternions):
            return q
        turns = q[self._quaternions]
        x, y, z, w = (turns * turns).T
        size = np.sqrt(x + y + z + w)  # in one order, as no library of linear algebra promises
        q[self._quaternions] = turns / size[:, None]
        return q

    def count_turns(self, q: np.ndarray) -> None:
        """Update the counts of full turns for the angles at pose q, which is within half a turn of the last pose."""
        s = self.simulation
        if n := len(s.program.angles):
            self._y[:] = self._state(q)
            self._accounts[-n:] = s.row().turned

    def basis(self, q: np.ndarray) -> np.ndarray | None:
        """Return an orthonormal basis (n_free, n) of motions that closed loops allow at pose q; None without loops."""
        if not self._closed:
            return None
        p, allowed = self.simulation.program, []
        for e in self._eye:
            y, *_ = self.simulation.native.close(self._state(q, e))
            allowed.append(y[p.nq : p.nq + p.nv][self.free])
        U, sizes, _ = np.linalg.svd(np.array(allowed).T)
        basis: np.ndarray = U[:, : int(np.sum(sizes > HALF))]  # a projection's are 0, or at least 1
        return basis

    def _refresh(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        place, speeds, accounts = self._parts
        place[:], speeds[:], accounts[:] = q, 0.0, self._accounts
        if v is not None:
            speeds[self._asked] = v
        self._evaluate()

    def _state(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        p = self.simulation.program
        y = np.zeros(p.ny)
        y[: p.nq], y[p.nq + p.nv :] = q, self._accounts
        if v is not None:
            y[self._velocities] = v
        return y
