"""Time histories of signals: P holds the piece of each that is active now, so a long record costs what a short does.

Breakpoints are step boundaries: the simulation ends a step there, commits it and asks for the next piece, so that the
integrators keep their order.  Times are integer nanoseconds.
"""

from __future__ import annotations

from bisect import bisect_right
from math import inf
from typing import Any

import numpy as np
from heavylift.kernel.description.forces import Signal

from .parameters import Parameters

__all__ = ["Histories"]


class Histories:
    """The histories of all forces; a piece is (local start [s], value there, slope)."""

    def __init__(self, signals: dict[str, Signal], parameters: Parameters, P: np.ndarray) -> None:
        self._P = P
        self._all: list[tuple[slice, list[int], Signal]] = []
        for name, s in signals.items():
            if s.times:
                at: Any = parameters.at["signal", name]
                self._all.append((at, [round(t * 1e9) for t in s.times], s))

    def write(self, epoch_ns: int, t: float = 0.0) -> None:
        """Bring the pieces that begin at or before local time t into P."""
        now = epoch_ns + round(t * 1e9)
        for at, times, s in self._all:
            i = bisect_right(times, now) - 1
            first = max(i, 0)
            inside = 0 <= i < len(times) - 1
            slope = (s.values[i + 1] - s.values[i]) / ((times[i + 1] - times[i]) * 1e-9) if inside else 0.0
            self._P[at] = [(times[first] - epoch_ns) * 1e-9, s.values[first], slope]

    def breaks(self, epoch_ns: int, after: float) -> list[float]:
        """The next breakpoint of each history in local seconds, later than `after`."""
        now = epoch_ns + round(after * 1e9)
        following = ((times, bisect_right(times, now)) for _, times, _ in self._all)
        return [(times[i] - epoch_ns) * 1e-9 for times, i in following if i < len(times)]

    def end(self, epoch_ns: int) -> float:
        """Local seconds after which nothing changes any more."""
        return max(((times[-1] - epoch_ns) * 1e-9 for _, times, _ in self._all), default=-inf)
