"""Closed forms of swinging loads: periods, modes, and the residual swing after a trolley move."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import acos, cos, pi, radians, sqrt

import numpy as np
from comparison import FORMS, Row, case
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import Body, Drive, InputSignal, Joint, Line, Load, Point, Rope, System, Wind
from small_scenes import SECOND, G, X, Y, Z, column, hand_over, started

TABLE = "Swing"
PERIODS = "tests/chain/test_pendulums_keep_their_period.py"
MODES = "tests/kernel/analysis/test_modes_of_small_motions.py"
RESIDUAL = "tests/chain/test_a_moving_trolley_leaves_a_swing.py"
BORNE = "tests/kernel/forces/ropes/test_ropes_bear_their_own_mass.py"
WIND, HEAVY = "tests/kernel/forces/test_loads_and_wind.py", "tests/kernel/forces/ropes/test_ropes_with_mass.py"
FINE = {"method": "dop853", "tolerance": 1e-12}


def hinge(name: str, parent: str, child: str, z: float = 0.0, q0: float = 0.0) -> Joint:
    """A hinge along y."""
    return Joint(name, "revolute", parent, child, (0.0, 0.0, z), axis=Y, q0=(q0,))


def oscillations(system: System) -> tuple:
    """Of small motions about rest, slowest first."""
    simulation = started(system)
    equilibrium(simulation)
    return modes(simulation).oscillations


def bob(mass: float, length: float, q0: float = 0.0) -> System:
    """A point load on a rigid link."""
    return System((Body("bob", mass, (0.0, 0.0, -length)),), (hinge("pivot", "world", "bob", q0=q0),), gravity=G)


@case(TABLE, "pendulum, T = 4 sqrt(L/g) K(sin(a/2))", PERIODS)
def exact_period() -> Iterator[Row]:
    x, want = FORMS["C01"]["given"], FORMS["C01"]["expected"]
    s = started(bob(1e5, x["L"], radians(x["th0_deg"])), **FINE)
    end = round(20.25 * want["T"] * SECOND)  # it passes the plumb line
    hand_over(s, end)
    angle, rate = s.state[:2]
    yield Row("period of 60 m at 10 degrees", want["T"], (end / SECOND - angle / rate) / 20.25, 1e-8, "s")


@case(TABLE, "physical pendulum, T = 2 pi sqrt((I + m d²)/(m g d))", MODES)
def physical_pendulum() -> Iterator[Row]:
    x, want = FORMS["C02"]["given"], FORMS["C02"]["expected"]
    i = want["I_G"]
    body = Body("block", x["m"], (0.0, 0.0, -x["d"]), ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
    (mode,) = oscillations(System((body,), (hinge("pivot", "world", "block"),), gravity=G))
    yield Row("period of a 600 t block", want["T"], 1.0 / mode.frequency, 1e-8, "s")


@case(TABLE, "block on n ropes, k = sum T r²/L", MODES)
def yaw_on_six_ropes() -> Iterator[Row]:
    x, want = FORMS["C02b"]["given"], FORMS["C02b"]["expected"]
    m, L, i = x["m"], x["L"], x["I_z"]
    EA = 1e4 * m * G  # hardly stretches
    body = Body("block", m, inertia=((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
    ropes = tuple(
        Rope(
            f"r{k}",
            (Line(Point("world", (a, b, L)), Point("block", (a, b, 0.0))),),
            EA,
            L * (1.0 - m * G / 6.0 / EA),
        )
        for k, (a, b) in enumerate(x["ropes"])
    )
    found = oscillations(System((body,), (Joint("free", "free", "world", "block"),), ropes=ropes, gravity=G))
    yaw = next(o for o in found if o.joints[0][0] == "free.wz")
    sway = next(o for o in found if o.joints[0][0] == "free.vx")
    yield Row("period of yaw, six ropes", want["T_yaw"], 1.0 / yaw.frequency, 1e-4, "s")
    yield Row("period of sway, six ropes", want["T_sway"], 1.0 / sway.frequency, 1e-3, "s")


@case(TABLE, "double pendulum, characteristic equation", MODES)
def double_pendulum() -> Iterator[Row]:
    x, want = FORMS["C03"]["given"], FORMS["C03"]["expected"]
    bodies = (Body("hook", x["m1"], (0.0, 0.0, -x["L1"])), Body("load", x["m2"], (0.0, 0.0, -x["L2"])))
    joints = (hinge("upper", "world", "hook"), hinge("lower", "hook", "load", -x["L1"]))
    slow, fast = oscillations(System(bodies, joints, gravity=G))
    yield Row("hook and load, slow mode", want["T1"], 1.0 / slow.frequency, 1e-8, "s")
    yield Row("hook and load, fast mode", want["T2"], 1.0 / fast.frequency, 1e-8, "s")


@case(TABLE, "pendulum on a free trolley, w = sqrt(g/L (1 + m/M))", MODES)
def free_trolley() -> Iterator[Row]:
    x, want = FORMS["C04"]["given"], FORMS["C04"]["expected"]
    bodies = (Body("trolley", x["M"]), Body("load", x["m"], (0.0, 0.0, -x["L"])))
    joints = (Joint("rail", "prismatic", "world", "trolley", axis=X), hinge("pivot", "trolley", "load"))
    (mode,) = oscillations(System(bodies, joints, gravity=G))
    rail, pivot = mode.shape
    yield Row("period", want["T"], 1.0 / mode.frequency, 1e-8, "s")
    ratio = abs(rail / (x["L"] * pivot))
    yield Row("travel of the trolley over swing of the load", want["trolley_to_load_amplitude"], ratio, 1e-8)


def moved(profile: list[tuple[float, float]], L: float, start: float = 0.0, gravity: float = G, end: float = 0.0):
    """A run of a pendulum below a trolley, driven through (time [s], speed [m/s]) along straight lines, until `end`."""
    bodies = (Body("trolley", 1.0), Body("load", 1.0, (0.0, 0.0, -L)))
    joints = (Joint("rail", "prismatic", "world", "trolley", axis=X), hinge("pivot", "trolley", "load", q0=start))
    drives = (Drive("drive", "rail", "prescribed"),)
    s = started(System(bodies, joints, drives=drives, gravity=gravity), **FINE, sample_ns=SECOND // 100)
    for (t, v), (later, faster) in pairwise(profile):
        accel = abs(faster - v) / (later - t) or 1.0  # any will do where the speed stays
        s.references.set_profile("drive", round(t * SECOND), faster, accel, None)
        s.settle()
        hand_over(s, round(later * SECOND))
    if end:
        s.settle()
        hand_over(s, round(end * SECOND))
    return s


def left_over(s, L: float, gravity: float = G) -> float:
    """Amplitude [rad] that a pendulum whose trolley stands has the energy for."""
    angle, rate = s.row().q[1], s.row().v[1]
    return acos(cos(angle) - L * rate**2 / (2 * gravity))


@case(TABLE, "trapezoid of a trolley, 4 (a/g) abs(sin(w ta/2) sin(w (ta + tc)/2))", RESIDUAL)
def residual_swing() -> Iterator[Row]:
    x, want = FORMS["C05"]["given"], FORMS["C05"]["expected"]
    t = np.cumsum([0.0, x["ta"], x["tc"], x["ta"]])
    s = moved(list(zip(t, (0.0, x["v"], x["v"], 0.0), strict=True)), x["L"])
    yield Row("residual angle, linear theory", want["theta_res_deg"], np.degrees(left_over(s, x["L"])), 5e-3, "deg")
    exact = want["theta_res_nonlinear_deg"]
    yield Row("the same, nonlinear equation by SciPy", exact, np.degrees(left_over(s, x["L"])), 1e-6, "deg")


@case(TABLE, "ramp as long as the period leaves no swing", RESIDUAL)
def shaped_ramp() -> Iterator[Row]:
    x = FORMS["C05b"]["given"]
    t = np.cumsum([0.0, x["ta"], x["tc"], x["ta"]])
    s = moved(list(zip(t, (0.0, x["v"], x["v"], 0.0), strict=True)), x["L"])
    yield Row("residual angle", 0.0, left_over(s, x["L"]), 1e-5, "rad", absolute=True)


@case(TABLE, "swinging rope, T = m g (3 - 2 cos a)", "tests/kernel/forces/ropes/test_hoisting_shocks.py")
def tension_at_the_bottom() -> Iterator[Row]:
    x, want = FORMS["C11b"]["given"], FORMS["C11b"]["expected"]
    m, L, start, k = x["m"], x["L"], radians(x["th0_deg"]), 1e9
    joints = (
        hinge("pivot", "world", "carrier", q0=start),
        Joint("slide", "prismatic", "carrier", "load", (0.0, 0.0, -L), axis=Z, q0=(-m * G * cos(start) / k,)),
    )
    rope = Rope("rope", (Line(Point("world"), Point("load")),), k * L, L, damping=2.0 * sqrt(k * m))
    system = System((Body("carrier", 0.0), Body("load", m)), joints, ropes=(rope,), gravity=G)
    s = started(system, tolerance=1e-10, sample_ns=SECOND // 200)
    yield Row("tension at the end of the swing", want["T_end"] / 1e3, float(s.row().tension[0]) / 1e3, 1e-6, "kN")
    hand_over(s, 5 * SECOND)
    yield Row("at the bottom", want["T_bottom"] / 1e3, column(s, "rope/tension")[1].max() / 1e3, 1e-4, "kN")


@case(TABLE, "drag, F = ½ rho C A v², tan a = F/(m g)", WIND)
def wind() -> Iterator[Row]:
    x, want = FORMS["C16"]["given"], FORMS["C16"]["expected"]
    at = Point("bob", (0.0, 0.0, -x["L"]))
    gale = Wind("gale", at, x["A"], x["C"], X, InputSignal(x["v"]))
    scene = bob(x["m"], x["L"])
    s = started(System(scene.bodies, scene.joints, forces=(gale,), gravity=G))
    leaning = -np.degrees(equilibrium(s).q[0])
    yield Row("angle of rest in 15 m/s", want["theta_deg"], leaning, 1e-3, "deg")
    gust = Load("gust", at, (want["F"], 0.0, 0.0), signal=InputSignal(times=(1.0, 1.0), values=(0.0, 1.0)))
    s = started(System(scene.bodies, scene.joints, forces=(gust,), gravity=G), **FINE, sample_ns=SECOND // 100)
    s.run(16 * SECOND)
    peak = -np.degrees(column(s, "joint/position")[1][:, 0].min())
    yield Row("peak after a sudden gust, 2 a", want["peak_deg"], peak, 1e-3, "deg")


@case(TABLE, "rope with mass: beta tan beta = m_rope/m; Rayleigh; string", HEAVY, full=True)
def rope_with_mass() -> Iterator[Row]:
    from test_ropes_with_mass import along, chain

    x, want = FORMS["C13"]["given"], FORMS["C13"]["expected"]
    found = oscillations(chain(*(x[key] for key in ("m", "L", "k", "m_rope"))))
    yield Row("axial frequency, 12 lumps", want["f_exact"], along(found, "z")[0], 2e-5, "Hz")
    want = FORMS["C13b"]["expected"]
    sway, string = along(found, "x")[:2]
    yield Row("sway, 12 lumps", want["w"] / (2 * pi), sway, 2e-5, "Hz")
    yield Row("first mode of the rope as a string", want["f_string_Hz"], string, 0.01, "Hz")


@case(TABLE, "rope whose mass its ends bear: m + m_rope/3 along, rod with a load across", BORNE, full=True)
def rope_mass_borne() -> Iterator[Row]:
    from test_ropes_bear_their_own_mass import ELASTIC, OWN, K, L, M, frequencies, hung

    across, along = frequencies(hung(ELASTIC))
    yield Row("axial frequency", sqrt(K / (M + OWN / 3.0)) / (2 * pi), along / (2 * pi), 1e-6, "Hz")
    stretched = L + (M + OWN / 2.0) * G / K
    want = sqrt(G / stretched * (M + OWN / 2.0) / (M + OWN / 3.0))
    yield Row("sway", want / (2 * pi), across / (2 * pi), 1e-6, "Hz")
