"""The rows' matrix G H^-1 F with contacts, whose pushes F differ from what they sense G, entry by entry.

Rows that share no tree do not couple: only entries that can be non-zero exist, so that a chain of loops costs in
proportion to its length.  What redundant rows get is in `proximal_passes`.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.constraints.complementarity.proximal_passes import MU, MU_SHARED, TINY, Proximal, fill_in


class Unsymmetric(Proximal):
    """Functions `factorise` (A, size, soft -> C, mu, pivot) and `multipliers` (C, mu, b, prior -> x) for one pattern of
    zeros of a matrix with two sides: rows may push otherwise than they sense.

    `couples`: pairs (r, s), r > s, of rows that share a degree of freedom; entries stand for (r, s) and (s, r).
    """

    def __init__(self, n: int, couples: Sequence[tuple[int, int]]) -> None:
        self.n = n
        pairs = sorted(couples)
        self.entries = [*((r, r) for r in range(n)), *pairs, *((s, r) for r, s in pairs)]
        self.lower = fill_in(n, [(s, r) for r, s in couples])
        self.filled = [(r, s) for s in range(n) for r in self.lower[s]]
        size = 2 * len(self.filled) + n
        self.factorise = Function("factorise_rows", self._factorise, {"A": len(self.entries), "size": n, "soft": n})
        self.multipliers = Function("multipliers", self._multipliers, {"C": size, "mu": n, "b": n, "prior": n})
        self._substitute = Function("substitute", self._substituted, {"C": size, "b": n})

    def _factorise(self, A: Array, size: Array, soft: Array) -> Outputs:
        """C = (L, U above the diagonal, 1/D) of A + mu."""
        M = {rs: 0.0 for r, s in self.filled for rs in ((r, s), (s, r))} | dict(zip(self.entries, A, strict=True))
        floor = sum(size, 0.0) * (MU_SHARED / self.n) + TINY
        mu = [(MU * a + floor) * k for k, a in zip(soft, size, strict=True)]
        diagonal = [M[r, r] for r in range(self.n)]
        for r in range(self.n):
            M[r, r] = diagonal[r] + mu[r]
        inverse: list[Scalar] = []
        for s in range(self.n):
            inverse.append(1.0 / M[s, s])
            for r in self.lower[s]:
                M[r, s] = M[r, s] * inverse[s]
                for t in self.lower[s]:
                    M[r, t] = M[r, t] - M[r, s] * M[s, t]
        return {
            "C": [*(M[r, s] for r, s in self.filled), *(M[s, r] for r, s in self.filled), *inverse],
            "mu": mu,
            "pivot": [(M[r, r] - mu[r]) / (diagonal[r] + mu[r]) for r in range(self.n)],
        }

    def _substituted(self, C: Array, b: Array) -> Outputs:
        n = len(self.filled)
        L, U = (dict(zip(self.filled, c, strict=True)) for c in (C[:n], C[n : 2 * n]))
        x = list(b)
        for s in range(self.n):
            for r in self.lower[s]:
                x[r] = x[r] - L[r, s] * x[s]
        for s in reversed(range(self.n)):
            y = x[s]
            for r in self.lower[s]:
                y = y - U[r, s] * x[r]
            x[s] = y * C[2 * n + s]
        return {"x": x}
