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
from heavylift.nodes.scene.inputs import Input
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .alignment import Alignment, Curve, correlation_time

STEP, OFFSET_STEP = 0.02, 0.5  # of a scale, and of the log's: steps of the central differences
NOISE = 0.5  # of a difference: what derivatives of twice the step may differ by, and curvature may be without a look
SHARE = 0.3  # of a direction that an input must have to be named with it
EVALUATIONS = 20
ENOUGH = 1e-4  # relative change of x or of the sum of squares that ends it
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Identifiable:
    """What is compared: times of the log (n,) [s]; per channel values, systematic standard uncertainty and scatter."""

    t: Floats
    values: Sequence[Floats]
    systematic: Sequence[Floats]
    scatter: Sequence[float]


@dataclass(frozen=True)
class InputEstimates:
    """Values and standard uncertainties of the inputs that the log tells, by number; why not, of others; the offset."""

    values: dict[int, float]
    sigma: dict[int, float]
    unknown: dict[int, str]
    at: Alignment


def estimate(
    simulate: Callable[[Floats], Sequence[Curve]], inputs: Sequence[Input], told: Identifiable, at: Alignment
) -> InputEstimates:
    """Fit what the log tells of the inputs, for whose values (m,) `simulate` gives the channels' curves."""
    m, known = len(inputs), dict[bytes, Sequence[Curve]]()
    unknowns = [(p.value, p.scale, *p.bounds, STEP) for p in inputs]
    unknowns += [(0.0, float(np.median(np.diff(told.t))), -np.inf, np.inf, OFFSET_STEP)] * at.estimated
    start, scale, lower, upper, step = (np.array(column) for column in zip(*unknowns, strict=True))
    free, unknown = list(range(len(start))), dict[int, str]()
    noisy = np.zeros(len(start), bool)

    def residuals(x: Floats) -> Floats:
        p = start.copy()
        p[free] = x * scale[free]
        if (key := p[:m].tobytes()) not in known:
            known[key] = simulate(p[:m])
        t = told.t + at.offset + (p[m] if at.estimated else 0.0)
        parts = zip(known[key], told.values, told.scatter, strict=True)
        return np.concatenate([(np.interp(t, T, S) - D) / s for (T, S), D, s in parts])

    def jacobian(x: Floats) -> Floats:
        columns = []
        for k, i in enumerate(free):
            h, centre = step[i] * np.eye(len(x))[k], x.copy()
            centre[k] = np.clip(x[k], lower[i] / scale[i] + 2.0 * step[i], upper[i] / scale[i] - 2.0 * step[i])
            up, down = residuals(centre + h), residuals(centre - h)
            columns.append((up - down) / (2.0 * step[i]))
            noisy[i] = False
            if i < m and _large(up + down - 2.0 * residuals(centre), up - down):  # a kink, or noise
                wide = residuals(centre + 2.0 * h) - residuals(centre - 2.0 * h)
                noisy[i] = _large(0.5 * wide - (up - down), up - down)
        return np.column_stack(columns)

    while any(i < m for i in free):
        names = [inputs[i].name for i in free if i < m]
        x, ends = start[free] / scale[free], (lower[free] / scale[free], upper[free] / scale[free])
        lost = _untold(jacobian(x), noisy[free], names)
        if not lost:
            found = least_squares(residuals, x, jacobian, ends, max_nfev=EVALUATIONS, xtol=ENOUGH, ftol=ENOUGH)
            lost = _untold(found.jac, noisy[free], names)
            if found.status == 0:
                lost = dict.fromkeys(
                    range(len(names)), f"the fit has not settled after {EVALUATIONS} steps; begin nearer"
                )
        if not lost:
            sigma = np.sqrt(np.diag(_covariance(found.jac, found.fun, told)))
            vague = [k for k in range(len(names)) if 2.0 * sigma[k] > 1.0 or found.active_mask[k]]
            lost = {k: f"the log leaves it uncertain by {200.0 * sigma[k]:.0f} % of its scale" for k in vague}
        if not lost:
            values = dict(zip(free, found.x * scale[free], strict=True))
            bars = dict(zip(free, sigma * scale[free], strict=True))
            if at.estimated:
                at = Alignment(at.offset + float(values.pop(m)), float(bars.pop(m)), at.correlation, True)
            return InputEstimates(
                {i: float(v) for i, v in values.items()}, {i: float(v) for i, v in bars.items()}, unknown, at
            )
        unknown |= {free[k]: why for k, why in lost.items()}
        free[:] = [i for k, i in enumerate(free) if k not in lost]
    return InputEstimates({}, {}, unknown, at)


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
    unit = J / np.linalg.norm(J, axis=0)
    alike = np.abs(unit.T @ unit - np.eye(J.shape[1])).max(axis=0)
    _, sizes, directions = np.linalg.svd(J, full_matrices=False)
    for direction in directions[sizes < 2.0]:
        involved = [k for k in range(m) if abs(direction[k]) > SHARE * np.abs(direction).max()]
        for k in involved:
            others = ", ".join(names[i] for i in involved if i != k) or "the log's offset"
            lost.setdefault(k, f"the log cannot tell it from {others} (correlation {alike[k]:.4f})")
    return lost


def _large(a: Floats, b: Floats) -> bool:
    return bool(np.linalg.norm(a) > NOISE * np.linalg.norm(b))


def _covariance(J: Floats, r: Floats, told: Identifiable) -> Floats:
    """(m, m) of x: scatter of each channel with its correlation time, and what its rows have in common."""
    A, n = np.linalg.inv(J.T @ J), len(told.values)
    middle, spare = np.zeros_like(A), len(r) / max(1, len(r) - J.shape[1])
    for Jk, rk, common, s in zip(np.split(J, n), np.split(r, n), told.systematic, told.scatter, strict=True):
        middle += correlation_time(rk) * spare * float(np.mean(rk * rk)) * (Jk.T @ Jk)
        shift = Jk.T @ (common / s)
        middle += np.outer(shift, shift)
    return A @ middle @ A
