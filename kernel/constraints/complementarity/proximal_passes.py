"""Multipliers of redundant rows by proximal passes.

Redundant rows make the rows' matrix A singular; (A + mu) x_n+1 = b + mu x_n converges to the solution of least norm
(Carpentier, Budhiraja, Mansard 2021, algorithm 2), so that rows of one sense share their load equally, and a singular
pose is passed with bounded multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalars

MU = 1e-6  # regularisation relative to a row's own diagonal
MU_SHARED = 1e-8  # and to the mean size of all rows, metres and radians alike: for what can only move together
TINY = 1e-300  # where no row can move anything
PASSES = 3  # each divides the error by 1/MU for well-conditioned rows


def fill_in(n: int, couples: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Per row or block s the later ones r that elimination of s touches; couples: pairs (s, r), s < r, of A."""
    later: list[list[int]] = [[] for _ in range(n)]
    for s, r in couples:
        later[s].append(r)
    for s in range(n):
        later[s].sort()
        for i, r in enumerate(later[s]):
            later[r] = sorted({*later[r], *later[s][i + 1 :]})
    return later


class Proximal:
    """What the factorisations of A + mu share: the passes."""

    _substitute: Function  # (C, b -> x) of one factorisation

    def _multipliers(self, C: Array, mu: Scalars, b: Scalars, prior: Scalars | None = None) -> Outputs:
        """Of redundant rows those next to `prior` (n,), to zero without."""
        first = b if prior is None else [e + m * y for e, m, y in zip(b, mu, prior, strict=True)]
        x = self._substitute(C=C, b=first).x
        for _ in range(PASSES - 1):
            x = self._substitute(C=C, b=[e + m * y for e, m, y in zip(b, mu, x, strict=True)]).x
        return {"x": x}
