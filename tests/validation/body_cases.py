"""Closed forms of beams, rotating bodies, contact with friction, linkages in print, and numerical methods."""

from __future__ import annotations

from collections.abc import Iterator
from math import acos, acosh, atan, cos, pi, sin, sqrt

import numpy as np
from comparison import FORMS, Row, case
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import Body, Joint, JointSpring, System
from heavylift.kernel.multibody import path_matrix
from small_scenes import MASS, SECOND, G, X, column, hand_over, started, times

BEAMS, ROTATION, CONTACT, METHODS = "Beams", "Rotating bodies and joints", "Contact and friction", "Numerical methods"
BEND, TOUCH = (
    "tests/kernel/multibody/flexible/test_beams_bend.py",
    "tests/kernel/constraints/contact/test_rigid_bodies_touch.py",
)
TOP, ARM = "tests/kernel/multibody/test_spinning_bodies.py", "tests/kernel/multibody/test_the_four_link_arm.py"
STEPS = "tests/kernel/methods/test_fixed_steps.py"
FINE = {"tolerance": 1e-10}


@case(BEAMS, "girder: P L³/48 EI, 5 q L⁴/384 EI, f of beam and load", BEND, full=True)
def girder_of_a_goliath() -> Iterator[Row]:
    from test_beams_bend import EI, GIRDER, LENGTH, MASS, Program, girder, sag

    want = FORMS["C18"]["expected"]
    own = sag(Program(girder()))
    yield Row("sag under its own 2 500 t", 5 * GIRDER * G * LENGTH**3 / (384 * EI), own, 5e-3, "m")
    yield Row("more under 900 t", want["d"], sag(Program(girder(load=MASS))) - own, 5e-3, "m")
    for name, scene, theirs, within in (
        ("own frequency", girder(), [want["f_empty"]], 1e-5),
        ("loaded by 900 t, 17/35 of its mass", girder(load=MASS), [want["f_loaded"]], 0.01),
        ("in series with its rope, mode {}", girder(load=MASS, rope=True), want["f_2dof"], 0.02),
    ):
        s = started(scene)
        equilibrium(s)
        found = modes(s).oscillations
        for k, f in enumerate(theirs):
            yield Row(name.format(k + 1), f, found[k].frequency, within, "Hz")


@case(BEAMS, "bending of uniform beams, roots of the frequency equation", BEND, full=True)
def bending_frequencies() -> Iterator[Row]:
    from dataclasses import replace

    from test_beams_bend import BEAM, EI, LENGTH, Flexible, Program

    for frame, roots in (
        ("clamped", (1.8751040687, 7.8547574382)),
        ("simply supported", (pi, 3 * pi)),
        ("free", (4.7300407449, 10.995607838)),
    ):
        body = Body("girder", 0.0, flexible=Flexible(3, BEAM, frame=frame))
        body = replace(body, inertia=((1.0, 0.0, 0.0), *body.inertia[1:]))
        joint = Joint("legs", "free" if frame == "free" else "fixed", "world", "girder")
        bent = Program(System((body,), (joint,), gravity=0.0)).graph.links[0].modes
        found = np.sqrt(bent.stiffness / bent.mass) * LENGTH**2 / sqrt(EI / BEAM.mass_per_length)
        for k, root in zip((0, 2), roots, strict=True):
            yield Row(f"{frame}, root {k + 1}", root, float(sqrt(found[k])), 5e-5)


@case(BEAMS, "clamped bar: axial pi/2L sqrt(EA/mu), torsion pi/2L sqrt(GJ/polar)", BEND, full=True)
def bars() -> Iterator[Row]:
    from dataclasses import replace

    from test_beams_bend import Beam, Flexible, Program, girder

    beam = Beam(10.0, 80.0, EA=2e9, GJ=3e6, polar=5.0, elements=64)
    twist = Program(replace(girder(Flexible(2, beam)), gravity=0.0)).graph.links[0].modes
    found = np.sqrt(twist.stiffness / twist.mass)
    for k, n in enumerate((1, 3)):
        yield Row(f"torsion, mode {k + 1}", n * pi / 20.0 * sqrt(3e6 / 5.0), float(found[k]), 1e-3, "rad/s")
    pulled = Program(girder(Flexible(1, replace(beam, GJ=0.0)))).graph.links[0].modes
    found = np.sqrt(pulled.stiffness / pulled.mass)
    yield Row("axial, mode 1", pi / 20.0 * sqrt(2e9 / 80.0), float(found[0]), 1e-4, "rad/s")


