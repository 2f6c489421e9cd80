"""A hemisphere of radius 1 m, computed by Capytaine 3.0 and written by it as netCDF and as files of WAMIT.

Both files are of another author and have different conventions (exp(-iwt) in SI units; exp(+iwt) without dimensions),
so equal numbers show that both are read as they are meant. Its 140 flat panels are inscribed in the sphere: their
volume is 3 % less.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.nodes.sea import Coefficients, capytaine, wamit

DATA = Path(__file__).parents[2] / "data"
RHO, G, VOLUME, HEIGHT = 1025.0, 9.81, 2.026395382746873, -0.2
SPHERE = 2.0 * np.pi / 3.0
WRITTEN = 1e-6  # relative: files of WAMIT have seven digits
PANELS = 0.1  # relative: flat panels, largest for the surge at the waterline


@pytest.fixture(scope="module")
def hull() -> Coefficients:
    return wamit(DATA / "hemisphere.1", VOLUME, HEIGHT, 1.0)


def test_wamit_and_capytaine_files_of_a_hemisphere_give_the_same_coefficients(hull: Coefficients) -> None:
    other = capytaine(DATA / "hemisphere.nc")
    names = ("w", "A", "B", "A_inf", "headings", "X", "density", "gravity", "K", "volume", "height")
    for name in names:
        of = (hull, other) if hasattr(hull, name) else (hull.hulls[0], other.hulls[0])
        one, two = (np.asarray(getattr(x, name)) for x in of)
        assert np.abs(one - two).max() <= 30.0 * WRITTEN * max(float(np.abs(two).max()), 1.0), name


def test_added_mass_of_a_hemisphere_is_that_of_its_theory(hull: Coefficients) -> None:
    """Heave at infinite frequency: half of the displaced mass; surge at Ka 0.1 and 1.0 by Hulme, J. Fluid Mech. 121
    (1982) 443-463."""
    displaced = RHO * SPHERE
    assert hull.A_inf[2, 2] / displaced == pytest.approx(0.5, rel=PANELS)
    assert hull.A_inf[0, 0] / displaced == pytest.approx(0.2732, rel=PANELS)
    surge = np.interp((0.1, 1.0), hull.w**2 / G, hull.A[:, 0, 0]) / displaced
    assert surge == pytest.approx((0.5223, 0.5740), rel=PANELS)


def test_heave_and_surge_loads_of_long_waves_have_the_size_and_phase_of_the_long_wave_limit(hull: Coefficients) -> None:
    """A wave along x lifts with rho g pi in phase with its elevation, and pushes along x with the mass of water and its
    added mass times the acceleration, a quarter of a period ahead; against x it pushes back."""
    w, ahead, behind = hull.w[0], hull.X[0, 0], hull.X[-1, 0]
    push = 1j * w * w * (RHO * VOLUME + hull.A[0, 0, 0])
    assert abs(ahead[0] - push) < PANELS * abs(push)
    assert abs(behind[0] + push) < PANELS * abs(push)
    assert abs(ahead[2] - RHO * G * np.pi) < PANELS * RHO * G * np.pi


def test_radiation_damping_satisfies_the_haskind_relation_with_the_wave_loads(hull: Coefficients) -> None:
    """Haskind's relation of a body of revolution in heave: B = k |X|^2 / (4 rho g vg), vg = g / 2 w."""
    w = hull.w
    want = w * w / G * np.abs(hull.X[0, :, 2]) ** 2 / (4.0 * RHO * G * G / (2.0 * w))
    assert hull.B[:, 2, 2] == pytest.approx(want, abs=PANELS * want.max())
