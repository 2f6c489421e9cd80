"""Ramps that leave no swing: speed profiles of constant-acceleration pulses whose effects on the swing cancel.

One pulse that lasts a whole swing period leaves no swing. Of two equal pulses that start half a period apart, the
second cancels the swing of the first, whatever their length: the zero-vibration shaper (Singer and Seering 1990, J.
Dyn. Sys. Meas. Control 112), here without damping. Both hold for the period at the beginning of a ramp; `residual` is
the remaining swing if the period changes during the ramp.
"""

from itertools import pairwise
from math import pi

from heavylift.kernel.algebra.elementary import cos, sin

HALVINGS = 60  # of a speed that is sought: as many as a float tells apart
Speeds = tuple[tuple[int, float], ...]  # (time [ns], speed [m/s or rad/s]), straight between them


def ramp(pulses: int, speed: float, accel: float, period: float) -> tuple[tuple[float, float], ...]:
    """Return points (time [s], speed) of a ramp from rest to a speed > 0 by one or two acceleration pulses.

    Two pulses use at most the acceleration `accel`. Pulses that would overlap have half the acceleration each."""
    if pulses == 1:
        return (0.0, 0.0), (period, speed)
    half, lasts = 0.5 * period, 0.5 * speed / accel
    if lasts <= half:
        return (0.0, 0.0), (lasts, 0.5 * speed), (half, 0.5 * speed), (half + lasts, speed)
    single = 0.5 * accel * half  # reached as the second pulse begins
    return (0.0, 0.0), (half, single), (2.0 * lasts, speed - single), (half + 2.0 * lasts, speed)


def times(
    pulses: int, distance: float | None, speed: float, accel: float, periods: tuple[float, float]
) -> tuple[float, float, float, float]:
    """Return the speed reached over a distance > 0 (None: unlimited), and the durations [s] of ramp-up, cruise and
    ramp-down.

    The mean speed during a ramp is half the reached speed."""

    def lasting(v: float) -> list[float]:
        return [ramp(pulses, v, accel, period)[-1][0] for period in periods]

    if distance is None:
        first, second = lasting(speed)
        return speed, first, 0.0, second
    low, high = 0.0, speed
    if 0.5 * speed * sum(lasting(speed)) <= distance:
        low = speed
    else:
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if 0.5 * middle * sum(lasting(middle)) <= distance else (low, middle)
    low = low or high
    first, second = lasting(low)
    return low, first, max(0.0, distance / low - 0.5 * (first + second)), second


def profile(
    pulses: int, distance: float | None, speed: float, accel: float, periods: tuple[float, float], start: int
) -> Speeds:
    """Return a speed profile from rest at `start` [ns] to a signed speed, or over a signed distance if one is given."""
    sign = -1.0 if (speed if distance is None else distance) < 0.0 else 1.0
    reached, first, cruise, _ = times(pulses, None if distance is None else abs(distance), abs(speed), accel, periods)
    rising = ramp(pulses, reached, accel, periods[0])
    if distance is None:
        return _rounded([(t, sign * v) for t, v in rising], start)
    falling = ramp(pulses, reached, accel, periods[1])
    found = _rounded([*rising, *((first + cruise + t, reached - v) for t, v in falling)], start)
    factor = distance / way(found)  # whole nanoseconds go a little too far or not far enough
    return tuple((t, v * factor) for t, v in found)


def stop(pulses: int, speed: float, accel: float, period: float, start: int) -> Speeds:
    """Return a speed profile from a signed speed at `start` [ns] to rest."""
    rising = ramp(pulses, abs(speed), accel, period)
    return _rounded([(t, speed - (v if speed > 0.0 else -v)) for t, v in rising], start)


def way(rows: Speeds) -> float:
    """Return the distance that a speed profile covers."""
    return sum(0.5 * (v + w) * (b - a) * 1e-9 for (a, v), (b, w) in pairwise(rows))


def _rounded(rows: list[tuple[float, float]], start: int) -> Speeds:
    """Return the speed profile with times in whole nanoseconds from `start`, and a single speed at each time."""
    return tuple({start + round(t * 1e9): v for t, v in rows}.items())


def residual(pulses: int, speed: float, accel: float, chosen: float, period: float, gravity: float) -> float:
    """Return the swing [rad] that a ramp chosen for one period [s] leaves in a pendulum with another period [s]."""
    w = 2.0 * pi / period
    lasts = ramp(pulses, speed, accel, chosen)[-1][0] - 0.5 * chosen * (pulses == 2)  # one pulse
    left = 2.0 * speed / pulses / lasts / gravity * abs(sin(0.5 * w * lasts))
    return float(left * (2.0 * abs(cos(0.25 * w * chosen)) if pulses == 2 else 1.0))
