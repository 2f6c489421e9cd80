"""A load on a rigid link keeps the exact pendulum period for twenty swings; a free trolley shortens the period."""

from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, Array, G, channel, happenings, near, play
from heavylift.nodes.scene import load
from scipy.interpolate import CubicHermiteSpline
from scipy.special import ellipk

SWINGS = 20
PERIOD = 1e-6  # of the exact period, over twenty swings, as the closed form demands
LINEAR = 1e-4  # of the period for infinitesimal swings: half a degree takes 2.6e-5 longer here
MOMENTUM = 1e-8  # of the momentum that trolley and load exchange: velocities are recorded in steps of a billionth


def crossings(t: Array, angle: Array, rate: Array) -> Array:
    """Times at which the angle falls through zero: the cubic through two samples and their rates, solved."""
    roots = CubicHermiteSpline(t, angle, rate).roots(extrapolate=False)
    return np.array([root for root in roots if np.interp(root, t, rate) < 0.0])


def samples(recording, joint: str) -> tuple[Array, Array, Array]:
    t, angle = channel(recording, "joint/position", f"{joint}.angle")
    _, rate = channel(recording, "joint/velocity", f"{joint}.rate")
    once = np.concatenate(([True], np.diff(t) > 0.0))  # an event is sampled at its instant, too
    return t[once], angle[once], rate[once]


def test_a_load_on_a_rigid_link_has_the_exact_pendulum_period(tmp_path: Path) -> None:
    form = CLOSED_FORMS["C01"]
    want = form["expected"]["T"]
    assert near(4 * np.sqrt(60 / G) * ellipk(np.sin(np.radians(5)) ** 2), want, 1e-14)

    falls = crossings(*samples(play(tmp_path, load("pendulum").text), "pivot"))

    assert near((falls[SWINGS] - falls[0]) / SWINGS, want, PERIOD)
    linear = form["expected"]["T_lin"]
    assert (falls[SWINGS] - falls[0]) / SWINGS / linear - 1 == pytest.approx(1.9e-3, abs=1e-5)


def test_the_commander_model_measures_the_exact_period_of_a_pendulum(tmp_path: Path) -> None:
    there_and_back = """\
  - {when: position of pivot <= 0 deg, wait: 1 s}
  - {when: position of pivot >= 0 deg, wait: 1 s}
"""
    scene = load("pendulum").text + "actions:\n" + (SWINGS + 1) * there_and_back

    recording = play(tmp_path, scene)

    reached = [h.t for h in happenings(recording, "reached")][::2]
    assert near((reached[SWINGS] - reached[0]) / SWINGS, CLOSED_FORMS["C01"]["expected"]["T"], PERIOD)


FREE_TROLLEY = """\
heavylift: 1
name: free-trolley
accuracy: 1e-8 %
samples: 20 Hz
end: 110 s
mechanism:
  bodies:
    trolley: {mass: 400 t}
    load: {mass: 450 t, com: [0, 0, -50 m]}
  joints:
    rail: {type: prismatic, child: trolley, at: [0, 0, 60 m], axis: [1, 0, 0]}
    pivot: {type: revolute, parent: trolley, child: load, axis: [0, -1, 0], start: 0.5 deg}
"""


def test_a_freely_rolling_trolley_shortens_the_pendulum_period_and_conserves_momentum(tmp_path: Path) -> None:
    want = CLOSED_FORMS["C04"]["expected"]
    trolley, load_mass, link = 400e3, 450e3, 50.0

    recording = play(tmp_path, FREE_TROLLEY)

    t, angle, rate = samples(recording, "pivot")
    falls = crossings(t, angle, rate)
    assert near((falls[10] - falls[0]) / 10, want["T"], LINEAR)
    _, roll = channel(recording, "joint/velocity", "rail.speed")
    of_load = load_mass * (roll + link * np.cos(angle) * rate)
    assert np.abs(trolley * roll + of_load).max() < MOMENTUM * np.abs(of_load).max()
    _, travel = channel(recording, "joint/position", "rail.travel")
    assert near(np.ptp(travel) / np.ptp(link * np.sin(angle)), want["trolley_to_load_amplitude"], LINEAR)
