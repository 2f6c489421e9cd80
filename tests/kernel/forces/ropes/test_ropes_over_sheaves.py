"""Ropes over sheaves: tackles (C14), capstans, belts, MuJoCo's wrapping tendons, energy balances."""

import json
from dataclasses import replace
from math import asin, exp, pi, sqrt
from pathlib import Path

import mujoco
import numpy as np
import pytest
from heavylift.kernel.description import Body, InputSignal, Joint, Line, Point, Reeving, Rope, Sheave, System
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, G, Y, Z, column, cube, events, imbalance, slider, started

STRAIN = 1e-4  # of these ropes
C14 = 1e-6  # with friction
EQUAL = 1e-9  # parts of a rope without friction
SAME = 1e-9  # as MuJoCo, relative to the largest acceleration
CLOSES = 1e-9  # of the energy turned over
FINE = {"tolerance": 1e-10, "sample_ns": 20_000_000}
FORMS = {c["id"]: c for c in json.loads((Path(__file__).parents[3] / "data" / "closed_forms.json").read_text())}
WORLD, LOAD = Point("world"), Point("load")


def tensions(s: Simulation, parts: int) -> np.ndarray:
    return np.array(s.row().shown[:parts])


def tackle(falls: int, eta: float, mass: float, height: float, EA: float, damping: float) -> System:
    """A load on so many falls, the first one from a winch."""
    sheaves = tuple(Sheave(WORLD if i % 2 else LOAD, efficiency=eta) for i in range(falls - 1))
    end = LOAD if falls % 2 else WORLD
    L0 = falls * height / (1.0 + mass * G / falls / EA)
    rope = Reeving("rope", WORLD, sheaves, end, EA, InputSignal(L0, driven=True), damping)
    return replace(slider(mass=mass, q0=-height), forces=(rope,))


def test_the_lead_line_of_a_tackle_carries_more_when_hoisting_and_less_when_lowering():
    given, expected = FORMS["C14"]["given"], FORMS["C14"]["expected"]
    W, n, eta = given["W"], given["n"], given["eta"]
    s = started(tackle(n, eta, W / G, 20.0, 1.0e8, 3e4), tolerance=1e-9)
    s.references.set_profile("rope", 0, -0.5, 0.5, None)
    s.settle()
    s.interrupt(25 * SECOND)
    T = tensions(s, n)
    assert T[0] == pytest.approx(expected["T_lead"], rel=C14)
    assert T[1:] / T[:-1] == pytest.approx(np.full(n - 1, eta), rel=C14)
    assert T.sum() == pytest.approx(expected["sum_parts"], rel=C14)
    assert given["MBF"] / T[0] == pytest.approx(expected["SF_lead"], rel=C14)
    assert s.row().v[0] == pytest.approx(0.5 / n, rel=3e-3), "rope speed over falls, as stretched"
    s.references.set_profile("rope", 25 * SECOND, 0.5, 0.5, None)
    s.settle()
    s.interrupt(60 * SECOND)
    T = tensions(s, n)
    assert T[0] == pytest.approx(W * (1 - 1 / eta) / (1 - 1 / eta**n), rel=C14)
    assert imbalance(s) < CLOSES


def test_all_parts_of_a_frictionless_tackle_have_equal_tension():
    given, expected = FORMS["C14"]["given"], FORMS["C14"]["expected"]
    scene = tackle(given["n"], 1.0, given["W"] / G, 20.0, 1.0e8, 0.0)
    s = started(scene, tolerance=1e-9)
    assert tensions(s, given["n"]) == pytest.approx(np.full(given["n"], expected["T_ideal"]), rel=EQUAL)
    assert given["MBF"] / tensions(s, given["n"])[0] == pytest.approx(expected["SF_ideal"], rel=EQUAL)
    lines = (Line(WORLD, LOAD, float(given["n"])),)
    rope = Rope("rope", lines, 1.0e8, scene.forces[0].signal.value)
    other = started(replace(scene, forces=(), ropes=(rope,)), tolerance=1e-9)
    for simulation in (s, other):
        simulation.state[1] = 0.3  # let it bounce
        simulation.settle()
        simulation.interrupt(SECOND)
    assert s.row().q[0] == pytest.approx(other.row().q[0], abs=1e-10)


def atwood(m1: float, m2: float, mu: float, swing: float = 0.0, R: float = 0.5, EA: float = 1e7) -> System:
    """Two loads on a rope over one fixed sheave; at rest they would hang in balance with one tension."""
    joints = (
        Joint("f1", "free", "world", "one", q0=(-R, 0.0, -4.0, 0.0, 0.0, 0.0, 1.0), v0=(swing, 0, 0, 0, 0, 0)),
        Joint("f2", "free", "world", "two", q0=(R, 0.0, -6.0, 0.0, 0.0, 0.0, 1.0)),
    )
    T = 2 * m1 * m2 / (m1 + m2) * G
    rope = Reeving(
        "rope",
        Point("one"),
        (Sheave(WORLD, Y, R, mu),),
        Point("two"),
        EA,
        InputSignal((10.0 + pi * R) / (1 + T / EA)),
        2e4,
    )
    bodies = (Body("one", m1, inertia=cube(m1, 0.2)), Body("two", m2, inertia=cube(m2, 0.2)))
    return System(bodies, joints, forces=(rope,), gravity=G)


