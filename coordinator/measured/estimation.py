"""Inputs of a scene that a log tells: weighted least squares of model and log, and which of them it does not tell.

The unknowns are scaled, x = p / scale; the log's offset is one of them unless it was given.  Weights are the channels'
scatter.  A direction of x is not told by the log where two standard uncertainties along it, from the singular values of
the weighted Jacobian, are more than the scale: inputs in it are named and not fitted.  Uncertainty of what is left: the
scatter of the residuals, widened where they hang together; and what all rows of a sensor have in common, for its stated
uncertainty is taken as that of its calibration, which no number of rows averages out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .alignment import Alignment, Curve, correlation_time

__all__ = ["Estimate", "Told", "estimate"]

STEP = 0.02  # of a scale: step of the central differences
NOISE = 0.5  # second over first difference above which a derivative is noise
SHARE = 0.3  # of a direction that an input must have to be named with it
EVALUATIONS = 8
ENOUGH = 1e-4  # relative change of x or of the sum of squares that ends it
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """What is compared: times of the log (n,) [s]; per channel values, systematic standard uncertainty and scatter."""

    t: Floats
    values: Sequence[Floats]
    systematic: Sequence[Floats]
    scatter: Sequence[float]


@dataclass(frozen=True)
class Estimate:
    """Values and standard uncertainties of the inputs that the log tells, by number; why not, of others; the offset."""

    values: dict[int, float]
    sigma: dict[int, float]
    unknown: dict[int, str]
    at: Alignment


class _Fit:
    """Residuals and their derivatives for some of the inputs, the others at their start."""

    def __init__(
        self, simulate: Callable[[Floats], Sequence[Curve]], start: Floats, scales: Floats, free: list[int],
        told: Told, at: Alignment,
    ) -> None:  # fmt: skip
        self.simulate, self.start, self.scales, self.free = simulate, start, scales, free
        self.told, self.at = told, at
        self.span = float(np.median(np.diff(told.t)))  # in which the offset is counted
        self.noisy = np.zeros(len(free), bool)

    def begin(self) -> Floats:
        x = self.start[self.free] / self.scales[self.free]
        return np.append(x, 0.0) if self.at.estimated else x

    def curves(self, x: Floats) -> Sequence[Curve]:
        p = self.start.copy()
        p[self.free] = x[: len(self.free)] * self.scales[self.free]
        return self.simulate(p)

    def offset(self, x: Floats) -> float:
        return self.at.offset + (float(x[-1]) * self.span if self.at.estimated else 0.0)

    def residuals(self, x: Floats) -> Floats:
        t, told = self.told.t + self.offset(x), self.told
        parts = zip(self.curves(x), told.values, told.scatter, strict=True)
        return np.concatenate([(np.interp(t, T, S) - D) / s for (T, S), D, s in parts])

    def jacobian(self, x: Floats) -> Floats:
        columns = []
        for k in range(len(x)):
            h = np.zeros(len(x))
            h[k] = STEP if k < len(self.free) else 0.5
            up, down = self.residuals(x + h), self.residuals(x - h)
            columns.append((up - down) / (2.0 * h[k]))
            if k < len(self.free):
                curved = np.linalg.norm(up + down - 2.0 * self.residuals(x))
                self.noisy[k] = curved > NOISE * np.linalg.norm(up - down)
        return np.column_stack(columns)


def estimate(
    simulate: Callable[[Floats], Sequence[Curve]], start: Floats, scales: Floats, bounds: Floats, names: Sequence[str],
    told: Told, at: Alignment,
) -> Estimate:  # fmt: skip
    """Fit what the log tells of inputs p (m,) within `bounds` (2, m), whose curves `simulate(p)` gives."""
    free, unknown = list(range(len(start))), dict[int, str]()
    known: dict[bytes, Sequence[Curve]] = {}

    def once(p: Floats) -> Sequence[Curve]:
        if (key := p.tobytes()) not in known:
            known[key] = simulate(p)
        return known[key]

    while True:
        fit = _Fit(once, start, scales, free, told, at)
        x = fit.begin()
        named = [names[i] for i in free]
        lost = _untold(fit.jacobian(x), fit.noisy, named)
        if not lost:
            ends = np.full((2, len(x)), np.inf) * [[-1.0], [1.0]]
            ends[:, : len(free)] = bounds[:, free] / scales[free]
            found = least_squares(fit.residuals, x, fit.jacobian, ends, max_nfev=EVALUATIONS, xtol=ENOUGH, ftol=ENOUGH)
            lost = _untold(found.jac, fit.noisy, named)
        if not lost:
            covariance = _covariance(found.jac, found.fun, told)
            sigma = np.sqrt(np.diag(covariance))
            for k in range(len(free)):
                if 2.0 * sigma[k] > 1.0 or found.active_mask[k]:
                    lost[k] = f"the log leaves it uncertain by {200.0 * sigma[k]:.0f} % of its scale"
        if not lost:
            break
        unknown |= {free[k]: why for k, why in lost.items()}
        free = [i for k, i in enumerate(free) if k not in lost]
        if not free:
            return Estimate({}, {}, unknown, at)
    values = {i: float(found.x[k] * scales[i]) for k, i in enumerate(free)}
    bars = {i: float(sigma[k] * scales[i]) for k, i in enumerate(free)}
    if at.estimated:
        at = Alignment(fit.offset(found.x), float(sigma[-1]) * fit.span, at.correlation, True)
    return Estimate(values, bars, unknown, at)


def _untold(J: Floats, noisy: NDArray[np.bool_], names: Sequence[str]) -> dict[int, str]:
    """Which of the first columns, the inputs, lie in a direction that the residuals do not tell, and why."""
    lost, m = dict[int, str](), len(names)
    for k in range(m):
        if (norm := float(np.linalg.norm(J[:, k]))) < 2.0:
            lost[k] = f"the log hardly depends on it (all of its scale moves residuals by {norm:.2g} of their scatter)"
        elif noisy[k]:
            lost[k] = "what it changes is lost in how the run itself jitters"
    if lost:
        return lost
    _, sizes, directions = np.linalg.svd(J, full_matrices=False)
    for size, direction in zip(sizes, directions, strict=True):
        involved = [k for k in range(m) if abs(direction[k]) > SHARE * np.abs(direction).max()]
        if size < 2.0 and involved:
            for k in involved:
                others = [names[i] for i in involved if i != k] or ["the log's offset"]
                cosine = max(abs(_cosine(J[:, k], J[:, i])) for i in range(J.shape[1]) if i != k)
                lost.setdefault(k, f"the log cannot tell it from {', '.join(others)} (correlation {cosine:.4f})")
    return lost


def _cosine(a: Floats, b: Floats) -> float:
    return float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b) or 1.0))


def _covariance(J: Floats, r: Floats, told: Told) -> Floats:
    """(m, m) of x: scatter of each channel with its correlation time, and what its rows have in common."""
    A = np.linalg.inv(J.T @ J)
    middle = np.zeros_like(A)
    parts = zip(
        np.split(J, len(told.values)), np.split(r, len(told.values)), told.systematic, told.scatter, strict=True
    )
    spare = len(r) / max(1, len(r) - J.shape[1])
    for Jk, rk, common, s in parts:
        middle += correlation_time(rk) * spare * float(np.mean(rk * rk)) * (Jk.T @ Jk)
        shift = Jk.T @ (common / s)
        middle += np.outer(shift, shift)
    return A @ middle @ A
