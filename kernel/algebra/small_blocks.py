"""Arithmetic of small dense matrices, stored row by row: one traced function per operation and size, on floats and
symbols.

A = L D L^T of symmetric matrices without pivoting, and an orthonormal frame of given columns. Factors C of a symmetric
block hold L below the diagonal and 1/D on it. Only blocks right of the diagonal are stored; in traced functions a row
of a block is a vector symbol, so that the processor works on whole rows.

Zeros known at tracing stay zeros, so a good order of the rows gives sparsity (Golub, Van Loan, Matrix Computations, 4.1
and 5.1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, Sym, is_sym, node, select, sqrt


def _rows(name: str, A: Array, n: int) -> list[Sym | Array]:
    """Return the rows of an input block, n numbers each: vector symbols, or arrays of floats."""
    out = []
    for at in range(0, len(A), n):
        inside = is_sym(A[at]) and A[at].op == "in" and A[at].args == (name, at)
        out.append(node("slice", name, at, width=n) if inside else np.array(A[at : at + n]))
    return out


class Blocks:
    """Traced functions for small dense blocks, one per operation and block size, created on first use."""

    def __init__(self) -> None:
        self._made: dict[str, Function] = {}

    def _get(self, name: str, body: Callable[..., Outputs], sizes: dict[str, int]) -> Function:
        if name not in self._made:
            self._made[name] = Function(name, body, sizes)
        return self._made[name]

    def factor(self, n: int) -> Function:
        """Return the function that factorises a symmetric M (n, n) as L D L^T: M -> factors C (n, n), pivots D (n,).

        Only the upper half of M is read.
        """

        def body(M: Array) -> Outputs:
            a = [list(M[n * i : n * i + n]) for i in range(n)]
            inverse, pivot = [], []
            for s in range(n):
                pivot.append(a[s][s])
                inverse.append(1.0 / a[s][s])
                for r in range(s + 1, n):
                    x = a[s][r] * inverse[s]
                    for t in range(r, n):
                        a[r][t] = a[r][t] - x * a[s][t]
                for r in range(s + 1, n):
                    a[s][r] = a[s][r] * inverse[s]
            C = [a[j][i] if j < i else inverse[i] if i == j else 0.0 for i in range(n) for j in range(n)]
            return {"C": C, "pivot": pivot}

        return self._get(f"block_factor{n}", body, {"M": n * n})

    def _solved(self, n: int, C: Array, b: list[Any]) -> list[Any]:
        """Solve M x = b with the factors C (n, n) of M; the elements of b are scalars or rows."""
        x = list(b)
        for s in range(n):
            for r in range(s + 1, n):
                x[r] = x[r] - C[n * r + s] * x[s]
        for s in reversed(range(n)):
            x[s] = x[s] * C[n * s + s]
            for r in range(s + 1, n):
                x[s] = x[s] - C[n * r + s] * x[r]
        return x

    def solve(self, n: int) -> Function:
        """Return the function that solves M x = b with the factors C (n, n) of M: C, b (n,) -> x (n,)."""
        return self._get(f"block_solve{n}", lambda C, b: {"x": self._solved(n, C, list(b))}, {"C": n * n, "b": n})

    def under(self, n: int, m: int) -> Function:
        """Return the function that solves M W = U with the factors C (n, n) of M: C, U (n, m) -> W (n, m)."""
        return self._get(
            f"block_under{n}_{m}", lambda C, U: {"W": self._solved(n, C, _rows("U", U, m))}, {"C": n * n, "U": n * m}
        )

    def less(self, n: int, m: int, k: int) -> Function:
        """Return the function that subtracts a product: M (n, m), U (k, n), W (k, m) -> M - U^T W."""

        def body(M: Array, U: Array, W: Array) -> Outputs:
            rows, w = _rows("M", M, m), _rows("W", W, m)
            for i in range(n):
                for l in range(k):
                    rows[i] = rows[i] - U[n * l + i] * w[l]
            return {"M_": rows}

        return self._get(f"block_less{n}_{m}_{k}", body, {"M": n * m, "U": k * n, "W": k * m})

    def minus_transposed(self, m: int, n: int) -> Function:
        """Return the function that subtracts a transposed product: x (m,), W (n, m), y (n,) -> x - W^T y."""

        def body(x: Array, W: Array, y: Array) -> Outputs:
            (out,) = _rows("x", x, m)
            for l, w in enumerate(_rows("W", W, m)):
                out = out - y[l] * w
            return {"x_": [out]}

        return self._get(f"block_minus_transposed{m}_{n}", body, {"x": m, "W": n * m, "y": n})

    def minus(self, n: int, m: int) -> Function:
        """Return the function that subtracts a product: x (n,), W (n, m), y (m,) -> x - W y."""

        def body(x: Array, W: Array, y: Array) -> Outputs:
            out = list(x)
            for i in range(n):
                for j in range(m):
                    out[i] = out[i] - W[m * i + j] * y[j]
            return {"x_": out}

        return self._get(f"block_minus{n}_{m}", body, {"x": n, "W": n * m, "y": m})

    def gram(self, n: int, m: int, k: int) -> Function:
        """Return the function that adds a product: A (n, m), Y (n, k), Z (k, m) -> A + Y Z."""

        def body(A: Array, Y: Array, Z: Array) -> Outputs:
            rows, z = _rows("A", A, m), _rows("Z", Z, m)
            for i in range(n):
                for l in range(k):
                    rows[i] = rows[i] + Y[k * i + l] * z[l]
            return {"A_": rows}

        return self._get(f"block_gram{n}_{m}_{k}", body, {"A": n * m, "Y": n * k, "Z": k * m})


class LDLT:
    """L D L^T factors of a symmetric matrix (n, n) with nonzero pivots."""

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
        """Return A^-1 b for one right-hand side b (n,), where A is the factorised matrix."""
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
    """Return the Householder QR factors of m columns (6,): orthogonal Q (6, 6), upper triangular R (m, m).

    The first m columns of Q, times R, are the given columns; the remaining ones span the space orthogonal to them.
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
