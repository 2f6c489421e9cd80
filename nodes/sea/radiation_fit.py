"""Fit of a passive state-space model of radiation forces to added mass and damping by frequency.

K(iw) = B(w) + iw (A(w) - A_inf) (Ogilvie, 5th Symposium on Naval Hydrodynamics, 1964) is fitted by G^T (iw - F)^-1 G
with F = J - R R^T, where J is skew-symmetric. The unconstrained least-squares fit over J, R and G always gives a
passive model (the port-Hamiltonian form; van der Schaft, L2-Gain and Passivity, 2017). Modes that damping couples are
fitted together, with as many states as the error requires.

The fit starts from a sum, with non-negative coefficients, of terms d d^T iw / (W^2 - w^2 + 2 i z W w) over a grid of
frequencies W, damping ratios z and directions d (Lawson and Hanson's NNLS), projected onto the states that respond most
at wave frequencies.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, schur
from scipy.optimize import least_squares, nnls

from .hydrodynamics import FitError

COUPLED = 1e-3  # of sqrt(B_ii B_jj): smaller couplings are rounding of the panels
BEYOND = 2.0  # times the first and last frequency: the grid of terms
FREQUENCIES, ANGLES = 24, 24  # of terms
DAMPINGS = (0.2, 0.35, 0.6, 1.0, 2.0)
SEEN = 200  # frequencies whose answers the projection keeps
GOOD = 0.02  # error at which no more states are tried
STATES = range(4, 13, 2)  # of coupled modes
TRIES = 100  # of a fit
LEAST = 1e-6  # [1/s] of the damping of a start, so that its root has a slope


class StateSpace(NamedTuple):
    """Passive state-space model x' = F x + G v, f = -G^T x with F (n, n), G (n, m)."""

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
        self.wanted = self.rows(K / np.outer(self.size, self.size))

    def rows(self, K: np.ndarray) -> np.ndarray:
        """Return the damping and added mass in K (..., n, m, m) as one vector, each divided by the largest value of its
        mode."""
        parts = K.real, K.imag / self.w[:, None, None] / self._ratio
        flat = [x[..., self._upper[0], self._upper[1]].reshape(*K.shape[:-3], -1) for x in parts]
        return np.concatenate(flat, axis=-1)

    def fitted(self) -> StateSpace:
        """Return the model with the fewest states whose error is below GOOD; if there is none, the model with the
        smallest error."""
        terms, found = self._terms(), list[tuple[float, StateSpace]]()
        for n in (n for n in STATES if n >= 2 * self.m):
            space = self._polished(self._projected(terms, n))
            error = float(np.abs(self.rows(space.memory(self.w)) - self.wanted).max())
            found.append((error, space))
            if error < GOOD:
                break
        return min(found, key=lambda x: x[0])[1]

    def _terms(self) -> StateSpace:
        """Return the sum of terms that fits the data best."""
        w, axes = self.w, np.eye(self.m)
        turns = np.pi * np.arange(1, ANGLES) / ANGLES
        pairs = [(axes[i], axes[j]) for i, j in combinations(range(self.m), 2)]
        ways = [*axes, *(np.cos(t) * a + np.sin(t) * b for a, b in pairs for t in turns)]
        ends = w[0] / BEYOND, BEYOND * w[-1]
        grid = [(W, z, d) for W in np.geomspace(*ends, FREQUENCIES) for z in DAMPINGS for d in ways]
        made = [
            self.rows((1j * w / (W * W - w * w + 2j * z * W * w))[:, None, None] * np.outer(d, d)) for W, z, d in grid
        ]
        shares = nnls(np.array(made).T, self.wanted, maxiter=100 * len(made))[0]
        kept = [(W, z, np.sqrt(share) * d) for (W, z, d), share in zip(grid, shares, strict=True) if share > 0.0]
        G = np.zeros((2 * len(kept), self.m))
        G[::2] = [d for _, _, d in kept]
        return StateSpace(block_diag(*([[-2.0 * z * W, -W], [W, 0.0]] for W, z, _ in kept)), G)

    def _projected(self, space: StateSpace, n: int) -> StateSpace:
        """Return the model projected onto the n states that respond most at wave frequencies; it stays passive."""
        seen = space.answers(np.geomspace(self.w[0] / BEYOND, BEYOND * self.w[-1], SEEN))
        snapshots = np.concatenate([*seen], axis=1)
        V = np.linalg.svd(np.concatenate([snapshots.real, snapshots.imag], axis=1), full_matrices=False)[0][:, :n]
        return StateSpace(V.T @ space.F @ V, V.T @ space.G)

    def _polished(self, start: StateSpace) -> StateSpace:
        """Return the least-squares fit of J, R and G that starts from a given model."""
        n, m = start.G.shape
        above = np.triu_indices(n, 1)
        skew, lost = 0.5 * (start.F - start.F.T), np.linalg.eigh(-0.5 * (start.F + start.F.T))
        root = lost[1] * np.sqrt(np.maximum(lost[0], LEAST))
        cuts = len(above[0]), len(above[0]) + n * n

        def unpacked(x: np.ndarray) -> tuple[StateSpace, np.ndarray]:
            J, R = np.zeros((n, n)), x[cuts[0] : cuts[1]].reshape(n, n)
            J[above] = x[: cuts[0]]
            return StateSpace(J - J.T - R @ R.T, x[cuts[1] :].reshape(n, m)), R

        def error(x: np.ndarray) -> np.ndarray:
            return np.asarray(self.rows(unpacked(x)[0].memory(self.w)) - self.wanted)

        def slope(x: np.ndarray) -> np.ndarray:
            """Return the derivative of the error with respect to the parameters x, from dK = dG^T X + Y^T dG + Y^T dF X
            with X = (iw - F)^-1 G and Y = (iw - F)^-T G."""
            space, R = unpacked(x)
            X, Y = space.answers(self.w), StateSpace(space.F.T, space.G).answers(self.w)
            by_F = np.einsum("wia,wjb->ijwab", Y, X)
            by_R = -np.einsum("ikwab,kj->ijwab", by_F + by_F.swapaxes(0, 1), R)
            by_G = np.zeros((n, m, len(self.w), m, m), complex)
            for mode in range(m):
                by_G[:, mode, :, mode, :] += X.swapaxes(0, 1)
                by_G[:, mode, :, :, mode] += Y.swapaxes(0, 1)
            by_J = (by_F - by_F.swapaxes(0, 1))[above]
            parts = (by_J, by_R.reshape(-1, *by_R.shape[2:]), by_G.reshape(-1, *by_G.shape[2:]))
            return np.asarray(np.concatenate([self.rows(part) for part in parts]).T)

        begin = np.concatenate([skew[above], root.ravel(), start.G.ravel()])
        try:
            return unpacked(least_squares(error, begin, slope, max_nfev=TRIES).x)[0]
        except np.linalg.LinAlgError:  # of its singular values
            return start


