"""Waves on water of finite depth: the dispersion relation against SciPy, phases over position, other data."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Component, Hydrodynamics, loads_in_sea, read_hydrodynamics, wave_number
from scipy.optimize import brentq

G = 9.80665
ROUNDING = 1e-12  # relative: of a root by two methods
SCENE = """
heavylift: 1
name: shallow
end: 20 s
waves: {height: 2 m, period: 8 s, depth: %s m, heading: 30 deg}
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    at: [%s m, 40 m, 0 m]
    motion: %s
actions: [{wait: 1 s}]
"""
GIVEN = "given\n    responses: {heave: [1 m/m, 0 deg]}"
FILE = "forces\n    com: [0 m, 0 m, 2 m]\n    floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m}}"


def bundled() -> Hydrodynamics:
    path = vessels_folder() / "barge-110.json"
    return read_hydrodynamics(path.read_bytes(), path.name)


@pytest.mark.parametrize("depth", [0.5, 5.0, 20.0, 100.0, 4000.0])
def test_wave_numbers_satisfy_the_dispersion_relation(depth: float) -> None:
    for w in np.geomspace(0.05, 4.0, 40):
        want = brentq(lambda k, w=w: w * w - G * k * np.tanh(k * depth), 1e-6, 100.0, xtol=1e-15, rtol=1e-14)
        assert wave_number(w, G, depth) == pytest.approx(want, rel=ROUNDING)


def test_wave_numbers_tend_to_those_of_deep_and_of_shallow_water() -> None:
    """Deep: w^2 / g, in the same bits as ever; shallow: w / sqrt(g h)."""
    assert wave_number(0.8, G) == 0.8 * 0.8 / G
    assert wave_number(0.8, G, 1000.0) == pytest.approx(0.8 * 0.8 / G, rel=ROUNDING)
    assert wave_number(1e-3, G, 10.0) == pytest.approx(1e-3 / np.sqrt(10.0 * G), rel=1e-6)


def test_wave_loads_on_a_hull_repeat_after_one_wavelength_and_change_sign_after_half_a_wavelength() -> None:
    w, to, depth = 2.0 * np.pi / 9.0, 0.6, 15.0
    length = 2.0 * np.pi / brentq(lambda k: w * w - G * k * np.tanh(k * depth), 1e-6, 1.0, xtol=1e-15, rtol=1e-14)
    sea = [Component(w, 1.3, to, 0.2)]

    def loads(share: float) -> np.ndarray:
        at = (share * length * np.cos(to), share * length * np.sin(to))
        found = loads_in_sea(bundled(), sea, at, 0.3, G, 10.0, depth)
        return np.array([x.cosines[0] + 1j * x.sines[0] for x in found])

    size = np.abs(loads(0.0)).max()
    assert np.abs(loads(1.0) - loads(0.0)).max() < 1e-9 * size
    assert np.abs(loads(0.5) + loads(0.0)).max() < 1e-9 * size


def test_the_phase_lag_of_prescribed_vessel_motions_is_wave_number_times_distance_at_any_depth() -> None:
    """Its phase lags by the wave number times the distance along the waves."""
    w = 2.0 * np.pi / 8.0
    for depth in (6.0, 25.0):
        drives = parse(SCENE % (depth, 70.0, GIVEN)).plan.machines[0].system.drives
        heave = next(x.wave for x in drives if x.joint == "barge.heave")
        k = brentq(lambda k, h=depth: w * w - G * k * np.tanh(k * h), 1e-6, 1.0, xtol=1e-15, rtol=1e-14)
        distance = 70.0 * np.cos(np.pi / 6.0) + 40.0 * np.sin(np.pi / 6.0)
        assert heave is not None
        assert heave.phase == pytest.approx(-k * distance, rel=1e-9)


def test_hydrodynamic_data_of_deep_water_are_refused_at_15_m_depth_and_accepted_at_60_m() -> None:
    """Waves of 8 s are 100 m long."""
    with pytest.raises(
        SceneError, match=r"(?s)its data are for deep water; on water 15 m deep .* 0.8\d+ times as long.*hull --depth"
    ):
        parse(SCENE % (15, 0.0, FILE))
    assert parse(SCENE % (60, 0.0, FILE)).plan.machines


def test_the_water_depth_stated_in_a_hull_file_is_read() -> None:
    text = msgspec.json.encode(msgspec.structs.replace(bundled(), depth=15.0))
    assert read_hydrodynamics(text, "barge.json").depth == 15.0