@pytest.mark.parametrize("swing", [0.0, 1.0])
def test_a_rope_on_a_capstan_slips_beyond_the_ratio_of_euler_and_eytelwein(swing):
    """200 kg against 120 kg: more than exp(0.1 pi), so they run with a = g (m1 - rho m2)/(m1 + rho m2)."""
    m1, m2, rho = 200.0, 120.0, exp(0.1 * pi)
    s = started(atwood(m1, m2, 0.1, swing), **FINE)
    s.interrupt(SECOND)
    v = -s.row().v[2]
    s.settle()
    s.interrupt(3 * SECOND // 2)
    assert [what for _, what in events(s)] == ["slip"]
    if not swing:
        assert (-s.row().v[2] - v) / 0.5 == pytest.approx(G * (m1 - rho * m2) / (m1 + rho * m2), rel=STRAIN)
        T = tensions(s, 2)
        assert T[0] / T[1] == pytest.approx(rho, rel=1e-6)
    assert column(s, "account")[1][-1, 0] > 100.0, "the sheave is warm"
    assert imbalance(s) < CLOSES


def test_a_rope_on_a_capstan_holds_below_the_ratio_of_euler_and_eytelwein():
    m1, m2 = 200.0, 120.0
    s = started(atwood(m1, m2, 0.4), **FINE)
    s.interrupt(2 * SECOND)
    assert events(s) == []
    assert tensions(s, 2) == pytest.approx([m1 * G, m2 * G], rel=1e-6)
    assert abs(s.row().v).max() < 1e-6


def test_a_swing_reverses_the_direction_of_slip_over_a_sheave():
    """A winch that goes up and down: the sheave slips, sticks and slips back; no energy is lost from the accounts."""
    load = slider(mass=1000.0, q0=-10.0)
    sheave = Sheave(Point("world", (-0.3, 0.0, 0.0)), Y, 0.3, 0.15)
    L0 = (sqrt(8.0**2 - 0.3**2) + 10.0 + 0.3 * (pi / 2 + asin(0.3 / 8.0))) / (1 + 1000.0 * G / 2e7)
    winch = Point("world", (-8.3, 0.0, 0.0))
    rope = Reeving("rope", winch, (sheave,), LOAD, 2e7, InputSignal(L0, driven=True), 3e4)
    s = started(replace(load, forces=(rope,)), **FINE)
    for i, speed in enumerate((-0.5, 0.5, -0.5)):
        s.references.set_profile("rope", 2 * i * SECOND, speed, 0.5, None)
        s.settle()
        s.interrupt(2 * (i + 1) * SECOND)
    log = [what for _, what in events(s)]
    assert log.count("slip") >= 3
    assert log.count("stick") >= 2
    assert imbalance(s) < CLOSES


def test_a_load_that_falls_into_its_tackle_bounces():
    scene = tackle(4, 0.95, 1000.0, 10.0, 2e6, 1e3)
    s = started(replace(scene, joints=(replace(scene.joints[0], q0=(-9.7,)),)), **FINE)
    s.run(4 * SECOND)
    log = [what for _, what in events(s)]
    assert "slack" in log
    assert log.count("taut") >= 2
    assert imbalance(s) < CLOSES


def test_wrapped_ropes_exert_the_forces_of_mujocos_tendons():
    """A boom on a hinge with a sheave at its tip, a fixed sheave, an eye between them, a load on a free joint."""
    boom, load = (
        Body("boom", 300.0, (2.0, 0.0, 0.0), cube(300.0, 2.0)),
        Body("load", 200.0, (0.1, 0.05, 0.0), cube(200.0, 1.0)),
    )
    a, b, eye = (-3.0, 0.0, 0.2), (0.05, 0.0, 0.3), (2.0, 0.0, 0.6)
    one, two = (0.0, 0.0, 1.0), (4.0, 0.0, 0.0)
    sheaves = (
        Sheave(Point("world", one), Y, 0.4),
        Sheave(Point("boom", eye)),
        Sheave(Point("boom", two), Y, 0.3),
    )
    L0, EA, d = 9.0, 5e4, 300.0
    rope = Reeving("rope", Point("world", a), sheaves, Point("load", b), EA, InputSignal(L0), d)
    angle, v0 = -0.2, (0.3, 0.0, -0.8, 0.0, 0.2, 0.0)
    system = System(
        (boom, load),
        (
            Joint("hinge", "revolute", "world", "boom", axis=Y, q0=(angle,), v0=(0.15,)),
            Joint("free", "free", "world", "load", q0=(4.4, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0), v0=v0),
        ),
        forces=(rope,),
        gravity=G,
    )

    def numbers(x):
        return " ".join(repr(float(e)) for e in x)

    def wheel(name, p, r):
        return f'<geom name="{name}" type="cylinder" size="{r} 0.2" pos="{numbers(p)}" euler="{pi / 2} 0 0" mass="0"/>'

    def inertial(x):
        I = numbers(x.inertia[i][i] for i in range(3))
        return f'<inertial pos="{numbers(x.com)}" mass="{x.mass}" diaginertia="{I}"/>'

    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 -{G}"><flag contact="disable"/></option><worldbody>'
        f'<site name="a" pos="{numbers(a)}"/>{wheel("w1", one, 0.4)}<site name="s1" pos="0 0 1.9"/>'
        f'<body name="boom"><joint type="hinge" axis="0 1 0"/>{inertial(boom)}<site name="eye" pos="{numbers(eye)}"/>'
        f'{wheel("w2", two, 0.3)}<site name="s2" pos="4.6 0 0.4"/></body>'
        f'<body name="load"><freejoint/>{inertial(load)}<site name="b" pos="{numbers(b)}"/></body></worldbody>'
        f'<tendon><spatial stiffness="{EA / L0}" damping="{d}" springlength="0 {L0}"><site site="a"/>'
        '<geom geom="w1" sidesite="s1"/><site site="eye"/><geom geom="w2" sidesite="s2"/><site site="b"/></spatial>'
        "</tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qpos[:] = [angle, 4.4, 0.0, -2.0, 1.0, 0.0, 0.0, 0.0]
    data.qvel[:] = [0.15, *v0]
    mujoco.mj_forward(model, data)
    s = started(system)
    n = s.program.nq
    theirs = data.qacc.copy()
    theirs[1:4] -= np.cross(v0[3:], v0[:3])
    ours = s.X[s.native.at["f"]][n : n + 7]
    assert sum(s.row().shown[4:8]) == pytest.approx(data.ten_length[0], rel=1e-12)
    assert s.row().shown[0] > 1000.0, "taut"
    assert ours == pytest.approx(theirs, abs=SAME * np.abs(theirs).max())


@pytest.mark.parametrize("crossed", [False, True])
def test_the_length_of_a_rope_over_two_sheaves_is_that_of_an_open_or_crossed_belt(crossed):
    """Straight parts of an open and of a crossed belt: sqrt(d^2 - (r1 -+ r2)^2); arcs by their angles."""
    d, r1, r2, down = 6.0, 0.8, 0.3, 5.0
    turn = -1.0 if crossed else 1.0
    sheaves = (Sheave(WORLD, Y, r1), Sheave(Point("world", (d, 0.0, 0.0)), (0.0, turn, 0.0), r2))
    guide = Joint("guide", "prismatic", "world", "load", (-r1, 0.0, 0.0), axis=Z, q0=(-down,))
    end = Point("world", (d + r2, 0.0, -down * turn))
    rope = Reeving("r", LOAD, sheaves, end, 1e6, InputSignal(30.0))
    s = started(System((Body("load", 1.0),), (guide,), forces=(rope,)))
    lean = asin((r1 - turn * r2) / d)
    straight = sqrt(d * d - (r1 - turn * r2) ** 2)
    arcs = r1 * (pi / 2 + lean) + r2 * (pi / 2 - turn * lean)
    assert sum(s.row().shown[3:6]) == pytest.approx(2 * down + straight + arcs, rel=1e-12)


def test_a_drum_is_turned_by_the_rope_that_sticks_to_it():
    """A free drum with a load on one side and a spring-held end on the other: stuck rope turns it, as a gear would."""
    R, m, I, mu = 0.5, 50.0, 40.0, 1.0
    bodies = (Body("drum", 1.0, inertia=((I, 0, 0), (0, I, 0), (0, 0, I))), Body("load", m))
    joints = (
        Joint("pin", "revolute", "world", "drum", axis=Y),
        Joint("guide", "prismatic", "world", "load", (R, 0.0, -3.0), axis=Z),
    )
    T = 0.5 * m * G  # half of what it will carry
    EA = 1e6
    rope = Reeving(
        "r",
        Point("world", (-R, 0.0, -3.0)),
        (Sheave(Point("drum"), Y, R, mu),),
        LOAD,
        EA,
        InputSignal((6 + pi * R) / (1 + T / EA)),
    )
    s = started(System(bodies, joints, forces=(rope,), gravity=G), tolerance=1e-12, sample_ns=FINE["sample_ns"])
    s.run(2 * SECOND)
    assert events(s) == []
    assert imbalance(s) < CLOSES
    _, q = column(s, "joint/position")
    assert np.abs(q[:, 1] + R * q[:, 0]).max() < 0.01, "load down, drum round"


def test_machine_code_and_interpreted_python_agree_on_ropes_over_sheaves():
    native, oracle = (
        started(atwood(200.0, 120.0, 0.1, 1.0), native=n, tolerance=1e-8, h_max=0.01) for n in (True, False)
    )
    for s in (native, oracle):
        s.interrupt(SECOND // 20)
    assert [e for e in events(native)] == [e for e in events(oracle)] == [("rope", "slip")]
    assert native.row().shown == pytest.approx(oracle.row().shown, rel=1e-11)
    assert native.row().accounts == pytest.approx(oracle.row().accounts, rel=1e-9)
