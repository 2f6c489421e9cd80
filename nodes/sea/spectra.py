"""Irregular long-crested or short-crested waves: spectra, and their components with directions and phases.

The spectral density S(w) is one-sided: its integral is Hs^2 / 16. Pierson-Moskowitz and JONSWAP follow DNV-RP-C205,
3.5.4 and 3.5.5. A spectrum is divided into bands with a constant ratio of frequencies; each band becomes one component
at a random frequency in the band, so that the sum does not repeat itself, with a random phase. Amplitudes are scaled to
the total energy. In a short-crested sea each component has its own direction, drawn from cos^2s((theta - heading) / 2)
(Jefferys, Applied Ocean Research 9 (1987) 237-244).
"""

from collections.abc import Callable
from math import pi, sqrt
from random import Random
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import cos, exp, power

LOWEST, HIGHEST = 0.4, 4.0  # of a spectrum's peak frequency: behind them is less than 0.5 % of the energy
EQUATION = 5.0 / 16.0
WIDTHS = 0.07, 0.09  # of JONSWAP's peak, below and above it
DIRECTIONS = 720  # steps of the spreading function over the circle

Density = Callable[[float], float]  # S(w) [m2 s]


class Component(NamedTuple):
    """One regular wave of a sea: frequency [rad/s], amplitude [m], direction to which it travels [rad], phase [rad] at
    the origin."""

    frequency: float
    amplitude: float
    direction: float
    phase: float


def pierson_moskowitz(w: float, Hs: float, Tp: float) -> float:
    """Return the spectral density S(w) [m2 s] of a fully developed sea with the significant height Hs [m] and the peak
    period Tp [s]."""
    ratio = 2.0 * pi / (Tp * w)
    square = ratio * ratio
    return EQUATION * Hs * Hs * square * square / w * float(exp(-1.25 * square * square))


def jonswap(w: float, Hs: float, Tp: float, gamma: float) -> float:
    """Return the spectral density S(w) [m2 s] of a growing sea, not yet scaled to its energy, which `components` does;
    gamma = 1 is Pierson-Moskowitz."""
    peak = 2.0 * pi / Tp
    off = (w / peak - 1.0) / WIDTHS[w > peak]
    return pierson_moskowitz(w, Hs, Tp) * float(power(gamma, exp(-0.5 * off * off)))


def components(
    density: Density, Hs: float, ends: tuple[float, float], n: int, heading: float, spreading: float, seed: str
) -> list[Component]:
    """Return n wave components of a spectrum between two frequencies [rad/s], scaled to the energy of the significant
    height Hs [m].

    `heading`: mean direction to which the waves travel [rad]; `spreading`: the exponent s of cos^2s, or 0 for
    long-crested waves.
    """
    random = Random(f"waves {seed}")
    step = float(power(ends[1] / ends[0], 1.0 / n))
    turned = _drawn(spreading)
    found, low = [], ends[0]
    for _ in range(n):
        w = low * (1.0 + (step - 1.0) * random.random())
        away, phase = turned(random.random()), 2.0 * pi * random.random()
        found.append(Component(w, sqrt(2.0 * max(density(w), 0.0) * low * (step - 1.0)), heading + away, phase))
        low *= step
    energy = sum(0.5 * x.amplitude * x.amplitude for x in found)
    scale = sqrt(Hs * Hs / 16.0 / energy) if energy else 0.0
    return [x._replace(amplitude=scale * x.amplitude) for x in found if x.amplitude]


def _drawn(s: float) -> Callable[[float], float]:
    """Return the inverse of the cumulative distribution of directions [rad] about the mean one, as a function of a
    number between 0 and 1."""
    if not s:
        return lambda share: 0.0
    step = 2.0 * pi / DIRECTIONS
    middles = [-pi + (i + 0.5) * step for i in range(DIRECTIONS)]
    least = exp(-30.0 / s)  # below it the power is less than 1e-26
    weights = [float(power(c, 2.0 * s)) if (c := float(cos(0.5 * x))) > least else 0.0 for x in middles]
    all_ = sum(weights)

    def angle(share: float) -> float:
        left = share * all_
        for middle, weight in zip(middles, weights, strict=True):
            if left < weight:
                return middle + (left / weight - 0.5) * step
            left -= weight
        return middles[-1]

    return angle
