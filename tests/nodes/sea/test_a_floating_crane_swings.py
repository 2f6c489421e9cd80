"""A load that swings below the boom of a floating crane: periods of the coupled pendulum and barge.

The reference is another formulation: the displacement of the barge's origin, its rotation vector and the displacement
of the load relative to the tip; the Hessian of the exact potential energy by differences, the kinetic energy by one
Jacobian, and the radiation in the frequency domain. A published case gives no figures that could be used here.
"""

from __future__ import annotations

from functools import cache
from random import Random

import numpy as np
import pytest
from heavylift.kernel.analysis import modes
from heavylift.kernel.description import WORLD, Body, Bushing, Joint, Load, Point, Radiation, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Hydrodynamics, read_hydrodynamics
from scipy.optimize import newton
from scipy.spatial.transform import Rotation

G, MOORED = 9.80665, (4e5, 4e5, 4e8)  # [N/m, N/m, N m]
INERTIA = np.diag([1.4e9, 15e9, 15e9])
STEP = 1e-3  # [m, rad] of differences
CLOSE = 1e-4  # relative


@cache
def hull() -> Hydrodynamics:
    path = vessels_folder() / "barge-110.json"
    return read_hydrodynamics(path.read_bytes(), path.name)


class FloatingCrane:
    """A barge whose load hangs on a rope of L [m] from the tip of its boom; it floats on an even keel."""

    def __init__(self, seed: int) -> None:
        random = Random(seed)
        self.tip = np.array([random.uniform(30.0, 70.0), random.uniform(-25.0, 25.0), random.uniform(30.0, 80.0)])
        self.L, self.load = random.uniform(10.0, 60.0), random.uniform(50e3, 600e3)
        self.whole = hull().density * hull().volume
        self.barge = self.whole - self.load
        self.com = np.array([*(-self.load / self.barge * self.tip[:2]), random.uniform(0.0, 3.0)])
        above = (self.barge * self.com[2] + self.load * self.tip[2]) / self.whole
        stiff = [self.whole * G * (z - above) for z in hull().metacentres]
        self.K = np.diag([*MOORED[:2], hull().density * G * hull().waterplane, *stiff, MOORED[2]])
        self.buoyancy = np.array([0.0, 0.0, above])  # where it acts

    def modes(self) -> list[complex]:
        """s = -zeta w + i w sqrt(1 - zeta^2) of the kernel's modes."""
        of, zero = hull(), (0.0,) * 6
        link = Body("load", self.load, (0.0, 0.0, -self.L))
        bodies = Body("barge", self.barge, tuple(self.com), tuple(map(tuple, INERTIA)), added=of.added_mass), link
        free = Joint("free", "free", WORLD, "barge", q0=(*zero, 1.0), v0=zero)
        water = Bushing("water", Point(WORLD), Point("barge"), tuple(map(tuple, self.K.tolist())), ((0.0,) * 6,) * 6)
        up = Load("up", Point("barge", tuple(self.buoyancy)), (0.0, 0.0, self.whole * G))
        memory = Radiation("memory", Point("barge"), of.radiation.F, of.radiation.G)
        hung = Joint(
            "rope", "universal", "barge", "load", tuple(self.tip), axis=(0.0, 1.0, 0.0), second=(1.0, 0.0, 0.0)
        )
        s = Simulation(System(bodies, (free, hung), forces=(up, water, memory), gravity=G), 1e-8)
        s.start()
        return [2.0 * np.pi * m.frequency * (-m.damping + 1j * np.sqrt(1.0 - m.damping**2))
                for m in modes(s).oscillations]  # fmt: skip

    def places(self, q: np.ndarray) -> np.ndarray:
        """(3, 3) barge's centre of mass, centre of buoyancy and load at q: surge to yaw, load relative to the tip."""
        R, (x, y) = Rotation.from_rotvec(q[3:6]).as_matrix(), q[6:]
        rope = np.array([x, y, -np.sqrt(self.L**2 - x * x - y * y)])
        return np.array([q[:3] + R @ p for p in (self.com, self.buoyancy)] + [q[:3] + R @ self.tip + rope])

    def potential(self, q: np.ndarray) -> float:
        z = self.places(q)[:, 2]
        return float(G * (self.barge * z[0] - self.whole * z[1] + self.load * z[2]) + 0.5 * q[:6] @ self.K @ q[:6])

    def impedance(self, s: complex) -> np.ndarray:
        """(8, 8) loads per motion as exp(s t)."""
        e = STEP * np.eye(8)
        J = np.array([(self.places(x) - self.places(-x)) / (2.0 * STEP) for x in e]).transpose(1, 2, 0)
        M = self.barge * J[0].T @ J[0] + self.load * J[2].T @ J[2]
        M[3:6, 3:6] += INERTIA
        V = self.potential
        H = np.array([[V(a + b) - V(a - b) - V(b - a) + V(-a - b) for b in e] for a in e]) / (4.0 * STEP**2)
        F, R = np.array(hull().radiation.F), np.array(hull().radiation.G)
        M[:6, :6] += np.array(hull().added_mass)
        Z = s * s * M + H
        Z[:6, :6] += s * (R.T @ np.linalg.solve(s * np.eye(len(F)) - F, R.astype(complex)))
        return Z


@pytest.mark.parametrize("seed", range(6))
def test_a_floating_crane_swings_as_the_coupled_pendulum_and_barge(seed: int) -> None:
    crane = FloatingCrane(seed)
    found = crane.modes()
    assert len(found) == 8
    scale = np.exp(np.linalg.slogdet(crane.impedance(1.2j))[1])
    for s in found:
        root = newton(lambda x: np.linalg.det(crane.impedance(x)) / scale, s * (1.0 + 1e-3), tol=1e-12)
        assert abs(root - s) < CLOSE * abs(s)


def test_a_small_load_on_a_short_rope_below_a_floating_crane_swings_as_from_a_fixed_point() -> None:
    crane = FloatingCrane(1)
    crane.L, crane.load = 4.0, 1e3
    crane.barge, crane.com = crane.whole - crane.load, np.array([0.0, 0.0, crane.com[2]])
    w = [abs(s) for s in crane.modes()]
    assert min(abs(x - np.sqrt(G / crane.L)) for x in w) < CLOSE * np.sqrt(G / crane.L)
