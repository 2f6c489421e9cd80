"""A trolley follows its speed profile under any load; the residual swing is that of the equations."""

from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, G, channel, near, play
from scipy.integrate import solve_ivp

NONLINEAR = 1e-6  # of the residual angle of the nonlinear equation
LINEAR = 5e-3  # of the linear closed form, at one degree
STILL = 1e-5  # [rad] what a shaped ramp may leave

LINK = 50.0

TROLLEY = """\
heavylift: 1
name: trolley
accuracy: 1e-6 %
samples: 1 Hz
end: {end} s
mechanism:
  bodies:
    trolley: {{mass: 400 t}}
    load: {{mass: 450 t, com: [0, 0, -50 m]}}
  joints:
    rail: {{type: prismatic, child: trolley, at: [0, 0, 60 m], axis: [1, 0, 0]}}
    pivot: {{type: revolute, parent: trolley, child: load, axis: [0, -1, 0]}}
  drives:
    drive: {{joint: rail, type: prescribed, ramp: {a!r} m/s2}}
actions:
  - drive: drive {v!r} m/s by {d!r} m
"""


def residual(angle: float, rate: float) -> float:
    """Amplitude [rad] of the swing that a pendulum at rest overhead has the energy for."""
    return float(np.arccos(np.cos(angle) - LINK * rate**2 / (2 * G)))


def nonlinear(a: float, ta: float, tc: float) -> float:
    """Residual angle of L th'' = -g sin th - x'' cos th over the three pieces of a trapezoid, by SciPy."""
    state = [0.0, 0.0]
    for push, span in ((a, ta), (0.0, tc), (-a, ta)):

        def swing(_: float, y: list[float], push: float = push) -> list[float]:
            return [y[1], -(G * np.sin(y[0]) + push * np.cos(y[0])) / LINK]

        state = solve_ivp(swing, (0.0, span), state, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    return residual(*state)


def after_the_move(folder: Path, a: float, v: float, d: float, seconds: float) -> np.ndarray:
    """Residual angles at the samples after the trolley has come to rest."""
    recording = play(folder, TROLLEY.format(a=a, v=v, d=d, end=int(seconds) + 30))
    t, angle = channel(recording, "joint/position", "pivot.angle")
    _, rate = channel(recording, "joint/velocity", "pivot.rate")
    _, travel = channel(recording, "joint/position", "rail.travel")
    after = t > seconds
    assert np.abs(travel[after] - d).max() < 1e-12 * d
    return np.array([residual(*now) for now in zip(angle[after], rate[after], strict=True)])


def test_a_trolley_move_of_40_m_with_a_trapezoidal_speed_profile_leaves_a_swing_of_one_degree(tmp_path: Path) -> None:
    form = CLOSED_FORMS["C05"]
    given, expected = form["given"], form["expected"]
    want = nonlinear(given["a"], given["ta"], given["tc"])
    assert np.degrees(want) == pytest.approx(expected["theta_res_nonlinear_deg"], rel=NONLINEAR)

    left = after_the_move(tmp_path, given["a"], given["v"], given["d"], given["t_move"])

    assert len(left) > 25
    assert np.abs(left - want).max() < NONLINEAR * want
    assert near(want, expected["theta_res_rad"], LINEAR)


def test_a_trolley_acceleration_over_exactly_one_swing_period_leaves_no_swing(tmp_path: Path) -> None:
    given = CLOSED_FORMS["C05b"]["given"]
    distance = given["v"] * (given["ta"] + given["tc"])

    left = after_the_move(tmp_path, given["a"], given["v"], distance, 2 * given["ta"] + given["tc"])

    assert left.max() < STILL
