"""Two floating bodies that exchange waves: added mass and radiation memory with cross terms, in a regular wave."""

import numpy as np
from heavylift.kernel.description import (
    Body,
    Bushing,
    InputSignal,
    Joint,
    Load,
    Point,
    Radiation,
    SharedWater,
    System,
    Wave,
)
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, G, hand_over, started

PERIOD, RAMP, N = 9.0, 20.0, 40
W = 2.0 * np.pi / PERIOD
MASSES = (1.2e7, 7e6)
SIZE = np.array([1.0, 1.0, 1.0, 15.0, 40.0, 40.0] * 2)  # [m] of rotations
ALIKE = 1e-5  # of the largest: what is left of the start after fifty periods, and second-order terms


def _rows(A: np.ndarray) -> tuple:
    return tuple(map(tuple, np.asarray(A).tolist()))


def water(draws: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A (12, 12), K (12, 12), F (n, n) and G (n, 12), drawn so that A is positive and F + F^T is negative."""
    draw = draws.normal(size=(12, 12))
    A = 1.5e6 * np.outer(SIZE, SIZE) * (2.0 * np.eye(12) + 0.08 * draw @ draw.T)
    n = 16
    J, R = draws.normal(size=(n, n)), draws.normal(size=(n, n))
    F = 0.35 * (J - J.T) - 0.04 * R @ R.T - 0.05 * np.eye(n)
    K = np.diag([2e6, 2e6, 1.8e7, 4e9, 2e10, 4e9, 3e6, 3e6, 1.2e7, 3e9, 1e10, 4e9])
    return A, K, F, 900.0 * draws.normal(size=(n, 12)) * SIZE


def pair() -> tuple[System, np.ndarray]:
    """Both bodies in a wave, and the amplitudes (12,) of their motions by NumPy."""
    draws = np.random.default_rng(3)
    A, K, F, B = water(draws)
    X = 1e4 * SIZE * draws.normal(size=12) * np.exp(2j * np.pi * draws.uniform(size=12))
    bodies, joints, forces, M = [], [], [], A.copy()
    for i, (name, m) in enumerate(zip("ab", MASSES, strict=True)):
        at, here = (0.0, -20.0 + 40.0 * i, 0.0), slice(6 * i, 6 * i + 6)
        I = m * np.array([100.0, 700.0, 750.0])
        shared = SharedWater("a", _rows(A[6:, :6])) if i else None
        bodies.append(Body(name, m, inertia=_rows(np.diag(I)), added=_rows(A[here, here]), shared=shared))
        M[here, here] += np.diag([m, m, m, *I])
        joints.append(Joint(f"{name}.free", "free", "world", name, q0=(*at, 0.0, 0.0, 0.0, 1.0)))
        forces += [Load(f"{name}.buoyancy", Point(name), (0.0, 0.0, m * G)),
                   Bushing(f"{name}.water", Point("world", at), Point(name), _rows(K[here, here]),
                           _rows(np.zeros((6, 6))))]  # fmt: skip
        for part, x, phase in (("cos", X[here].real, 0.0), ("sin", X[here].imag, 0.5 * np.pi)):
            wave = InputSignal(0.0, wave=Wave(1.0, W, RAMP, phase))
            forces.append(
                Load(f"{name}.{part}", Point(name), tuple(x[:3].tolist()), tuple(x[3:].tolist()), signal=wave)
            )
    forces.append(Radiation("memory", Point("a"), _rows(F), _rows(B[:, :6]), beside=Point("b"),
                            G_beside=_rows(B[:, 6:])))  # fmt: skip
    memory = B.T @ np.linalg.solve(1j * W * np.eye(len(F)) - F, B.astype(complex))
    want = np.linalg.solve(K - W * W * M + 1j * W * memory, X)
    return System(tuple(bodies), tuple(joints), forces=tuple(forces)), want


def _balance(s: Simulation) -> float:
    row = s.row()
    signs = [1.0 if what == "heat" else -1.0 for what, _ in s.program.accounts]
    gained = sum(sign * float(x) for sign, x in zip(signs, row.accounts, strict=True))
    return float(row.kinetic + row.potential + sum(row.stored)) + gained


def test_two_hulls_that_exchange_waves_respond_as_their_frequency_domain_equations_predict() -> None:
    """All twelve amplitudes by x = (K - w^2 (M + A) + i w K(i w))^-1 X; the energy account closes."""
    system, want = pair()
    s = started(system, tolerance=1e-8)
    start = _balance(s)
    found, rest = np.zeros(12, complex), np.array([*s.row().q])
    for i in range(N):
        hand_over(s, round(PERIOD * (60 + i / N) * SECOND))
        q = np.array(s.row().q) - rest
        moved = np.concatenate([[*q[k : k + 3], *(2.0 * q[k + 3 : k + 6])] for k in (0, 7)])
        found += 2.0 / N * moved * np.exp(-1j * PERIOD * i / N * W)
        s.settle()
    assert np.abs((found - want) * SIZE).max() < ALIKE * np.abs(want * SIZE).max()
    accounts = zip(s.program.accounts, s.row().accounts, strict=True)
    works = sum(abs(float(x)) for (what, _), x in accounts if what == "work")
    assert abs(_balance(s) - start) < 1e-7 * works
