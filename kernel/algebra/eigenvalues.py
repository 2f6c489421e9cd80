"""The largest eigenvalues of B x = mu A x with their vectors, for vibration modes (A stiffness, B mass) and buckling
modes.

Uncoupled sets of degrees of freedom are solved separately, so that bending in either plane, stretching and torsion of a
straight beam do not mix even where their frequencies agree. A few vectors are found by subspace iteration (Bathe 2014,
section 11.6) on A^-1 B, whose products with A are known without multiplying by A; many, by reduction to a symmetric
matrix. Rigid motions are moved out of the way first (Hotelling's deflation).

The module also has interpolating splines and Chebyshev series that approximate them, for bodies that slide along a
beam.

By operations on elements alone, as in `arrays`. Sources: B-splines by the recurrence of Cox and de Boor (de Boor 1978,
chapter X) with as many knots as values (not-a-knot ends); series by discrete orthogonality at the roots of a Chebyshev
polynomial (Mason, Handscomb 2003, section 4.6), derivatives and integrals of series (section 2.4).
"""

import numpy as np

from .arrays import LuFactors, eigen, factored, times, total
from .elementary import cos

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
    """Return the n mode shapes (N, n) with K u = w^2 M u, lowest frequency first, M-orthogonal to the rigid motions
    `rigid` (N, r).

    Raises ZeroDivisionError if a motion other than these rigid ones has no stiffness.
    """
    R, W = orthonormal(rigid, times(M, rigid))
    if R.shape[1]:
        # M-orthonormal R at eigenvalue `far` instead of 0 for solving, and without mass for what is sought
        far = max(float(K[k, k] / M[k, k]) for k in range(len(K)))
        K, M = K + far * times(W, W.T), M - times(W, W.T)
    return largest(M, K, n)[1]


def largest(B: np.ndarray, A: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the n largest positive eigenvalues mu of B x = mu A x in descending order, and their vectors (N, n),
    scaled to x^T A x = 1.

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
    """Return the sets of degrees of freedom that A or B couples."""
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
    """Return the n largest eigenvalues and their vectors by subspace iteration with p unsymmetric start vectors."""
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
    """Return the columns of X orthonormalised with respect to A, in their order, and A times these columns.

    A column is dropped if its part orthogonal to the earlier ones is shorter than `least` times the column. By modified
    Gram-Schmidt, applied twice ("twice is enough", Kahan, Parlett).
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


def spline(x: np.ndarray, values: np.ndarray, degree: int, at: np.ndarray) -> np.ndarray:
    """Return the values (k, m) at `at` (k,) of the spline of odd degree that interpolates values (n, m) at x (n,)."""
    ends = (degree + 1) // 2
    knots = np.concatenate([x[:1].repeat(degree + 1), x[ends:-ends], x[-1:].repeat(degree + 1)])
    weights = factored(_splines(knots, degree, x)).solve(values)
    return times(_splines(knots, degree, at), weights)


def _splines(knots: np.ndarray, degree: int, x: np.ndarray) -> np.ndarray:
    """Return the values (k, n) of the n B-splines at x (k,)."""
    n = len(knots) - degree - 1
    N = np.zeros((len(x), len(knots) - 1))
    for k, place in enumerate(x):
        N[k, max(i for i in range(degree, n) if knots[i] <= place or i == degree)] = 1.0
    for d in range(1, degree + 1):
        width = knots[d:] - knots[:-d]
        width = np.where(width > 0.0, width, np.inf)  # none there
        rising, falling = (x[:, None] - knots[:-d]) / width, (knots[d:] - x[:, None]) / width
        N = rising[:, :-1] * N[:, :-1] + falling[:, 1:] * N[:, 1:]
    return N


def roots(n: int) -> np.ndarray:
    """Return the n roots of the Chebyshev polynomial T_n in descending order."""
    return np.array([cos(np.pi * (k + 0.5) / n) for k in range(n)])


def polynomials(x: np.ndarray, degree: int) -> np.ndarray:
    """Return the Chebyshev polynomials T_0, T_1, ... at x (k,) as columns (k, degree + 1)."""
    T = [np.ones(len(x)), x]
    while len(T) <= degree:
        T.append(2.0 * x * T[-1] - T[-2])
    return np.stack(T[: degree + 1], axis=1)


def series(values: np.ndarray, degree: int) -> np.ndarray:
    """Return the Chebyshev coefficients (degree + 1, m) of the polynomial that best approximates values (n, m) given at
    the roots of T_n."""
    n = len(values)
    out = times(polynomials(roots(n), degree).T, values) * (2.0 / n)
    out[0] *= 0.5
    return out


def derivative(c: np.ndarray) -> np.ndarray:
    """Return the coefficients (n, ...) of the derivative of a Chebyshev series (n, ...); the last coefficient is 0."""
    out = np.zeros((len(c) + 1, *c.shape[1:]))
    for k in reversed(range(1, len(c))):
        out[k - 1] = out[k + 1] + 2.0 * k * c[k]
    out[0] *= 0.5
    return out[:-1]


def integral(c: np.ndarray) -> np.ndarray:
    """Return the coefficients (n + 1, ...) of the integral from -1 of a Chebyshev series (n, ...)."""
    out = np.zeros((len(c) + 1, *c.shape[1:]))
    for k in range(len(c)):
        out[k + 1] += c[k] / (2.0 * (k + 1) if k else 1.0)
        if k > 1:
            out[k - 1] -= c[k] / (2.0 * (k - 1))
    if len(c) > 1:
        out[0] = 0.0
    for k in range(1, len(out)):
        out[0] += out[k] if k % 2 else -out[k]
    return out


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the coefficients (2n - 1, ...) of the product of two Chebyshev series (n, ...)."""
    n = len(a)
    out = np.zeros((2 * n - 1, *(a[0] * b[0]).shape))
    for i in range(n):
        half = 0.5 * a[i] * b  # 2 T_i T_j = T_i+j + T_|i-j|
        out[i : i + n] += half
        out[: n - i] += half[i:]
        out[1 : i + 1] += half[:i][::-1]
    return out
