"""Long runs, late events and distant places: drift and rounding stay below stated bounds."""

from dataclasses import replace
from math import pi, radians, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Threshold
from independent import period
from loads_and_swings import bar
from small_scenes import LENGTH, SECOND, G, column, hand_over, hung, started, times

DRIFT = 1e-6  # of the energy, and of a period in phase, in 1e5 s at tolerance 1e-12 (tests/full: 1e6 s, ten times that)
LATE = 100_000 * SECOND


def test_a_pendulum_keeps_energy_and_phase_for_100_000_seconds():
    a, L = radians(30.0), 20.0
    T = period(a, L)
    swings = round(1e5 / T)
    s = started(bar(L, a), method="dop853", tolerance=1e-12, h_max=1.0, sample_ns=1000 * SECOND)
    hand_over(s, round((swings + 0.25) * T * SECOND))
    v = 2.0 * sqrt(G / L) * np.sin(0.5 * a)
    assert abs(float(s.state[0])) / (v * T) < DRIFT, "phase at the bottom, in periods"
    e = column(s, "energy")[1]
    assert np.ptp(e[:, 0] + e[:, 1]) / np.ptp(e[:, 0]) < DRIFT


def test_an_event_after_100_000_seconds_is_located_as_exactly_as_the_first():
    """The load hangs, is unhooked late, hooked again on a longer rope and falls 1 m: taut to the nanosecond."""
    s = started(hung(LENGTH), tolerance=1e-11, h_max=100.0, sample_ns=1000 * SECOND)
    s.switches.unhook("rope")
    hand_over(s, LATE)
    nq = s.program.nq
    s.state[:nq], s.state[nq : nq + 1] = -LENGTH, 0.0
    s.hook("rope", L0=LENGTH + 1.0)
    s.settle()
    hand_over(s, LATE + SECOND)
    t_ns = next(t for t, e in s.log if e.what == "taut" and t > LATE)
    assert abs(t_ns - LATE - sqrt(2.0 / G) * 1e9) < 2.0


def test_events_far_apart_in_a_slow_motion_are_located_exactly():
    """The last of all crossings of the bottom comes when the closed form says: no stretch has begun in between."""
    a, L = radians(30.0), 20.0
    T = period(a, L)
    scene = replace(bar(L, a), thresholds=(Threshold("bottom", "joint", of="hinge"),))
    s = started(scene, method="dop853", tolerance=1e-13, h_max=1.0, sample_ns=1000 * SECOND)
    n = round(1e5 / T)
    hand_over(s, round(n * T * SECOND))
    s.switches.watch("bottom", 0.0, False)
    s.settle()
    hand_over(s, round((n + 0.5) * T * SECOND))
    assert times(s, "bottom", "reached")[-1] == pytest.approx((n + 0.25) * T, abs=1e-5)


@pytest.mark.parametrize("far", [1e3, 1e5])
def test_bodies_far_from_the_origin_swing_like_those_at_the_origin(far):
    a, L = radians(60.0), 20.0
    T = period(a, L)
    s = started(bar(L, a, at=(far, -far, far)), tolerance=1e-11)
    hand_over(s, round(10.25 * T * SECOND))
    assert abs(float(s.state[0])) < 1e-8
    assert float(s.row().poses[0]) == far
    assert 2.0 * pi / T < sqrt(G / L)
