"""Tolerances scale with the size of motion: closed forms from a nanometre to a hundred metres.

Once anything has moved at 1 cm/s the tolerance is that of a metre; below, it is that part of it.  A scene whose whole
motion is below a nanometre or so rests as before, and so does a stiff one that only its rounding moves.
"""

from dataclasses import replace
from math import cos, exp, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, JointSpring, Line, Point, Rope, System
from heavylift.kernel.islands import Islands
from heavylift.kernel.simulation import Simulation
from scipy_peers import PEERS
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, Y, column, hand_over, hung, slider, started

AMPLITUDES = [10.0**n for n in range(-9, 3)]  # [m]
OMEGA, ZETA = 6.0, 0.01  # [rad/s]; 28 swings in END leave 0.16 of the amplitude
END = 30
FOLLOWED = 2e-3  # of the first amplitude: 180 rad at 1e-5 each, that is a hundred times the tolerance
METHODS = {m: FOLLOWED for m in ("dopri5", "dop853", "radau5")}
SWING_OF_60_M = sqrt(G / 60.0)  # [rad/s]
SAME = 1e-12  # of the amplitude, between steps in machine code and on floats


def oscillator(amplitude: float, omega: float = OMEGA, zeta: float = ZETA, at: float = 0.0, name: str = "x") -> System:
    """A ton on a spring that is let go `amplitude` beside its place of rest, which is `at`."""
    spring = JointSpring(name, f"{name}-guide", 1e3 * omega**2, 2.0 * zeta * 1e3 * omega, at)
    return replace(slider(name, 1e3, X, at + amplitude), springs=(spring,), gravity=0.0)


def let_go(t: float, omega: float = OMEGA, zeta: float = ZETA) -> float:
    """Part of the amplitude where the oscillator is after t."""
    w = omega * sqrt(1.0 - zeta**2)
    return exp(-zeta * omega * t) * (cos(w * t) + zeta * omega / w * sin(w * t))


def after(scene: System, seconds: float = END, **options) -> Simulation:
    s = started(scene, **options)
    hand_over(s, round(seconds * SECOND))
    return s


@pytest.mark.parametrize("at", [0.0, 60.0])
@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_a_tiny_oscillation_keeps_its_amplitude_and_frequency(amplitude, at):
    end = (float(after(oscillator(amplitude, at=at)).state[0]) - at) / amplitude
    rounding = 1e3 * 2.0**-52 * at / amplitude
    assert end == pytest.approx(let_go(END), abs=FOLLOWED + rounding)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("amplitude", [1e-8, 1e-4])
def test_a_tiny_oscillation_is_resolved_by_every_method_with_error_control(method, amplitude):
    end = float(after(oscillator(amplitude), method=method).state[0]) / amplitude
    assert end == pytest.approx(let_go(END), abs=METHODS[method])


@pytest.mark.parametrize("method", sorted(set(PEERS) & {"scipy-dop853", "scipy-radau"}))
def test_scipy_methods_resolve_an_oscillation_of_tiny_amplitude(method):
    end = float(after(oscillator(1e-8), 3.0, method=method).state[0]) / 1e-8
    assert end == pytest.approx(let_go(3.0), abs=FOLLOWED)


@pytest.mark.parametrize("omega", [0.4, 100.0])
def test_oscillations_of_tiny_amplitude_are_resolved_at_low_and_high_frequencies(omega):
    end = float(after(oscillator(1e-8, omega), 180.0 / omega).state[0]) / 1e-8
    assert end == pytest.approx(let_go(180.0 / omega, omega), abs=FOLLOWED)


@pytest.mark.parametrize("angle", [10.0**n for n in range(-9, -3)])
def test_a_tiny_swing_of_a_pendulum_of_60_m_is_resolved(angle):
    """Four swings of 15.5 s; of its finite angle's detour it feels a sixteenth of the square."""
    hinge = Joint("hinge", "revolute", "world", "bob", axis=Y, q0=(angle,))
    s = after(System((Body("bob", 1e3, (0.0, 0.0, -60.0)),), (hinge,), gravity=G), 60.0)
    assert float(s.state[0]) / angle == pytest.approx(cos(SWING_OF_60_M * 60.0), abs=1e-4)


