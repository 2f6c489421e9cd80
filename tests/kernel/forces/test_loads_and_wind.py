"""Loads and wind: closed forms C16, C22 and C23, and histories whose breakpoints cost no accuracy."""

import json
from dataclasses import replace
from itertools import pairwise, product
from math import atan, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, InputSignal, Joint, Load, Master, Point, System, Wind
from heavylift.kernel.simulation import Simulation
from scipy.integrate import solve_ivp
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, G, X, Y, column, hung, imbalance, slider, started

PERMILLE = 1e-3  # what the closed forms accept
EXACT = 1e-12  # a cubic is integrated exactly, round-off apart
CLOSES = 1e-10  # of the energy turned over
PEAKS = {"tolerance": 1e-9, "sample_ns": 10_000_000, "h_max": 0.05}
FORMS = {c["id"]: c for c in json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())}


def pendulum(mass: float, length: float, start: float = 0.0) -> System:
    """A point mass below a hinge along y; positive angles swing it towards -x."""
    bob = Body("bob", mass, (0.0, 0.0, -length))
    return System((bob,), (Joint("hinge", "revolute", "world", "bob", axis=Y, q0=(start,)),), gravity=G)


BOB = Point("bob", (0.0, 0.0, -50.0))
C16 = FORMS["C16"]["given"]


def gale(signal: InputSignal) -> Wind:
    return Wind("gale", BOB, C16["A"], C16["C"], X, signal)


def test_a_load_in_the_wind_hangs_where_the_closed_form_says():
    expected = FORMS["C16"]["expected"]
    theta = -expected["theta_deg"] * pi / 180
    s = started(replace(pendulum(C16["m"], C16["L"], theta), forces=(gale(InputSignal(C16["v"])),)), **PEAKS)
    s.run(20 * SECOND)
    assert column(s, "wind/force")[1][0, 0] == pytest.approx(expected["F"], rel=1e-12)
    t, q = column(s, "joint/position")
    assert q[:, 0] == pytest.approx(np.full(len(t), theta), rel=PERMILLE)


def test_wind_acts_on_the_projected_sides_of_a_turned_box():
    """Of a box a x b x c that is turned by R, the wind sees A = sum |R_ji w_j| A_i, the area of its shadow."""
    turn = Rotation.from_euler("zyx", [0.5, -0.3, 1.1])
    size, sides, v = np.array([20.0, 16.0, 8.0]), (16.0 * 8.0, 20.0 * 8.0, 20.0 * 16.0), 15.0
    box = Body("box", 3e5, inertia=((1e7, 0.0, 0.0), (0.0, 1e7, 0.0), (0.0, 0.0, 1e7)))
    float_ = Joint("float", "free", "world", "box", q0=(0.0, 0.0, 0.0, *turn.as_quat()))
    gale = Wind("gale", Point("box"), 0.0, 1.2, X, InputSignal(v), sides=sides)
    s = started(System((box,), (float_,), forces=(gale,), gravity=G))
    corners = np.array(list(product(*((-x / 2, x / 2) for x in size)))) @ turn.as_matrix().T
    shadow = ConvexHull(corners[:, 1:]).volume  # of a polygon, its area
    assert column(s, "wind/force")[1][0, 0] == pytest.approx(0.5 * 1.225 * 1.2 * shadow * v**2, rel=1e-12)


def test_a_sudden_gust_swings_a_load_twice_as_far_as_steady_wind():
    F, theta = FORMS["C16"]["expected"]["F"], atan(FORMS["C16"]["expected"]["F"] / (C16["m"] * G))
    gust = Load("gust", BOB, (F, 0.0, 0.0), signal=InputSignal(times=(1.0, 1.0), values=(0.0, 1.0)))
    s = started(replace(pendulum(C16["m"], C16["L"]), forces=(gust,)), **PEAKS)
    s.run(16 * SECOND)
    t, q = column(s, "joint/position")
    assert np.all(q[t <= 1.0] == 0.0), "no wind yet"
    assert -q.min() == pytest.approx(2 * theta, rel=PERMILLE)
    assert imbalance(s) < CLOSES


