"""Added mass and damping at one frequency in place of memory: exact in a regular wave, of a measured error in a sea."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.ladder import Ladder, ModelLevel, at_level
from heavylift.coordinator.record import play
from heavylift.kernel.description import Bushing, Radiation
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.models.levels import at_frequency
from heavylift.nodes.plan import Fidelity, Plan
from heavylift.nodes.scene import load, parse

FLAT = Fidelity(water="one frequency")
SCENE = """
heavylift: 1
name: sea
end: 120 s
samples: 4 Hz
method: dopri5
waves: {%s, heading: 150 deg, ramp: 20 s}
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    heading: 30 deg
    com: [0 m, 0 m, 2 m]
    motion: forces
    floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}
actions: [{wait: 1 s}]
"""
REGULAR, SEA = "height: 10 cm, period: %d s", "seas: {wind: {Hs: 0.5 m, Tp: 8 s, components: 40}}"
CLOSE = 1e-2  # relative, of amplitudes after 15 minutes: what fitted couplings are not alike in both directions


def plan(waves: str) -> Plan:
    return parse(SCENE % waves).plan


def heave(of: Plan, times: np.ndarray) -> np.ndarray:
    s = Simulation(system(of), 1e-8)
    s.start()
    found = []
    for t in times:
        s.run(round(t * 1e9))
        found.append(s.row().poses.reshape(-1, 12)[0][2])
    return np.array(found)


@pytest.mark.parametrize("w", [0.3, 0.8, 1.5, 3.0])
def test_added_mass_and_damping_at_a_frequency_are_the_parts_of_the_radiation_transfer_function(w: float) -> None:
    (f,) = [f for f in system(plan(SEA)).forces if isinstance(f, Radiation)]
    F, G = np.array(f.F), np.array(f.G)
    K = G.T @ np.linalg.solve(1j * w * np.eye(len(F)) - F, G.astype(complex))
    K = 0.5 * (K + K.T)
    added, damping = at_frequency(f, w)
    assert np.array(damping) == pytest.approx(K.real, rel=1e-9, abs=1e-9 * np.abs(K).max())
    assert np.array(added) == pytest.approx(K.imag / w, rel=1e-9, abs=1e-9 * np.abs(K).max())


@pytest.mark.parametrize("period", [6, 8, 11])
def test_radiation_forces_at_one_frequency_are_exact_in_a_regular_wave_once_the_start_has_decayed(period: int) -> None:
    full = plan(REGULAR % period)
    times = 900.0 + period * np.arange(16) / 16.0
    both = [np.abs(np.exp(-2j * np.pi / period * times) @ heave(x, times)) for x in (full, at_level(full, FLAT))]
    assert both[1] == pytest.approx(both[0], rel=CLOSE)


def test_leaving_out_radiation_memory_changes_heave_in_an_irregular_sea_by_less_than_30_percent() -> None:
    full = plan(SEA)
    flat = at_level(full, FLAT)
    assert not [f for f in system(flat).forces if isinstance(f, Radiation)]
    assert [f.name for f in system(flat).forces if isinstance(f, Bushing)] == ["barge.radiation", "barge.water"]
    assert ModelLevel(flat).left_out == ("memory of radiated waves",)
    one, two = (play(x).past for x in (full, flat))
    z = [x.part(0, 480).poses["barge"][80:, 2] for x in (one, two)]
    assert 1e-3 < np.std(z[1] - z[0]) / np.std(z[0]) < 0.3


def test_the_model_level_without_radiation_memory_is_compared_only_for_vessels_in_waves() -> None:
    sea = Ladder(plan(SEA))
    assert [x.water for x in sea.compared] == ["motion given", "one frequency", "memory"]
    assert ModelLevel(at_level(plan(SEA), FLAT)).level == "as it is written, water at one frequency"
    assert sea.witnesses(FLAT) == [sea.full[-1]]
    assert "one frequency" not in {x.water for x in sea.plausible}
    for name in ("floating", "lift"):
        assert "one frequency" not in {x.water for x in Ladder(load(name).plan).compared}
