"""The mass of a straight, evenly stretched rope is shared by its two ends, without a body of its own."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import WORLD, Body, Drive, Joint, Line, Point, RigidRope, Rope, System
from heavylift.kernel.simulation import Simulation
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from small_scenes import SECOND, G, X, Z, column, hand_over, imbalance, started

M, OWN, L, K = 80e3, 5.6e3, 35.0, 2.0e7  # load, its rope [kg], length [m], stiffness [N/m]
SMALL = 1e-6  # relative: differences over 1e-4
SECOND_ORDER = (OWN / M) ** 2 / 10.0  # of a wave in the rope, which Rayleigh's quotient leaves out
CLOSES = 1e-8
SAME = 1e-7  # of the swing: both integrations have tolerances of 1e-10


def hung(rope, x: float = 0.0, z: float = -L) -> System:
    """A load on one rope; it moves along x and z."""
    slides = (
        Joint("x", "prismatic", WORLD, "carrier", axis=X, q0=(x,)),
        Joint("z", "prismatic", "carrier", "load", axis=Z, q0=(z,)),
    )
    rigid = isinstance(rope, RigidRope)
    ropes = {"rigid_ropes": (rope,)} if rigid else {"ropes": (rope,)}
    return System((Body("carrier", 0.0), Body("load", M)), slides, gravity=G, **ropes)


LINE = (Line(Point(WORLD), Point("load")),)
ELASTIC = Rope("rope", LINE, K * L, L, mass=OWN)
RIGID = RigidRope("rope", LINE, L, mass=OWN)


def frequencies(system: System) -> list[float]:
    """Of its small motions [rad/s], slowest first."""
    s = started(system)
    equilibrium(s)
    return sorted(2.0 * pi * m.frequency for m in modes(s).oscillations)


def test_one_third_of_the_rope_mass_moves_with_the_load_in_axial_vibration():
    """Rayleigh's quotient; the exact frequency is that of u tan u = m_rope / m, u = w sqrt(m_rope / k)."""
    axial = frequencies(hung(ELASTIC))[1]
    assert axial == pytest.approx(sqrt(K / (M + OWN / 3.0)), rel=SMALL)
    exact = brentq(lambda u: u * np.tan(u) - OWN / M, 1e-6, 1.0) * sqrt(K / OWN)
    assert axial == pytest.approx(exact, rel=SECOND_ORDER)


def test_a_heavy_rope_swings_as_a_rod_with_a_load_at_its_end():
    stretched = L + (M + OWN / 2.0) * G / K
    want = sqrt(G / stretched * (M + OWN / 2.0) / (M + OWN / 3.0))
    assert frequencies(hung(ELASTIC))[0] == pytest.approx(want, rel=SMALL)


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
def test_the_reported_tension_of_a_heavy_rope_is_that_at_the_hook(rope):
    stretched = L + (M + OWN / 2.0) * G / K if rope is ELASTIC else L
    s = started(hung(rope, z=-stretched))
    _, tension = column(s, "rope/tension")
    assert tension[0, 0] == pytest.approx(M * G, rel=1e-9)


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
def test_the_energy_balance_of_a_lift_includes_the_mass_of_its_ropes(rope):
    far = 0.2 * L
    s = started(hung(rope, x=far, z=-sqrt(L**2 - far**2)), tolerance=1e-10, sample_ns=50_000_000)
    hand_over(s, 10_000_000_000)
    assert imbalance(s) < CLOSES


def turned(angle: float) -> tuple[tuple[float, float, float], ...]:
    """The rotation by an angle [rad] about the vertical."""
    return ((cos(angle), -sin(angle), 0.0), (sin(angle), cos(angle), 0.0), (0.0, 0.0, 1.0))


def length(rope) -> float:
    """At rest [m]."""
    return L if isinstance(rope, RigidRope) else L + (M + OWN / 2.0) * G / K


def below_a_trolley(rope, draw: np.random.Generator, kind: str) -> tuple[System, np.ndarray]:
    """A load on one rope below a trolley, whose rail and axes are turned at random; the direction of its rail."""
    rail, axes = draw.uniform(-pi, pi, 2)
    joints = (
        Joint("rail", "prismatic", WORLD, "trolley", R_PJ=turned(rail), axis=X, R_CJ=turned(axes)),
        Joint("free", "free", WORLD, "load", q0=(0.0, 0.0, -length(rope), 0.0, 0.0, 0.0, 1.0)),
    )
    a, b = draw.permutation(["trolley", "load"]).tolist()
    rope = replace(rope, lines=(Line(Point(a), Point(b)),))
    round_ = ((M, 0.0, 0.0), (0.0, M, 0.0), (0.0, 0.0, M))
    w = 2.0 * pi * draw.uniform(0.5, 5.0)  # of a servo [rad/s]
    drive = Drive("traverse", "rail", kind, **({"kp": M * w**2, "kv": M * w} if kind == "servo" else {}))
    bodies = (Body("trolley", M), Body("load", M, inertia=round_))
    ropes = {"rigid_ropes": (rope,)} if isinstance(rope, RigidRope) else {"ropes": (rope,)}
    return System(bodies, joints, gravity=G, drives=(drive,), **ropes), np.array([cos(rail), sin(rail), 0.0])


