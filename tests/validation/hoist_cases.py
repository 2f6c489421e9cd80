"""Closed forms of hoisting: pick-up, ramps, lost loads, stops, slack and snatch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import atan2, cos, pi, sqrt

import numpy as np
from comparison import FORMS, Row, case
from heavylift.kernel.description import Body, Joint, Line, Point, RigidRope, Rope, Stop, System
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, Z, column, hand_over, hung, started, times

TABLE = "Hoisting"
SHOCKS = "tests/kernel/forces/ropes/test_hoisting_shocks.py"
SLACK = "tests/kernel/forces/ropes/test_ropes_slacken_and_tighten.py"
RIGID = "tests/kernel/constraints/test_rigid_ropes.py"
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 200}
EXACT = {"method": "dop853", "tolerance": 1e-11}
FACTOR = 1e-3  # the closed forms know no winch that stiffens the rope which it shortens


def hanging(m: float, k: float, L: float, at: float | None = None, **rope) -> System:
    """A load on a rope of stiffness k, at rest under its weight or at height -at."""
    scene = hung(L + m * G / k if at is None else at, L, **rope)
    return replace(scene, bodies=(Body("load", m),), ropes=(replace(scene.ropes[0], EA=k * L),))


def on_the_ground(m: float, k: float, L: float) -> System:
    """The same with its rope straight and slack, on ground that gives way by 5 nm."""
    stiff = 1e15
    ground = Stop("ground", "load-guide", -L + m * G / stiff, 1e6, stiff, 0.6 * sqrt(stiff * m))
    return replace(hanging(m, k, L, at=L, winch=True), stops=(ground,))


def factor(s, m: float) -> float:
    """Largest tension over the weight."""
    return max(column(s, topic)[1].max() for topic in ("rope/peak", "rope/tension")) / (m * G)


def wound(scene: System, speed: float, ramp: float, seconds: float):
    """After the winch has turned at this speed [m/s of rope, off the drum > 0]."""
    s = started(scene, **FINE)
    s.references.set_profile("rope", 0, speed, ramp, None)
    s.settle()
    hand_over(s, round(seconds * SECOND))
    return s


@case(TABLE, "pick-up at constant speed, phi = 1 + (v/g) sqrt(k/m)", SHOCKS)
def pick_up() -> Iterator[Row]:
    x, want = FORMS["C07a"]["given"], FORMS["C07a"]["expected"]
    s = wound(on_the_ground(x["m"], x["k"], x["L"]), -x["v"], 1e6, 8.0)
    eps, lifted = x["m"] * G / (x["k"] * x["L"]), times(s, "ground", "open")[0]
    yield Row("lift-off, L e/((1 + e) v)", x["L"] * eps / ((1 + eps) * x["v"]), lifted, 1e-5, "s")
    yield Row("lift-off, rope of constant stiffness", want["t_lift"], lifted, 3e-3, "s")
    yield Row("factor, 450 t at 3 m/min on 60 m", want["phi"], factor(s, x["m"]), FACTOR)
    x, want = FORMS["C07b"]["given"], FORMS["C07b"]["expected"]
    s = wound(on_the_ground(x["m"], x["k"], 1e4 * x["L"]), -x["v"], 1e6, 1.0)
    yield Row("factor, 10 m/min on 10 m", want["phi"], factor(s, x["m"]), FACTOR)


@case(TABLE, "ramp of the hoist under load, phi = 1 + 2 a/g", SHOCKS)
def ramp() -> Iterator[Row]:
    x, want = FORMS["C07c"]["given"], FORMS["C07c"]["expected"]
    s = wound(hanging(x["m"], x["k"], 6e5, winch=True), -x["v"], x["v"] / x["ta"], 4.0)
    t, T = column(s, "rope/tension")
    weight = x["m"] * G
    yield Row("factor in the ramp", want["phi_in_ramp"], T[t <= x["ta"]].max() / weight, FACTOR)
    yield Row("factor after it", want["phi_after"], T[t > x["ta"]].max() / weight, FACTOR)


@case(TABLE, "sudden loss of 30 % of the load, 1 - 2 dm/m", SHOCKS)
def lost_load() -> Iterator[Row]:
    x, want = FORMS["C22"]["given"], FORMS["C22"]["expected"]
    m, k, L = x["m"], x["k"], 60.0
    lost, stiff = m * x["dm_over_m"], 1e4 * k
    low = -L - m * G / k
    joints = tuple(
        Joint(f"{name}-guide", "prismatic", "world", name, axis=Z, q0=(z,))
        for name, z in (("load", low), ("part", low - 1.0 - lost * G / stiff))
    )
    ropes = (
        Rope("rope", (Line(Point("world"), Point("load")),), k * L, L),
        Rope("hook", (Line(Point("load"), Point("part")),), stiff, 1.0),
    )
    s = started(System((Body("load", m - lost), Body("part", lost)), joints, ropes=ropes, gravity=G), **FINE)
    s.interrupt(0)
    s.unhook("hook")
    s.settle()
    hand_over(s, 2 * SECOND)
    yield Row("least factor", want["phi3"], column(s, "rope/tension")[1][:, 0].min() / (m * G), FACTOR)


@case(TABLE, "stop while lowering, 1 + (v w/g) abs(sin(w ts/2)/(w ts/2))", SHOCKS)
def stop_while_lowering() -> Iterator[Row]:
    x, want = FORMS["C23"]["given"], FORMS["C23"]["expected"]
    for name, seconds, phi in (("in 0.4 s", x["ts"], want["phi"]), ("at once", 1e-4, want["phi_instant"])):
        scene = hanging(x["m"], x["k"], 6e5, winch=True)
        scene = replace(scene, joints=tuple(replace(j, v0=(-x["v"],)) for j in scene.joints))
        s = wound(scene, x["v"], 1e9, 1.0)
        s.references.set_profile("rope", SECOND, 0.0, x["v"] / seconds, None)
        s.settle()
        hand_over(s, 4 * SECOND)
        t, T = column(s, "rope/tension")
        yield Row(f"factor, stopped {name}", phi, T[t > 1.0 + seconds].max() / (x["m"] * G), FACTOR)


@case(TABLE, "load let go on a straight rope, phi = 2", "tests/extremes/test_peaks_between_steps.py")
def let_go() -> Iterator[Row]:
    s = started(hung(LENGTH), **EXACT)
    hand_over(s, 2 * SECOND)
    yield Row("factor", 2.0, factor(s, MASS), 1e-6)


@case(TABLE, "snatch after a fall, phi = 1 + sqrt(1 + 2 h/d)", SLACK)
def snatch() -> Iterator[Row]:
    x, want = FORMS["C11"]["given"], FORMS["C11"]["expected"]
    k, h, w = x["k"], x["h"], sqrt(x["k"] / x["m"])
    s = started(hanging(x["m"], k, LENGTH, at=LENGTH - h), **EXACT)
    hand_over(s, 2 * SECOND)
    yield Row("factor after 50 mm", want["phi_snatch"], factor(s, x["m"]), 1e-7)
    v, taut, slack = sqrt(2 * G * h), times(s, "rope", "taut"), times(s, "rope", "slack")
    yield Row("rope straight, sqrt(2 h/g)", sqrt(2 * h / G), taut[0], 1e-7, "s")
    yield Row("time in the rope", (2 * pi - 2 * atan2(v * w, G)) / w, slack[0] - taut[0], 1e-6, "s")
    yield Row("flight, 2 v/g", 2 * v / G, taut[1] - slack[0], 1e-6, "s")


def on_a_rigid_rope(L: float, z: float, vx: float = 0.0) -> System:
    """A point load in the x-z plane on a rope that does not stretch."""
    joints = (
        Joint("x", "prismatic", "world", "carrier", axis=X, v0=(vx,)),
        Joint("z", "prismatic", "carrier", "load", axis=Z, q0=(z,)),
    )
    rope = RigidRope("rope", (Line(Point("world"), Point("load")),), L)
    return System((Body("carrier", 0.0), Body("load", MASS)), joints, rigid_ropes=(rope,), gravity=G)


@case(TABLE, "rope that cannot stretch: fall, and swing too slow for the loop", RIGID)
def rigid_rope() -> Iterator[Row]:
    fine = {"tolerance": 1e-10, "sample_ns": 10_000_000, "h_max": 0.02}
    s = started(on_a_rigid_rope(20.0, -18.0), **fine)
    s.run(SECOND)
    yield Row("taut after a fall of 2 m", 2.0 / sqrt(G), times(s, "rope", "taut")[0], 1e-6, "s")
    yield Row("impulse, m sqrt(2 g h)", MASS * sqrt(4.0 * G) / 1e3, s.log[0][1].value / 1e3, 1e-7, "kN s")
    L = 10.0
    s = started(on_a_rigid_rope(L, -L, sqrt(3.5 * G * L)), **fine)
    s.run(5 * SECOND)
    slack, taut = (times(s, "rope", what)[0] for what in ("slack", "taut"))
    t, q = column(s, "joint/position")
    yield Row("height of slackening, L sin 30°", L / 2, q[np.argmin(np.abs(t - slack)), 1], 1e-6, "m")
    yield Row("parabola to the circle", 4.0 * sqrt(0.5 * L / G) * cos(pi / 6), taut - slack, 1e-6, "s")


@case("Design factors", "EN 13001-2 / EN 1991-3, phi2 = phi2,min + beta2 v: HC1, as the closed forms quote it", SHOCKS)
def hoisting_class() -> Iterator[Row]:
    yield from beside("EN13001_HC1", "factor at 3 m/min, 450 t")


@case("Design factors", "0027/ND rev. 11, table 5-1: onshore, 300 t < W <= 1000 t", SHOCKS)
def marine_rule() -> Iterator[Row]:
    yield from beside("NobleDenton_onshore_300_1000t", "factor at 3 m/min, 450 t")


def beside(rule: str, quantity: str) -> Iterator[Row]:
    """What a rule takes at C07d's speed and what the 450 t load does on 60 m of rope."""
    x, want = FORMS["C07d"]["given"], FORMS["C07d"]["expected"]
    s = wound(on_the_ground(MASS, EA / LENGTH, LENGTH), -x["v_h"], 1e6, 8.0)
    yield Row(quantity, want[rule], factor(s, MASS), 1e-3, bound=True)
