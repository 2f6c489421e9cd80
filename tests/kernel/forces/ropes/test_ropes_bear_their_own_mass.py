"""The mass of a straight, evenly stretched rope is shared by its two ends, without a body of its own."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import WORLD, Body, Joint, Line, Point, RigidRope, Rope, System
from heavylift.kernel.simulation import Simulation
from scipy.optimize import brentq
from small_scenes import G, X, Z, column, hand_over, imbalance, started

M, OWN, L, K = 80e3, 5.6e3, 35.0, 2.0e7  # load, its rope [kg], length [m], stiffness [N/m]
SMALL = 1e-6  # relative: differences over 1e-4
SECOND_ORDER = (OWN / M) ** 2 / 10.0  # of a wave in the rope, which Rayleigh's quotient leaves out
CLOSES = 1e-8


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


def test_one_third_of_the_rope_mass_moves_with_the_load_in_axial_motion():
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
def test_the_energy_balance_includes_the_mass_of_a_rope(rope):
    far = 0.2 * L
    s = started(hung(rope, x=far, z=-sqrt(L**2 - far**2)), tolerance=1e-10, sample_ns=50_000_000)
    hand_over(s, 10_000_000_000)
    assert imbalance(s) < CLOSES


def test_a_rope_without_mass_needs_fewer_operations_than_a_rope_with_mass():
    def operations(rope):
        return len(Simulation(hung(rope)).method.f_rate.nodes)

    assert operations(replace(ELASTIC, mass=0.0)) < operations(ELASTIC)


@pytest.mark.parametrize("rope", [ELASTIC, RIGID], ids=lambda r: type(r).__name__)
def test_ropes_with_and_without_mass_have_separate_code(rope):
    with_mass, without = (Simulation(hung(r), native=False).native.structure for r in (rope, replace(rope, mass=0.0)))
    assert with_mass != without


@pytest.mark.parametrize(("change", "told"), [
    ({"mass": -1.0}, "mass"),
    ({"lines": (Line(Point(WORLD), Point("load"), 0.5),)}, "let their shares add up to 1"),
])  # fmt: skip
def test_an_invalid_mass_of_a_rope_is_refused(change, told):
    with pytest.raises(KernelError, match=told):
        Simulation(hung(replace(ELASTIC, **change)))
