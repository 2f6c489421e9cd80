"""A slider on a modal beam: the moving force of Fryba (1972), and a heavy trolley against 60 finite elements."""

from dataclasses import replace
from math import pi, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Beam, Body, Drive, Flexible, Joint, Load, Point, Stop, System
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.multibody.flexible import beam_matrices, hermite
from heavylift.kernel.simulation import Simulation
from scipy.linalg import lu_factor, lu_solve
from small_scenes import SECOND, G, column, hand_over, imbalance, started

LENGTH, EI, GIRDER = 150.0, 4137180468750.0, 2.5e6
SPEED = 30.0  # fast: it crosses in 5.5 periods of the girder
CLOSE = 0.005  # of the largest deflection
TROLLEY = 9.0e5
GIRDER_BODY = Body(
    "girder", 0.0, flexible=Flexible(5, Beam(LENGTH, GIRDER / LENGTH, EI_y=EI), frame="simply supported")
)


def crane(trolley: float, drive: bool = True, **system) -> System:
    """A girder with a trolley that starts at its left end."""
    joints = (Joint("legs", "fixed", "world", "girder"), Joint("rail", "slider", "girder", "trolley"))
    drives = (Drive("drive", "rail", "prescribed"),) if drive else ()
    return System((GIRDER_BODY, Body("trolley", trolley)), joints, drives=drives, **system)


def crossing(system: System):
    """Times and deflections of midspan while the trolley crosses at constant speed."""
    s = started(system, tolerance=1e-8, sample_ns=20_000_000, h_max=0.01)
    s.references.set_profile("drive", 0, SPEED, 1e7, LENGTH)
    s.settle()
    s.run(int(0.98 * LENGTH / SPEED * SECOND))
    t, q = column(s, "joint/position")
    link = s.program.graph.links[s.program.graph.number("girder")]
    return t, q[:, link.q_modes] @ link.modes.at(LENGTH / 2)[2]


def test_the_deflection_of_a_girder_under_a_moving_force_agrees_with_theory():
    """w = sum of 2 P/(m L) sin(n pi x/L) (sin W_n t - W_n/w_n sin w_n t)/(w_n^2 - W_n^2), W_n = n pi v/L."""
    P, mu = 9.0e6, GIRDER / LENGTH
    force = Load("weight", Point("trolley"), (0.0, 0.0, -P))
    t, w = crossing(crane(0.0, forces=(force,), gravity=0.0))

    def series(time):
        total = 0.0
        for n in range(1, 40, 2):
            wn, Wn = (n * pi / LENGTH) ** 2 * sqrt(EI / mu), n * pi * SPEED / LENGTH
            swing = (np.sin(Wn * time) - Wn / wn * np.sin(wn * time)) / (wn**2 - Wn**2)
            total = total - 2 * P / GIRDER * sin(n * pi / 2) * swing
        return total

    want = series(t)
    assert np.abs(want).max() > 0.15, "more than the static deflection"
    assert np.abs(w - want).max() < CLOSE * np.abs(want).max()


def sixty_elements(mass: float, times: np.ndarray) -> np.ndarray:
    """Midspan under a moving mass by Newmark's trapezoidal rule on 60 elements: nothing modal, nothing floating.

    (M + m N N^T) q" + m v (2 N N_x^T) q' + (K + m v^2 N N_xx^T) q = -m g N, N the shapes at x = v t.
    """
    beam = Beam(LENGTH, GIRDER / LENGTH, EI_y=EI, elements=60)
    M, K = beam_matrices(beam)
    at = [d for d in range(len(M)) if d % 6 in (2, 4) and d not in (2, len(M) - 4)]
    M, K = M[np.ix_(at, at)], K[np.ix_(at, at)]

    def shapes(x):
        d = 1e-4 * LENGTH / 60
        N = hermite(beam, x)[:, at]
        return N[2], -N[4], (hermite(beam, x - d)[4, at] - hermite(beam, x + d)[4, at]) / (2 * d)

    h = times[1] - times[0]
    q, v, own = np.zeros(len(at)), np.zeros(len(at)), -G * mass_of_gravity(beam)[at]
    N = shapes(0.0)[0]
    a, out = np.linalg.solve(M + mass * np.outer(N, N), own - mass * G * N), [0.0]
    middle = hermite(beam, LENGTH / 2)[2, at]
    for time in times[1:]:
        N, N_x, N_xx = shapes(SPEED * time)
        effective = M + mass * np.outer(N, N)
        C = 2.0 * mass * SPEED * np.outer(N, N_x)
        stiff = K + mass * SPEED**2 * np.outer(N, N_xx)
        q_p, v_p = q + h * v + h * h / 4 * a, v + h / 2 * a
        factor = lu_factor(effective + h / 2 * C + h * h / 4 * stiff)
        a = lu_solve(factor, own - mass * G * N - C @ v_p - stiff @ q_p)
        q, v = q_p + h * h / 4 * a, v_p + h / 2 * a
        out.append(float(middle @ q))
    return np.array(out)


