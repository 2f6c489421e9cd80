"""A = L D L^T of symmetric matrices without pivoting, and an orthonormal frame of given columns; floats and symbols.

Zeros that are known when the text is traced stay zeros, so a good order of the rows is all that sparsity needs
(Golub, Van Loan, Matrix Computations, 4.1 and 5.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, select, sqrt


class LDLT:
    """Factors of a symmetric matrix (n, n); pivots must not vanish."""

    def __init__(self, A: Sequence[Sequence[Scalar]]) -> None:
        n = len(A)
        self.L = [[0.0] * n for _ in range(n)]
        self.D_inverse: list[Scalar] = []
        U = [[A[i][j] for j in range(i + 1)] for i in range(n)]
        for k in range(n):
            d = 1.0 / U[k][k]
            self.D_inverse.append(d)
            for i in range(k + 1, n):
                self.L[i][k] = U[i][k] * d
            for i in range(k + 1, n):
                for j in range(k + 1, i + 1):
                    U[i][j] = U[i][j] - U[i][k] * self.L[j][k]

    def solve(self, b: Scalars) -> list[Scalar]:
        """A^-1 b for one right hand side (n,)."""
        n = len(self.L)
        y: list[Scalar] = list(b)
        for i in range(n):
            for k in range(i):
                y[i] = y[i] - self.L[i][k] * y[k]
        y = [e * d for e, d in zip(y, self.D_inverse, strict=True)]
        for i in reversed(range(n)):
            for k in range(i + 1, n):
                y[i] = y[i] - self.L[k][i] * y[k]
        return y


def frame(columns: list[Array]) -> tuple[Any, Any]:
    """Q (n, n) orthogonal and R (m, m) upper triangular with columns = Q[:, :m] R, by Householder reflections.

    The other columns of Q span what is orthogonal to all given ones.
    """
    n, m = 6, len(columns)
    Q, R = np.eye(n), [[0.0] * m for _ in range(m)]
    for k, column in enumerate(columns):
        x = Q.T @ column
        norm = sqrt(x[k:] @ x[k:])
        sign = select(x[k] >= 0.0, 1.0, -1.0)
        u = np.array([*([0.0] * k), x[k] + sign * norm, *x[k + 1 :]])
        w = (Q @ u) * (1.0 / (norm * (norm + sign * x[k])))
        Q = Q - np.array([[a * b for b in u] for a in w])
        for i in range(k):
            R[i][k] = x[i]
        R[k][k] = -sign * norm
    return Q, R
