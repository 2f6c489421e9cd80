"""Radiation terms from added mass and damping by frequency: a passive fit in the frequency domain.

K(iw) = B(w) + iw (A(w) - A_inf) (Ogilvie 1964) is fitted by terms R iw / (W^2 - w^2 + 2 i z W w) with R symmetric and
positive semidefinite, so that any result is passive, K(0) >= 0 and K vanishes at long times, whatever the data (the
properties of Perez and Fossen, Modeling, Identification and Control 30 (2009) 1-15). R = L L^T makes the least-squares
problem free of constraints; frequencies and damping ratios are fitted with it. Each column of L is one term.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from .hydrodynamics import FitError, RadiationTerm

COUPLED = 1e-3  # of sqrt(B_ii B_jj): smaller couplings are rounding of the panels
FEWEST, MOST = 2, 8  # poles
GOOD = 0.02  # error at which no more poles are tried
FLAT = 1e-2, 5.0  # damping ratios of terms


class RadiationFit(NamedTuple):
    """Terms with their error."""

    terms: list[RadiationTerm]
    error: FitError


def fitted(w: np.ndarray, A: np.ndarray, B: np.ndarray, A_inf: np.ndarray) -> RadiationFit:
    """Return the radiation terms of added mass A and damping B (n, 6, 6) at frequencies w (n,) [rad/s]."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(B).max(axis=0).diagonal(), 1e-12 * np.abs(B).max()))
    unit = np.outer(scale, scale)
    K = (B + 1j * w[:, None, None] * (A - A_inf)) * unit
    terms: list[RadiationTerm] = []
    for modes in _groups(np.abs(B).max(axis=0) * unit):
        part = K[:, modes][:, :, modes]
        for W, z, d in _fit_group(w, part):
            direction = np.zeros(6)
            direction[modes] = d / scale[modes]
            terms.append(RadiationTerm(W, z, tuple(direction.tolist())))  # type: ignore[arg-type]
    return RadiationFit(terms, error_of(terms, w, A, B, A_inf))


def error_of(terms: list[RadiationTerm], w: np.ndarray, A: np.ndarray, B: np.ndarray, A_inf: np.ndarray) -> FitError:
    """Return the largest errors of added mass and damping over all frequencies and modes, as parts of the largest
    values of the modes."""
    K = sum((_transfer(w, x.frequency, x.damping)[:, None, None] * np.outer(x.direction, x.direction) for x in terms),
            np.zeros((len(w), 6, 6), complex))  # fmt: skip
    found_A, found_B = K.imag / w[:, None, None] + A_inf, K.real
    worst = []
    for found, given in ((found_A, A), (found_B, B)):
        largest = np.abs(given).max(axis=0).diagonal()
        sizes = np.sqrt(np.outer(largest, largest))
        worst.append(float((np.abs(found - given).max(axis=0) / np.maximum(sizes, 1e-9 * sizes.max())).max()))
    return FitError(*worst)


def _transfer(w: np.ndarray, W: float, z: float) -> np.ndarray:
    return 1j * w / (W * W - w * w + 2j * z * W * w)


def _groups(size: np.ndarray) -> list[list[int]]:
    """Return the modes that damping couples, each group sorted."""
    group = list(range(6))
    for i, j in combinations(range(6), 2):
        if max(size[i, j], size[j, i]) > COUPLED:
            group = [group[i] if g == group[j] else g for g in group]
    return [[i for i in range(6) if group[i] == g] for g in sorted(set(group))]


def _fit_group(w: np.ndarray, K: np.ndarray) -> list[tuple[float, float, np.ndarray]]:
    """Return frequency, damping ratio and direction (m,) of the terms of coupled modes with K (n, m, m), sizes of 1."""
    m = K.shape[1]
    best: tuple[float, list[tuple[float, float, np.ndarray]]] = (np.inf, [])
    peak = w[int(np.argmax(np.abs(K.real.trace(axis1=1, axis2=2))))]
    for n in range(FEWEST, MOST + 1):
        start_w = peak * np.geomspace(0.6, 1.8, n)
        start = np.concatenate([np.log(start_w), np.log(np.full(n, 0.4)), np.tile(np.eye(m).ravel() * 0.6, n)])

        def model(x: np.ndarray, n: int = n) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            return np.exp(x[:n]), np.exp(x[n : 2 * n]), x[2 * n :].reshape(n, m, m)

        def residual(x: np.ndarray) -> np.ndarray:
            W, z, L = model(x)
            made = sum(_transfer(w, W[k], z[k])[:, None, None] * (L[k] @ L[k].T) for k in range(len(W)))
            off = made - K
            weight = peak / w[:, None, None]
            return np.concatenate([off.real.ravel(), (off.imag * np.minimum(weight, 2.0)).ravel()])

        low, high = np.full(len(start), -np.inf), np.full(len(start), np.inf)
        low[n : 2 * n], high[n : 2 * n] = np.log(FLAT[0]), np.log(FLAT[1])
        low[:n], high[:n] = np.log(0.2 * w[0]), np.log(4.0 * w[-1])
        found = least_squares(residual, start, bounds=(low, high), xtol=1e-12, ftol=1e-12, max_nfev=400)
        worst = float(np.abs(residual(found.x)).max())
        if worst < best[0]:
            W, z, L = model(found.x)
            best = worst, [(float(W[k]), float(z[k]), L[k][:, j]) for k in range(n) for j in range(m)]
        if worst < GOOD:
            break
    largest = max(float(d @ d) for _, _, d in best[1])
    return [x for x in best[1] if float(x[2] @ x[2]) > 1e-6 * largest]
