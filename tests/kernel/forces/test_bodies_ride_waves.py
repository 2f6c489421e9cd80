"""Bodies in regular waves: motion that is given, added mass, and the linear response of a body that floats."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Bushing, Drive, InputSignal, Joint, Load, Point, System, Wave
from heavylift.kernel.equations import equations
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.simulation import Simulation
from scipy.integrate import solve_ivp
from small_scenes import SECOND, G, cube, hand_over, started

PERIOD, RAMP = 9.0, 20.0
W = 2.0 * np.pi / PERIOD
MOTIONS = {  # amplitude [m, rad] and phase [rad]
    "surge": (0.4, 0.3), "sway": (0.2, -1.0), "heave": (0.7, 0.1), "yaw": (0.01, 2.0), "pitch": (0.02, -0.5),
    "roll": (0.05, 1.2),
}  # fmt: skip
AXES = dict(zip(MOTIONS, ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0), (0, 0, 1.0), (0, 1.0, 0), (1.0, 0, 0)), strict=True))
TIP = (10.0, 30.0, 55.0)


def given() -> System:
    """A barge that six prescribed joints move, with a load of 100 t on a spring below the tip of its crane."""
    names = list(MOTIONS)
    bodies = [Body(name, 0.0) for name in names[:-1]] + [Body("barge", 1.4e7, (0.0, 0.0, 2.0), cube(1.4e7, 40.0))]
    joints = [
        Joint(n, "prismatic" if i < 3 else "revolute", ["world", *names][i], bodies[i].name, axis=AXES[n], q0=(0.0,))
        for i, n in enumerate(names)
    ]
    drives = [Drive(f"{n}.drive", n, "prescribed", wave=Wave(a, W, RAMP, p)) for n, (a, p) in MOTIONS.items()]
    load = Body("load", 1e5, inertia=cube(1e5))
    free = Joint("free", "free", "world", "load", q0=(*TIP[:2], 25.0, 0.0, 0.0, 0.0, 1.0))
    k = np.diag([4e5, 4e5, 4e6, 1e7, 1e7, 1e7])
    hung = Bushing(
        "fall", Point("barge", TIP), Point("load", (0.0, 0.0, 30.0 - 1e5 * G / 4e6)), _rows(k), _rows(0.02 * k)
    )
    return System((*bodies, load), (*joints, free), drives=tuple(drives), forces=(hung,))


def _rows(A: np.ndarray) -> tuple:
    return tuple(map(tuple, A.tolist()))


def _turn(axis: str, q: float) -> np.ndarray:
    c, s = np.cos(q), np.sin(q)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def _tip(t: float) -> np.ndarray:
    """Where the tip is, by formula."""
    u = min(t / RAMP, 1.0)
    q = {n: u**3 * (10 - 15 * u + 6 * u * u) * a * np.cos(W * t + p) for n, (a, p) in MOTIONS.items()}
    R = _turn("z", q["yaw"]) @ _turn("y", q["pitch"]) @ _turn("x", q["roll"])
    return np.array([q["surge"], q["sway"], q["heave"]]) + R @ TIP


@pytest.mark.parametrize("t", [0.0, 7.3, 20.0, 71.9])
def test_the_tip_of_a_crane_on_a_vessel_moves_by_the_given_vessel_motion(t):
    """Place, velocity and acceleration of a point of a vessel whose motion is given, within and after the ramp."""
    program = Program(given())
    P = program.parameters.initial.copy()
    P[program.parameters.at["clock", ""]] = t
    x = evaluate(program, 0.0, program.initial_state(), P)
    R, o, r, V = np.reshape(x.ends[program.graph.number("barge")], -1)[:21].astype(float), 0, 0, 0
    R, o, r, V = R[:9].reshape(3, 3), R[9:12], R[12:15], R[15:]
    h = 1e-3
    before, here, after = (_tip(t + d) if t + d > 0.0 else np.array(TIP) for d in (-h, 0.0, h))
    place = o + r + R @ TIP
    assert np.abs(place - here).max() < 1e-12
    velocity = V[3:] + np.cross(V[:3], r + R @ TIP)
    assert np.abs(velocity - (after - before) / (2 * h)).max() < 2e-7
    names = [k.body.name for k in program.graph.links]
    a = np.array([float(x.references[f"{n}.drive"][2]) for n in MOTIONS])
    want = [_second(n, t) for n in MOTIONS]
    assert names[:5] == list(MOTIONS)[:5]
    assert a == pytest.approx(want, abs=1e-12)


def _second(name: str, t: float) -> float:
    """The second derivative of a motion, by a complex step of its first one."""
    a, p = MOTIONS[name]

    def rate(t: complex) -> complex:
        u = t / RAMP if t.real < RAMP else 1.0
        r, dr = u**3 * (10 - 15 * u + 6 * u * u), 30 * u * u * (1 - u) ** 2 / RAMP if t.real < RAMP else 0.0
        return a * (dr * np.cos(W * t + p) - r * W * np.sin(W * t + p))

    return float(rate(t + 1e-30j).imag / 1e-30)


def test_the_drives_that_move_a_vessel_supply_all_its_energy():
    """What the load and the barge gain and the damper takes is the work of the six drives, to 1e-9 of it."""
    s = started(given(), tolerance=1e-9)
    start = s.row()
    hand_over(s, 40 * SECOND)
    row = s.row()
    works = {n: x for (what, n), x in zip(s.program.accounts, row.accounts, strict=True) if what == "work"}
    assert set(works) == {f"{n}.drive" for n in MOTIONS}
    assert abs(_balance(s, row) - _balance(s, start)) < 1e-7 * sum(map(abs, works.values()))


def _balance(s: Simulation, row) -> float:
    signs = [1.0 if what == "heat" else -1.0 for what, _ in s.program.accounts]
    gained = sum(sign * float(x) for sign, x in zip(signs, row.accounts, strict=True))
    return float(row.kinetic + row.potential + sum(row.stored)) + gained


ADDED = np.diag([3.0, 8.0, 12.0, 5.0, 7.0, 2.0]) + 0.5
SLENDER = Body("hull", 4.0, (0.1, 0.0, -0.2), ((3.0, 0.1, 0.0), (0.1, 4.0, 0.0), (0.0, 0.0, 5.0)), added=_rows(ADDED))


def rigid(body: Body) -> np.ndarray:
    """(6, 6) rigid-body inertia about the origin, linear before angular."""
    c = np.array([[0, -body.com[2], body.com[1]], [body.com[2], 0, -body.com[0]], [-body.com[1], body.com[0], 0]])
    m = body.mass
    return np.block([[m * np.eye(3), -m * c], [m * c, np.array(body.inertia) - m * c @ c]])


def test_a_body_in_an_ideal_fluid_follows_kirchhoffs_equations():
    """Twist after 3 s of a tumbling body with a full added mass, against Kirchhoff's equations by SciPy."""
    v0 = (0.5, -0.2, 0.1, 0.3, 0.7, -0.4)
    free = Joint("free", "free", "world", "hull", q0=(0.0,) * 6 + (1.0,), v0=v0)
    s = started(System((SLENDER,), (free,), gravity=0.0), tolerance=1e-11)
    hand_over(s, 3 * SECOND)
    M = rigid(SLENDER) + ADDED

    def rate(t, v):
        p = M @ v
        return np.linalg.solve(
            M, -np.concatenate([np.cross(v[3:], p[:3]), np.cross(v[3:], p[3:]) + np.cross(v[:3], p[:3])])
        )

    there = solve_ivp(rate, (0.0, 3.0), v0, rtol=1e-12, atol=1e-13).y[:, -1]
    assert np.asarray(s.row().v) == pytest.approx(there, abs=1e-8)
    assert float(s.row().kinetic) == pytest.approx(0.5 * np.array(v0) @ M @ v0, rel=1e-9)