def test_gust_spectra_agree_with_scipy():
    """Drag of the air that the swinging load feels, along a record of gusts; the same law written for SciPy."""
    times, speeds = (0.5, 1.5, 4.0, 4.0, 9.0), (0.0, 20.0, 12.0, 17.0, 5.0)
    m, L = C16["m"], C16["L"]
    record = InputSignal(times=times, values=speeds)
    s = started(replace(pendulum(m, L), forces=(gale(record),)), tolerance=1e-11, sample_ns=SECOND, h_max=0.1)
    s.interrupt(12 * SECOND)

    def rate(t, y, start, v, slope):
        w = np.array([v + slope * (t - start), 0.0])
        along = np.array([-np.cos(y[0]), np.sin(y[0])])  # direction of the bob's motion in x, z
        u = w - L * y[1] * along
        drag = 0.5 * 1.225 * C16["C"] * C16["A"] * np.linalg.norm(u) * u
        return [y[1], -G / L * np.sin(y[0]) + drag @ along / (m * L)]

    y = [0.0, 0.0]
    for a, b, v, slope in (
        (0.5, 1.5, 0.0, 20.0),
        (1.5, 4.0, 20.0, -3.2),
        (4.0, 9.0, 17.0, -2.4),
        (9.0, 12.0, 5.0, 0.0),
    ):
        y = solve_ivp(rate, (a, b), y, method="DOP853", rtol=1e-12, atol=1e-14, args=(a, v, slope)).y[:, -1]
    assert s.row().q[0] == pytest.approx(y[0], rel=1e-8)
    assert imbalance(s) < CLOSES


def test_breakpoints_of_a_force_history_are_boundaries_of_integration_steps():
    """A piecewise linear force makes a piecewise cubic motion, which DOPRI5 integrates exactly in steps of any length
    as long as none crosses a breakpoint; the force of the first and last value holds outside."""
    times, values = (0.3, 0.5, 0.5, 1.7, 2.1), (2.0, -1.0, 4.0, 0.0, 1.5)
    push = Load("push", Point("load"), (10.0, 0.0, 0.0), signal=InputSignal(times=times, values=values))
    s = started(replace(slider(mass=5.0, axis=X), forces=(push,)), tolerance=1e-3, h_max=10.0)
    s.run(3 * SECOND)
    s.interrupt(3 * SECOND)
    knots = [0.0, *times, 3.0]
    force = [values[0], *values, values[-1]]
    x = v = 0.0
    for (a, b), (f, g) in zip(pairwise(knots), pairwise(force), strict=True):
        h, slope = b - a, (g - f) / (b - a) if b > a else 0.0
        x, v = x + v * h + 2.0 * (f * h**2 / 2 + slope * h**3 / 6), v + 2.0 * (f * h + slope * h**2 / 2)
    assert s.row().q[0] == pytest.approx(x, rel=EXACT)
    assert s.row().v[0] == pytest.approx(v, rel=EXACT)


def test_a_scene_at_rest_starts_to_move_at_the_time_when_a_force_begins():
    late = Load("late", Point("load"), (1.0, 0.0, 0.0), signal=InputSignal(times=(100.0, 100.0), values=(0.0, 1.0)))
    s = started(replace(slider(mass=1.0, axis=X), forces=(late,)))
    s.run(102 * SECOND)
    s.interrupt(102 * SECOND)
    assert s.row().q[0] == pytest.approx(2.0, rel=EXACT)


def test_the_signal_of_a_force_follows_commands_and_later_its_master_drive():
    push = Load("push", Point("load"), (6.0, 0.0, 0.0), signal=InputSignal(0.0, driven=True))
    s = started(replace(slider(mass=2.0, axis=X), forces=(push,), masters=(Master("m"),)), tolerance=1e-9)
    s.references.set_profile("push", 0, 0.5, 1e3, 0.5)
    s.settle()
    s.interrupt(2 * SECOND)
    assert s.row().shown[0] == pytest.approx(0.5)
    s.set_follow("push", "m", (2.0, 0.0, 0.0))
    s.references.set_profile("m", 2 * SECOND, -0.25, 1e3, -0.25)
    s.settle()
    s.interrupt(4 * SECOND)
    assert s.row().shown[0] == pytest.approx(0.0, abs=1e-12)
    assert s.row().v[0] == pytest.approx(3.0 * (0.25 + 0.5 + 0.25), rel=2e-3)
    assert imbalance(s) < CLOSES


