"""Fit of a passive and reciprocal state-space model of radiation forces to added mass and damping by frequency.

The memory of Cummins' equation, K(iw) = B(w) + iw (A(w) - A_inf) (Ogilvie, 5th Symposium on Naval Hydrodynamics,
1964), is symmetric, and its real part is positive. Such functions are G^T (iw - F)^-1 G with F = [[-D, W], [-W^T, -E]],
G = [H; 0] and diagonal D, E >= 0 (Anderson and Vongpanitlerd, Network Analysis and Synthesis, 1973, chapter 10). The
unconstrained least-squares fit over the roots of D and E, W and H is therefore always passive and reciprocal. Modes
that damping couples are fitted together, with as many states as the error requires.

The fit starts from K(s) = 2/pi int B(u) s / (s^2 + u^2) du, of which each frequency is a damped oscillator, projected
onto the states that respond most at wave frequencies.
"""

from collections.abc import Callable
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.linalg import block_diag, cho_factor, cho_solve

from .hydrodynamics import FitError

COUPLED = 5e-3  # of sqrt(B_ii B_jj): smaller couplings are left out as rounding of the panels
BEYOND = 2.0  # times the first and last frequency: where the start is projected
TAIL, LEFT = 1.6, 0.3  # times the last frequency: where damping ends in the start; and its share halfway
OSCILLATORS, SMALL = 160, 1e-4  # of the start up to the last frequency; share of the largest that is left out
SEEN = 60  # frequencies whose answers the projection keeps
NOISE = 1e-12  # of the largest damping: smaller ones of a mode are rounding
GOOD = 0.02  # error at which no more states are tried
TRIES = 100  # of a fit
FIRST, DONE = 1e-4, 1e-5  # damping of the first step, of the largest slope; relative gain at which a fit ends
LEAST = 1e-6  # [1/s] of the damping of a start, so that its root has a slope

Function = Callable[[np.ndarray], np.ndarray]


class StateSpace(NamedTuple):
    """A passive state-space model of the radiation force: x' = F x + G v, f = -G^T x with F (n, n), G (n, m)."""

    F: np.ndarray
    G: np.ndarray

    def memory(self, w: np.ndarray) -> np.ndarray:
        """Return the transfer function K(iw) (len(w), m, m) from velocities to forces at the frequencies w [rad/s]."""
        return np.asarray(self.G.T @ self.answers(w))

    def answers(self, w: np.ndarray) -> np.ndarray:
        """Return the complex state amplitudes (len(w), n, m) for unit velocities at the frequencies w [rad/s]."""
        n = len(self.F)
        found: np.ndarray = np.linalg.solve(1j * w[:, None, None] * np.eye(n) - self.F, self.G.astype(complex))
        return found


class Network(NamedTuple):
    """A radiation model as a reciprocal network: F = [-D W; -W^T -E], G = [H; 0], with diagonals D, E (n,)."""

    D: np.ndarray
    W: np.ndarray
    E: np.ndarray
    H: np.ndarray

    @property
    def space(self) -> StateSpace:
        """The reciprocal network as a state-space model."""
        F = np.block([[-np.diag(self.D), self.W], [-self.W.T, -np.diag(self.E)]])
        return StateSpace(F, np.concatenate([self.H, np.zeros_like(self.H)]))


