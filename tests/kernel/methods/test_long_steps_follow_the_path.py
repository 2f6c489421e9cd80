"""What nobody asks for is damped away: where only tensions must be right, steps are as long as the tensions allow."""

import numpy as np
import pytest
from heavylift.kernel.description.mechanics import Body, Drive, Joint, Line, Point, Rope, System
from heavylift.kernel.methods import sdirk
from small_scenes import SECOND, G, X, column, cube, hand_over, started

BEAM, TROLLEY, LONG = 2.0e4, 4.0e4, 20.0  # [kg], [kg], distance of the ropes [m]
ASKED = 0.01  # of the tensions
SLOW = 0.05  # [m/s]
METHODS = ("sdirk2",)


def carried() -> System:
    """A beam hung by two ropes, along which a trolley is driven."""
    ropes = tuple(
        Rope(name, (Line(Point("world", (x, 0.0, 0.0)), Point("beam", (x, 0.0, 0.5))),), 4e8, 15.0, damping=5e5)
        for name, x in (("left", -LONG / 2), ("right", LONG / 2))
    )
    bodies = (Body("beam", BEAM, inertia=cube(BEAM, LONG)), Body("trolley", TROLLEY, inertia=cube(TROLLEY)))
    joints = (
        Joint("free", "free", "world", "beam", q0=(0.0, 0.0, -15.52, 0.0, 0.0, 0.0, 1.0)),
        Joint("rail", "prismatic", "beam", "trolley", axis=X, q0=(-8.0,)),
    )
    return System(bodies, joints, ropes=ropes, drives=(Drive("drive", "rail", "prescribed"),), gravity=G)


def driven(method: str, **options):
    s = started(carried(), method=method, sample_ns=SECOND // 2, **options)
    s.references.set_profile("drive", 0, SLOW, 0.01, 16.0)
    s.settle()
    hand_over(s, 400 * SECOND)
    return s


def lever(t: np.ndarray, s) -> np.ndarray:
    """(n, 2) tensions of both ropes by the lever rule, with the trolley where the drive has it [N]."""
    x = column(s, "joint/position")[1][:, -1:]
    return 0.5 * BEAM * G + TROLLEY * G * (0.5 + np.hstack([-x, x]) / LONG)


@pytest.mark.parametrize("method", METHODS)
def test_a_trolley_crosses_a_hanging_beam_in_long_steps(method):
    s = driven(method, tolerance=ASKED, tensions_only=True)
    t, tensions = column(s, "rope/tension")
    wrong = np.abs(tensions - lever(t, s)) / tensions.max()
    assert wrong[t > 5.0].max() < ASKED
    assert s["accepted"] < 200  # the swing of the beam alone is 50 periods


@pytest.mark.parametrize("method", METHODS)
def test_later_jacobians_leave_out_what_velocities_change(method):
    """The first one has both halves, a column of each for every velocity."""
    s = driven(method, tolerance=ASKED, tensions_only=True)
    halves = s["differences"] / s.program.nv
    assert s["factorisations"] + 1 <= halves < 2 * s["factorisations"]


@pytest.mark.parametrize("method", METHODS)
def test_a_step_that_must_end_where_it_does_is_solved_as_well_as_it_can_be(method, monkeypatch):
    """Iterations that come no nearer than rounding lets them are enough then; elsewhere the step would be shorter."""
    s = started(pendulum(0.1), method=method, tolerance=ASKED, tensions_only=True, native=False)
    for name in ("SOLVED", "ROUND_OFF"):
        monkeypatch.setattr(sdirk, name, 0.0)
    s.integrator.led(0.01)
    assert s["t"] == 0.01
    monkeypatch.setattr(sdirk, "BARELY", 0.0)
    assert not s.integrator.forced(0.02)
    assert (s["t"], s["h"]) == (0.01, 0.005)


def pendulum(angle: float) -> System:
    """A load on a rope of 20 m, stretched by its weight, that is let go at an angle."""
    line = Line(Point("world"), Point("load"))
    start = (20.0 * np.sin(angle), 0.0, -20.0 * np.cos(angle), 0.0, 0.0, 0.0, 1.0)
    load, free = Body("load", TROLLEY, inertia=cube(TROLLEY)), Joint("free", "free", "world", "load", q0=start)
    rope = Rope("rope", (line,), 4e8, 20.0 / (1.0 + TROLLEY * G * np.cos(angle) / 4e8), damping=5e5)
    return System((load,), (free,), ropes=(rope,), gravity=G)


def swinging(angle: float, **options):
    """That for a minute."""
    s = started(pendulum(angle), **options)
    hand_over(s, 60 * SECOND)
    t, q = column(s, "joint/position")
    return s, t, q[:, 0] / 20.0


@pytest.mark.parametrize("method", METHODS)
def test_a_swing_that_the_tension_hardly_feels_is_damped_away(method):
    """Of 2 degrees, which change the tension by 0.2 %; where the tolerance is that of the state it goes on."""
    s, t, x = swinging(np.radians(2.0), method=method, tolerance=0.05, tensions_only=True)
    assert np.abs(x[t > 50.0]).max() < 0.5 * np.sin(np.radians(2.0))
    assert s["accepted"] < 80
    s, t, x = swinging(np.radians(2.0), method=method, tolerance=1e-6)
    assert np.abs(x[t > 50.0]).max() == pytest.approx(np.sin(np.radians(2.0)), rel=ASKED)


@pytest.mark.parametrize("method", METHODS)
def test_a_swing_that_the_tension_feels_is_followed(method):
    """Let go at 30 degrees the load pulls with m g (3 - 2 cos 30) below, and with m g cos 30 where it turns back."""
    s, t, x = swinging(np.radians(30.0), method=method, tolerance=1e-3, tensions_only=True)
    assert s.native.part("top")[0] == pytest.approx(TROLLEY * G * (3.0 - 2.0 * np.cos(np.radians(30.0))), rel=ASKED)
    assert np.abs(x[t > 50.0]).max() == pytest.approx(0.5, rel=0.05)