def test_a_tiny_bounce_of_a_load_on_its_rope_is_resolved():
    """C07a's load a micrometre below its rest, which lies 60 m below the origin."""
    rest = LENGTH * (1.0 + MASS * G / EA)
    omega = sqrt(EA / LENGTH / MASS)
    s = after(hung(rest + 1e-6), 10.0)
    assert (-float(s.state[0]) - rest) / 1e-6 == pytest.approx(cos(omega * 10.0), abs=FOLLOWED)
    t, T = column(s, "rope/tension")
    expected = MASS * G + EA / LENGTH * 1e-6 * np.cos(omega * t)
    assert np.abs(T[:, 0] - expected).max() < FOLLOWED * EA / LENGTH * 1e-6


def test_tiny_motions_are_the_same_in_machine_code_and_interpreted_python():
    for amplitude in (1e-8, 1e-3):
        native, oracle = (after(oscillator(amplitude), 2.0, native=x) for x in (True, False))
        assert native.native.evaluations == oracle.native.evaluations
        assert float(native.state[0]) == pytest.approx(float(oracle.state[0]), abs=SAME * amplitude)


def test_a_swing_of_one_nanometre_needs_no_more_steps_than_a_swing_of_one_metre():
    """Down to a nanometre a swing costs no more than one of a metre does."""
    swift = after(oscillator(1.0)).native.evaluations
    assert all(after(oscillator(a)).native.evaluations < swift for a in AMPLITUDES if a < 1.0)


def test_motion_as_small_as_rounding_errors_counts_as_rest():
    for stiffer in (1.0, 100.0, 1e4):
        rest = LENGTH * (1.0 + MASS * G / (stiffer * EA))
        scene = hung(rest)
        s = started(replace(scene, ropes=(replace(scene.ropes[0], EA=stiffer * EA),)))
        s.run(60 * SECOND)
        assert s.native.evaluations < 20, stiffer
    pinned = hung(LENGTH * (1.0 + MASS * G / (1e6 * EA)))
    s = started(replace(pinned, ropes=(replace(pinned.ropes[0], EA=1e6 * EA),)), method="radau5")
    s.run(5 * SECOND)
    assert s.native.evaluations < 2000, "8322 rad/s: not at rest, but in long steps"


def side_by_side() -> Islands:
    """A metre and a micrometre, and a long slack rope that could be hooked between them."""
    small, large = oscillator(1e-6, name="small"), oscillator(1.0, name="large")
    tie = Rope("tie", (Line(Point("small"), Point("large")),), EA, 100.0, hooked=False)
    parts = {k: getattr(small, k) + getattr(large, k) for k in ("bodies", "joints", "springs")}
    s = Islands(System(**parts, ropes=(tie,), gravity=0.0))
    s.start()
    s.run(END * SECOND)
    s.interrupt(END * SECOND)
    return s


def test_each_island_of_bodies_has_its_own_scale_of_the_integration_tolerance():
    s = side_by_side()
    s.settle()
    at = {p.given.bodies[0].name: p for p in s.parts}
    assert float(at["small"].state[0]) / 1e-6 == pytest.approx(let_go(END), abs=FOLLOWED)
    assert at["small"]["scale"] < 1e-2
    assert at["large"]["scale"] == 1.0


def test_two_islands_that_merge_continue_with_the_larger_scale_of_the_integration_tolerance():
    s = side_by_side()
    s.hook("tie")
    s.settle()
    (one,) = s.parts
    assert one["scale"] == 1.0


def test_a_snapshot_of_a_simulation_keeps_the_scale_of_the_integration_tolerance():
    s = started(oscillator(1e-7))
    s.run(5 * SECOND)
    kept = s.snapshot()
    s.run(END * SECOND)
    other = started(oscillator(1e-7))
    other.restore(kept)
    other.run(END * SECOND)
    assert other["scale"] == s["scale"] < 1e-3
    assert other.X.tobytes() == s.X.tobytes()
