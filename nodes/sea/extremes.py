"""Quantiles of the largest value in a random sea, from one value for each of several seeds, with confidence.

The largest values of equally long runs follow Gumbel's distribution if the runs have many independent peaks, such as
Gaussian motions, whose peaks are Rayleigh's. The most probable maximum (MPM) is its mode, the quantile 1/e. With the
place u and scale b fitted to n values, (x - u) / b has, for each quantile x, a distribution that depends on n alone
(Lawless, Statistical Models and Methods for Lifetime Data, 5.1.2). It is sampled once, and gives an estimate without
bias (in the median) and an exact bound. Values that are not Gumbel's by the Anderson-Darling test (Stephens, Biometrika
64 (1977) 583-588) have a quantile and a bound by their order instead, which assume nothing.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import e, inf, isfinite, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MPM = "MPM"
FEWEST = 10  # seeds: with fewer the interval is wider than the value
SURE = 0.95  # confidence of a bound
DRAWS = 20_000  # samples of the pivot: its quantiles are within 2 % of the scale
CONSTANT = 1e-9  # relative: a spread that is rounding
REFUSED = 1.038  # A* of Anderson and Darling at 1 %
STEPS = 40  # of Newton's method for a scale, which needs less than ten


class Extreme(NamedTuple):
    """Estimated quantile of the largest value in a run, with its confidence bound and the method of estimation.

    `above`: distance to the upper 95 % bound, infinite if there are too few values."""

    value: float
    above: float
    how: str


def part_of(quantile: str, length: float, duration: float | None) -> float:
    """Return the probability of a quantile, such as P90 or MPM, for the largest value in a run of `length` [s].

    `duration` [s]: stationary operation to which the quantile refers (None: the run)."""
    part = 1.0 / e if quantile == MPM else float(quantile[1:]) / 100.0
    return part if duration is None else part ** (length / duration)


def extreme(values: Sequence[float], part: float) -> Extreme:
    """Estimate the quantile with probability `part` of the largest value in a run from one largest value per seed.

    The largest value is minus infinity for a seed that has no value."""
    x = np.sort(np.asarray(values, float))
    least, most = float(x[0]), float(x[-1])
    if isfinite(least) and isfinite(most):
        if most - least <= CONSTANT * max(abs(least), abs(most)):
            return Extreme(most, 0.0, "equal for all seeds")
        place, scale = (float(a[0]) for a in gumbel_fit(x[None]))
        if _fits(x, place, scale):
            middle, high = _pivot(len(x), part)
            return Extreme(place + scale * middle, scale * (high - middle), "Gumbel's distribution")
    return _by_order(x, part)


def gumbel_fit(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the locations and scales (k,) of Gumbel distributions fitted to samples (k, n) by maximum likelihood."""
    mean = x.mean(axis=1, keepdims=True)
    z = x - mean
    scale = z.std(axis=1, keepdims=True) * sqrt(6.0) / np.pi
    for _ in range(STEPS):
        w = np.exp(-z / scale)
        total, first, second = (np.sum(w * z**k, axis=1, keepdims=True) for k in range(3))
        miss = scale + first / total  # of scale = mean(z) - sum(w z) / sum(w)
        slope = 1.0 + (second / total - (first / total) ** 2) / scale**2
        step = np.maximum(-miss / slope, -0.5 * scale)
        scale = scale + step
        if np.abs(step / scale).max() < CONSTANT:
            break
    place = mean - scale * np.log(np.exp(-z / scale).mean(axis=1, keepdims=True))
    return place[:, 0], scale[:, 0]


@lru_cache(64)
def _pivot(n: int, part: float) -> tuple[float, float]:
    """Return the median and the 95 % quantile of (x - place) / scale for a quantile x and samples of n."""
    place, scale = gumbel_fit(np.random.default_rng(n).gumbel(size=(DRAWS, n)))
    middle, high = np.quantile((-log(-log(part)) - place) / scale, (0.5, SURE))
    return float(middle), float(high)


def _fits(x: NDArray[np.float64], place: float, scale: float) -> bool:
    """Return whether sorted values may be from Gumbel's distribution."""
    n = len(x)
    w = np.exp(-(x - place) / scale)  # -log F
    log_rest = np.log(np.maximum(-np.expm1(-w), 1e-300))
    odd = 2.0 * np.arange(1, n + 1) - 1.0
    square = -n - float(np.mean(odd * (-w + log_rest[::-1])))
    return square * (1.0 + 0.2 / sqrt(n)) <= REFUSED


def _by_order(x: NDArray[np.float64], part: float) -> Extreme:
    """Return the quantile and its bound from the order of the values: the number below a quantile is binomial."""
    from scipy.stats import binom

    n = len(x)
    value = float(x[max(0, int(np.ceil(part * n - CONSTANT)) - 1)])
    k = int(binom.ppf(SURE, n, part))  # at most so many are below it
    if k >= n:
        return Extreme(value, inf, f"too few seeds: {int(np.ceil(log(1.0 - SURE) / log(part)))} are needed")
    high = float(x[k])
    return Extreme(value, high - value if high > value else 0.0, "order of the values")
