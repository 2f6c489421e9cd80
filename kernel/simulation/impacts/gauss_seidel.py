"""Contact forces one contact after the other: Gauss-Seidel with projection on Coulomb's disks.

Where many contacts hold one body, the forces among them are not unique and pivoting can go round in circles between
sets that are all right.  Sweeps (Jourdan, Alart, Jean, Comput. Meth. Appl. Mech. Eng. 155 (1998)) find one of the
solutions whenever there is one in practice, more slowly.  Plain floats in a fixed order.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

SWEEPS = 3000
SETTLED = 1e-12  # change of a sweep relative to the largest force
ENOUGH = 1e-8  # change that is accepted after all sweeps


def sweep(A: np.ndarray, b: np.ndarray, mu: np.ndarray, moving: np.ndarray) -> tuple[np.ndarray, bool]:
    """x (3m,) impulses or forces as in `coulomb.settle`, and whether they have settled."""
    a, w, x = A.tolist(), b.tolist(), [0.0] * len(b)
    contacts = [
        (3 * i, float(mu[i]), [float(e) for e in moving[i]], _rate(A[3 * i + 1 : 3 * i + 3, 3 * i + 1 : 3 * i + 3]))
        for i in range(len(mu))
    ]
    change = 0.0
    for _ in range(SWEEPS):
        change = 0.0
        for n, friction, u, rate in contacts:
            given = u[0] != 0.0 or u[1] != 0.0
            own = a[n][n] - (friction * (a[n][n + 1] * u[0] + a[n][n + 2] * u[1]) if given else 0.0)
            if own <= 0.0:
                return np.array(x), False
            push = max(0.0, x[n] - w[n] / own)
            if given:
                new = [push, -friction * push * u[0], -friction * push * u[1]]
            else:
                change = max(change, _move(a, w, x, n, [push, x[n + 1], x[n + 2]]))
                s, t = x[n + 1] - rate * w[n + 1], x[n + 2] - rate * w[n + 2]
                size, limit = sqrt(s * s + t * t), friction * push
                part = limit / size if size > limit else 1.0
                new = [push, part * s, part * t]
            change = max(change, _move(a, w, x, n, new))
        if change <= SETTLED * max(map(abs, x)):
            return np.array(x), True
    return np.array(x), change <= ENOUGH * max(map(abs, x))


def _rate(block: np.ndarray) -> float:
    """1 / largest eigenvalue of the (2, 2) tangential block."""
    (p, q), (_, r) = block.tolist()
    return 2.0 / (p + r + sqrt((p - r) * (p - r) + 4.0 * q * q)) if p + r > 0.0 else 0.0


def _move(a: list[list[float]], w: list[float], x: list[float], n: int, new: list[float]) -> float:
    """Give one contact new forces; returns their largest change."""
    most = 0.0
    for k, value in enumerate(new, n):
        d = value - x[k]
        if d != 0.0:
            x[k] = value
            most = max(most, abs(d))
            for i, row in enumerate(a):
                w[i] += row[k] * d
    return most
