"""Predictor and corrector of the equilibrium path: find the equilibrium near a pose with frozen discrete states.

The predictor is the tangent, the first step of Newton's method with the stiffness of the last point, plus the change of
this tangent since the point before. The corrector iterates with the stiffness of the last point; if that fails, it
computes a new one (Allgower, Georg, 2003, chapters 2 and 6).
"""

from math import inf, isfinite

import numpy as np
from heavylift.kernel.model.tangent_stiffness import SECOND
from heavylift.kernel.simulation.simulation import Simulation

from .equilibrium import ROUNDING, STILL
from .poses import Poses

NEWTON = 12  # corrector steps of one point
SLOW = 0.1  # contraction above which the stiffness is renewed
CLOSE = 1e-9  # [m, rad] of a corrector step behind which the next one is none
BEND = 0.15  # [m, rad] of a corrector step: what predicted poses may be off
WIDEST = 1.0  # [m, rad] of a corrector step; a tangent may be longer
PART = 0.01  # of the way of the commands along which a tangent is taken: stiff laws are straight so far
LONG = 100.0  # [s] of pseudo time: leaves neutral directions alone


class Corrector:
    """Finds static equilibria of a simulation near given poses by prediction and Newton's method."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._program: object = None
        self._slope: tuple[np.ndarray, int] | None = None  # the last tangent per nanosecond, and its step
        self.renew(simulation.state[: simulation.program.nq].copy())

    def renew(self, q: np.ndarray) -> None:
        """Restart the prediction of equilibria at pose q (nq,) with a new stiffness, after commands or switching."""
        if self._program is not self._simulation.program:
            self._program = self._simulation.program
            self.poses = Poses(self._simulation)
        self._slope = None
        self._stiffen(q)

    def place(self, q: np.ndarray) -> np.ndarray:
        """Return pose q (nq,) with the coordinates of prescribed drives set to their commanded values."""
        s = self._simulation
        q = q.copy()
        for d in s.program.system.drives:
            if d.kind == "prescribed":
                q[s.program.graph.coordinate(d.name, d.joint, d.coordinate)[0]] = s.references.value(d.name, s.epoch)
        return self.poses.unit(q)

    def guards(self, q: np.ndarray) -> np.ndarray:
        """Return the guards (event functions, negative after their event) of all force laws at a pose."""
        self.poses.accelerations(q)
        return self.poses.guards()

    def _stiffen(self, q: np.ndarray) -> None:
        self._factorise(q, self.poses.stiffness(q, SECOND))

    def _factorise(self, q: np.ndarray, K: np.ndarray) -> None:
        self._K = K
        self.poses.factorise(K, LONG, self.poses.basis(q))

    def predicted(self, q0: np.ndarray, P0: np.ndarray, dt: int) -> tuple[np.ndarray | None, float]:
        """Return the equilibrium `dt` [ns] after the one at q0: predicted by tangent and curvature, then corrected.

        Also returns its distance from the prediction; the equilibrium is None if there is none nearby. P0: parameters
        at q0; the simulation already has the parameters at the end of the step.
        """
        poses, P = self.poses, self._simulation.P
        q, P1 = self.place(q0), P.copy()
        # the tangent is taken over a small part of the step, where stiff one-sided laws are still linear
        P[:] = P0 + PART * (P1 - P0)
        tangent = poses.solve(poses.accelerations(q0 + PART * (q - q0))) / PART
        P[:] = P1
        if not np.isfinite(tangent).all():
            return None, inf
        distance = tangent
        if self._slope is not None:
            slope, before = self._slope
            # curvature from the last two tangents (Adams-Bashforth of second order)
            distance = tangent + (0.5 * dt / before) * (tangent - dt * slope)
        q = poses.moved(q, distance)
        # one corrector step with the old stiffness measures how far the prediction was off
        _, bend, q = poses.newton_step(q)  # stiff ropes have their lengths again, then stiffness is looked at
        if not bend <= 2.0 * BEND:
            return None, bend
        last = self._K
        self._stiffen(q)
        found = self.corrected(q)
        if found is None:
            # back to the old stiffness, from which a shorter step starts
            self._factorise(q0, last)
        else:
            self._slope = tangent / dt, dt
        return found, bend

    def corrected(self, q: np.ndarray) -> np.ndarray | None:
        """Return the equilibrium near a pose q (nq,) with frozen discrete states; None if Newton's method fails."""
        poses, last, fresh, stalled = self.poses, inf, 0, 0
        before = inf
        for _ in range(NEWTON):
            size, distance, moved = poses.newton_step(q)
            if not isfinite(size):
                return None
            # accelerations that stopped falling are rounding of stiff laws
            stalled = stalled + 1 if size > 0.5 * before and size < ROUNDING else 0
            if size <= STILL or last <= CLOSE or stalled >= 3:
                return q
            if not distance <= WIDEST:
                return None
            # slow contraction: the stiffness has changed too much, compute a new one
            if distance > SLOW * last or (last == inf and fresh == 0 and distance > BEND):
                if fresh >= 3 and distance > last:
                    return None
                fresh += 1
                self._stiffen(q)
                _, distance, moved = poses.newton_step(q)
                if not distance <= WIDEST:
                    return None
            q = moved
            # quadratic convergence: the next correction would be smaller than CLOSE
            if last < inf and distance * min(1.0, distance / last) <= CLOSE:  # the next one would be no step any more
                return q
            last, before = distance, size
        return None

    def stiffness(self, q: np.ndarray) -> float:
        """Return the smallest eigenvalue of the tangent stiffness relative to the inertia at a pose [1/s2]: positive if
        the equilibrium is stable."""
        K, B = self.poses.stiffness(q, SECOND), self.poses.basis(q)
        # with closed loops, only motions that they allow count
        K = K if B is None else B.T @ K @ B
        # the smallest eigenvalue decides stability
        return float(np.linalg.eigvals(-K).real.min(initial=inf))