class CoupledModes:
    """Added mass A and damping B (n, m, m) of coupled modes at the frequencies w (n,), and the added mass A_inf (m, m)
    at infinite frequency.

    They are scaled by the largest damping of each mode.
    """

    def __init__(self, w: np.ndarray, A: np.ndarray, B: np.ndarray, A_inf: np.ndarray, modes: list[int]) -> None:
        self.w, self.m = w, len(modes)
        every = np.ix_(range(len(w)), modes, modes)
        largest = [np.abs(X[:, modes, modes]).max(axis=0) for X in (A, B)]
        self.size = np.sqrt(largest[1])
        self._upper = np.triu_indices(self.m)
        self._ratio = np.sqrt(np.outer(largest[0], largest[0])) / np.outer(self.size, self.size)
        K = B[every] + 1j * w[:, None, None] * (A[every] - A_inf[np.ix_(modes, modes)])
        self.K = K / np.outer(self.size, self.size)
        self.wanted = self.rows(self.K)

    def rows(self, K: np.ndarray) -> np.ndarray:
        """Return damping and added mass in K (..., n, m, m) as one vector, each mode divided by its largest value."""
        parts = K.real, K.imag / self.w[:, None, None] / self._ratio
        flat = [x[..., self._upper[0], self._upper[1]].reshape(*K.shape[:-3], -1) for x in parts]
        return np.concatenate(flat, axis=-1)

    def fitted(self) -> StateSpace:
        """Return the smallest state-space model with an error below the constant GOOD, or else the most accurate
        one."""
        start, found = self._oscillators(), list[tuple[float, StateSpace]]()
        for n in range(max(2, self.m + self.m // 3), max(6, 3 * self.m) + 1, max(1, 2 * self.m // 3)):
            space = self._polished(self._projected(*start, n)).space
            error = float(np.abs(self.rows(space.memory(self.w)) - self.wanted).max())
            found.append((error, space))
            if error < GOOD:
                break
        return min(found, key=lambda x: x[0])[1]

    def _oscillators(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the frequencies W (k,), the dampings 2 z W (k,) and the inputs H (k, m) of the start."""
        last, damping = self.w[-1], self.K.real
        places = np.array([0.0, *self.w, 0.5 * (1.0 + TAIL) * last, TAIL * last])
        values = np.concatenate([0.0 * damping[:1], damping, LEFT * damping[-1:], 0.0 * damping[:1]])
        edges = np.linspace(0.0, TAIL * last, int(TAIL * OSCILLATORS))
        W, width = 0.5 * (edges[1:] + edges[:-1]), edges[1]
        given = PchipInterpolator(places, values)(W)
        sizes, V = np.linalg.eigh(2.0 / np.pi * width * given)
        kept = sizes > SMALL * sizes.max()
        H = V.swapaxes(1, 2)[kept] * np.sqrt(sizes[kept])[:, None]
        return np.repeat(W, kept.sum(axis=1)), np.full(len(H), 2.0 * width), H

    def _projected(self, W: np.ndarray, damping: np.ndarray, H: np.ndarray, n: int) -> Network:
        """Return the start with W^T = diag(W), projected onto the n states of either half that respond most at wave
        frequencies; it stays passive and reciprocal."""
        s = 1j * np.geomspace(self.w[0] / BEYOND, BEYOND * self.w[-1], SEEN)
        of = H[:, None] / (s * s + np.outer(damping, s) + (W * W)[:, None])[..., None]
        halves = of * s[:, None], of * W[:, None, None]
        seen = (x.reshape(len(W), -1) for x in halves)
        U, V = (np.linalg.svd(np.hstack([x.real, x.imag]), full_matrices=False)[0][:, :n] for x in seen)
        D, P = np.linalg.eigh((U.T * damping) @ U)
        return Network(D, -P.T @ (U.T * W) @ V, np.zeros(n), P.T @ U.T @ H)

    def _polished(self, start: Network) -> Network:
        """Return the least-squares fit of the roots of D and E, W and H that starts from a given model."""
        n, m = start.H.shape
        cuts = np.cumsum([n, n * n, n])

        def unpacked(x: np.ndarray) -> Network:
            d, W, e, H = np.split(x, cuts)
            return Network(d * d, W.reshape(n, n), e * e, H.reshape(n, m))

        def error(x: np.ndarray) -> np.ndarray:
            return np.asarray(self.rows(unpacked(x).space.memory(self.w)) - self.wanted)

        def slope(x: np.ndarray) -> np.ndarray:
            """Return the derivatives of the fit's error with respect to the parameters x, one row for each parameter.

            They follow from dK = dG^T X + Y^T dG + Y^T dF X with X = (iw - F)^-1 G = [a; b] and, by reciprocity, Y =
            (iw - F)^-T G = [a; -b]."""
            a, b = np.split(unpacked(x).space.answers(self.w), 2, axis=1)
            by_d, by_e = (
                2.0 * root[:, None, None, None] * np.einsum("wia,wib->iwab", y, y)
                for root, y in ((-x[:n], a), (x[cuts[1] : cuts[2]], b))
            )
            by_W = np.einsum("wia,wjb->ijwab", a, b).reshape(-1, len(self.w), m, m)
            by_H = np.zeros((n, m, len(self.w), m, m), complex)
            for mode in range(m):
                by_H[:, mode, :, mode] = a.swapaxes(0, 1)
            parts = (
                by_d,
                by_W + by_W.swapaxes(-1, -2),
                by_e,
                (by_H + by_H.swapaxes(-1, -2)).reshape(-1, *by_W.shape[1:]),
            )
            return np.concatenate([self.rows(part) for part in parts])

        d, e = (np.sqrt(np.maximum(x, LEAST)) for x in (start.D, start.E))
        return unpacked(_least(error, slope, np.concatenate([d, start.W.ravel(), e, start.H.ravel()])))


def _least(error: Function, slope: Function, x: np.ndarray) -> np.ndarray:
    """Return the x that minimises the sum of squared errors, by Levenberg's method with normal equations: SciPy's
    singular values of so many columns take minutes. The damping of steps is Nielsen's (IMM-REP-1999-05)."""
    missed, J, grow = error(x), slope(x), 2.0
    damping = FIRST * float((J * J).sum(axis=1).max())
    for _ in range(TRIES):
        step = cho_solve(cho_factor(J @ J.T + damping * np.eye(len(x))), -J @ missed)
        new = error(x + step)
        before, after = missed @ missed, new @ new
        if after < before:
            gain = (before - after) / float(step @ (damping * step - J @ missed))
            x, missed, J = x + step, new, slope(x + step)
            damping, grow = damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), 2.0
            if before - after < DONE * before:
                break
        else:
            damping, grow = damping * grow, 2.0 * grow
    return x


def fitted(w: np.ndarray, A: np.ndarray, B: np.ndarray, A_inf: np.ndarray) -> tuple[StateSpace, FitError]:
    """Return a state-space model fitted to added mass A and damping B at the frequencies w, and the error of the fit.

    A and B are (n, m, m), w (n,) [rad/s]; the error includes couplings that are left out."""
    F, G, m = list[np.ndarray](), list[np.ndarray](), len(A_inf)
    for modes in _groups(np.abs(B).max(axis=0)):
        of = CoupledModes(w, A, B, A_inf, modes)
        space = of.fitted()
        rows = np.zeros((len(space.F), m))
        rows[:, modes] = space.G * of.size
        F.append(space.F)
        G.append(rows)
    whole = StateSpace(block_diag(*F), np.concatenate(G))
    K = whole.memory(w)
    damping, added = (
        np.abs((x - y) / np.outer(*2 * [_sizes(np.abs(y).max(axis=0))])).max()
        for x, y in ((K.real, B), (K.imag / w[:, None, None] + A_inf, A))
    )
    return whole, FitError(float(added), float(damping))


def _groups(largest: np.ndarray) -> list[list[int]]:
    """Return the groups of modes that are coupled by damping, given the largest damping (m, m); each group is
    sorted."""
    m = len(largest)
    size = _sizes(largest)
    group = [*range(m)]
    for i, j in combinations(range(m), 2):
        if max(largest[i, j], largest[j, i]) > COUPLED * size[i] * size[j]:
            group = [group[i] if g == group[j] else g for g in group]
    return [[i for i in range(m) if group[i] == g] for g in sorted(set(group))]


def _sizes(largest: np.ndarray) -> np.ndarray:
    """Return the root of the largest value of each mode (m,), given those of all pairs (m, m); of rounding errors, that
    of the least which is none."""
    return np.asarray(np.sqrt(np.maximum(largest.diagonal(), NOISE * largest.max())))
