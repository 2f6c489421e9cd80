"""Damping of the water between two hulls near each other, whose resonance potential theory makes too high.

This is a model of viscous losses, which come from model tests or a damping lid, and of one resonance only. Of the
states x' = F x + G v of the water, with an orthonormal basis Q of the two states of the strongest resonance l, F' = F -
rate (Q Q^T + S Q Q^T S) / 2, where S is +1 for states with an input and -1 for the others: the network stays reciprocal
(S F' S = F'^T, so that radiation is symmetric) and passive. The rate [1/s] is that at which the stated ratio is added
to -Re l / |l|; other eigenvalues move little. For small damping a lid with dissipation e [1/s] (Chen, Hydrodynamics in
offshore and naval applications, 2004) has the ratio e / (2 w). By Haskind's relation the wave loads have the same
resonance, as a part R / (i w - l) that is found by least squares beside a parabola in w, and the same l is moved there.
"""

import msgspec
import numpy as np
from heavylift.kernel.errors import SceneError
from scipy.optimize import brentq

from .hydrodynamics import GapDamping, Hydrodynamics

LIGHT = 0.15  # damping ratio above which states of the water are no resonance
WINDOW = 0.3  # of the frequency of the resonance, to both sides, where loads are split
ORDER = 2  # of the polynomial in w
SIMILAR = 0.5  # of the strongest peak: another one as high is to be damped as well
FASTEST = 10.0  # times the rate that a resonance by itself needs: more finds no solution
EXACT = 1e-9  # of the ratio that is reached


def with_gap_damping(hull: Hydrodynamics, ratio: float, source: str) -> Hydrodynamics:
    """Return the data of two hulls with a damping ratio added to the resonance of the water between them.

    `source`: where the ratio comes from. Raises SceneError if there is no second hull or no resonance."""
    second = hull.beside
    if second is None:
        raise SceneError(f"{hull.name}: damping of a gap needs the data of two hulls")
    if not 0.0 < ratio < 1.0:
        raise SceneError(f"{hull.name}: the damping of a gap is above 0 and below 1, a part of critical, not {ratio:g}")
    F, G = np.array(hull.radiation.F), np.hstack([np.array(hull.radiation.G), np.array(second.hull.radiation.G)])
    value, states, others = _resonance(F, G, np.array(hull.loads.frequencies), hull.name)
    Q = np.linalg.qr(np.column_stack([states.real, states.imag]))[0]
    S = np.where(np.any(G != 0.0, axis=1), 1.0, -1.0)
    D = 0.5 * (1.0 + np.outer(S, S)) * (Q @ Q.T)
    total = ratio + _ratio(value)

    def moved(rate: float) -> complex:
        """Return the eigenvalue whose states are most those of the resonance, damped by a rate [1/s]."""
        values, V = np.linalg.eig(F - rate * D)
        return complex(values[np.argmax(np.where(values.imag >= 0.0, np.linalg.norm(Q.T @ V, axis=0), 0.0))])

    def missed(rate: float) -> float:
        return _ratio(moved(rate)) - total

    fastest = FASTEST * ratio * abs(value)
    rate = brentq(missed, 0.0, fastest, xtol=EXACT * EXACT) if missed(fastest) > 0.0 else fastest
    if abs(missed(rate)) > EXACT:
        message = f"{hull.name}: its resonance at {abs(value):.3g} rad/s cannot have the damping ratio {total:.3g}"
        raise SceneError(f"{message}, its own with {ratio:g} added; give a smaller one")
    damped = tuple(map(tuple, (F - rate * D).tolist()))
    first, other = (_damped_loads(x, value, moved(rate)) for x in (hull, second.hull))
    water = msgspec.structs.replace(hull.radiation, F=damped)
    left = next((abs(x) for x in others if _ratio(x) < ratio), None)
    beside = msgspec.structs.replace(second, hull=other, damping=GapDamping(ratio, abs(value), source, left))
    return msgspec.structs.replace(first, radiation=water, beside=beside)


def _ratio(value: complex) -> float:
    return -value.real / abs(value)


def _resonance(F: np.ndarray, G: np.ndarray, w: np.ndarray, name: str) -> tuple[complex, np.ndarray, list[complex]]:
    """Return the eigenvalue and the states (n,) of the resonance with the highest peak of damping, relative to the
    largest damping of each mode in the range of the frequencies w [rad/s]; and the others with similar peaks."""
    values, V = np.linalg.eig(F)
    into, out = np.linalg.solve(V, G.astype(complex)), G.T @ V
    parts = out.T * into  # (n, modes): those of K_jj
    largest = np.real(np.sum(parts[:, None] / (1j * w[:, None] - values[:, None, None]), axis=0)).max(axis=0)
    peaks = (np.abs(parts) / np.abs(values.real)[:, None] / np.maximum(largest, largest.max() * 1e-12)).max(axis=1)
    inside = (w[0] < values.imag) & (values.imag < w[-1]) & (-values.real < LIGHT * np.abs(values))
    if not inside.any():
        raise SceneError(
            f"{name}: between its hulls there is no resonance from {w[0]:.3g} to {w[-1]:.3g} rad/s to damp"
        )
    k = int(np.argmax(np.where(inside, peaks, 0.0)))
    similar = np.flatnonzero(inside & (peaks > SIMILAR * peaks[k]))
    return complex(values[k]), V[:, k], [complex(values[i]) for i in similar if i != k]


def _damped_loads(hull: Hydrodynamics, value: complex, moved: complex) -> Hydrodynamics:
    """Return the data of a hull whose wave loads have the resonance moved from one eigenvalue to another."""
    loads = hull.loads
    w, X = np.array(loads.frequencies), np.array(loads.real) + 1j * np.array(loads.imaginary)
    near = np.abs(w - value.imag) < WINDOW * value.imag
    x = (w[near] - value.imag) / (WINDOW * value.imag)
    parts = np.column_stack([1.0 / (1j * w[near] - value), *(x**k for k in range(ORDER + 1))])
    if len(parts) <= parts.shape[1]:
        raise SceneError(f"{hull.name}: it has too few frequencies near {value.imag:.3g} rad/s")
    given = X[:, near].swapaxes(0, 1).reshape(len(parts), -1)
    R = np.linalg.lstsq(parts, given, rcond=None)[0][0].reshape(len(X), 1, 6)
    change = 1.0 / (1j * w - moved) - 1.0 / (1j * w - value)
    found = X + R * change[:, None]
    real, imaginary = (tuple(tuple(map(tuple, x)) for x in part.tolist()) for part in (found.real, found.imag))
    return msgspec.structs.replace(hull, loads=msgspec.structs.replace(loads, real=real, imaginary=imaginary))
