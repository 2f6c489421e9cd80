"""Irregular long-crested or short-crested waves: spectra, and their components with directions and phases.

The spectral density S(w) is one-sided: its integral is Hs^2 / 16. Pierson-Moskowitz and JONSWAP follow DNV-RP-C205,
3.5.4 and 3.5.5, the two peaks of wind sea and swell Torsethaugen and Haver (ISOPE 2004), for the North Sea. A spectrum
is divided into bands with a constant ratio of frequencies; each band becomes one component at a random frequency in the
band, so that the sum does not repeat itself, with a random phase. Amplitudes are scaled to
the total energy. In a short-crested sea each component has its own direction, drawn from cos^2s((theta - heading) / 2)
(Jefferys, Applied Ocean Research 9 (1987) 237-244).
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import pi, sqrt
from random import Random
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import cos, exp, power

LOWEST, HIGHEST = 0.4, 4.0  # of a spectrum's peak frequency: behind them is less than 0.5 % of the energy
EQUATION = 5.0 / 16.0
WIDTHS = 0.07, 0.09  # of JONSWAP's peak, below and above it
NEWTON = 5  # steps from 5 %: each squares the error
DIRECTIONS = 720  # steps of the spreading function over the circle

Density = Callable[[float], float]  # S(w) [m2 s]


class Component(NamedTuple):
    """A regular wave of a sea: frequency [rad/s], amplitude [m], direction of travel and phase at the origin [rad]."""

    frequency: float
    amplitude: float
    direction: float
    phase: float


def pierson_moskowitz(w: float, Hs: float, Tp: float) -> float:
    """Return the spectral density S(w) [m2 s] of a fully developed sea with height Hs [m] and peak period Tp [s]."""
    ratio = 2.0 * pi / (Tp * w)
    square = ratio * ratio
    return EQUATION * Hs * Hs * square * square / w * float(exp(-1.25 * square * square))


def jonswap(w: float, Hs: float, Tp: float, gamma: float) -> float:
    """Return the JONSWAP spectral density S(w) [m2 s] of a growing sea, not yet scaled to the energy of the sea.

    `components` scales it; gamma = 1 is Pierson-Moskowitz."""
    peak = 2.0 * pi / Tp
    off = (w / peak - 1.0) / WIDTHS[w > peak]
    return pierson_moskowitz(w, Hs, Tp) * float(power(gamma, exp(-0.5 * off * off)))


class SpectralPeak(NamedTuple):
    """One of the two peaks of Torsethaugen's spectrum: height [m], period [s], peak enhancement."""

    Hs: float
    Tp: float
    gamma: float

    def density(self, w: float) -> float:
        """Return the spectral density S(w) [m2 s] of this peak before scaling to the sea's energy; tail w^-4."""
        ratio = 0.5 * w * self.Tp / pi
        off, fourth = (ratio - 1.0) / WIDTHS[ratio > 1.0], 1.0 / (ratio * ratio * ratio * ratio)
        return fourth * float(exp(-fourth)) * float(power(self.gamma, exp(-0.5 * off * off)))


def torsethaugen(Hs: float, Tp: float) -> tuple[SpectralPeak, SpectralPeak]:
    """Return the primary and the secondary peak of a sea with wind waves and swell.

    The wind waves are the primary peak if Tp is below the period 6.6 Hs^(1/3) of a fully developed sea."""
    third = 1.0 / 3.0
    full = 6.6 * float(power(Hs, third))

    def enhanced(height: float, period: float) -> float:
        return max(1.0, 35.0 * float(power(2.0 * pi / 9.81 * height / (period * period), 0.857)))

    wind = Tp <= full
    lowest, width, floor = (2.0 * sqrt(Hs), 0.5, 0.7) if wind else (25.0, 0.3, 0.6)
    away = (full - Tp) / (full - lowest)
    share = (1.0 - floor) * exp(-(away / width) * (away / width)) + floor
    first, second = share * Hs, sqrt(1.0 - share * share) * Hs
    if wind:
        return SpectralPeak(first, Tp, enhanced(first, Tp)), SpectralPeak(second, full + 2.0, 1.0)
    swell = SpectralPeak(first, Tp, enhanced(Hs, full) * (1.0 + 6.0 * away))
    return swell, SpectralPeak(second, 6.6 * float(power(second, third)), 1.0)


def between(table: Sequence[tuple[float, float]], w: float) -> float:
    """Return a value interpolated linearly in a table with frequencies in ascending order; 0 outside."""
    for (a, x), (b, y) in pairwise(table):
        if a <= w <= b:
            return x + (y - x) * (w - a) / (b - a)
    return 0.0


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


def wave_number(frequency: float, gravity: float, depth: float | None = None) -> float:
    """Return the wave number k [rad/m] of a wave with a frequency w [rad/s] on water of the depth h [m].

    From w^2 = g k tanh(k h); for depth None, deep water, from w^2 = g k."""
    deep = frequency * frequency / gravity
    if depth is None:
        return deep
    x = deep * depth
    y = x / sqrt(_tanh(x))  # Eckart, Proceedings of the NBS symposium on gravity waves (1951): within 5 %
    for _ in range(NEWTON):
        t = _tanh(y)
        y -= (y * t - x) / (t + y * (1.0 - t * t))
    return y / depth


def _tanh(x: float) -> float:
    small = float(exp(-2.0 * x))
    return (1.0 - small) / (1.0 + small)


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
