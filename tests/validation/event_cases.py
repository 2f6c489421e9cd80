"""Closed forms of impacts, friction, springs, stops and brakes, and of failures in a lift."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import asin, atan, cos, exp, pi, radians, sin, sqrt

import numpy as np
from comparison import Row, case
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import (
    Ball,
    Body,
    Box,
    Brake,
    Contact,
    Joint,
    JointSpring,
    Point,
    Spring,
    Stop,
    Support,
    System,
    Torsion,
)
from small_scenes import EA, MASS, SECOND, G, X, Z, column, cube, hand_over, slider, started, times

CONTACT, ELASTIC, MISHAPS = "Contact and friction", "Springs, stops, brakes", "What goes wrong in a lift"
TOUCH = "tests/kernel/constraints/contact/test_rigid_bodies_touch.py"
SLIPS = "tests/kernel/constraints/contact/test_a_contact_slips_as_a_whole.py"
NAMED, PATHS = "tests/extremes/test_named_cases.py", "tests/kernel/analysis/test_equilibrium_paths.py"
WALL = "tests/kernel/constraints/contact/test_crates_on_rigid_ropes_touch.py"
STOPS = "tests/kernel/forces/test_supports_stops_and_brakes.py"
FINE = {"tolerance": 1e-10}


@case(CONTACT, "box under a growing push, F = mu m g", SLIPS, full=True)
def box_that_slips() -> Iterator[Row]:
    from test_a_contact_slips_as_a_whole import pushed

    mass, mu, most = 5.0, 0.3, 1.5
    s = pushed(mass, (2.0, 2.0, 0.5), mu, 0.1, most * mu * mass * G)
    hand_over(s, 9 * SECOND // 10)
    yield Row("part of m g at the slip", mu, most * mu * times(s, "ground", "slip")[0], 1e-6)


@case(CONTACT, "three balls in a row, 1 m/s: -1/3, 2/3, 2/3 together, 0, 0, 1 one by one", TOUCH, full=True)
def three_balls() -> Iterator[Row]:
    from contact_scenes import row_of_balls

    for name, gap, want in (("touching", 0.0, 2 / 3), ("1 mm apart", 1e-3, 1.0)):
        s = started(row_of_balls(gap, 1.0), **FINE)
        s.run(2 * SECOND)
        yield Row(f"speed of the third, {name}", want, float(s.state[s.program.nq + 12]), 1e-8, "m/s")


@case(CONTACT, "bouncing ball, t = sqrt(2 h/g) (1 + e)/(1 - e)", TOUCH, full=True)
def bouncing_ball() -> Iterator[Row]:
    from contact_scenes import bouncing

    s = started(bouncing(1.0, 0.6), **FINE)
    s.run(4 * SECOND)
    want = sqrt(2.0 / G) * 1.6 / 0.4
    yield Row("end of infinitely many bounces, e = 0.6", want, times(s, "floor", "captured")[0], 1e-4, "s")


@case(CONTACT, "ball that slides over an edge, cos = 2/3 + v²/(3 g r)", TOUCH, full=True)
def ball_over_an_edge() -> Iterator[Row]:
    from contact_scenes import ball, brick

    v, r = 0.2, 0.5
    body, joint = ball("ball", r, 2.0, (0.9, 0.0, 1.0 + r), (v, 0.0, 0.0, 0.0, 0.0, 0.0))
    post = Joint("post", "fixed", "world", "low")
    pair = Contact("pair", Ball("ball", radius=r), Box("low", (2.0, 2.0, 2.0)), 0.0)
    scene = System((brick("low", (2.0, 2.0, 2.0), 10.0), body), (post, joint), contacts=(pair,), gravity=G)
    s = started(scene, **FINE, subscribed=frozenset(["pair"]))
    for _ in range(2):  # it comes to the edge, and leaves it
        s.run(3 * SECOND)
        s.fire()
        s.settle()
    yield Row("cosine where it leaves", 2 / 3 + v * v / (3 * G * r), float(s.state[2] - 1.0) / r, 1e-6)


@case(CONTACT, "load on a rope against a wall, p = (1 + e) m v/cos a", WALL, full=True)
def swing_against_a_wall() -> Iterator[Row]:
    from test_crates_on_rigid_ropes_touch import MASS as BALL, against_a_wall, speed_at

    angle, e = -radians(30), 0.5
    s = started(against_a_wall(angle, e), **FINE)
    s.run(SECOND)
    yield Row("impulse at 30°, e = 0.5", (1 + e) * BALL * speed_at(angle) / cos(angle), s.log[0][1].value, 1e-7, "N s")


@case(ELASTIC, "mass on a spring, T = 2 pi sqrt(m/k)", "tests/kernel/forces/test_springs_and_bushings.py", full=True)
def springs() -> Iterator[Row]:
    k, m = 50.0, 2.0
    spring = Spring("s", Point("world", (0.0, 0.0, 5.0)), Point("load"), 3.0, k)
    (mode,) = modes(started(replace(slider(mass=m, q0=2.0), gravity=0.0, forces=(spring,)))).oscillations
    yield Row("period", 2 * pi * sqrt(m / k), 1.0 / mode.frequency, 1e-8, "s")
    k, i, wide = 12.0, 3.0, 3.0
    disc = Body("disc", 1.0, inertia=((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
    joint = Joint("pin", "revolute", "world", "disc", axis=Z, q0=(wide,))
    s = started(System((disc,), (joint,), forces=(Torsion("t", "world", "disc", Z, k),), gravity=0.0), **FINE)
    quarter = pi / 2 * sqrt(i / k)
    hand_over(s, round(quarter * SECOND))
    passed = round(quarter * SECOND) / SECOND - s.state[0] / s.state[1]
    yield Row("torsion bar from 172°, a quarter", quarter, float(passed), 1e-8, "s")


@case(ELASTIC, "door between closer and stop, pi/w1 + pi/w2", STOPS, full=True)
def door() -> Iterator[Row]:
    i, k, k_stop = 2.0e4, 8.0e4, 1.5e6
    scene = System(
        (Body("door", 0.0, inertia=((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))),),
        (Joint("hinge", "revolute", "world", "door", axis=X, v0=(-0.2,)),),
        springs=(JointSpring("closer", "hinge", k),),
        stops=(Stop("stop", "hinge", -5.0, 0.0, k_stop, 0.0),),
        gravity=G,
    )
    s = started(scene, tolerance=1e-11, h_max=0.01)
    s.run(40 * SECOND)
    free, pressed = pi / sqrt(k / i), pi / sqrt((k + k_stop) / i)
    yield Row("fifth touch of the stop", 5 * free + 4 * pressed, times(s, "stop", "closed")[4], 1e-7, "s")


@case(ELASTIC, "brake, way v²/2 a, time v/a", STOPS, full=True)
def brake() -> Iterator[Row]:
    mass, v, force = 3.0e5, 0.5, 3.0e4
    scene = replace(slider(axis=X, mass=mass, v0=v), brakes=(Brake("b", "load-guide", force, 1e9, 1e6),))
    s = started(scene, tolerance=1e-11, h_max=0.01)
    s.interrupt(0)
    s.set_brake("b", True)
    s.settle()
    s.run(20 * SECOND)
    yield Row("way", v * v / (2 * force / mass), float(s.state[0]), 1e-4, "m")
    yield Row("time", v * mass / force, times(s, "b", "stick")[0], 1e-3, "s")


@case(MISHAPS, "loader on two falls, k = T b²/4 L", NAMED, full=True)
def yaw_of_a_loader() -> Iterator[Row]:
    from test_named_cases import block, sling

    m, b, L, i = 12e3, 1.2, 40.0, 9e3
    ropes = tuple(sling(f"fall{n}", (x, 0.0, L), (x, 0.0, 0.0), 1e9, L) for n, x in enumerate((-b / 2, b / 2)))
    s = started(block(m, ropes, inertia=((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))))
    equilibrium(s)
    yaw = next(o for o in modes(s).oscillations if o.joints[0][0] == "float.wz")
    yield Row("period of yaw", 2 * pi * sqrt(i / (m * G * b * b / (4 * L))), 1.0 / yaw.frequency, 1e-3, "s")


@case(MISHAPS, "off-lead on a rough pad, T = mu W/(sin a + mu cos a)", NAMED, full=True)
def off_lead_slip() -> Iterator[Row]:
    from test_named_cases import block, sling

    a, mu, k, W, h = radians(0.5), 0.12, 2e9, MASS * G, 60.0
    pad = Support("pad", Point("block"), 0.0, k, 0.5 * sqrt(k * MASS), mu, 2e9, 1e7)
    rope = sling("rope", (h * np.tan(a), 0.0, h), (0.0, 0.0, 0.0), EA, h / cos(a) + 1e-3, winch=True)
    scene = block(MASS, (rope,), (0.0, 0.0, -W / k), inertia=cube(MASS, 10.0), supports=(pad,))
    s = started(scene, tolerance=1e-10, sample_ns=SECOND // 20)
    s.references.set_profile("rope", 0, -5e-3, 1e-2, None)
    s.settle()
    hand_over(s, 35 * SECOND)
    t, T = column(s, "rope/tension")
    at = float(np.interp(times(s, "pad", "slip")[0], t, T[:, 0])) / W
    yield Row("part of the weight at which the load slips, 0.5°", mu / (sin(a) + mu * cos(a)), at, 5e-3)


@case(MISHAPS, "one of seven slings breaks, stiff plate on springs", NAMED, full=True)
def sling_that_breaks() -> Iterator[Row]:
    from test_named_cases import block, sling

    m, L, EA_, broken = 4.8e5, 20.0, 6e8, 2
    at = [(-9.0, -4.0), (-9.0, 4.0), (-3.0, -4.0), (-3.0, 4.0), (3.0, -4.0), (3.0, 4.0), (9.0, 0.0)]
    k, inertia = EA_ / L, ((m * 30.0, 0.0, 0.0), (0.0, m * 60.0, 0.0), (0.0, 0.0, m * 80.0))
    ropes = tuple(sling(f"s{n}", (x, y, L), (x, y, 0.0), EA_, L, 0.15 * sqrt(k * m)) for n, (x, y) in enumerate(at))
    s = started(block(m, ropes, (0.0, 0.0, -m * G / 7.0 / k), inertia=inertia), tolerance=1e-10)
    for until in (20, 60):
        rest = [p for n, p in enumerate(at) if until == 20 or n != broken]
        A = np.array([(1.0, x, y) for x, y in rest])
        want = (A @ np.linalg.solve(A.T @ A, [m * G, 0.0, 0.0])).max()
        hand_over(s, until * SECOND)
        name = "seven" if until == 20 else "the other six at rest"
        yield Row(f"highest of {name}", want / 1e3, max(s.row().tension) / 1e3, 5e-3, "kN")
        s.unhook(f"s{broken}")
        s.settle()


@case(MISHAPS, "load dragged by a rope: tractrix, tan(a/2) = exp(-s/l)", PATHS, full=True)
def tractrix() -> Iterator[Row]:
    from test_equilibrium_paths import dragged, following, moved

    l, distance = 5.0, 12.0
    path = following(dragged(l))
    moved(path, "drive", 0.1, distance)
    path.run(200 * SECOND)
    angle = 2.0 * atan(exp(-distance / l))
    yield Row("angle of the rope after 12 m", angle, asin(-float(path.points[-1].q[1]) / l), 0.01, "rad")


@case(MISHAPS, "centre above the lugs, two ropes: stable up to 2 k a²/W", PATHS, full=True)
def metacentre() -> Iterator[Row]:
    from heavylift.kernel.description import Line, Rope
    from scipy.optimize import brentq
    from test_equilibrium_paths import following

    k, a, L, m, i = 2e6, 1.0, 30.0, 2e5, 4e5
    W = m * G
    length = L * (1.0 + W / 2 / (k * L))

    def stiffness(h: float) -> float:
        plane = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
        body = Body("load", m, (0.0, h, 0.0), ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
        ropes = tuple(
            Rope(f"r{n}", (Line(Point("world", (x, 0.0, length)), Point("load", (x, 0.0, 0.0))),), k * L, L)
            for n, x in enumerate((-a, a))
        )
        across = Joint("plane", "planar", "world", "load", R_PJ=plane)
        return float(following(System((body,), (across,), ropes=ropes, gravity=G)).stiffness())

    want = 2 * k * a * a / W
    yield Row("highest centre", want, brentq(stiffness, 0.9 * want, 1.1 * want, xtol=1e-9), 1e-4, "m")
