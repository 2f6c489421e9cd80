"""Hulls with data by frequency: regular waves against the frequency domain, irregular ones by their statistics."""

from __future__ import annotations

import heavylift
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.scene import parse
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Hydrodynamics, hull_of, read_hydrodynamics
from scipy.io import netcdf_file

G = 9.80665
SCENE = """
heavylift: 1
name: sea
end: 400 s
seed: %d
waves: {%s, heading: %s, ramp: 40 s}
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    heading: %s
    com: [0 m, 0 m, 2 m]
    inertia: [1.4e6 t m2, 15e6 t m2, 15e6 t m2]
    motion: forces
    floating:
      hydrodynamics: %s
      mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}
      damping: [[4e5, 0, 0, 0, 0, 0], [0, 4e5, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0],
                [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 4e8]]
actions: [{wait: 1 s}]
"""
LINEAR = 1e-4  # relative: stiffness and trim by a tolerance of rest
MASS, INERTIA = 14432e3, (1.4e9, 15e9, 15e9)
MOORING = np.diag([4e5, 4e5, 0.0, 0.0, 0.0, 4e8])


def scene(waves: str, heading: str = "150 deg", bow: str = "0 deg", seed: int = 1, hull: str = "barge-110") -> str:

    return SCENE % (seed, waves, heading, bow, hull)


def hull() -> Hydrodynamics:
    path = vessels_folder() / "barge-110.json"
    return read_hydrodynamics(path.read_bytes(), path.name)


def answer(of: Hydrodynamics, w: float, heading: float) -> np.ndarray:
    """(6,) motion of the origin per wave amplitude, by linear algebra in the frequency domain."""
    return np.linalg.solve(impedance(of, 1j * w), np.array(of.load(w, heading)))


def impedance(of: Hydrodynamics, s: complex) -> np.ndarray:
    """(6, 6) loads per motion of the origin as exp(s t)."""
    c = 2.0
    rigid = np.diag([MASS] * 3 + list(INERTIA))
    rigid[3, 3] += MASS * c * c
    rigid[4, 4] += MASS * c * c
    rigid[0, 4] = rigid[4, 0] = MASS * c
    rigid[1, 3] = rigid[3, 1] = -MASS * c
    C = MOORING.copy()
    C[2, 2] = of.density * G * of.waterplane
    C[3, 3], C[4, 4] = (MASS * G * (z - c) for z in of.metacentres)
    F, R = np.array(of.radiation.F), np.array(of.radiation.G)
    K = R.T @ np.linalg.solve(s * np.eye(len(F)) - F, R.astype(complex))
    return s * s * (rigid + np.array(of.added_mass)) + s * (K + MOORING) + C  # [N s/m] as [N/m]


def motion(s: Simulation, until: float) -> np.ndarray:
    """(6,) displacements and small rotations of the barge at a time."""
    s.run(round(until * 1e9))
    pose = s.row().poses.reshape(-1, 12)[0]
    R = pose[3:].reshape(3, 3)
    return np.array([*pose[:3], R[2, 1], -R[2, 0], R[1, 0]])


@pytest.mark.parametrize(("period", "heading"), [(6.0, 150.0), (8.0, 150.0), (10.0, 90.0), (12.0, 180.0)])
def test_motions_of_a_hull_in_a_regular_wave_agree_with_the_frequency_domain(period, heading):
    """After 15 minutes the amplitude of each motion is that of the linear system to 0.5 % of its kind's largest."""
    small = parse(scene(f"height: 2 cm, period: {period} s", f"{heading} deg").replace("400 s", "2000 s"))
    s = Simulation(system(small.plan), 1e-8)
    s.start()
    w = 2.0 * np.pi / period
    times = 900.0 + period * np.arange(16) / 16.0
    found = np.array([motion(s, t) for t in times])
    amplitudes = 2.0 / 16.0 * np.abs(np.exp(-1j * w * times) @ found)
    want = 0.01 * np.abs(answer(hull(), w, np.radians(heading)))
    for kind in (slice(0, 3), slice(3, 6)):
        assert amplitudes[kind] == pytest.approx(want[kind], abs=5e-3 * want[kind].max())


def test_a_linear_model_of_a_hull_includes_its_radiation_memory():
    """Its transfer function from a load is that of the frequency domain, and its modes let it move without any load."""
    small = parse(scene("height: 1 cm, period: 8 s", "180 deg"))
    model = heavylift.linearise(small, ["barge.heave wave"], ["pose/barge/z"])
    for w in (0.3, 0.7, 1.5):
        found = model.C @ np.linalg.solve(1j * w * np.eye(len(model.A)) - model.A, model.B) + model.D
        want = np.linalg.solve(impedance(hull(), 1j * w), np.eye(6)[2])[2]
        assert abs(found[0, 0]) == pytest.approx(abs(want), rel=LINEAR)
    s = Simulation(system(small.plan), 1e-8)
    s.start()
    equilibrium(s)
    found = modes(s).oscillations
    assert len(found) == 6
    for mode in found:
        w, damped = 2.0 * np.pi * mode.frequency, -mode.damping + 1j * np.sqrt(1.0 - mode.damping**2)
        Z = impedance(hull(), w * damped)
        size = np.sqrt(np.abs(impedance(hull(), 1.2j * w).diagonal()))  # so that metres compare with radians
        values = np.linalg.svd(Z / np.outer(size, size), compute_uv=False)
        assert values[-1] < LINEAR * values[0], "nearly singular"


BAD = {
    ("height: 1 m, period: 8 s", "nothing"): "there is no file 'nothing' beside the scene, and no bundled hull",
    ("height: 1 m", "barge-110"): "waves are either regular, with 'height' and 'period', or irregular, with 'seas'",
    ("seas: {wind: {Hs: 1 m}}", "barge-110"): "Tp",
}