def fitted(w: np.ndarray, A: np.ndarray, B: np.ndarray, A_inf: np.ndarray) -> tuple[StateSpace, FitError]:
    """Fit a state-space model of the radiation force to added mass A and damping B (n, 6, 6) at the frequencies w (n,)
    [rad/s]; return the model and its error."""
    F, G, worst = list[np.ndarray](), list[np.ndarray](), np.zeros(2)
    for modes in _groups(np.abs(B).max(axis=0)):
        of = CoupledModes(w, A, B, A_inf, modes)
        space = of.fitted()
        T, Z = schur(space.F, output="real")  # as few numbers as a rotation of the states allows
        rows = np.zeros((len(T), 6))
        rows[:, modes] = Z.T @ space.G * of.size
        F.append(T)
        G.append(rows)
        missed = np.abs(of.rows(space.memory(w)) - of.wanted).reshape(2, -1)
        worst = np.maximum(worst, missed.max(axis=1))
    return StateSpace(block_diag(*F), np.concatenate(G)), FitError(float(worst[1]), float(worst[0]))


def _groups(largest: np.ndarray) -> list[list[int]]:
    """Return the groups of modes that are coupled by damping, given the largest damping (6, 6); each group is
    sorted."""
    size = np.sqrt(np.maximum(largest.diagonal(), 1e-12 * largest.max()))
    group = [*range(6)]
    for i, j in combinations(range(6), 2):
        if max(largest[i, j], largest[j, i]) > COUPLED * size[i] * size[j]:
            group = [group[i] if g == group[j] else g for g in group]
    return [[i for i in range(6) if group[i] == g] for g in sorted(set(group))]
