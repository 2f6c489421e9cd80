"""Radiation of waves by a floating body, with memory: Cummins' equation in passive states.

Cummins, The impulse response function and ship motions, Schiffstechnik 9 (1962) 101-109; states in place of the
convolution: Perez and Fossen, Modeling, Identification and Control 30 (2009) 1-15. In the port-Hamiltonian form x' = F
x + G v, f = -G^T x the energy of the water near by is x^T x / 2, and waves carry away the power -x^T F x.
"""

from collections.abc import Hashable

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars
from heavylift.kernel.description.forces import Radiation

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench
from .springs import UNIT, filled

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


class RadiationLaw(ForceLaw[Radiation]):
    """Radiation force at a point of a body, with the states of the water."""

    def check(self, f: Radiation) -> None:
        n = len(f.F)
        square = n == len(f.G) and all(len(row) == n for row in f.F)
        self.demand(f, "F", square, "must be a square matrix, with a row of G for each of its rows")
        F, R = np.array(f.F).reshape(n, n), np.array(f.R)
        growth = float(np.linalg.eigvalsh(F + F.T).max(initial=0.0))
        passive = growth <= UNIT * float(np.abs(F).max(initial=0.0))
        self.demand(f, "F", passive, f"makes energy from nothing: F + F^T has the eigenvalue {growth:g}")
        self.demand(f, "R", bool(np.abs(R @ R.T - np.eye(3)).max() < UNIT), "is not a rotation")

    def shape(self, f: Radiation) -> Hashable:
        return _places(f)

    def numbers(self, f: Radiation, poses: Poses) -> list[float]:
        matrices = (x for A in (f.F, f.G) for row in A for x in row if x)
        return [*f.at.p, *(float(x) for x in np.ravel(f.R)), *matrices]

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
        x_P, _, v = attachment(ends[0], p[:3], "a")
        R, given = np.reshape(p[3:12], (3, 3)), iter(p[12:])
        x, (F, G) = np.array(counted), (filled(places, given, shape) for places, shape in _places(f))
        own = F @ x
        rates = own + G @ join(R.T @ v, R.T @ ends[0][15:18])
        force = -(G.T @ x)
        return LawOutput(
            [wrench(x_P, R @ force[:3], R @ force[3:])],
            heat=-(x @ own), stored=0.5 * (x @ x), shown=list(force), turned=list(counted), turning=list(rates),
        )  # fmt: skip

    def shows(self, f: Radiation) -> list[SampledQuantity]:
        return [SampledQuantity("radiation/force", f"{f.name}.{c}", "N or N m") for c in COMPONENTS]


def _places(f: Radiation) -> tuple[tuple[list[int], tuple[int, int]], ...]:
    """Return the flat places of the nonzero entries of F and G, and the shapes of both."""
    n = len(f.F)
    return tuple(([i for i, x in enumerate(x for row in A for x in row) if x], (n, m)) for A, m in ((f.F, n), (f.G, 6)))
