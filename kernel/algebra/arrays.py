"""Linear algebra on NumPy arrays without BLAS or LAPACK, with bit-identical results on every processor.

Sums, products, quotients and roots of elements are rounded correctly everywhere; what differs between libraries is the
order of sums and which factors are fused. Here every order is written out, and NumPy vectorises across it. Sources:
elimination by outer products (Golub, Van Loan 2013, section 3.2), cyclic Jacobi rotations in the order of a tournament,
half of the rows at a time (section 8.5.5).
"""

from dataclasses import dataclass

import numpy as np

ORTHOGONAL = 1e-15  # part of the geometric mean of its diagonal elements below which another element is zero
SWEEPS = 40  # far more than any matrix needs


def total(x: np.ndarray) -> np.ndarray:
    """Return the sum of an array along its first axis, by pairwise summation."""
    if not len(x):
        return np.zeros(x.shape[1:])
    while len(x) > 1:
        half = len(x) // 2
        x = np.concatenate([x[:half] + x[half : 2 * half], x[2 * half :]])
    return np.asarray(x[0])


def times(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Return the product A B of a matrix A (n, k) and a matrix (k, m) or vector (k,) B."""
    out = np.zeros((len(A), *B.shape[1:]))  # summed column by column of A, for the same bits everywhere
    for k, (first, end) in enumerate(_filled(A)):
        if first < end:
            out[first:end] += (A[first:end, k, None] if B.ndim > 1 else A[first:end, k]) * B[k]
    return out


def _filled(A: np.ndarray) -> list[tuple[int, int]]:
    """Return, for each column, the range of rows (first, end) that spans its nonzero entries."""
    if not A.size:
        return []
    there = A != 0.0
    first, end = np.argmax(there, axis=0), len(A) - np.argmax(there[::-1], axis=0)
    return [
        (i, j) if some else (0, 0)
        for i, j, some in zip(first.tolist(), end.tolist(), np.any(there, axis=0), strict=True)
    ]


def sizes(x: np.ndarray) -> np.ndarray:
    """Return the lengths of 3-vectors that lie along the last axis of an array."""
    return np.asarray(np.sqrt(x[..., 0] * x[..., 0] + x[..., 1] * x[..., 1] + x[..., 2] * x[..., 2]))


@dataclass(frozen=True)
class LuFactors:
    """L U factors of a matrix (n, n), stored in one array; L has a unit diagonal.

    `filled`: for each column, the range of rows that holds its nonzero entries.
    """

    LU: np.ndarray  # (n, n)
    filled: list[tuple[int, int]]

    def solve(self, B: np.ndarray) -> np.ndarray:
        """Return the solution X (n, m) of A X = B for right-hand sides B (n, m)."""
        X = np.array(B, float)
        for k, (_, end) in enumerate(self.filled):
            X[k + 1 : end] -= self.LU[k + 1 : end, k, None] * X[k]
        for k, (first, _) in reversed([*enumerate(self.filled)]):
            X[k] /= self.LU[k, k]
            X[first:k] -= self.LU[first:k, k, None] * X[k]
        return X

    def half(self) -> np.ndarray:
        """Return an inverse square root of the factorised positive definite matrix A: X (n, n) with X^T A X = I."""
        X = np.eye(len(self.LU))
        for k in reversed(range(len(X))):
            X[:k] -= self.LU[k, :k, None] * X[k]
        return np.asarray(X / np.sqrt(np.array([self.LU[k, k] for k in range(len(X))])))


def factored(A: np.ndarray, least: float = 0.0) -> LuFactors:
    """Return the L U factors of a matrix (n, n) without pivoting, as for positive definite and spline matrices.

    Raises ZeroDivisionError if a pivot is not larger than `least` times the diagonal element of the original matrix.
    """
    LU = np.array(A, float)
    for k in range(len(LU)):
        if not LU[k, k] > least * abs(float(A[k, k])):
            raise ZeroDivisionError(f"pivot {k}")
        if k + 1 == len(LU):
            break
        down, right = (k + 2 + int(np.flatnonzero(x).max(initial=-1)) for x in (LU[k + 1 :, k], LU[k, k + 1 :]))
        LU[k + 1 : down, k] /= LU[k, k]
        LU[k + 1 : down, k + 1 : right] -= LU[k + 1 : down, k, None] * LU[k, k + 1 : right]
    return LuFactors(LU, _filled(LU))


def eigen(S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues (n,) of a symmetric matrix in ascending order, and its eigenvectors as columns (n, n)."""
    n = len(S)
    A, V = (S + S.T) * 0.5, np.eye(n)
    ring = np.arange(n + n % 2)
    for _ in range(SWEEPS):
        done = True
        for _ in range(len(ring) - 1):
            ring = np.concatenate([ring[:1], ring[-1:], ring[1:-1]])
            i, j = ring[: len(ring) // 2], ring[: len(ring) // 2 - 1 : -1]
            i, j = i[np.maximum(i, j) < n], j[np.maximum(i, j) < n]  # who meets nobody waits
            large = np.abs(A[i, j]) > ORTHOGONAL * np.sqrt(np.abs(A[i, i])) * np.sqrt(np.abs(A[j, j]))
            if not np.any(large):
                continue
            done = False
            i, j = i[large], j[large]
            z = (A[j, j] - A[i, i]) / (2.0 * A[i, j])
            with np.errstate(over="ignore"):  # an angle of zero then
                t = np.where(z < 0.0, -1.0, 1.0) / (np.abs(z) + np.sqrt(1.0 + z * z))
            c = 1.0 / np.sqrt(1.0 + t * t)
            s = c * t
            A[:, i], A[:, j] = c * A[:, i] - s * A[:, j], s * A[:, i] + c * A[:, j]
            V[:, i], V[:, j] = c * V[:, i] - s * V[:, j], s * V[:, i] + c * V[:, j]
            c, s = c[:, None], s[:, None]
            A[i], A[j] = c * A[i] - s * A[j], s * A[i] + c * A[j]
            A[i, j] = A[j, i] = 0.0
        if done:
            break
    values = np.array([A[k, k] for k in range(n)])
    order = np.argsort(values, kind="stable")
    return values[order], V[:, order]
