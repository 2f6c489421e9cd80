"""Friction among contacts whose forces are not unique: Coulomb's law, regularised as x_t = -mu x_n w_t /
|(w_t, e)|.

Sticking contacts creep by the order of e, and of all forces within the cones the solution takes those that stay away
from the limits; sliding contacts move far faster. So whether a body slips does not depend on how its places share their
load: it slips if no forces within all cones hold it (Moreau, Application of convex analysis, 1976: the limit of
friction is the yield surface of the body as a whole). Newton's method on w_t and x_t together, with e decreasing, as
for total variation (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20 (1999)).

Contact forces one contact after the other: Gauss-Seidel with projection on Coulomb's disks. If many contacts hold one
body, the forces among them are not unique, and pivoting can cycle between sets that are all valid. Sweeps (Jourdan,
Alart, Jean, Comput. Meth. Appl. Mech. Eng. 155 (1998)) find one of the solutions whenever there is one in practice,
more slowly. Plain floats in a fixed order.
"""

from math import sqrt

import numpy as np
from heavylift.kernel.algebra.dense import solve

FIRST, LAST, FACTOR = 1.0, 1.1e-12, 0.03  # e, relative to the largest free acceleration
SLIPS = 3e3  # times e that what slides is faster than; it is within 1 / (2 SLIPS^2) = 6e-8 of its limit
DECIDED = 1e-2  # of e z^3, z = w_t / e, which is 1/2 at the limit: below it tells on which side of it the forces are
ROUGH = 1e-2  # change at which round-off may be what is left
STEPS = 40  # of Newton's method for each e
SETTLED = 1e-6  # change of a step, relative to e and to the limits, that is small enough


