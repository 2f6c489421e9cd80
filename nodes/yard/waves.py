"""Waves that a step of a yard allows: heights by peak period, within a sector of directions.

DNV-RP-N103 and DNV-ST-N001 limit an operation by significant wave height and peak period together, since the motions
of vessels and loads depend on both.
"""

from bisect import bisect_left
from dataclasses import dataclass, replace
from math import inf, tau

from heavylift.nodes.scene.text.spelling import range_of
from heavylift.nodes.scene.text.units import ANGLE, LENGTH, TIME

from .fields import Taking

EDGE = 1e-9  # [rad] of a sector, which rounding must not cut off


@dataclass(frozen=True, order=True)
class WaveLimit:
    """The largest significant wave heights Hs [m] that a step allows, by ascending peak period Tp [s], times a factor.

    `sector`: first direction [rad] from which waves may come, and the angle [rad] of the sector, clockwise."""

    heights: tuple[tuple[float, float], ...]  # (Tp, Hs)
    sector: tuple[float, float] = (0.0, tau)
    factor: float = 1.0

    def times(self, factor: float) -> "WaveLimit":
        """Return a copy of this wave limit with another alpha factor."""
        return replace(self, factor=factor)

    @property
    def steady(self) -> bool:
        """Whether the largest allowed wave height is the same for all peak periods."""
        return len({height for _, height in self.heights}) == 1

    def at(self, period: float | None) -> float:
        """Return the largest allowed wave height [m] at a peak period; between two listed periods, the lower height.

        Above and below all listed periods, -1 is returned; for an unknown period, the lowest of all heights."""
        after, of = bisect_left(self.heights, (period or 0.0, 0.0)), self.heights
        if period is None:
            return self.factor * min(x for _, x in of)
        if after < len(of) and of[after][0] == period:
            return self.factor * of[after][1]
        return self.factor * min(of[after - 1][1], of[after][1]) if 0 < after < len(of) else -1.0

    def allows(self, height: float, period: float | None, direction: float | None) -> bool:
        """Return whether waves of a height [m], peak period [s] and direction [rad] are within the limit."""
        first, width = self.sector
        return height <= self.at(period) and (direction is None or (direction - first + EDGE) % tau <= width + 2 * EDGE)


def wave_limit(given: Taking, step: str) -> WaveLimit | None:
    """Return the waves that a step allows; None if it has no limit."""
    at = ("steps", step, "limits", "Hs")
    listed = given.source.at(at)
    if listed is None:
        if given.source.at((*at[:-1], "from")) is not None:
            given.source.fault((*at[:-1], "from"), "give the wave height 'Hs' beside it")
        return None
    sector = given.take(("steps", step, "limits", "from"), _sector, (0.0, tau))
    if not isinstance(listed, dict):
        height = given.take(at, _height, 1.0)
        return WaveLimit(((0.0, height), (inf, height)), sector)
    pairs = [(given.take((*at, x), TIME.read, 0.0, value=x), given.take((*at, x), _height, 1.0)) for x in listed]
    if len({x for x, _ in pairs}) < 2 or any(x <= 0.0 for x, _ in pairs):
        given.source.fault(at, "write one height for each of two or more periods: {6 s: 2 m, 9 s: 1.2 m}")
    return WaveLimit(tuple(sorted(pairs)), sector)


def _height(text: object) -> float:
    """Read the significant wave height [m] up to which a step is allowed."""
    if not (found := LENGTH.read(str(text))) > 0.0:
        raise ValueError(f"'{text}' is not a valid wave limit: write a height above 0, such as 1 m")
    return found


def _sector(text: object) -> tuple[float, float]:
    """Read a sector of directions, such as `330..30 deg`."""
    found = range_of(str(text))
    if not found or found.step:
        raise ValueError(f"'{text}' is not a valid sector: write the directions from which waves may come: 330..30 deg")
    first, last = (ANGLE.read(f"{x} {found.unit}") for x in (found.low, found.high))
    if first == last:
        raise ValueError(f"'{text}' is a sector without width: write two directions, or 0..360 deg for all")
    return first % tau, (last - first) % tau or tau
