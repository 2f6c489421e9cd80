"""The largest eigenvalues of B x = mu A x with their vectors: modes (A stiffness, B mass) and buckling modes alike.

What does not hang together is solved apart, so that bending in one plane, bending in the other, stretching and torsion
of a straight beam stay what they are even where their frequencies agree.  A few vectors are found by subspace iteration
(Bathe 2014, section 11.6) on A^-1 B, whose products with A are known without multiplying by A; many, by reduction to a
symmetric matrix.  Rigid motions are moved out of the way first (Hotelling's deflation).
"""

from __future__ import annotations

import numpy as np

from .arrays import LuFactors, eigen, factored, times, total

SPARE = 8  # vectors beyond those sought and half as many again
SETTLED, LONGER = (
    1e-6,
    5,
)  # change of an eigenvalue; its vector, of half as many digits, is given so many times the steps
MOST = 100  # steps, for models with crowds of equal frequencies
NOTHING = 1e-12  # of its length, what is left of a vector that is a sum of others
SINGULAR = 1e-13  # of a diagonal element, a pivot that is rounding
GOLDEN = 0.6180339887498949


def eigenmodes(M: np.ndarray, K: np.ndarray, n: int, rigid: np.ndarray) -> np.ndarray:
    """(N, n) shapes of K u = w^2 M u, lowest frequency first, that are M-orthogonal to the rigid motions (N, r).

    Raises ZeroDivisionError if anything else moves without stiffness.
    """
    R, W = orthonormal(rigid, times(M, rigid))
    if R.shape[1]:
        # M-orthonormal R at eigenvalue `far` instead of 0 for solving, and without mass for what is sought
        far = max(float(K[k, k] / M[k, k]) for k in range(len(K)))
        K, M = K + far * times(W, W.T), M - times(W, W.T)
    return largest(M, K, n)[1]


def largest(B: np.ndarray, A: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """The n largest eigenvalues mu of B x = mu A x, descending, and their vectors (N, n), of unit x^T A x; fewer if B
    has not as many that are positive.

    Raises ZeroDivisionError if A is not positive definite.
    """
    found: list[tuple[float, int, np.ndarray]] = []
    for part in _connected(A, B) if n else []:
        values, vectors = _largest_of_one(B[np.ix_(part, part)], A[np.ix_(part, part)], n)
        for k, value in enumerate(values.tolist()):
            if value > 0.0:
                whole = np.zeros(len(A))
                whole[part] = vectors[:, k]
                found.append((value, len(found), whole))
    found = sorted(found, key=lambda f: (-f[0], f[1]))[:n]
    return np.array([f[0] for f in found]), np.array([f[2] for f in found]).reshape(len(found), len(A)).T


def _connected(A: np.ndarray, B: np.ndarray) -> list[list[int]]:
    """Degrees of freedom that hang together."""
    touches = (A != 0.0) | (B != 0.0)
    left, parts = np.ones(len(A), bool), list[list[int]]()
    for first in range(len(A)):
        if left[first]:
            part, new = np.zeros(len(A), bool), [first]
            while len(new):
                part[new] = True
                new = [int(k) for k in np.flatnonzero(np.any(touches[new], axis=0) & ~part)]
            left &= ~part
            parts.append([int(k) for k in np.flatnonzero(part)])
    return parts


def _largest_of_one(B: np.ndarray, A: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    N, p = len(A), n + n // 2 + SPARE
    factors = factored(A, SINGULAR)
    if 2 * p < N:
        values, vectors = _iterated(B, factors, n, p)
        if len(values) == min(n, N):
            return values, vectors
    X = factors.half()
    values, turn = eigen(times(X.T, times(B, X)))
    return values[::-1][:n], times(X, turn[:, ::-1][:, :n])


def _iterated(B: np.ndarray, factors: LuFactors, n: int, p: int) -> tuple[np.ndarray, np.ndarray]:
    """By subspace iteration with p vectors, from ones that no symmetry knows."""
    k = np.arange(len(B) * p, dtype=float) + 1.0
    phase = k * k * GOLDEN
    X = (phase - np.floor(phase) - 0.5).reshape(-1, p)
    values, steps, last = np.zeros(0), 0, MOST
    while steps < last:
        Z = times(B, X)
        X, _ = orthonormal(factors.solve(Z), Z)
        steps += 1
        if last < MOST and steps < last:
            continue  # the vectors are apart, and come nearer by themselves
        before = values
        values, turn = eigen(times(X.T, times(B, X)))
        values, X = values[::-1][:n], times(X, turn[:, ::-1])
        if last == MOST and len(values) == len(before) and np.all(np.abs(values - before) <= SETTLED * values):
            last = min(MOST - 1, LONGER * steps)
    return values, X[:, :n]


def orthonormal(X: np.ndarray, AX: np.ndarray, least: float = NOTHING) -> tuple[np.ndarray, np.ndarray]:
    """Columns of X made A-orthonormal, in their order, but for those of which less than `least` is new; A times them.

    By modified Gram-Schmidt, twice ("twice is enough", Kahan, Parlett).
    """
    X, AX = X.copy(), AX.copy()
    first = total(X * AX)
    kept: list[int] = []
    for turn in range(2):
        kept = []
        for k in range(X.shape[1]):
            size = total(X[:, k] * AX[:, k])
            if not size > (least * least * first[k] if not turn else 0.0):
                X[:, k] = AX[:, k] = 0.0
                continue
            kept.append(k)
            size = np.sqrt(size)
            X[:, k] /= size
            AX[:, k] /= size
            along = total(AX[:, k, None] * X[:, k + 1 :])
            X[:, k + 1 :] -= X[:, k, None] * along
            AX[:, k + 1 :] -= AX[:, k, None] * along
    return X[:, kept], AX[:, kept]
