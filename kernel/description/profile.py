"""Trapezoid speed profiles: the reference that every drive, winch and master follows.

A profile starts with displacement 0 and speed v0, changes its speed at a1 for d1 seconds, cruises, changes it at a2
for d2 seconds, and keeps the speed it then has (0, unless the move is endless).  Durations follow
t = d/v + v/a if d >= v^2/a else 2 sqrt(d/a).  Plain Python, so that the DEVS models compute the same instants as the
kernel.
"""

from dataclasses import dataclass
from math import copysign, inf, isfinite, sqrt


@dataclass(frozen=True)
class Trapezoid:
    """A trapezoid speed profile: speed v0 [m/s], acceleration a1 [m/s2] for d1 [s], constant speed for `cruise` [s],
    acceleration a2 for d2 [s]."""

    v0: float
    a1: float
    d1: float
    cruise: float
    a2: float
    d2: float

    @property
    def duration(self) -> float:
        """Time from the start until the last change of speed [s]; inf if the move is endless."""
        return self.d1 + self.cruise + self.d2

    def speed(self, t: float) -> float:
        """Return the speed t seconds after the start of the profile [m/s or rad/s]."""
        return self.v0 + self.a1 * _clamp(t, self.d1) + self.a2 * _clamp(t - self.d1 - self.cruise, self.d2)

    def displacement(self, t: float) -> float:
        """Return the displacement t seconds after the start of the profile [m or rad]."""
        t = max(t, 0.0)
        return self.v0 * t + self.a1 * _ramp(t, self.d1) + self.a2 * _ramp(t - self.d1 - self.cruise, self.d2)


REST = Trapezoid(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def _clamp(t: float, d: float) -> float:
    return min(max(t, 0.0), d)


def _ramp(t: float, d: float) -> float:
    """Return the integral of min(t, d) over time: t^2/2 up to t = d, linear after that."""
    c = _clamp(t, d)
    return c * (max(t, 0.0) - 0.5 * c)


def trapezoid(distance: float | None, speed: float, accel: float, v0: float = 0.0) -> Trapezoid:
    """Return the fastest trapezoid speed profile that moves by a signed distance from speed v0.

    distance None: an endless move at `speed` (0: ramp down and stop).

    `speed` is a magnitude if a distance is given; otherwise its sign is the direction. accel > 0. If v0 is too high to
    stop within the distance, the profile overshoots and comes back. Raises ValueError for accel <= 0 or for a distance
    at speed 0.
    """
    if not (isfinite(accel) and accel > 0.0):
        raise ValueError(f"acceleration must be positive, not {accel}")
    if not (isfinite(speed) and isfinite(v0) and isfinite(distance or 0.0)):
        raise ValueError(f"speed {speed} and distance {distance} must be finite numbers")
    if distance is None:
        return Trapezoid(v0, copysign(accel, speed - v0), abs(speed - v0) / accel, inf, 0.0, 0.0)
    if distance == 0.0 and v0 == 0.0:
        return REST
    if speed == 0.0:
        raise ValueError("a distance cannot be travelled at speed 0; give a speed")
    stop = v0 * abs(v0) / (2.0 * accel)  # where braking at once would end
    sign = copysign(1.0, distance - stop)
    top = sign * abs(speed)
    d1 = abs(top - v0) / accel
    # ground covered by changing v0 -> top -> 0 without cruise
    ramps = (v0 + top) / 2.0 * d1 + sign * top * top / (2.0 * accel)
    cruise = (distance - ramps) / top
    if cruise < 0.0:  # the top speed is not reached
        top = sign * sqrt(max(0.0, sign * distance * accel + v0 * v0 / 2.0))
        d1, cruise = abs(top - v0) / accel, 0.0
    return Trapezoid(v0, copysign(accel, top - v0), d1, cruise, -sign * accel, abs(top) / accel)
