"""Winding, two slack intervals and one unhooking, against an implicit integrator on equations written by hand.

A hook hangs on a winch rope and swings; a load hangs on the hook by a sling and is thrown upwards.  Both are point
masses in space; the equations below are Newton's, the events SciPy's own.
"""

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from scipy.integrate import solve_ivp
from small_scenes import SECOND, G, cube, events, hand_over, started

HOOK, LOAD = 1.0e4, 2.0e4
ROPE = {"EA": 1.0e7, "L0": 20.0, "damping": 1.0e4}
SLING = {"EA": 4.0e6, "L0": 8.0, "damping": 4.0e3}
SPEED, RAMP, DISTANCE = -0.5, 0.4, -1.0  # the drum winds one metre
HOOK_AT, HOOK_V = np.array([0.0, 0.0, -20.4]), np.array([0.6, -0.3, 0.0])
LOAD_AT, LOAD_V = np.array([0.2, 0.1, -28.5]), np.array([0.2, 0.4, 6.0])
UNHOOKED, END = 4.2, 5.0
EVENT_TIMES = 1e-7  # [s]
PLACES = 1e-8  # [m] and [m/s] after five seconds


def drum(t):
    """Unstretched length and its rate: 1.25 s ramp up, 0.75 s cruise, 1.25 s ramp down."""
    ramp, cruise = 0.5 / RAMP, (1.0 - 0.5 * 0.5 / RAMP) / 0.5
    on, off = min(t, ramp), min(max(t - ramp - cruise, 0.0), ramp)
    wound = RAMP * on * (t - on / 2.0) - RAMP * off * (max(t - ramp - cruise, 0.0) - off / 2.0)
    return ROPE["L0"] - wound, -RAMP * (on - off)


KNEES = (0.5 / RAMP, 0.5 / RAMP + (1.0 - 0.5 * 0.5 / RAMP) / 0.5, 1.0 / RAMP + (1.0 - 0.5 * 0.5 / RAMP) / 0.5)


def pull(p, v, L0, dL0, law):
    """Tension before the clamp, elongation and direction of a rope along p."""
    l = np.linalg.norm(p)
    e = l - L0
    return law["EA"] * e / L0 + law["damping"] * (p @ v / l - dL0), e, p / l


def ropes(t, y):
    x1, v1, x2, v2 = y.reshape(4, 3)
    L0, dL0 = drum(t)
    return pull(x1, v1, L0, dL0, ROPE), pull(x2 - x1, v2 - v1, SLING["L0"], 0.0, SLING)


def by_hand():
    """Events (time, name, what) and the state at the end."""
    log, y, t = [], np.concatenate([HOOK_AT, HOOK_V, LOAD_AT, LOAD_V]), 0.0
    names = ("rope", "sling")
    hooked = [True, True]
    taut = [e > 0.0 and trial > 0.0 for trial, e, _ in ropes(t, y)]

    def rate(t, y):
        _, v1, _, v2 = y.reshape(4, 3)
        (T1, _, u1), (T2, _, u2) = ropes(t, y)
        F1 = T1 * taut[0] * u1
        F2 = T2 * taut[1] * u2
        down = np.array([0.0, 0.0, -G])
        return np.concatenate([v1, down + (F2 - F1) / HOOK, v2, down - F2 / LOAD])

    def guard(i):
        def value(t, y):
            trial, e, _ = ropes(t, y)[i]
            return 1.0 if not hooked[i] else trial * 1e-6 if taut[i] else -min(e, trial * 1e-6)

        value.terminal, value.direction = True, -1
        return value

    for stop in (*KNEES, UNHOOKED, END):
        while t < stop:
            guards = [guard(0), guard(1)]
            s = solve_ivp(rate, (t, stop), y, "Radau", rtol=1e-12, atol=1e-12, events=guards)
            t, y = s.t[-1], s.y[:, -1]
            for i, when in enumerate(s.t_events):
                if len(when):
                    taut[i] = not taut[i]
                    log.append((t, names[i], "taut" if taut[i] else "slack"))
        if stop == UNHOOKED:
            hooked[1] = taut[1] = False
    return log, y


def by_the_kernel():
    ball = cube(1.0)
    bodies = (Body("hook", HOOK, inertia=ball), Body("load", LOAD, inertia=ball))
    joints = tuple(
        Joint(f"{b.name}-free", "free", "world", b.name, q0=(*x, 0.0, 0.0, 0.0, 1.0), v0=(*v, 0.0, 0.0, 0.0))
        for b, x, v in zip(bodies, (HOOK_AT, LOAD_AT), (HOOK_V, LOAD_V), strict=True)
    )
    cables = (
        Rope("rope", (Line(Point("world"), Point("hook")),), winch=True, **ROPE),
        Rope("sling", (Line(Point("hook"), Point("load")),), **SLING),
    )
    s = started(System(bodies, joints, ropes=cables, gravity=G), tolerance=1e-12, sample_ns=SECOND)
    s.references.set_profile("rope", 0, SPEED, RAMP, DISTANCE)
    s.settle()
    hand_over(s, round(UNHOOKED * SECOND))
    s.unhook("sling")
    s.settle()
    hand_over(s, round(END * SECOND))
    return s


@pytest.fixture(scope="module")
def runs():
    return by_hand(), by_the_kernel()


def test_the_reference_trajectory_has_one_winch_move_and_two_slack_intervals_and_one_unhooking(runs):
    (log, _), s = runs
    assert events(s) == [(name, what) for _, name, what in log]
    sling = [what for name, what in events(s) if name == "sling"]
    assert sling == ["slack", "taut", "slack", "taut"]
    assert s.row().length[0] == pytest.approx(19.0, abs=1e-12)
    assert s.row().tension[1] == 0.0


@pytest.mark.large
def test_events_of_the_reference_trajectory_agree_with_those_of_an_implicit_integrator(runs):
    (log, _), s = runs
    for (t_ns, _), (t, name, what) in zip(s.log, log, strict=True):
        assert t_ns * 1e-9 == pytest.approx(t, abs=EVENT_TIMES), (name, what)


def test_final_poses_of_the_reference_trajectory_agree_with_those_of_an_implicit_integrator(runs):
    (_, y), s = runs
    x1, v1, x2, v2 = y.reshape(4, 3)
    state = s.state
    for got, want in ((state[:3], x1), (state[7:10], x2), (state[14:17], v1), (state[20:23], v2)):
        assert np.abs(got - want).max() < PLACES