@case(BEAMS, "moving force, Frýba 1972", "tests/kernel/forces/test_a_trolley_runs_on_a_girder.py", full=True)
def moving_force() -> Iterator[Row]:
    from heavylift.kernel.description import Load, Point
    from test_a_trolley_runs_on_a_girder import EI, GIRDER, LENGTH, SPEED, crane, crossing

    P, mu = 9.0e6, GIRDER / LENGTH
    t, w = crossing(crane(0.0, forces=(Load("weight", Point("trolley"), (0.0, 0.0, -P)),), gravity=0.0))
    want = np.zeros_like(t)
    for n in range(1, 40, 2):
        wn, Wn = (n * pi / LENGTH) ** 2 * sqrt(EI / mu), n * pi * SPEED / LENGTH
        want -= 2 * P / GIRDER * sin(n * pi / 2) * (np.sin(Wn * t) - Wn / wn * np.sin(wn * t)) / (wn**2 - Wn**2)
    k = int(np.argmin(want))
    yield Row("largest deflection, 30 m/s", -want[k], -w[k], 5e-3, "m")


@case(ROTATION, "torque-free symmetric body, lam = (I3 - I1) w3/I1", TOP, full=True)
def symmetric_top() -> Iterator[Row]:
    from scipy.spatial.transform import Rotation
    from test_spinning_bodies import I1, I3, W3, WT, top

    want = FORMS["C17"]["expected"]
    s = started(top("free"), tolerance=1e-12, sample_ns=SECOND)
    hand_over(s, 100 * SECOND)
    wx, wy = s.row().v[3:5]
    turned = np.unwrap([want["lam"] * 100.0, np.arctan2(wy, wx)])[1]
    yield Row("rate of the body's wobble", want["lam"], float(turned) / 100.0, 1e-8, "rad/s")
    H = np.array([I1 * WT, 0.0, I3 * W3])
    axis = H / np.linalg.norm(H)
    got, start = Rotation.from_quat(s.row().q[3:7]).apply([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    a, b = (v - (v @ axis) * axis for v in (start, got))
    angle = np.unwrap([want["precession"] * 100.0, np.arctan2(np.cross(a, b) @ axis, a @ b)])[1]
    yield Row("precession, H/I1", want["precession"], float(angle) / 100.0, 1e-8, "rad/s")


@case(
    ROTATION, "nut on a screw, q'' = -m g p/(m p² + I)", "tests/kernel/multibody/test_every_joint_agrees_with_others.py"
)
def nut_on_a_screw() -> Iterator[Row]:
    p, m, i = 0.05, 120.0, 3.0
    nut = Body("nut", m, inertia=((5.0, 0.0, 0.0), (0.0, 5.0, 0.0), (0.0, 0.0, i)))
    s = started(System((nut,), (Joint("screw", "screw", "world", "nut", pitch=p),), gravity=G), tolerance=1e-11)
    hand_over(s, SECOND)
    yield Row("angle after 1 s", -0.5 * m * G * p / (m * p * p + i), float(s.state[0]), 1e-9, "rad")


@case(
    ROTATION, "founding paper (Procedia Technology 1, 2012): eq. (5)", "tests/kernel/multibody/test_the_path_matrix.py"
)
def path_matrix_of_the_arm() -> Iterator[Row]:
    form = FORMS["C19a"]
    apart = np.abs(path_matrix(form["given"]["parent"]) - np.array(form["expected"]["T"])).sum()
    yield Row("entries of T that differ, four-link arm", 0.0, float(apart), 1e-9, absolute=True)


@case(ROTATION, "Lagrange's equations of the four-link arm", ARM)
def four_link_arm() -> Iterator[Row]:
    from test_the_four_link_arm import arm

    want = FORMS["C19b"]["expected"]
    s = started(arm())
    f = s.X[s.method.layout.at["f"]]
    for k in (0, 3):
        yield Row(f"acceleration of joint {k + 1}", want["qdd"][k], float(f[4 + k]), 1e-9, "rad/s²")


@case(
    ROTATION,
    "founding paper, fig. 6 (d) with its printed sign",
    ARM,
    why="the figure has the wrong sign: a resting arm stands on its base with its weight, as the next row has it",
)
def base_of_the_arm() -> Iterator[Row]:
    from test_the_four_link_arm import arm, reactions

    want = FORMS["C19b"]["expected"]
    base = reactions(arm(cells=True, at_rest=True))["slide-z0"]
    yield Row("base of the resting arm", want["base_force_at_rest_with_printed_sign"], base, 1e-9, "N")


@case(ROTATION, "weight of the same arm", ARM)
def weight_of_the_arm() -> Iterator[Row]:
    from test_the_four_link_arm import arm, reactions

    base = reactions(arm(cells=True, at_rest=True))["slide-z0"]
    yield Row("base of the resting arm", FORMS["C19b"]["expected"]["total_weight"], base, 1e-9, "N")


@case(CONTACT, "Coulomb: a = g (sin - mu cos), s = v²/2 a", TOUCH, full=True)
def sliding_block() -> Iterator[Row]:
    from contact_scenes import on_slope, way

    mu = 0.4
    angle = 1.5 * atan(mu)
    s = started(on_slope(angle, mu), **FINE)
    hand_over(s, 2 * SECOND)
    yield Row("acceleration", G * (sin(angle) - mu * cos(angle)), way(s.state, angle)[0] / 2.0, 1e-8, "m/s²")
    angle, v = 0.5 * atan(mu), 3.0
    a = G * (mu * cos(angle) - sin(angle))
    s = started(on_slope(angle, mu, v), **FINE)
    s.run(5 * SECOND)
    yield Row("way to rest", v * v / (2 * a), way(s.state, angle)[0], 1e-8, "m")
    yield Row("time to rest", v / a, times(s, "slope", "stick")[0], 1e-8, "s")


@case(CONTACT, "rocking block, Housner 1963 (small angles)", TOUCH, full=True)
def rocking_block() -> Iterator[Row]:
    from contact_scenes import rocker, rocking

    b, h, part = 0.02, 0.4, 0.3
    alpha, p = rocking(b, h)
    s = started(rocker(b, h, part * alpha), **FINE)
    s.run(SECOND // 2)
    first = times(s, "ground", "impact")[0]
    yield Row("first impact", acosh(1.0 / (1.0 - part)) / p, first, alpha * alpha, "s")


@case(METHODS, "frequency error of leapfrog, 2 asin(w h/2)/(w h) - 1", STEPS)
def leapfrog() -> Iterator[Row]:
    x, want = FORMS["C21"]["given"], FORMS["C21"]["expected"]
    w, h = x["w"], x["h"]
    guide = Joint("guide", "prismatic", "world", "load", axis=X, q0=(1.0,))
    scene = System((Body("load", MASS),), (guide,), springs=(JointSpring("k", "guide", MASS * w * w),), gravity=0.0)
    s = started(scene, method="semi-implicit-euler", step=h, sample_ns=round(h * 1e9))
    hand_over(s, 10 * SECOND)
    q = column(s, "joint/position")[1][:, 0]
    cosine = np.dot(q[2:] + q[:-2], q[1:-1]) / (2.0 * np.dot(q[1:-1], q[1:-1]))
    yield Row("step of 10 ms at 1.3 Hz", want["leapfrog"], acos(cosine) / (w * h) - 1.0, 1e-3)


@case(METHODS, "time of a trapezoid, d/v + v/a or 2 sqrt(d/a)", "tests/chain/test_stages_take_their_time.py", full=True)
def stages() -> Iterator[Row]:
    import tempfile
    from pathlib import Path

    from chain import play
    from test_stages_take_their_time import CRANE, FORM, MOVES

    with tempfile.TemporaryDirectory() as folder:
        events = [e for e in play(Path(folder), CRANE).events() if e.type in ("Run", "Done")]
    for form, actuator, order, _ in (*MOVES[:3], MOVES[4]):
        begun, done = (
            [e for e in events if e.type == kind and e.value["actor"] == actuator][order] for kind in ("Run", "Done")
        )
        yield Row(form, FORM[form], (done.t_ns - begun.t_ns) / SECOND, 1e-9, "s")
