"""Equations of extreme cases, independent of the kernel, solved by SciPy or in closed form."""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.special import ellipk

G = 9.80665


def bounce(mass, k, t):
    """A load let go where its rope is straight: way down [m] and tension [N] at time t, largest tension."""
    w = sqrt(k / mass)
    down = G / w**2 * (1.0 - cos(w * t))
    return down, k * down, 2.0 * mass * G


def chain(masses, springs, x0, t):
    """(n,) displacements at time t of masses in a row, each on a spring under the one before, let go from x0."""
    n = len(masses)
    K = np.zeros((n, n))
    for i, k in enumerate(springs):
        K[i, i] += k
        if i:
            K[i - 1, i - 1] += k
            K[i, i - 1] = K[i - 1, i] = -k
    root = np.sqrt(masses)
    w2, V = eigh(K / np.outer(root, root))
    return V @ (np.cos(np.sqrt(np.maximum(w2, 0.0)) * t) * (V.T @ (root * x0))) / root


def period(amplitude, length):
    """[s] of a pendulum let go at rest."""
    return 4.0 * sqrt(length / G) * ellipk(sin(0.5 * amplitude) ** 2)


def turn(speed, length):
    """[s] that a pendulum needs to go round once, from its speed at the bottom [m/s]."""
    k2 = 4.0 * G * length / speed**2
    return 4.0 * length / speed * ellipk(k2)


def planar(mass, inertia, ropes, state, t, tolerance=1e-10):
    """(6,) x, z, tilt and their rates at time t of a block on tension-only ropes in a vertical plane.

    ropes: (anchor x, z, lug x, z from the centre of mass, EA, L0, damping); tilt is positive from z towards x.
    """

    def slope(_, y):
        x, z, a, u, w, r = y
        fx, fz, moment = 0.0, -mass * G, 0.0
        for ax, az, lx, lz, EA, L0, c in ropes:
            px, pz = cos(a) * lx + sin(a) * lz, -sin(a) * lx + cos(a) * lz
            dx, dz = ax - x - px, az - z - pz
            l = hypot(dx, dz)
            rate = -(dx * (u + r * pz) + dz * (w - r * px)) / l
            pull = max(0.0, EA * (l - L0) / L0 + c * rate) if l > L0 else 0.0
            gx, gz = pull * dx / l, pull * dz / l
            fx, fz, moment = fx + gx, fz + gz, moment + gx * pz - gz * px
        return [u, w, r, fx / mass, fz / mass, moment / inertia]

    return solve_ivp(slope, (0.0, t), state, method="DOP853", rtol=tolerance, atol=tolerance, max_step=0.01).y[:, -1]


def double_pendulum(m, l, i, y0, t):
    """Angles and rates (4,) of two equal uniform bars of length l, one below the other, from rest positions y0."""

    def slope(_, y):
        a, b, u, v = y
        M = np.array(
            [[i + 1.25 * m * l * l, 0.5 * m * l * l * cos(a - b)], [0.5 * m * l * l * cos(a - b), i + 0.25 * m * l * l]]
        )
        s = 0.5 * m * l * l * sin(a - b)
        f = [-s * v * v - 1.5 * m * G * l * sin(a), s * u * u - 0.5 * m * G * l * sin(b)]
        return [u, v, *np.linalg.solve(M, f)]

    return solve_ivp(slope, (0.0, t), y0, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]


def hoisted(mass, EA, L0, ground, k, d, winch, t):
    """(z, z') of a load on springy ground under a rope from z = 0 whose length winch(t) -> (L0, L0') commands."""

    def slope(s, y):
        z, w = y
        L, _ = winch(s)
        pull = max(0.0, EA * (-z - L) / L)
        push = max(0.0, k * (ground - z) - d * w) if z < ground else 0.0
        return [w, (pull + push) / mass - G]

    start = [ground - mass * G / k, 0.0]
    return solve_ivp(slope, (0.0, t), start, method="Radau", rtol=1e-9, atol=1e-11, max_step=2e-3).y[:, -1]


__all__ = ["G", "atan2", "bounce", "chain", "double_pendulum", "hoisted", "period", "pi", "planar", "turn"]