def regularised(
    A: np.ndarray, b: np.ndarray, mu: np.ndarray, moving: np.ndarray, size: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Return the solution of Coulomb friction regularised by softness: impulses or forces, and which contacts slide.

    x (3m,) impulses or forces; which contacts slide (m,) and their directions u (m, 2); softness (m, 2) of sticking
    tangents, relative to that of the normals. Other arguments as in `coulomb.ContactProblem`; `size` (3m,): softness of
    each row; x: initial forces. Returns None if nothing pushes, or for a singular step.
    """
    m = len(mu)
    given = np.abs(moving).sum(axis=1) > 0.0
    rubs = np.flatnonzero(~given & (mu > 0.0))
    normal = 3 * np.arange(m)
    tangents = np.array([3 * i + k for i in rubs for k in (1, 2)], int)
    B = float(np.abs(b).max())
    # columns of the normals, with the friction of contacts that slide already
    Z = A[:, normal] - np.stack(
        [mu[i] * (moving[i, 0] * A[:, 3 * i + 1] + moving[i, 1] * A[:, 3 * i + 2]) for i in range(m)], axis=1
    )
    x, xn = x.copy(), np.maximum(x[::3], 0.0)
    # the largest friction limit is the scale of forces
    most = float((mu * xn).max(initial=0.0))
    if not most > 0.0:
        return None
    w = np.zeros((len(rubs), 2))
    xt = x[tangents].reshape(-1, 2)
    e = FIRST * B
    T = A[:, tangents]
    usual = sum(size[normal].tolist()) / m
    while True:
        # normals are softened in proportion to e, so that indeterminate ones have a unique solution
        soft = e / most * size[normal] / usual
        before = 1.0
        for _ in range(STEPS):
            c = mu[rubs] * xn[rubs]
            held = np.sqrt((xt * xt).sum(axis=1))
            # x_t is projected on the cone before each Newton step, as Chan, Golub and Mulet do with the dual variable
            xt = xt * np.minimum(1.0, c / np.maximum(held, 1e-300))[:, None]
            # |(w_t, e)|: the smoothed norm
            sigma = np.sqrt((w * w).sum(axis=1) + e * e)
            free = b + _times(Z, xn) + _times(T, xt.ravel())
            # primal-dual active set: a normal pushes if its force less its approach is positive
            on = xn - (free[normal] + soft * xn) / np.diag(Z[normal]) > 0.0
            G = xt * sigma[:, None] + c[:, None] * w
            n = m + 2 * len(rubs)
            M, r = np.zeros((n, n)), np.zeros(n)
            rows = np.concatenate([normal, tangents])
            M[:, :m] = Z[rows]
            r = -free[rows]
            r[m:] += w.ravel()
            for k, i in enumerate(rubs):
                across = T[rows][:, 2 * k : 2 * k + 2]
                D = (xt[k][:, None] * w[k] / sigma[k] + c[k] * np.eye(2)) / sigma[k]
                M[:, m + 2 * k : m + 2 * k + 2] = -(across[:, 0:1] * D[0] + across[:, 1:2] * D[1])
                v = w[k] * mu[i] / sigma[k]
                M[:, i] -= across[:, 0] * v[0] + across[:, 1] * v[1]
                g = G[k] / sigma[k]
                r += across[:, 0] * g[0] + across[:, 1] * g[1]
            M[m:, m:] -= np.eye(2 * len(rubs))
            for j in range(m):
                if on[j]:
                    M[j, j] += soft[j]
                    r[j] -= soft[j] * xn[j]
                else:
                    M[j], r[j] = 0.0, -xn[j]
                    M[j, j] = 1.0
            try:
                d = np.array(solve(M.tolist(), r.tolist()))
            except ZeroDivisionError:
                return None
            if not np.isfinite(d).all():
                return None
            dw, dn = d[m:].reshape(-1, 2), d[:m]
            D = xt * ((w * dw).sum(axis=1) / sigma)[:, None] + c[:, None] * dw + w * (mu[rubs] * dn[rubs])[:, None]
            dx = -(G + D) / sigma[:, None]
            w, xt, xn = w + dw, xt + dx, xn + dn
            largest = max(e, float(np.abs(w).max()))
            step = max(
                float(np.abs(dx).max()) / most, float(np.abs(dn).max()) / most, float(np.abs(dw).max()) / largest
            )
            if step <= SETTLED or ROUGH > step > 0.5 * before:  # settled, or as far as round-off lets it
                break
            before = step
        else:
            break
        z = max(1.0, float(np.sqrt((w * w).sum(axis=1)).max(initial=0.0)) / e)
        if step > SETTLED or e <= max(LAST, DECIDED / z**3) * B:
            break
        e *= FACTOR
    x = np.zeros(3 * m)
    x[normal] = xn
    x[tangents] = xt.ravel()
    for i in np.flatnonzero(given):
        x[3 * i + 1 : 3 * i + 3] = -mu[i] * xn[i] * moving[i]
    size = np.reshape(size, (m, 3))
    softness, slides = np.ones((m, 2)), np.zeros(m, bool)
    creep = np.sqrt((w * w).sum(axis=1)) / e
    own = (1.0 + creep * creep) ** 1.5 / np.maximum(mu[rubs] * xn[rubs] / most, LAST) * usual
    softness[rubs] = own[:, None] / size[rubs, 1:]
    z = float(creep.max(initial=0.0))
    slides[rubs] = (creep > sqrt(SLIPS)) & (z > SLIPS or e * z**3 > 10.0 * DECIDED * B)
    u = np.zeros((m, 2))
    u[rubs] = w / (np.maximum(creep, 1.0) * e)[:, None]
    return x, slides, u, softness


def _times(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return A x, summed column by column."""
    out = np.zeros(len(A))
    for k in range(len(x)):
        out = out + A[:, k] * x[k]
    return out


SWEEPS = 3000
SWEPT = 1e-12  # change of a sweep relative to the largest force
ENOUGH = 1e-8  # change that is accepted after all sweeps


def sweep(A: np.ndarray, b: np.ndarray, mu: np.ndarray, moving: np.ndarray) -> tuple[np.ndarray, bool]:
    """Return impulses or forces x (3m,) of a contact problem by projected Gauss-Seidel, and whether it converged."""
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
        if change <= SWEPT * max(map(abs, x)):
            return np.array(x), True
    return np.array(x), change <= ENOUGH * max(map(abs, x))


def _rate(block: np.ndarray) -> float:
    """Return 1 / largest eigenvalue of the (2, 2) tangential block."""
    (p, q), (_, r) = block.tolist()
    return 2.0 / (p + r + sqrt((p - r) * (p - r) + 4.0 * q * q)) if p + r > 0.0 else 0.0


def _move(a: list[list[float]], w: list[float], x: list[float], n: int, new: list[float]) -> float:
    """Set the forces of one contact from row n on, and update w; return the largest change of a force."""
    most = 0.0
    for k, value in enumerate(new, n):
        d = value - x[k]
        if d != 0.0:
            x[k] = value
            most = max(most, abs(d))
            for i, row in enumerate(a):
                w[i] += row[k] * d
    return most
