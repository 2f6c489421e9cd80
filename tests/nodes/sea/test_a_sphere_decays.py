"""A sphere that is let go in still water, as in the heave decay of IEA OES Task 10, against its frequency domain.

Radius 5 m, 261.8 t, afloat to its middle on deep water of 1000 kg/m3 (Wendt et al., EWTEC 2017; Kramer et al., Energies
14 (2021) 269 is its model). Added mass and damping are Hulme's (J. Fluid Mech. 121 (1982) 443-463, table 1), in 2/3 rho
pi R^3 and that times w. The reference needs no memory: the spectrum of the speed after a release at x0 is
-C x0 / (C - w^2 (M + A) + i w B) (Cummins; Ogilvie), transformed back by quadrature.
"""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.kernel.analysis import linear_model, modes
from heavylift.kernel.description import Body, Joint, JointSpring, Point, Radiation, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.sea import CoupledModes, StateSpace
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

R, MASS, RHO, G = 5.0, 261.8e3, 1000.0, 9.81
DISPLACED, STIFFNESS = 2.0 / 3.0 * np.pi * RHO * R**3, np.pi * RHO * G * R**2
KA = [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0,
      7.0, 8.0, 9.0, 10.0]  # fmt: skip
ADDED = [0.8310, 0.8764, 0.8627, 0.7938, 0.7157, 0.6452, 0.5861, 0.5381, 0.4999, 0.4698, 0.4464, 0.4284, 0.4047, 0.3924,
         0.3871, 0.3864, 0.3884, 0.3988, 0.4111, 0.4322, 0.4471, 0.4574, 0.4647, 0.4700, 0.4740, 0.4771]  # fmt: skip
DAMPING = [0.0, 0.1036, 0.1816, 0.2793, 0.3254, 0.3410, 0.3391, 0.3271, 0.3098, 0.2899, 0.2691, 0.2484, 0.2096, 0.1756,
           0.1469, 0.1229, 0.1031, 0.0674, 0.0452, 0.0219, 0.0116, 0.0066, 0.0040, 0.0026, 0.0017, 0.0012]  # fmt: skip
FIT = 0.01  # of the first displacement: the fit of the memory misses 2 % of the largest coefficient at most
ROUNDING = 1e-6  # relative


@pytest.fixture(scope="module")
def water() -> StateSpace:
    w = np.sqrt(np.array(KA[1:]) * G / R)
    A, B = DISPLACED * np.array(ADDED[1:]), DISPLACED * w * np.array(DAMPING[1:])
    whole = np.zeros((2, len(w), 6, 6))
    whole[:, :, 2, 2] = A, B
    return CoupledModes(w, *whole, 0.5 * DISPLACED * np.eye(6), [2]).fitted()


def sphere(water: StateSpace, x0: float) -> Simulation:
    """The sphere on a vertical guide, let go at x0 [m] above its rest."""
    rows = np.zeros((len(water.F), 6))
    size = np.sqrt(DISPLACED * np.sqrt(G / R) * np.max(np.sqrt(KA) * DAMPING))  # by which a fit scales its damping
    rows[:, 2] = water.G[:, 0] * size
    memory = Radiation("water", Point("sphere"), tuple(map(tuple, water.F)), tuple(map(tuple, rows)))
    added = tuple(tuple(row) for row in (0.5 * DISPLACED * np.diag([0, 0, 1.0, 0, 0, 0])).tolist())
    third = 0.4 * MASS * R * R
    body = Body("sphere", MASS, inertia=tuple(map(tuple, np.diag([third] * 3).tolist())), added=added)
    guide = Joint("heave", "prismatic", "world", "sphere", axis=(0.0, 0.0, 1.0), q0=(x0,))
    s = Simulation(
        System((body,), (guide,), springs=(JointSpring("C", "heave", STIFFNESS),), forces=(memory,), gravity=0.0), 1e-9
    )
    s.start()
    return s


def decay(t: float) -> float:
    """Height at a time t [s] after a release at 1 m, from Hulme's numbers."""
    added, damping = (CubicSpline(KA, x) for x in (ADDED, DAMPING))

    def part(w: float) -> float:
        ka = w * w * R / G
        A = float(added(ka)) if ka < KA[-1] else 0.5 - (0.5 - ADDED[-1]) * KA[-1] / ka
        B = float(damping(ka)) if ka < KA[-1] else 0.0
        V = -STIFFNESS / (STIFFNESS - w * w * (MASS + DISPLACED * A) + 1j * w * w * DISPLACED * B)
        return V.real * np.sin(w * t) / w

    return 1.0 + 2.0 / np.pi * quad(part, 1e-9, 40.0, limit=2000)[0]


def test_the_heave_decay_of_a_sphere_agrees_with_its_frequency_domain_solution(water: StateSpace) -> None:
    s = sphere(water, 1.0)
    for t in np.arange(0.5, 20.1, 0.5):
        s.interrupt(round(t * 1e9))
        assert float(s.row().q[0]) == pytest.approx(decay(t), abs=FIT)


def test_a_ball_released_from_a_height_five_times_as_large_moves_five_times_as_far(water: StateSpace) -> None:
    """Let go at 5 m, a linear model moves five times as far as from 1 m."""
    one, five = sphere(water, 1.0), sphere(water, 5.0)
    for s in (one, five):
        s.interrupt(round(7.3e9))
    assert float(five.row().q[0]) == pytest.approx(5.0 * float(one.row().q[0]), rel=ROUNDING)


def test_the_natural_period_of_a_sphere_follows_from_its_added_mass(water: StateSpace) -> None:
    """The mode of the linear model and that of `modes` are one; without damping w^2 (M + A(w)) = C, which it raises by
    zeta^2."""
    s = sphere(water, 0.0)
    A = linear_model(s, [], ["joint/position/*"]).A
    (mode,) = modes(s).oscillations
    w = 2.0 * np.pi * mode.frequency
    found = [x for x in np.linalg.eigvals(A) if x.imag > 0.0]
    nearest = min(found, key=lambda x: abs(abs(x) - w))
    assert (abs(nearest), -nearest.real / abs(nearest)) == pytest.approx((w, mode.damping), rel=ROUNDING)
    added = CubicSpline(KA, ADDED)
    want = brentq(lambda x: x * x * (MASS + DISPLACED * float(added(x * x * R / G))) - STIFFNESS, 1.0, 2.0)
    assert w == pytest.approx(want, rel=mode.damping**2)
