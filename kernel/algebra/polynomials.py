"""Splines through values at places, and Chebyshev series that follow them: for what slides along a beam.

By operations on elements alone, as in `arrays`.  Sources: B-splines by the recurrence of Cox and de Boor (de Boor
1978, chapter X) with as many knots as values (not-a-knot ends); series by discrete orthogonality at the roots of a
Chebyshev polynomial (Mason, Handscomb 2003, section 4.6), derivatives and integrals of series (section 2.4).
"""

from __future__ import annotations

import numpy as np

from .arrays import factored, times
from .elementary import cos


def spline(x: np.ndarray, values: np.ndarray, degree: int, at: np.ndarray) -> np.ndarray:
    """(k, m) at the places `at` (k,), of the spline of an odd degree through values (n, m) at ascending x (n,)."""
    ends = (degree + 1) // 2
    knots = np.concatenate([x[:1].repeat(degree + 1), x[ends:-ends], x[-1:].repeat(degree + 1)])
    weights = factored(_splines(knots, degree, x)).solve(values)
    return times(_splines(knots, degree, at), weights)


def _splines(knots: np.ndarray, degree: int, x: np.ndarray) -> np.ndarray:
    """(k, n) B-splines at x (k,)."""
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
    """(n,) of the Chebyshev polynomial T_n, descending."""
    return np.array([cos(np.pi * (k + 0.5) / n) for k in range(n)])


def polynomials(x: np.ndarray, degree: int) -> np.ndarray:
    """(k, degree + 1) T_0, T_1, ... at x (k,)."""
    T = [np.ones(len(x)), x]
    while len(T) <= degree:
        T.append(2.0 * x * T[-1] - T[-2])
    return np.stack(T[: degree + 1], axis=1)


def series(values: np.ndarray, degree: int) -> np.ndarray:
    """(degree + 1, m) coefficients of the best approximation to values (n, m) at the roots of T_n."""
    n = len(values)
    out = times(polynomials(roots(n), degree).T, values) * (2.0 / n)
    out[0] *= 0.5
    return out


def derivative(c: np.ndarray) -> np.ndarray:
    """(n, ...) coefficients of the derivative of a series (n, ...); the last is 0."""
    out = np.zeros((len(c) + 1, *c.shape[1:]))
    for k in reversed(range(1, len(c))):
        out[k - 1] = out[k + 1] + 2.0 * k * c[k]
    out[0] *= 0.5
    return out[:-1]


def integral(c: np.ndarray) -> np.ndarray:
    """(n + 1, ...) coefficients of the integral of a series (n, ...) from -1."""
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
    """(2n - 1, ...) coefficients of the product of two series (n, ...): 2 T_i T_j = T_(i+j) + T_|i-j|."""
    n = len(a)
    out = np.zeros((2 * n - 1, *(a[0] * b[0]).shape))
    for i in range(n):
        half = 0.5 * a[i] * b
        out[i : i + n] += half
        out[: n - i] += half[i:]
        out[1 : i + 1] += half[:i][::-1]
    return out