@pytest.mark.parametrize(("waves", "name"), BAD)
def test_impossible_hydrodynamic_data_are_refused_in_one_sentence(waves, name):
    with pytest.raises(SceneError) as error:
        parse(scene(waves, hull=name))
    assert BAD[waves, name] in str(error.value)


def test_a_vessel_that_floats_deeper_than_its_data_is_refused():
    with pytest.raises(
        SceneError, match="it weighs 15000 t with all that stands on it, and its hull displaces 14432 t"
    ):
        parse(scene("height: 1 m, period: 8 s").replace("14432 t", "15000 t"))


@pytest.mark.parametrize("waves", ["height: 1 m, period: 2 s", "seas: {s: {Hs: 1 m, Tp: 3 s}}"])
def test_waves_are_refused_with_the_share_of_energy_outside_the_frequencies_of_the_hull_data(waves: str) -> None:
    """The file has data up to 2.6 rad/s; half of the energy of a sea is above its mean period."""
    with pytest.raises(SceneError, match=r"\d+% of the energy .* 0.1 to 2.6 rad/s, more than 5%; data from .* enough"):
        parse(scene(waves))
    for seed in range(3):
        assert parse(scene("seas: {s: {Hs: 1 m, Tp: 5 s, components: 10}}", seed=seed)).plan.machines, "for any seed"


def test_water_of_a_density_unlike_that_of_the_hull_data_is_refused_and_so_are_unstable_vessels() -> None:
    with pytest.raises(SceneError, match="data has 1025 kg/m3, not 1000"):
        parse(scene("height: 1 m, period: 8 s, density: 1000 kg/m3"))
    with pytest.raises(SceneError, match=r"not stable in roll: GM is -2.67 m"):
        parse(scene("height: 1 m, period: 8 s").replace("com: [0 m, 0 m, 2 m]", "com: [0 m, 0 m, 22 m]"))


def test_prescribed_motions_of_a_vessel_are_refused_in_an_irregular_sea():
    text = scene("seas: {wind: {Hs: 1 m, Tp: 8 s}}")
    given = (
        text[: text.index("    motion: forces")] + "    responses: {heave: [0.5 m/m, 0 deg]}\nactions: [{wait: 1 s}]\n"
    )
    with pytest.raises(SceneError, match="write 'motion: forces' with 'hydrodynamics'"):
        parse(given)


def test_the_largest_heave_of_a_hull_grows_with_the_sea_and_repeats_with_its_seed():
    """Twice the height of the sea gives twice the motion, to what is not linear; the same seed the same bits."""

    def largest(Hs: float) -> list[float]:
        s = Simulation(system(parse(scene(f"seas: {{wind: {{Hs: {Hs} m, Tp: 8 s, components: 60}}}}")).plan), 1e-6)
        s.start()
        return [motion(s, t)[2] for t in np.arange(50.0, 200.0, 1.0)]

    small, same, double = largest(0.2), largest(0.2), largest(0.4)
    assert small == same
    assert np.abs(np.array(double) - 2.0 * np.array(small)).max() < 0.02 * np.abs(double).max()


def test_a_hull_is_read_from_a_file_of_capytaine(tmp_path):
    """Written as Capytaine does, exp(-iwt) and all: loads, hydrostatics and added mass come back."""
    of = hull()
    w = np.array([*of.loads.frequencies, np.inf])
    F, R = np.array(of.radiation.F), np.array(of.radiation.G)
    K = R.T @ np.linalg.solve(1j * w[:-1, None, None] * np.eye(len(F)) - F, R.astype(complex))
    A = np.concatenate([K.imag / w[:-1, None, None], np.zeros((1, 6, 6))]) + np.array(of.added_mass)
    B = np.concatenate([K.real, np.zeros((1, 6, 6))])
    X = np.array(of.loads.real) - 1j * np.array(of.loads.imaginary)
    X = np.concatenate([X.swapaxes(0, 1), np.full((1, X.shape[0], 6), np.nan)])
    mass = of.density * of.volume
    stiffness = np.diag([0, 0, of.density * 9.81 * of.waterplane, *(mass * 9.81 * z for z in of.metacentres), 0])
    data = {
        "omega": w, "wave_direction": np.array(of.loads.headings), "added_mass": A, "radiation_damping": B,
        "excitation_force": np.array([X.real, X.imag]), "hydrostatic_stiffness": stiffness,
        "disp_mass": np.array([mass]), "rho": np.array([of.density]), "g": np.array([9.81]),
    }  # fmt: skip
    with netcdf_file(tmp_path / "barge.nc", "w") as file:
        for name, x in data.items():
            for i, n in enumerate(x.shape):
                file.createDimension(f"{name}{i}", n)
            file.createVariable(name, "d", [f"{name}{i}" for i in range(x.ndim)])[:] = x
    found = hull_of(tmp_path / "barge.nc")
    assert found.volume == pytest.approx(of.volume, rel=1e-6)
    assert found.waterplane == pytest.approx(of.waterplane, rel=1e-6)
    assert found.metacentres == pytest.approx(of.metacentres, rel=1e-6)
    assert np.array(found.added_mass) == pytest.approx(np.array(of.added_mass), abs=1.0)
    assert found.load(0.77, 2.0) == pytest.approx(of.load(0.77, 2.0), abs=1.0)
    assert max(found.radiation.error.added_mass, found.radiation.error.damping) < 0.03


def test_a_hull_file_that_is_not_netcdf_is_refused_in_one_sentence(tmp_path):
    (tmp_path / "barge.nc").write_text("no")
    with pytest.raises(SceneError, match=r"barge.nc: it is not a netCDF file"):
        hull_of(tmp_path / "barge.nc")
