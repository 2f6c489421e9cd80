"""Extreme cases of simultaneous events, indeterminate forces and invalid numbers."""

from dataclasses import replace
from functools import cache
from math import cos, inf, pi, sin, sqrt

import numpy as np
from cells import Extreme, go, started
from heavylift.kernel.description import Body, Joint, Line, Lock, Point, RigidRope, Rope, Stop, System
from independent import double_pendulum, hoisted
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, Y, Z, hung, slider, times


def caught(stiff: float = 1.0) -> Extreme:
    """A load falls into its rope; the peak between two samples is that of energy."""
    k = EA * stiff / LENGTH
    scene = hung(LENGTH - 1.0, v0=0.0)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=EA * stiff),))

    def run(options: dict):
        s = go(started(scene, options, sample_ns=SECOND // 2), SECOND)
        peak = max(float(r[s.method.row_layout.at["peak"]][0]) for _, r in s.rows)
        want = MASS * G + sqrt((MASS * G) ** 2 + 2.0 * k * MASS * G * 1.0)
        when = times(s, "rope", "taut")[0]
        return max(abs(peak - want) / want, abs(when - sqrt(2.0 / G))), s

    return Extreme(f"falls 1 m into its rope x {stiff:g}", run)


def two_at_once() -> Extreme:
    """Two loads fall 1 m into two ropes in the same nanosecond."""
    one = hung(LENGTH - 1.0)
    other = replace(
        slider("other", MASS, Z, -(LENGTH - 1.0)),
        ropes=(Rope("second", (Line(Point("world"), Point("other")),), EA, LENGTH),),
    )
    scene = System(
        one.bodies + other.bodies, one.joints + other.joints, ropes=one.ropes + other.ropes, gravity=G,
    )  # fmt: skip

    def run(options: dict):
        s = go(started(scene, options), SECOND * 6 // 10)
        a, b = times(s, "rope", "taut")[0], times(s, "second", "taut")[0]
        assert a == b
        w = sqrt(EA / LENGTH / MASS)
        late, v = 0.6 - sqrt(2.0 / G), sqrt(2.0 * G)
        down = G / w**2 * (1.0 - cos(w * late)) + v / w * sin(w * late)
        return float(np.abs(-s.state[:2] - LENGTH - down).max()), s

    return Extreme("two events at one instant", run)


def reversal() -> Extreme:
    """The hoist lifts a load off springy ground and turns round in the moment of lift-off."""
    k, ground, v = 1e9, -LENGTH, 0.05
    d = 0.3 * 2.0 * sqrt(k * MASS)
    turned = round((MASS * G / EA * LENGTH + MASS * G / k) / v * SECOND)
    stop = Stop("ground", "load-guide", ground, 100.0, k, d)
    scene = replace(hung(LENGTH + MASS * G / k, LENGTH + MASS * G / k, winch=True), stops=(stop,))
    L0 = LENGTH + MASS * G / k

    def winch(t: float):
        return (L0 - v * t, -v) if t < turned * 1e-9 else (L0 - v * (2.0 * turned * 1e-9 - t), v)

    @cache
    def want() -> float:
        return float(hoisted(MASS, EA, L0, ground, k, d, winch, turned * 1e-9 + 1.0)[0])

    def run(options: dict):
        s = started(scene, options)
        s.references.set_profile("rope", 0, -v, 1e7, None)
        s.settle()
        s.run(turned)
        s.interrupt(turned)
        s.references.set_profile("rope", turned, v, 1e7, None)
        s.settle()
        go(s, turned + SECOND)
        return abs(float(s.state[0]) - want()) / (MASS * G / k), s

    return Extreme("hoist reversal at lift-off", run)


def freed() -> Extreme:
    """Two bars swing as one; after a second their locked hinge is freed in motion."""
    m, l, a = 1e4, 5.0, 1.0
    i = m * l * l / 12.0
    inertia = ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, 0.0))
    scene = System(
        tuple(Body(n, m, (0.0, 0.0, -0.5 * l), inertia) for n in ("upper", "lower")),
        (
            Joint("top", "revolute", "world", "upper", axis=Y, q0=(a,)),
            Joint("elbow", "revolute", "upper", "lower", (0.0, 0.0, -l), axis=Y),
        ),
        locks=(Lock("lock", "elbow", True),),
        gravity=G,
    )

    def run(options: dict):
        s = started(scene, options)
        s.run(SECOND)
        s.interrupt(SECOND)
        at = s.state[:4].copy()
        s.set_lock("lock", False)
        s.settle()
        go(s, 2 * SECOND)
        want = double_pendulum(m, l, i, [at[0], at[0], at[2], at[2]], 1.0)
        return float(np.abs(s.state[:2] - [want[0], want[1] - want[0]]).max()), s

    return Extreme("a locked joint freed in motion", run)


def redundant() -> Extreme:
    """Three equal rigid ropes side by side hold a load on a guide and share its weight."""
    ropes = tuple(RigidRope(f"rope{n}", (Line(Point("world"), Point("load")),), LENGTH) for n in range(3))
    scene = replace(slider(q0=-LENGTH), rigid_ropes=ropes)

    def run(options: dict):
        s = go(started(scene, options), SECOND)
        T = s.row().pull
        return max(float(np.abs(np.array(T) - MASS * G / 3.0).max()) / (MASS * G), abs(float(s.state[0]) + LENGTH)), s

    return Extreme("three ropes for one load", run)


def collinear() -> Extreme:
    """Three points of a rope in one line with the load, pulled across: the sideways stiffness is that of tension."""
    h, pull, m = 10.0, 1e6, 1e3
    strain = pull / EA
    L0 = h / (1.0 + strain)
    lines = [Line(Point("world", (0.0, y, 0.0)), Point("load")) for y in (-h, h)]
    scene = replace(
        slider(mass=m, axis=X, q0=0.05),
        ropes=tuple(Rope(f"rope{n}", (line,), EA, L0) for n, line in enumerate(lines)), gravity=0.0,
    )  # fmt: skip
    w = sqrt(2.0 * pull / h / m)

    def run(options: dict):
        t = 0.75 * 2.0 * pi / w
        s = go(started(scene, options), round(t * SECOND))
        # Duffing: w' = w (1 + 3/8 a x0^2), of the stretch that the way aside adds; the phase is read at a zero
        a = (EA / L0 - pull / h) / (2.0 * pull / h) / h**2 * 1.0
        phase = 0.75 * 2.0 * pi * (1.0 + 3.0 / 8.0 * a * 0.05**2)
        return abs(float(s.state[0]) / 0.05 - cos(phase)), s

    return Extreme("collinear ropes, pulled across", run)


def meets() -> Extreme:
    """A rope whose ends meet has no direction."""
    return Extreme("ends of a rope meet", lambda options: (inf, go(started(hung(0.0), options), SECOND)))


def not_a_number(what: str, value: float) -> Extreme:
    """NaN or infinity in a description, a state or a command."""

    def run(options: dict):
        scene = hung(LENGTH, winch=True)
        if what in ("EA", "L0", "damping"):
            scene = replace(scene, ropes=(replace(scene.ropes[0], **{what: value}),))
        if what == "mass":
            scene = replace(scene, bodies=(replace(scene.bodies[0], mass=value),))
        if what in ("q0", "v0"):
            scene = replace(scene, joints=(replace(scene.joints[0], **{what: (value,)}),))
        s = started(scene, options)
        if what == "speed":
            s.references.set_profile("rope", 0, value, 0.1, None)
            s.settle()
        if what == "force":
            s.P[s.program.parameters.at["gravity", ""]] = value
        return inf, go(s, SECOND // 10)

    return Extreme(f"{what} is {value}", run)
