"""Explicit Runge-Kutta methods of a tableau, each with the dense output of its literature.

Hairer, Norsett, Wanner, Solving ODEs I: II.1 (stages), II.5 (error estimates), II.6 (dense output).
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from .method import Attempt, Exponents, Method, Rate, combine, fallen_in
from .tableaus import DORMAND_PRINCE_5, KUTTA_4, Tableau

__all__ = ["DormandPrince5", "Kutta4", "RungeKutta"]


class RungeKutta(Method):
    """Stages of an explicit tableau; a tableau whose last stage is the solution needs no further evaluation."""

    tableau: Tableau

    def attempt(self, s: SimpleNamespace, rate: Rate, h: Any, among: Any) -> Attempt:
        k, y, r = [s.f], s.y, s
        seen: list[tuple[float, Any]] = []

        def evaluate(c: float, weights: list[float]) -> None:
            nonlocal y, r
            y = s.y + h * combine(weights, k)
            r = rate(s.t + c * h, among, y)
            k.append(r.dy)
            seen.append((c, fallen_in(r)))

        for c, a in zip(self.tableau.c[1:], self.tableau.A[1:], strict=True):
            evaluate(c, a)
        if not self._first_same_as_last:
            evaluate(1.0, self.tableau.b)
        error = h * combine(self.tableau.error, k) if self.tableau.error else None
        return Attempt(y, k[-1], r, error, seen, k)

    @property
    def _first_same_as_last(self) -> bool:
        return self.tableau.A[-1] == self.tableau.b[:-1] and self.tableau.c[-1] == 1

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        one = np.eye(len(J))
        k: list[np.ndarray] = []
        for a in self.tableau.A:
            k.append(J @ (one + h * combine(a, k)))
        result: np.ndarray = one + h * combine(self.tableau.b, k)
        return result


class Kutta4(RungeKutta):
    """Fourth order, four evaluations, no error estimate; between the ends the cubic through both slopes."""

    name = "rk4"
    order = 4
    tableau = KUTTA_4
    vectors = ("d1", "d2", "d3")

    def keep(self, s: SimpleNamespace, h: Any, a: Attempt) -> None:
        s.d1 = a.y - s.y
        s.d2 = h * s.f - s.d1
        s.d3 = s.d1 - h * a.f - s.d2

    def interpolate(self, s: SimpleNamespace, x: Any) -> Any:
        return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * s.d3))


class DormandPrince5(RungeKutta):
    """Dormand-Prince 5(4) with the fourth-order dense output of Hairer, Norsett, Wanner I, II.6."""

    name = "dopri5"
    order = 5
    tableau = DORMAND_PRINCE_5
    exponents = Exponents(down=-0.2, up=-0.14, memory=0.04)
    vectors = ("d1", "d2", "d3", "d4")
    dense = (
        -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    )  # fmt: skip

    def keep(self, s: SimpleNamespace, h: Any, a: Attempt) -> None:
        s.d1 = a.y - s.y
        s.d2 = h * s.f - s.d1
        s.d3, s.d4 = s.d1 - h * a.f - s.d2, h * combine([*self.dense], a.k)

    def interpolate(self, s: SimpleNamespace, x: Any) -> Any:
        return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * (s.d3 + (1.0 - x) * s.d4)))
