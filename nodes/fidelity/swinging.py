"""What an error of a pendulum's frequency makes of its swing, in closed form: moves ramp up with a, cruise, ramp down.

With y = w ta / 2 of a ramp and x = w (ta + tc) / 2, the load swings out by R = a / w^2 (1 - cos w ta) in the ramp and
keeps A = 4 a / w^2 |sin y sin x| after the move, so that an error of the frequency changes them by

    dR / R = (-2 + w ta cot y) dw / w          within -2 and 0
    dA / A = (-2 + y cot y + x cot x) dw / w   not bounded: where x is a multiple of pi nothing swings

The frequency of a lift is known to a twentieth before its equations are solved, and hooks whose ropes differ share it:
largest values over all that it may be.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import pi

from heavylift.kernel.algebra.elementary import cos, sin

__all__ = ["Swing", "away", "envelope", "excursion", "farthest"]

KNOWN = 0.05  # relative uncertainty of a frequency from lengths alone
STILL = 1e-6  # excursion of nothing that moves [m]
PLACES = 15  # at which it is tried
Omegas = tuple[float, float]  # lowest and highest that it may be [rad/s]


@dataclass(frozen=True)
class Swing:
    """A move of what hooks hang from: ramp [m/s2], duration of ramp and cruise, time from its begin to the end [s]."""

    ramp: float
    ramping: float
    cruising: float
    lasting: float
    along: bool = False  # the rails


def excursion(swings: Iterable[Swing], omegas: Omegas) -> float:
    """How far the load swings out at least [m]; where nothing moves, as far as a step of a ramp of 1 cm/s2 would."""
    sizes = [min(max(_ramp(s, w), _left(s, w)) for w in _frequencies(omegas)) for s in swings]
    found = max(sizes, default=0.0)
    return found if found > STILL else 0.01 / (omegas[1] * omegas[1])


def farthest(swings: Iterable[Swing], omegas: Omegas) -> float:
    """How far the load swings out at most [m]."""
    return sum(max(max(_ramp(s, w), _left(s, w)) for w in _frequencies(omegas)) for s in swings)


def envelope(swings: Iterable[Swing], omegas: Omegas) -> float:
    """Relative error of the largest excursion or of the frequency, whichever is more, for one of the frequency."""
    return max([2.0, *(_slope(s, w) for s in swings for w in _frequencies(omegas))])


def away(swings: Iterable[Swing], omegas: Omegas) -> float:
    """Error of the load's place for a relative error of the frequency [m]."""
    return sum(farthest([s], omegas) * omegas[1] * s.lasting for s in swings)


def _frequencies(omegas: Omegas) -> Iterator[float]:
    low, high = omegas[0] * (1.0 - KNOWN), omegas[1] * (1.0 + KNOWN)
    for i in range(PLACES):
        yield low + (high - low) * i / (PLACES - 1)


def _ramp(s: Swing, w: float) -> float:
    return float(s.ramp / (w * w) * (1.0 - cos(min(w * s.ramping, pi))))


def _left(s: Swing, w: float) -> float:
    y, x = w * s.ramping / 2.0, w * (s.ramping + s.cruising) / 2.0
    return float(4.0 * s.ramp / (w * w) * abs(sin(y) * sin(x)))


def _slope(s: Swing, w: float) -> float:
    """dA / dw of what is left after the move, relative to the larger of both excursions."""
    y, x = w * s.ramping / 2.0, w * (s.ramping + s.cruising) / 2.0
    change = -2.0 * sin(y) * sin(x) + y * cos(y) * sin(x) + x * sin(y) * cos(x)
    return float(4.0 * s.ramp / (w * w) * abs(change) / max(_ramp(s, w), _left(s, w), 1e-12))