def travelled(system: System, speed: float, accel: float, by: float) -> Simulation:
    """After 16 s, in which a trolley has moved."""
    s = started(system, tolerance=1e-10, sample_ns=50_000_000)
    s.references.set_profile("traverse", 0, speed, accel, by)
    s.settle()
    hand_over(s, 16 * SECOND)
    return s


RAMPS = [(seed, *np.random.default_rng(seed).uniform((0.2, 0.1, 1.0), (0.6, 0.4, 3.0)).tolist()) for seed in range(4)]


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
@pytest.mark.parametrize(("seed", "speed", "accel", "by"), RAMPS)
def test_a_driven_trolley_swings_a_load_as_the_kinetic_energy_of_an_even_rope_demands(rope, seed, speed, accel, by):
    """Lagrange's equations of (M v.v + m (u.u + u.v + v.v)/3)/2 with the trolley's u given, integrated by SciPy."""
    system, rail = below_a_trolley(rope, np.random.default_rng(seed), "prescribed")
    q = travelled(system, speed, accel, by).row().q
    ramp = min(speed / accel, sqrt(by / accel))
    stop = by / (accel * ramp)
    ramps = [(0.0, ramp, accel), (ramp, stop, 0.0), (stop, stop + ramp, -accel), (stop + ramp, 16.0, 0.0)]
    moves, weighs, drives = M + OWN / 3.0, M + OWN / 2.0, OWN / 6.0

    def elastic(t, x, a):
        r = np.array(x[:2])  # of the load, from the trolley
        l = sqrt(r @ r)
        f = -K * max(l - L, 0.0) / l * r - weighs * G * np.array([0.0, 1.0]) - drives * np.array([a, 0.0])
        return [*x[2:], *(f / moves - np.array([a, 0.0]))]

    def rigid(t, x, a):
        return [x[1], -(weighs * G * sin(x[0]) + (moves + drives) * a * cos(x[0])) / (moves * L)]

    slope, x = (elastic, [0.0, -length(rope), 0.0, 0.0]) if rope is ELASTIC else (rigid, [0.0, 0.0])
    for start, end, a in ramps:
        x = solve_ivp(slope, (start, end), x, args=(a,), method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    want = [x[0], x[1]] if rope is ELASTIC else [L * sin(x[0]), -L * cos(x[0])]
    largest = speed * sqrt(L / G)
    assert [q[1:4] @ rail - by, q[3]] == pytest.approx(want, abs=SAME * largest)


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
@pytest.mark.parametrize("kind", ["prescribed", "servo"])
@pytest.mark.parametrize(("seed", "speed", "accel", "by"), RAMPS)
def test_the_work_of_a_drive_includes_the_work_done_on_the_mass_of_a_rope(rope, kind, seed, speed, accel, by):
    system, _ = below_a_trolley(rope, np.random.default_rng(seed), kind)
    assert imbalance(travelled(system, speed, accel, by)) < CLOSES


def test_a_rope_that_is_not_hooked_moves_no_body():
    system, _ = below_a_trolley(replace(ELASTIC, hooked=False), np.random.default_rng(1), "prescribed")
    assert np.allclose(travelled(system, 0.5, 0.2, 2.0).row().q[1:3], 0.0)


def test_a_rope_without_mass_needs_fewer_operations_than_a_rope_with_mass():
    def operations(rope):
        return len(Simulation(hung(rope)).method.f_rate.nodes)

    assert operations(replace(ELASTIC, mass=0.0)) < operations(ELASTIC)


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
def test_ropes_with_mass_and_ropes_without_mass_have_separate_compiled_code(rope):
    with_mass, without = (Simulation(hung(r), native=False).native.structure for r in (rope, replace(rope, mass=0.0)))
    assert with_mass != without


@pytest.mark.parametrize(("change", "told"), [
    ({"mass": -1.0}, "mass"),
    ({"lines": (Line(Point(WORLD), Point("load"), 0.5),)}, "let their shares add up to 1"),
])  # fmt: skip
def test_an_invalid_mass_of_a_rope_is_refused(change, told):
    with pytest.raises(KernelError, match=told):
        Simulation(hung(replace(ELASTIC, **change)))
