"""The worked example of 0027/ND rev 11.2, appendix B.1.2: two hooks, a tilt of 3 degrees, a centre of mass in doubt.

The kernel's equilibrium of a body on two plumb ropes is held against the formulae of the standard.
"""

from math import asin, cos, degrees, radians, sin

import pytest
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.limits import SHARING, daf, hoisting_factor, partial_factor

L, C, D = 25.0, 12.0, 13.0  # [m] between the hooks, from the centre of mass to each
A, B = 10.0, 14.0  # [m] from the centre of mass up to the lift points of each
X, Z = 0.9, 0.8  # [m] envelope of the centre of mass
TILT = radians(3.0)
WEIGHT = 1e6  # [N]
G = 9.80665
STATIC = 1e-5  # relative: the ropes stretch by half a millimetre, by which the body leans


def shares(near: tuple[float, float], far: tuple[float, float], tilt: float) -> tuple[float, float]:
    """Shares of two plumb ropes at points (x, z) from the centre of mass, the body tilted so that +z goes to +x."""
    points = [(x * cos(tilt) + z * sin(tilt), z * cos(tilt) - x * sin(tilt)) for x, z in (near, far)]
    k, high = 1e12, 1000.0
    ropes = tuple(
        Rope(f"hook-{i}", (Line(Point("world", (x, 0.0, z + high)), Point("load", (p[0], 0.0, p[1]))),), k, high)
        for i, ((x, z), p) in enumerate(zip(points, (near, far), strict=True), 1)
    )
    load = Body("load", WEIGHT / G, (0.0, 0.0, 0.0), ((1e8, 0, 0), (0, 1e8, 0), (0, 0, 1e8)))
    plane = Joint("plane", "planar", "world", "load", axis=(0.0, 1.0, 0.0), second=(1.0, 0.0, 0.0), q0=(0.0, 0.0, tilt))
    simulation = Simulation(System((load,), (plane,), ropes=ropes, gravity=G))
    simulation.start()
    rest = equilibrium(simulation).tensions
    return rest["hook-1"] / WEIGHT, rest["hook-2"] / WEIGHT


def test_two_hooks_with_a_height_difference_of_1_m_tilt_the_load_by_less_than_the_standard_assumes() -> None:
    assert degrees(asin(1.0 / L)) == pytest.approx(2.29, abs=0.005)
    assert asin(1.0 / L) < TILT


def test_each_hook_of_the_two_hook_example_carries_its_published_share() -> None:
    first = ((B + Z) * sin(TILT) + (D + X) * cos(TILT)) / (L * cos(TILT) + (B - A) * sin(TILT))
    found, other = shares((-(C - X), A + Z), (D + X, B + Z), TILT)
    assert found == pytest.approx(first, rel=STATIC)
    assert found + other == pytest.approx(1.0, rel=STATIC)
    second = ((A + Z) * sin(TILT) + (C + X) * cos(TILT)) / (L * cos(TILT) - (B - A) * sin(TILT))
    _, found = shares((-(C + X), A + Z), (D - X, B + Z), -TILT)
    assert found == pytest.approx(second, rel=STATIC)
    level, _ = shares((-C, A), (D, B), 0.0)
    assert level == pytest.approx(D / L, rel=STATIC)
    assert (f"{first:.3f}", f"{second:.3f}", f"{level:.3f}") == ("0.582", "0.543", "0.520")


def test_load_factors_in_the_example_with_two_hooks_are_those_of_the_standard() -> None:
    assert [(daf("onshore", mass) or (0.0, ""))[0] for mass in (50e3, 100e3, 300e3, 900e3, 1500e3, 5e6)] == [
        1.10, 1.10, 1.05, 1.05, 1.03, 1.03,
    ]  # fmt: skip
    assert partial_factor() == pytest.approx(1.3 * 1.3 * 1.5 * 1.25 * 1.2), "7.3.1 with a hand splice, used in a yard"
    assert partial_factor(termination=1.0, consequence=1.0, material=1.35, wear=1.0) == pytest.approx(2.3), (
        "the least of 7.3.1"
    )
    assert {name: (s.message, s.factor) for name, s in SHARING.items()} == {
        "four slings": ("1.25 on each diagonal in turn", 1.25),
        "over a hook": ("45:55", pytest.approx(55 / 50)),
        "sliding": ("32.5:67.5", pytest.approx(67.5 / 50)),
        "greased sheave": ("49:51", pytest.approx(51 / 50)),
    }


def test_the_hoisting_factor_of_en_13001_grows_with_lift_off_speed_and_hoisting_class() -> None:
    assert hoisting_factor(0.0, "HC1") == 1.05
    assert hoisting_factor(0.5, "HC4") == pytest.approx(1.20 + 0.68 * 0.5)
