"""Radiation of waves by a floating body, with memory: Cummins' equation in passive states.

Cummins, The impulse response function and ship motions, Schiffstechnik 9 (1962) 101-109; states in place of the
convolution: Perez and Fossen, Modeling, Identification and Control 30 (2009) 1-15. In the port-Hamiltonian form x' = F
x + G v, f = -G^T x the energy of the water near by is x^T x / 2, and waves carry away the power -x^T F x.
"""

from collections.abc import Hashable

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars
from heavylift.kernel.description.forces import Radiation, Row6
from heavylift.kernel.description.units import Matrix, Point

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench
from .springs import UNIT, filled

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


class RadiationLaw(ForceLaw[Radiation]):
    """Force law of wave radiation at a point of a floating body, with memory states of the water."""

    def check(self, f: Radiation) -> None:
        n = len(f.F)
        square = {n} == {len(G) for _, G, _ in _of_bodies(f)} and all(len(row) == n for row in f.F)
        self.demand(f, "F", square, "must be a square matrix, with a row of G for each of its rows")
        F = np.array(f.F).reshape(n, n)
        growth = float(np.linalg.eigvalsh(F + F.T).max(initial=0.0))
        passive = growth <= UNIT * float(np.abs(F).max(initial=0.0))
        self.demand(f, "F", passive, f"makes energy from nothing: F + F^T has the eigenvalue {growth:g}")
        for key, (_, _, given) in zip(("R", "R_beside"), _of_bodies(f), strict=False):
            R = np.array(given)
            self.demand(f, key, bool(np.abs(R @ R.T - np.eye(3)).max() < UNIT), "is not a rotation")

    def shape(self, f: Radiation) -> Hashable:
        return _places(f)

    def numbers(self, f: Radiation, poses: Poses) -> list[float]:
        matrices = (x for A in (f.F, *(G for _, G, _ in _of_bodies(f))) for row in A for x in row if x)
        return [*(float(x) for at, _, R in _of_bodies(f) for x in (*at.p, *np.ravel(R))), *matrices]

    def angles(self, f: Radiation) -> int:
        return len(f.F)

    def turns(self, f: Radiation, poses: Poses) -> None:
        return None

    def answer(
        self,
        f: Radiation,
        p: Array,
        ends: list[Array],
        signal: Scalars,
        joint: Scalars,
        t: Scalar,
        counted: Scalars = (),
    ) -> LawOutput:
        given, x = iter(p[12 * len(ends) :]), np.array(counted)
        F, *every = (filled(places, given, shape) for places, shape in _places(f))
        own = F @ x
        rates, wrenches, shown = own, list[Array](), list[Scalar]()
        for end, G, name, of in zip(ends, every, "ab", np.reshape(p[: 12 * len(ends)], (-1, 12)), strict=False):
            x_P, _, v = attachment(end, of[:3], name)
            R = np.reshape(of[3:], (3, 3))
            rates = rates + G @ join(R.T @ v, R.T @ end[15:18])
            force = -(G.T @ x)
            wrenches.append(wrench(x_P, R @ force[:3], R @ force[3:]))
            shown += list(force)
        return LawOutput(
            wrenches, heat=-(x @ own), stored=0.5 * (x @ x), shown=shown, turned=list(counted), turning=list(rates)
        )

    def shows(self, f: Radiation) -> list[SampledQuantity]:
        of = (f.name, f"{f.name}.beside")[: len(_of_bodies(f))]
        return [SampledQuantity("radiation/force", f"{name}.{c}", "N or N m") for name in of for c in COMPONENTS]


def _of_bodies(f: Radiation) -> list[tuple[Point, tuple[Row6, ...], Matrix]]:
    """Return the point, the rows of G and the axes of each body."""
    return [(f.at, f.G, f.R), *([(f.beside, f.G_beside, f.R_beside)] if f.beside else [])]


def _places(f: Radiation) -> tuple[tuple[list[int], tuple[int, int]], ...]:
    """Return the flat places of the nonzero entries of F and each G, and their shapes."""
    n = len(f.F)
    matrices = ((f.F, n), *((G, 6) for _, G, _ in _of_bodies(f)))
    return tuple(([i for i, x in enumerate(x for row in A for x in row) if x], (n, m)) for A, m in matrices)
