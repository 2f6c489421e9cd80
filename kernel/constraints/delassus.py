"""The rows' matrix G H^-1 G^T, factorised as far as its zeros allow, and the multipliers by proximal passes.

Rows that share no tree do not couple: only entries that can be non-zero exist, so that a chain of loops costs in
proportion to its length.  What redundant rows get is in `proximal`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..function import Function
from .proximal import MU, Proximal, fill_in

__all__ = ["Delassus", "Lopsided"]


class Delassus(Proximal):
    """Functions `factorise` (A, size -> C, mu, pivot) and `multipliers` (C, mu, b -> x) for one pattern of zeros.

    `couples`: pairs (r, s), r > s, of rows that share a degree of freedom; `equal`: rows of one kind whose multipliers'
    sum of squares is the norm, such as tensions of ropes; other rows, of mixed units, count by their own diagonals.
    """

    def __init__(self, n: int, couples: Sequence[tuple[int, int]], equal: Sequence[Sequence[int]] = ()) -> None:
        self.n, self.equal = n, equal
        self.entries = [(r, r) for r in range(self.n)] + sorted(couples)
        self.lower = fill_in(n, [(s, r) for r, s in couples])
        self.filled = [(r, s) for s in range(self.n) for r in self.lower[s]]
        size = {"C": len(self.filled) + self.n, "mu": self.n, "b": self.n}
        self.factorise = Function("factorise_rows", self._factorise, {"A": len(self.entries), "size": self.n})
        self.multipliers = Function("multipliers", self._multipliers, size)
        self._substitute = Function("substitute", self._substituted, {"C": size["C"], "b": self.n})

    def _factorise(self, A: Any, size: Any) -> dict[str, Any]:
        """C = (L below the diagonal, 1/D) of A + mu; pivot: what elimination leaves of a diagonal, relative."""
        M = dict.fromkeys(self.filled, 0.0) | dict(zip(self.entries, A, strict=True))
        diagonal = [M[r, r] for r in range(self.n)]
        mu = self.regularisation(diagonal, size)
        for r in range(self.n):
            M[r, r] = diagonal[r] + mu[r]
        inverse: list[Any] = []
        for s in range(self.n):
            inverse.append(1.0 / M[s, s])
            for i, r in enumerate(self.lower[s]):
                a = M[r, s] * inverse[s]
                for t in self.lower[s][i:]:
                    M[t, r] = M[t, r] - a * M[t, s]
            for r in self.lower[s]:
                M[r, s] = M[r, s] * inverse[s]
        return {
            "C": [*(M[rs] for rs in self.filled), *inverse],
            "mu": mu,
            "pivot": [(M[r, r] - mu[r]) / (diagonal[r] + mu[r]) for r in range(self.n)],
        }

    def _substituted(self, C: Any, b: Any) -> dict[str, Any]:
        L = dict(zip(self.filled, C, strict=False))
        x = list(b)
        for s in range(self.n):
            for r in self.lower[s]:
                x[r] = x[r] - L[r, s] * x[s]
        for s in reversed(range(self.n)):
            y = x[s] * C[len(self.filled) + s]
            for r in self.lower[s]:
                y = y - L[r, s] * x[r]
            x[s] = y
        return {"x": x}


class Lopsided(Delassus):
    """The same where rows push otherwise than they sense, so that the matrix has two sides: `factorise` (A, size,
    soft -> C, mu, pivot).  Entries stand for pairs (r, s) and (s, r)."""

    def __init__(self, n: int, couples: Sequence[tuple[int, int]], equal: Sequence[Sequence[int]] = ()) -> None:
        super().__init__(n, couples, equal)
        self.entries += [(s, r) for r, s in sorted(couples)]
        size = 2 * len(self.filled) + n
        self.factorise = Function("factorise_rows", self._split, {"A": len(self.entries), "size": n, "soft": n})
        self.multipliers = Function("multipliers", self._multipliers, {"C": size, "mu": n, "b": n})
        self._substitute = Function("substitute", self._substituted, {"C": size, "b": n})

    def _split(self, A: Any, size: Any, soft: Any) -> dict[str, Any]:
        """C = (L, U above the diagonal, 1/D) of A + mu."""
        M = {rs: 0.0 for r, s in self.filled for rs in ((r, s), (s, r))} | dict(zip(self.entries, A, strict=True))
        floor = self.floor(size)
        mu = [MU * k * a + floor for k, a in zip(soft, size, strict=True)]
        diagonal = [M[r, r] for r in range(self.n)]
        for r in range(self.n):
            M[r, r] = diagonal[r] + mu[r]
        inverse: list[Any] = []
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

    def _substituted(self, C: Any, b: Any) -> dict[str, Any]:
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
