"""Irregular waves as cubic Hermite pieces, so that a step evaluates one cubic however many harmonics a sea has.

A piece begins at each multiple of `piece` of the run's time; its values and slopes at both ends are those of the sum of
harmonics, so that a cubic misses harmonic w by at most (w piece)^4 / 384 of its amplitude (Hermite's remainder). Sums
are in one order by operations on elements, with this project's own sine and cosine: the same bits on every processor.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from heavylift.kernel.algebra.arrays import total
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import WaveSum

COEFFICIENTS = 5  # local start of the piece [s], then those of 1, u, u^2, u^3 of the time u since then
Knot = tuple[np.ndarray, np.ndarray]  # values and slopes (n,)


class WavePieces:
    """Cubic polynomials in time that represent all irregular waves; waves of equal frequencies are summed."""

    def __init__(self, waves: Mapping[str, WaveSum], at: Mapping[tuple[str, str], slice], P: np.ndarray) -> None:
        groups: dict[tuple[object, ...], list[str]] = {}
        for name, wave in waves.items():
            groups.setdefault((wave.frequencies, wave.ramp, wave.piece, bool(wave.by[0])), []).append(name)
        places = np.arange(len(P))
        self._groups = [
            _Sea([waves[name] for name in names], np.array([places[at["waves", name]] for name in names]))
            for names in groups.values()
        ]
        self._P = P

    def __len__(self) -> int:
        return len(self._groups)

    def write(self, epoch_ns: int, t: float = 0.0) -> None:
        """Write the cubic polynomials that represent all waves at local time t [s] into the parameter block P."""
        for sea in self._groups:
            self._P[sea.places] = sea.piece(epoch_ns, epoch_ns + round(t * 1e9))

    def breaks(self, epoch_ns: int, after: float) -> list[float]:
        """Return the end times [local s] of the polynomials that represent the waves at the local time `after` [s]."""
        now = epoch_ns + round(after * 1e9)
        return [((now // sea.length + 1) * sea.length - epoch_ns) * 1e-9 for sea in self._groups]


class _Sea:
    """Waves of the same frequencies. `length`: of a piece [ns]; `places`: (n, 5) of its numbers in P."""

    def __init__(self, waves: list[WaveSum], places: np.ndarray) -> None:
        self.places, self._ramp = places, waves[0].ramp
        self.length = round(waves[0].piece * 1e9)
        self._w = np.array(waves[0].frequencies)
        self._sum = np.array([(x.cosines, x.sines) for x in waves]).transpose(1, 2, 0)
        self._by = np.array([x.by for x in waves]).transpose(1, 2, 0)  # each (2, harmonics, n)
        self._knots: dict[int, Knot] = {}  # the last two

    def piece(self, epoch_ns: int, now_ns: int) -> np.ndarray:
        """Return the cubic polynomials of n waves valid at time `now_ns`: start [s] and four coefficients (n, 5)."""
        k = now_ns // self.length
        self._knots = {i: self._knots.get(i) or self._knot(i) for i in (k, k + 1)}
        (x, dx), (y, dy) = self._knots[k], self._knots[k + 1]
        h = self.length * 1e-9
        rise = (y - x) / h
        start = np.full(len(x), (k * self.length - epoch_ns) * 1e-9)
        return np.array([start, x, dx, (3.0 * rise - 2.0 * dx - dy) / h, (dx + dy - 2.0 * rise) / (h * h)]).T

    def _knot(self, k: int) -> Knot:
        t = k * self.length * 1e-9
        u = min(t / self._ramp, 1.0)
        r, dr = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * u * u * (1.0 - u) * (1.0 - u) / self._ramp
        angle: Any = self._w * t
        c, s = cos(angle)[:, None], sin(angle)[:, None]

        def summed(C: np.ndarray, S: np.ndarray) -> Knot:
            return total(c * C + s * S), total(self._w[:, None] * (c * S - s * C))

        value, slope = summed(*self._sum)
        if self._by.size:
            (C, S), (D, T) = self._sum, self._by
            (y, dy), (other, rate), (z, dz) = summed(-S, C), summed(D, T), summed(-T, D)
            value, slope = value * other + y * z, slope * other + value * rate + dy * z + y * dz
            r, dr = r * r, 2.0 * r * dr
        return r * value, dr * value + r * slope
