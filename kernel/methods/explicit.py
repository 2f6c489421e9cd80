"""Explicit Runge-Kutta methods from tableaus, each with the dense output of its literature, and symplectic Euler.

Hairer, Norsett, Wanner, Solving ODEs I: II.1 (stages), II.5 (error estimates), II.6 (dense output).
"""

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.method import Rate, StepState
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates

from .dop853 import DENSE, DORMAND_PRINCE_5, DORMAND_PRINCE_8, EXTRA_A, EXTRA_C, KUTTA_4, THIRD_ORDER_ERROR, Tableau
from .method import Attempt, Exponents, Method, combine, fallen_in


class RungeKutta(Method):
    """An explicit Runge-Kutta method; if its last stage is the derivative at the solution, the next step reuses it."""

    tableau: Tableau

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        k, seen = [s.f], list[tuple[float, Value]]()
        stages = [*zip(self.tableau.c[1:], self.tableau.A[1:], strict=True)]
        # without the FSAL property (first same as last) the derivative at the end costs one more evaluation
        if not self._first_same_as_last:
            stages.append((1.0, self.tableau.b))
        for c, weights in stages:
            y = s.y + h * combine(weights, k)
            r = rate(s.t + c * h, among, y)
            k.append(r.dy)
            seen.append((c, fallen_in(r)))
        return Attempt(y, k[-1], r, self.error(h, k), seen, k)

    def error(self, h: Value, k: list[Value]) -> Value:
        """Return the local error estimate (see `Attempt.error`); None if the tableau has no error weights."""
        return h * combine(self.tableau.error, k) if self.tableau.error else None

    @property
    def _first_same_as_last(self) -> bool:
        return self.tableau.A[-1] == self.tableau.b[:-1] and self.tableau.c[-1] == 1

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        # y' = J y: stages are matrices applied to the initial value, so that their combination is the stability
        # function R(hJ)
        one = np.eye(len(J))
        k: list[np.ndarray] = []
        for a in self.tableau.A:
            k.append(J @ (one + h * combine(a, k)))
        result: np.ndarray = one + h * combine(self.tableau.b, k)
        return result


class Kutta4(RungeKutta):
    """Classical Runge-Kutta: fourth order, four evaluations, no error estimate; cubic Hermite interpolation."""

    name = "rk4"
    order = evaluations = 4
    tableau = KUTTA_4
    vectors = ("d1", "d2", "d3")

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        # cubic Hermite in the form of Hairer, Norsett, Wanner I, (II.6.15): two values, two slopes
        s.d1 = a.y - s.y
        s.d2 = h * s.f - s.d1
        s.d3 = s.d1 - h * a.f - s.d2

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * s.d3))


class DormandPrince5(RungeKutta):
    """Dormand-Prince 5(4) with the fourth-order dense output of Hairer, Norsett, Wanner I, II.6.

    This is the only method that clamps laws beyond an event (see `Setting`), which keeps the digests of earlier
    recordings.
    """

    name = "dopri5"
    order = 5
    evaluations = 6
    tableau = DORMAND_PRINCE_5
    exponents = Exponents(down=-0.2, up=-0.14, memory=0.04)
    vectors = ("d1", "d2", "d3", "d4")
    dense = (
        -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    )  # fmt: skip

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1 = a.y - s.y
        # terms of CONTD5 in their program dopri5.f
        s.d2 = h * s.f - s.d1
        s.d3, s.d4 = s.d1 - h * a.f - s.d2, h * combine([*self.dense], a.k)

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * (s.d3 + (1.0 - x) * s.d4)))


class DormandPrince8(RungeKutta):
    """Dormand-Prince 8(5,3) with dense output of order 7, whose three extra stages are computed on demand."""

    name = "dop853"
    order = 8
    evaluations = 12
    tableau = DORMAND_PRINCE_8
    exponents = Exponents(down=-0.125, up=-0.0875, memory=0.025)
    stages = tuple(f"k{i}" for i in range(1, 14))
    terms = tuple(f"d{i}" for i in range(1, 8))
    vectors = (*terms, *stages)
    completes = True

    def error(self, h: Value, k: list[Value]) -> Value:
        return h * combine(self.tableau.error, k), h * combine(THIRD_ORDER_ERROR, k)

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1 = a.y - s.y
        s.d2 = h * s.f - s.d1
        s.d3 = s.d1 - h * a.f - s.d2
        # the extra stages of the dense output need all stages, but only steps with samples or events pay for them
        for name, k in zip(self.stages, a.k, strict=True):
            setattr(s, name, k)

    def complete(self, s: StepState, rate: Rate) -> None:
        k = [getattr(s, name) for name in self.stages]
        for c, a in zip(EXTRA_C, EXTRA_A, strict=True):
            # the middle of the step selects the piece of the profile, since a stage may lie on the boundary of two
            k.append(rate(s.t0 + c * s.h0, s.t0 + 0.5 * s.h0, s.d0 + s.h0 * combine(a, k)).dy)
        for name, weights in zip(self.terms[3:], DENSE, strict=True):
            setattr(s, name, s.h0 * combine(weights, k))

    def interpolate(self, s: StepState, x: Value) -> Value:
        # Horner's scheme with alternating factors x and 1 - x, as CONTD8
        y = s.d7
        for i in range(6, -1, -1):
            y = getattr(s, f"d{i}") + (x if i % 2 == 0 else 1.0 - x) * y
        return y


class SemiImplicitEuler(Method):
    """Semi-implicit (symplectic) Euler method: updates velocities first, then coordinates with the new velocities.

    Quaternions follow dq/dt = N(q) v.

    Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1.2 (1.9). Its energy error stays bounded; its relative
    frequency error is that of leapfrog, (w h)^2 / 24. The dense output is a step of the method to that time, so that
    events lie on the method's own solution.
    """

    name = "semi-implicit-euler"
    order = evaluations = 1
    vectors = ("d1", "d2")

    def __init__(self, program: Program) -> None:
        nq, nv, ny = program.nq, program.nv, program.ny
        links = program.graph.links

        def drift(y: Value, f: Value) -> dict[str, Value]:
            """Return N(q) dv/dt, the part of d2q/dt2 that accelerations cause, where dq/dt = N(q) v."""
            # dq/dt = N(q) v for quaternions: the change of v acts through the same N(q), not directly
            dv = f[nq : nq + nv]
            turned = [join(rates(k.joint.kind, y[k.q], dv[k.v]), dv[k.v_modes]) for k in links]
            return {"x": join(*turned, np.zeros(ny - nq))}

        self._drift = Function("drift", drift, {"y": ny, "f": ny}, vectors=["x"])

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        # coordinates move with the new velocities: h dq/dt + h^2 N(q) dv/dt
        gain = (h * h) * self._drift(y=s.y, f=s.f).x
        y = s.y + (h * s.f + gain)
        r = rate(s.t + h, among, y)
        return Attempt(y, r.dy, r, None, [(1.0, fallen_in(r))], [gain])

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1, s.d2 = h * s.f, a.k[0]

    def interpolate(self, s: StepState, x: Value) -> Value:
        # the same step to x h, so the second-order gain grows with x^2: events lie on the numerical solution itself
        return s.d0 + x * (s.d1 + x * s.d2)

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        # velocities first, then coordinates with them: the product of two triangular maps, hence symplectic
        kick, move = np.eye(len(J)), np.eye(len(J))
        kick[nq:] += h * J[nq:]
        move[:nq] += h * J[:nq]
        result: np.ndarray = move @ kick
        return result