def test_a_load_stated_in_the_axes_of_a_body_turns_with_the_body():
    """A thruster that pushes across a turning rod spins it up with constant moment."""
    rod = Body("rod", 3.0, (1.0, 0.0, 0.0), ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    joint = Joint("pin", "revolute", "world", "rod")
    tip = Load("tip", Point("rod", (2.0, 0.0, 0.0)), (0.0, 8.0, 0.0), (0.0, 0.0, 4.0), axes="body")
    s = started(System((rod,), (joint,), forces=(tip,), gravity=0.0))
    s.run(3 * SECOND)
    s.interrupt(3 * SECOND)
    assert s.row().v[0] == pytest.approx((8.0 * 2.0 + 4.0) / 4.0 * 3.0, rel=1e-9)
    assert imbalance(s) < CLOSES


def test_losing_half_of_a_load_slackens_the_rope():
    """C22: a rope carries (1 - 2 dm/m) of the weight at least, and goes slack from dm = m/2 on."""
    given = FORMS["C22"]["given"]
    m = given["m"]

    def least(share: float) -> tuple[float, bool]:
        s = started(_hung(m, given["k"], share), **PEAKS)
        s.run(3 * SECOND)
        T = column(s, "rope/tension")[1][:, 0]
        return T.min() / (m * G), any(e.what == "slack" for _, e in s.log)

    assert least(given["dm_over_m"]) == (pytest.approx(FORMS["C22"]["expected"]["phi3"], rel=PERMILLE), False)
    assert least(0.51)[1]
    assert not least(0.49)[1]


def _hung(m: float, k: float, share: float) -> System:
    """A load of which a share, here a force, is lost after a second."""
    scene = hung(60.0 + m * G / k)
    rope = replace(scene.ropes[0], EA=k * 60.0)
    gone = Load(
        "part", Point("load"), (0.0, 0.0, -share * m * G), signal=InputSignal(times=(1.0, 1.0), values=(1.0, 0.0))
    )
    return replace(scene, bodies=(Body("load", (1.0 - share) * m),), ropes=(rope,), forces=(gone,))


@pytest.mark.parametrize(("ts", "key"), [(0.4, "phi"), (1e-6, "phi_instant")])
def test_the_peak_tension_of_an_emergency_stop_while_lowering_agrees_with_the_closed_form(ts, key):
    """C23: phi = 1 + v w/g |sin(w ts/2)/(w ts/2)|, and the whole of it if the brake bites at once."""
    given = FORMS["C23"]["given"]
    m, k, v = given["m"], given["k"], given["v"]
    scene = hung(60.0 + m * G / k, v0=-v, winch=True)
    long = 60.0 * k  # the stretched length counts: w as the rope has it where it stops
    s = started(replace(scene, bodies=(Body("load", m),), ropes=(replace(scene.ropes[0], EA=long),)), **PEAKS)
    s.references.set_profile("rope", 0, v, 1e6, None)
    s.settle()
    s.interrupt(SECOND // 10)
    s.references.set_profile("rope", SECOND // 10, 0.0, v / ts, None)
    s.settle()
    s.run(3 * SECOND)
    w = sqrt(k / m)
    assert FORMS["C23"]["expected"]["phi"] == pytest.approx(1 + v * w / G * abs(sin(w * 0.2) / (w * 0.2)), rel=1e-9)
    after = column(s, "rope/peak")[1][:, 0].max() / (m * G)
    assert after == pytest.approx(FORMS["C23"]["expected"][key], rel=PERMILLE)


@pytest.mark.parametrize(
    ("force", "told"),
    [
        (Wind("w", Point("load"), -1.0, 1.0, X, InputSignal(1.0)), "wind 'w': area is -1; it cannot be negative"),
        (Wind("w", Point("load"), 1.0, 1.0, (1.0, 1.0, 0.0), InputSignal(1.0)), "must be a unit vector"),
        (Load("f", Point("lod"), X), "'f': there is no body 'lod'"),
        (Load("f", Point("load"), (float("nan"), 0.0, 0.0)), "load 'f': force is nan; it must be a finite number"),
        (Load("f", Point("load"), X, signal=InputSignal(times=(0.0, 1.0), values=(1.0,))), "2 times and 1 values"),
        (Load("f", Point("load"), X, signal=InputSignal(times=(2.0, 1.0), values=(1.0, 1.0))), "goes back to 1.0 s"),
        (Load("f", Point("load"), X, signal=InputSignal(times=(2.0,), values=(1.0,), driven=True)), "one of them"),
    ],
)
def test_invalid_loads_on_bodies_are_refused(force, told):
    with pytest.raises(KernelError) as e:
        Simulation(replace(slider(), forces=(force,)))
    assert told in str(e.value)
    assert "\n" not in str(e.value)
