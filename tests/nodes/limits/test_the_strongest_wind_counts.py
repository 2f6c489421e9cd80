"""The wind speed at any time is that of the strongest history, at a jump the larger value."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.kernel.description import InputSignal
from heavylift.nodes.limits import wind_speed


def speed(s: InputSignal, t: float) -> float:
    """One history at one time, by its definition."""
    here = [abs(v) for at, v in zip(s.times, s.values, strict=True) if at == t]
    if here:
        return max(here)
    if not s.times or t <= s.times[0] or t >= s.times[-1]:
        return abs(s.value) if not s.times else abs(s.values[0] if t <= s.times[0] else s.values[-1])
    i = next(i for i, at in enumerate(s.times) if at > t)
    (a, b), (u, v) = s.times[i - 1 : i + 1], s.values[i - 1 : i + 1]
    return abs(u + (v - u) * (t - a) / (b - a))


@pytest.mark.parametrize("seed", range(5))
def test_the_strongest_wind_speed_of_random_wind_histories_with_jumps_is_found(seed: int) -> None:
    random = np.random.default_rng(seed)
    winds = [InputSignal(-4.0)]
    for _ in range(2):
        times = np.sort(np.repeat(random.integers(0, 50, 8), random.integers(1, 3, 8)))[:12]
        times = [t for i, t in enumerate(times.tolist()) if i < 2 or times[i - 2] != t]  # a jump has two sides
        winds.append(InputSignal(0.0, tuple(map(float, times)), tuple(random.uniform(-9.0, 9.0, len(times)).tolist())))
    t = np.sort([*random.uniform(-5.0, 60.0, 40), *range(50)])
    expected = [max(speed(s, x) for s in winds) for x in t.tolist()]
    assert np.max([wind_speed(s, t) for s in winds], axis=0) == pytest.approx(expected, rel=1e-12)