def mass_of_gravity(beam: Beam) -> np.ndarray:
    """Mass matrix times a unit displacement along z."""
    M, _ = beam_matrices(beam)
    up = np.zeros(len(M))
    up[2::6] = 1.0
    return M @ up


def test_the_deflection_of_a_girder_under_a_trolley_of_a_third_of_its_mass_agrees_with_theory():
    t, w = crossing(crane(TROLLEY, gravity=G))
    steps = np.linspace(0.0, t[-1], 2001)
    want = np.interp(t, steps, sixty_elements(TROLLEY, steps))
    assert np.abs(want).max() > 0.3
    assert np.abs(w - want).max() < CLOSE * np.abs(want).max()


def test_a_trolley_that_rolls_into_the_sag_conserves_the_energy_balance():
    """Undriven, it accelerates downhill; energy goes between its motion, its height and the girder."""
    system = crane(TROLLEY, drive=False, gravity=G)
    rail = replace(system.joints[1], q0=(50.0,))
    s = started(replace(system, joints=(system.joints[0], rail)), tolerance=1e-10, sample_ns=50_000_000, h_max=0.01)
    hand_over(s, 20 * SECOND)
    _, q = column(s, "joint/position")
    assert q[-1, -1] > 50.2, "downhill"
    assert imbalance(s) < 1e-8


def test_an_end_stop_holds_a_trolley_and_leaving_the_girder_is_reported():
    system = crane(TROLLEY, drive=False, gravity=G)
    joints = (system.joints[0], replace(system.joints[1], q0=(140.0,), v0=(10.0,)))
    stop = Stop("bumper", "rail", 1.0, 148.0, 5.0e7, 5.0e6)
    held = started(replace(system, joints=joints, stops=(stop,)), sample_ns=100_000_000)
    hand_over(held, 3 * SECOND)
    assert ("bumper", "closed") in [(e.name, e.what) for _, e in held.log]
    loose = started(replace(system, joints=joints), sample_ns=100_000_000)
    with pytest.raises(KernelError, match=r"slider 'rail' at 1.1.0 s: it has left its beam"):
        hand_over(loose, 3 * SECOND)


def test_a_joint_along_a_flexible_body_is_refused_if_the_body_is_not_a_beam():
    joint = Joint("rail", "slider", "world", "trolley")
    with pytest.raises(KernelError, match="joint 'rail': a slider needs a flexible beam; 'world' is rigid"):
        Program(System((Body("trolley", 1.0),), (joint,)))


def test_machine_code_and_interpreted_python_agree_on_a_slider():
    simulation = Simulation(crane(TROLLEY, drive=False, gravity=G), cache=False)
    random = np.random.default_rng(1)
    y = np.concatenate([random.normal(size=simulation.program.nv) * 0.1, random.normal(size=simulation.program.nv)])
    y[5] = 60.0
    simulation.state[: len(y)] = y
    simulation.native.call("refresh")
    native = simulation.X[simulation.method.layout.at["f"]][: len(y)]
    plain = evaluate(simulation.program, 0.0, simulation.state, simulation.program.parameters.initial).dy[: len(y)]
    plain = np.asarray(plain, float)
    assert native == pytest.approx(plain, rel=1e-11, abs=1e-11 * np.abs(plain).max())
