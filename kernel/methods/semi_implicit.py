"""Semi-implicit (symplectic) Euler: velocities first, then coordinates with the new velocities.

Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1.2 (1.9).  Order 1; one evaluation a step; its energy error
stays bounded, and its frequency error is that of leapfrog, (w h)^2 / 24.  Quaternions go through dq/dt = N(q) v.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.step_state import Rate, StepState
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates

from .method import Attempt, Method, fallen_in

__all__ = ["SemiImplicitEuler"]


class SemiImplicitEuler(Method):
    """The dense output is a step of the method to that time, so that events lie on its own solution."""

    name = "semi-implicit-euler"
    order = evaluations = 1
    vectors = ("d1", "d2")

    def __init__(self, program: Program) -> None:
        nq, nv, ny = program.nq, program.nv, program.ny
        links = program.graph.links

        def drift(y: Value, f: Value) -> dict[str, Value]:
            """N(q) dv/dt: what dq/dt gains per second while the velocities change."""
            dv = f[nq : nq + nv]
            turned = [join(rates(k.joint.kind, y[k.q], dv[k.v]), dv[k.v_modes]) for k in links]
            return {"x": join(*turned, np.zeros(ny - nq))}

        self._drift = Function("drift", drift, {"y": ny, "f": ny}, vectors=["x"])

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        gain = (h * h) * self._drift(y=s.y, f=s.f).x
        y = s.y + (h * s.f + gain)
        r = rate(s.t + h, among, y)
        return Attempt(y, r.dy, r, None, [(1.0, fallen_in(r))], [gain])

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1, s.d2 = h * s.f, a.k[0]

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + x * s.d2)

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        kick, move = np.eye(len(J)), np.eye(len(J))
        kick[nq:] += h * J[nq:]
        move[:nq] += h * J[:nq]
        result: np.ndarray = move @ kick
        return result