@pytest.mark.parametrize("formulation", ["recursive", "articulated", "embedding", "augmented"])
def test_added_mass_resists_acceleration_and_has_no_weight(formulation):
    """Let go in gravity, a body starts with (M + A)^-1 times its own weight, by every formulation."""
    free = Joint("free", "free", "world", "hull", q0=(1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0))
    program = Program(System((SLENDER,), (free,)), formulation)
    x = evaluate(program, 0.0, program.initial_state(), program.parameters.initial)
    weight = rigid(SLENDER) @ [0.0, 0.0, -G, 0.0, 0.0, 0.0]
    want = np.linalg.solve(rigid(SLENDER) + ADDED, weight)
    assert np.array(x.dv, float) == pytest.approx(want, rel=1e-9, abs=1e-12)


def test_a_floating_body_responds_to_waves_as_its_frequency_domain_equations_predict():
    """Amplitude and phase of all six motions: x = (K - w^2 (M + A) + i w B)^-1 F, with full A and B, by NumPy."""
    m = 1.2e7
    hull = Body("hull", m, (0.5, 0.0, 1.0), ((1.2e9, 0.0, 0.0), (0.0, 6e9, 0.0), (0.0, 0.0, 6.5e9)))
    A = np.diag([1e6, 6e6, 1.1e7, 6e8, 5e9, 2e9])
    A[1, 3] = A[3, 1] = -9e6
    A[0, 4] = A[4, 0] = 4e6
    B = np.diag([1e6, 3e6, 6e6, 2.5e8, 3e9, 8e8])
    B[2, 4] = B[4, 2] = 2e6
    K = np.diag([2e6, 2e6, 1.8e7, 9e8, 9e9, 4e8])
    F = 0.01 * np.array([1e6 * np.exp(0.3j), 2e6 * np.exp(-1j), 9e6, 8e7 * np.exp(2j), 9e8 * np.exp(-0.5j), 5e7])
    loads = []
    for name, part, phase in (("cos", F.real, 0.0), ("sin", F.imag, 0.5 * np.pi)):
        wave = InputSignal(0.0, wave=Wave(1.0, W, RAMP, phase))
        loads.append(Load(name, Point("hull"), tuple(part[:3].tolist()), tuple(part[3:].tolist()), signal=wave))
    lift = Load("buoyancy", Point("hull", hull.com), (0.0, 0.0, m * G))
    water = Bushing("water", Point("world"), Point("hull"), _rows(K), _rows(B))
    free = Joint("free", "free", "world", "hull", q0=(0.0,) * 6 + (1.0,))
    system = System((replace(hull, added=_rows(A)),), (free,), forces=(*loads, lift, water))
    s = started(system, tolerance=1e-9)
    n = 40
    found = np.zeros(6, complex)
    for i in range(n):  # one more period, in n parts
        t = PERIOD * (4 * n + i / n)
        hand_over(s, round(t * SECOND))
        row = s.row()
        s.settle()
        q = np.array([*row.q[:3], *(2.0 * x for x in row.q[3:6])])
        found += 2.0 / n * q * np.exp(-1j * W * t)
    want = np.linalg.solve(K - W * W * (rigid(hull) + A) + 1j * W * B, F)
    assert np.abs(found - want).max() < 2e-4 * np.abs(want).max()


def test_printed_equations_contain_added_mass():
    """Of the body that has an added mass, in both forms of its equations."""
    free = Joint("free", "free", "world", "hull", q0=(0.0,) * 6 + (1.0,))
    message = equations(System((SLENDER,), (free,)))
    assert "the water takes A a + v x* (A v) of its added mass A: of hull" in message
    assert "added mass of the water, on which g does not act: of hull" in message


def test_a_drive_that_is_not_prescribed_cannot_follow_a_wave():
    """Others are a sentence, as is a wave without a ramp."""
    distances = {"servo": 1.0, "prescribed": 0.0}
    for kind, ramp in distances.items():
        system = replace(given(), drives=(Drive("d", "heave", kind, 1.0, 1.0, wave=Wave(1.0, W, ramp)),))
        with pytest.raises(
            KernelError, match=r"drive .d.: (only prescribed drives can follow a wave|it has a wave with a ramp)"
        ):
            Program(system)
