"""Extremes of stiffness, mass and swing."""

from dataclasses import replace
from math import cos, inf, pi, radians, sin, sqrt

import numpy as np
from cells import Extreme, go, started
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from independent import bounce, chain, period, planar, turn
from small_scenes import EA, LENGTH, MASS, SECOND, G, Y, Z, cube, hung

MICROMETRE = 1e-6  # [m] place errors below are the tolerance's


def stiffness(factor: float) -> Extreme:
    """A load let go on a straight rope; from 1e4 on it is 10 cm of rope, with the rest of the factor in EA."""
    L0 = LENGTH if factor < 1e3 else 0.1
    k = EA / LENGTH * factor
    scene = hung(L0, L0)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=k * L0),))

    def run(options: dict):
        t = max(1.0, 4.0 / sqrt(k / MASS))
        s = go(started(scene, options), round(t * SECOND))
        down, _, most = bounce(MASS, k, t)
        peak = max(float(r[s.method.row_layout.at["peak"]][0]) for _, r in s.rows)
        place = abs(-float(s.state[0]) - L0 - down) / (2.0 * MASS * G / k + MICROMETRE)
        return max(place, abs(peak - most) / most), s

    return Extreme(f"rope stiffness x {factor:g}", run)


def ratio(r: float) -> Extreme:
    """A hook between rope and sling, and a load r times as heavy; the load is let go a tenth above its rest."""
    hook, load = (MASS / r, MASS) if r >= 1.0 else (MASS, MASS * r)
    scene = System(
        (Body("hook", hook), Body("load", load)),
        tuple(Joint(f"{n}-guide", "prismatic", "world", n, axis=Z) for n in ("hook", "load")),
        ropes=(
            Rope("rope", (Line(Point("world"), Point("hook")),), EA, LENGTH),
            Rope("sling", (Line(Point("hook"), Point("load")),), EA / 10.0, LENGTH / 10.0),
        ),
        gravity=G,
    )
    k = EA / LENGTH
    rest = np.array([LENGTH + (hook + load) * G / k, 0.0])
    rest[1] = rest[0] + 0.1 * LENGTH + load * G / k
    lift = 0.1 * load * G / k

    def run(options: dict):
        s = started(
            replace(
                scene, joints=tuple(replace(j, q0=(-x,)) for j, x in zip(scene.joints, rest - [0.0, lift], strict=True))
            ),
            options,
        )
        go(s, SECOND // 2)
        want = -rest + chain([hook, load], [k, k], np.array([0.0, lift]), 0.5)
        return float(np.abs(s.state[:2] - want).max()) / (lift + MICROMETRE), s

    return Extreme(f"load to hook {r:g}", run)


def empty_hook() -> Extreme:
    """The hook alone, 45 t less its load, with the sling hanging slack from it."""
    scene = hung(LENGTH)
    scene = replace(scene, bodies=(replace(scene.bodies[0], mass=500.0),))

    def run(options: dict):
        s = go(started(scene, options), SECOND)
        return abs(-float(s.state[0]) - LENGTH - bounce(500.0, EA / LENGTH, 1.0)[0]) / (1000.0 * G * LENGTH / EA), s

    return Extreme("empty hook, 0.5 t", run)


def massless(what: str) -> Extreme:
    """A body on which a force acts although nothing resists it."""
    mass, inertia = (0.0, cube(0.0)) if what == "mass" else (10.0, cube(0.0))
    body = Body("hook", mass, inertia=inertia)
    joint = Joint("float", "free", "world", "hook", q0=(0.0, 0.0, -LENGTH, 0.0, 0.0, 0.0, 1.0))
    line = Line(Point("world"), Point("hook", (0.1, 0.0, 0.0)))
    scene = System((body,), (joint,), ropes=(Rope("rope", (line,), EA, LENGTH),), gravity=G)

    def run(options: dict):
        return inf, go(started(scene, options), SECOND // 10)

    return Extreme(f"no {what}", run)


# ---- swing ---------------------------------------------------------------------------------------------------


def bar(length: float, angle: float, speed: float = 0.0, at=(0.0, 0.0, 0.0)) -> System:
    """A point load on a stiff bar, hinged; angle from straight down."""
    hinge = Joint("hinge", "revolute", "world", "bob", p_PJ=at, axis=Y, q0=(angle,), v0=(speed,))
    return System((Body("bob", 1e5, (0.0, 0.0, -length)),), (hinge,), gravity=G)


def swing(degrees: float, at=(0.0, 0.0, 0.0), name: str = "") -> Extreme:
    a, L = radians(degrees), 20.0

    def run(options: dict):
        T = period(a, L)
        s = go(started(bar(L, a, at=at), options), round(1.25 * T * SECOND))
        # at a quarter beyond a period it passes the bottom at full speed
        v = 2.0 * sqrt(G / L) * sin(0.5 * a)
        return max(abs(float(s.state[0])) / a, abs(abs(float(s.state[1])) - v) / v), s

    return Extreme(name or f"swing to {degrees:g} degrees", run)


def over_the_top() -> Extreme:
    L = 20.0
    v = 1.05 * sqrt(4.0 * G * L)

    def run(options: dict):
        s = go(started(bar(L, 0.0, v / L), options), round(3.0 * turn(v, L) * SECOND))
        return max(abs(float(s.state[0]) - 6.0 * pi) / (2.0 * pi), abs(float(s.state[1]) * L - v) / v), s

    return Extreme("three times over the top", run)


def on_a_rope(degrees: float) -> Extreme:
    """A block on one elastic rope swings; beyond 90 degrees the rope goes slack and snaps taut."""
    a, m, i, L = radians(degrees), 1e5, 1e5 * 4.0 / 6.0, 20.0
    ropes = [(0.0, 0.0, 0.0, 1.0, 1e8, L, 2e5)]
    reach = L + 1.0 + (m * G * cos(a) / 1e8 * L if degrees < 90 else -0.2)
    x, z = -reach * sin(a), -reach * cos(a)

    def run(options: dict):
        half = 0.5 * a
        q0 = (x, 0.0, z, 0.0, sin(half), 0.0, cos(half))
        line = Line(Point("world"), Point("block", (0.0, 0.0, 1.0)))
        scene = System(
            (Body("block", m, inertia=cube(m)),), (Joint("float", "free", "world", "block", q0=q0),),
            ropes=(Rope("rope", (line,), 1e8, L, 2e5),), gravity=G,
        )  # fmt: skip
        s = go(started(scene, options), 4 * SECOND)
        want = planar(m, i, ropes, [x, z, a, 0.0, 0.0, 0.0], 4.0)
        return float(np.hypot(s.state[0] - want[0], s.state[2] - want[1])) / L, s

    return Extreme(f"a rope let go at {degrees:g} degrees", run)
