"""Two barges side by side that exchange waves: data of Capytaine 3.0, a file of both hulls, a scene in waves.

`two-barges.nc` is by Capytaine: boxes of 60 x 20 m and 36 x 14 m, 8 m apart, 620 panels with lids.
"""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.limits import checks_of
from heavylift.nodes.models import system
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import load
from heavylift.nodes.sea import (
    Coefficients,
    Hydrodynamics,
    StateSpace,
    capytaine,
    drift_of,
    hull_of,
    wamit,
    with_drift,
    with_gap_damping,
)
from scipy.io import netcdf_file

DATA = Path(__file__).parents[2] / "data" / "two-barges.nc"
G, RHO, BESIDE = 9.80665, 1025.0, 25.0
HEADING, BOW = np.radians(150.0), np.radians(30.0)
DAMPING = [4e5, 4e5, 0.0, 0.0, 0.0, 4e7]
MOORINGS = [1e5, 1e5, 0.0, 0.0, 0.0, 1e8], [5e4, 5e4, 0.0, 0.0, 0.0, 2e7]
SIZES, HEIGHTS = np.array([[60.0, 20.0, 6.0], [36.0, 14.0, 4.0]]), (1.0, 0.0)
PLACES = np.array([[5.0, -4.0], [5.0 - BESIDE * np.sin(BOW), -4.0 + BESIDE * np.cos(BOW)]])
CLOSE = 5e-3  # of the largest motion of a kind: what waves of 2 cm move that is not linear, and g of the file
LONG = 0.1  # [rad] of phase that the longest wave in the file is not yet still water
FITTED = 0.05  # the same, by the error of the radiation fit: 2 % of the largest coefficient of each mode
GAP_RATIO = 0.05  # of critical, added
PISTON = 0.02  # of the peak of the gap's own response: with damping, other states of the water take part in it
RESONANCE = 1.1  # [rad/s] of the gap, where motions miss more: coefficients are small beside their largest
SCENE = """
heavylift: 1
name: pair
end: 400 s
method: dopri5
waves: {height: 2 cm, period: %r s, heading: 150 deg, ramp: 40 s}
vessels:
  big:
    mass: 3690 t
    size: [60 m, 20 m, 6 m]
    draught: 3 m
    at: [5 m, -4 m, 0 m]
    heading: 30 deg
    com: [0 m, 0 m, 1 m]
    motion: forces
    floating:
      hydrodynamics: pair.json
      mooring: {surge: 100 kN/m, sway: 100 kN/m, yaw: 100 MN m/rad}
      damping: &damping %s
  small:
    mass: 1033.2 t
    size: [36 m, 14 m, 4 m]
    draught: 2 m
    at: [%.6f m, %.6f m, 0 m]
    heading: 30 deg
    motion: forces
    floating: {beside: big, mooring: {surge: 50 kN/m, sway: 50 kN/m, yaw: 20 MN m/rad}, damping: *damping}
actions: [{wait: 1 s}]
"""


def text(w: float = 0.8) -> str:
    return SCENE % (2.0 * np.pi / w, np.diag(DAMPING).tolist(), *PLACES[1])


@pytest.fixture(scope="module")
def pair() -> Hydrodynamics:
    return hull_of(DATA)


def placed(folder: Path, of: Hydrodynamics, scene: str) -> Path:
    (folder / "pair.json").write_bytes(msgspec.json.encode(of))
    (folder / "pair.yaml").write_text(scene)
    return folder / "pair.yaml"


def motions(scene: Path, w: float) -> tuple[np.ndarray, Simulation]:
    """Complex amplitudes (2, 6) of both vessels in their axes at rest after a quarter of an hour."""
    s = Simulation(system(load(scene).plan), 1e-8)
    s.start()
    times, found = 900.0 + 2.0 * np.pi / w * np.arange(16) / 16.0, []
    rest = np.array([[np.cos(BOW), -np.sin(BOW), 0.0], [np.sin(BOW), np.cos(BOW), 0.0], [0.0, 0.0, 1.0]])
    for t in times:
        s.run(round(t * 1e9))
        s.interrupt(round(t * 1e9))
        poses = s.row().poses.reshape(2, 12)
        s.settle()
        turned = [rest.T @ pose[3:].reshape(3, 3) for pose in poses]
        away = [rest.T @ (pose[:3] - (*p, 0.0)) for pose, p in zip(poses, PLACES, strict=True)]
        found.append([[*x, R[2, 1], R[0, 2], R[1, 0]] for x, R in zip(away, turned, strict=True)])
    return 2.0 / 16.0 * np.einsum("t,tij->ij", np.exp(-1j * w * times), np.array(found)), s


def rigid() -> tuple[np.ndarray, np.ndarray]:
    """Inertia and stiffness (12, 12) of both vessels about their origins."""
    M, C = np.zeros((12, 12)), np.zeros((12, 12))
    read = capytaine(DATA)
    for i, ((a, b, c), z, moored, of) in enumerate(zip(SIZES, HEIGHTS, MOORINGS, read.hulls, strict=True)):
        draught, own = 0.5 * c, slice(6 * i, 6 * i + 6)
        m = RHO * a * b * draught
        T = np.eye(6)
        T[0, 4], T[1, 3] = z, -z
        M[own, own] = T.T @ np.diag([m] * 3 + [m / 12.0 * x for x in (b * b + c * c, a * a + c * c, a * a + b * b)]) @ T
        tilts = [G / 9.81 * of.K[j, j] + m * G * (of.height - z) for j in (3, 4)]
        C[own, own] = np.diag([0.0, 0.0, RHO * G * a * b, *tilts, 0.0]) + np.diag(moored)
    return M, C


def raw(w: float) -> tuple[np.ndarray, np.ndarray]:
    """Radiation -w^2 A + i w B (12, 12), and loads (12,) per amplitude with phases at the origin of big, in Capytaine's
    file."""
    with netcdf_file(DATA, "r", mmap=False) as file:
        data = {name: np.array(x.data, float) for name, x in file.variables.items() if x.data.dtype.kind == "f"}
    n = int(np.argmin(np.abs(data["omega"] - w)))
    h = int(np.argmin(np.abs(data["wave_direction"] - (HEADING - BOW))))
    A, B = (x[n].T for x in (data["added_mass"], data["radiation_damping"]))
    X = data["excitation_force"][:, n, h]
    return -w * w * 0.5 * (A + A.T) + 0.5j * w * (B + B.T), X[0] - 1j * X[1]


def answer(w: float, radiation: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Motions (2, 6) by linear algebra, with phases at the origin of the waves."""
    M, C = rigid()
    delay = w * w / G * PLACES[0] @ (np.cos(HEADING), np.sin(HEADING))
    Z = -w * w * M + radiation + 1j * w * np.diag(DAMPING * 2) + C
    return 0.01 * np.exp(-1j * delay) * np.linalg.solve(Z, X).reshape(2, 6)


def fitted_answer(pair: Hydrodynamics, w: float, X: np.ndarray | None = None) -> np.ndarray:
    """Motions (2, 6) with the fitted memory."""
    of, second = pair.radiation, pair.beside
    assert second
    K = StateSpace(np.array(of.F), np.concatenate([of.G, second.hull.radiation.G], axis=1)).memory(np.array([w]))[0]
    A_inf = np.block([[np.array(pair.added_mass), np.array(second.added_mass).T],
                      [np.array(second.added_mass), np.array(second.hull.added_mass)]])  # fmt: skip
    return answer(w, -w * w * A_inf + 1j * w * K, raw(w)[1] if X is None else X)


def assert_energy_closes(s: Simulation, scene: Path) -> None:
    row = s.row()
    signs = [1.0 if what == "heat" else -1.0 for what, _ in s.program.accounts]
    gained = sum(sign * float(x) for sign, x in zip(signs, row.accounts, strict=True))
    works = sum(abs(float(x)) for (what, _), x in zip(s.program.accounts, row.accounts, strict=True) if what == "work")
    start = Simulation(system(load(scene).plan), 1e-8)
    start.start()
    first, last = (float(x.kinetic + x.potential + sum(x.stored)) for x in (start.row(), row))
    assert abs(last + gained - first) < 1e-6 * works


@pytest.mark.parametrize("w", [0.8, RESONANCE, pytest.param(0.5, marks=pytest.mark.large)])
def test_two_hulls_in_a_wave_move_as_their_coupled_equations_predict(tmp_path: Path, pair: Hydrodynamics, w: float):
    """With the fitted memory to 0.5 %, with the coefficients of the file to the error of the fit; alone they would move
    differently; the energy account closes."""
    found, s = motions(placed(tmp_path, pair, text(w)), w)
    X = raw(w)[1]
    want, theirs = fitted_answer(pair, w), answer(w, *raw(w))
    Z, alone = raw(w)[0], np.kron(np.eye(2), np.ones((6, 6)))
    apart = answer(w, Z * alone, X)
    for kind in (slice(0, 3), slice(3, 6)):
        largest = np.abs(want[:, kind]).max()
        assert np.abs(found[:, kind] - want[:, kind]).max() < CLOSE * largest
        if w != RESONANCE:
            assert np.abs(found[:, kind] - theirs[:, kind]).max() < FITTED * largest
        assert np.abs(apart[:, kind] - want[:, kind]).max() > 2.0 * FITTED * largest, "waves between them matter"
    assert_energy_closes(s, tmp_path / "pair.yaml")


MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@pytest.mark.parametrize("w", [0.5, 0.8, RESONANCE])
def test_prescribed_motions_of_two_hulls_are_those_of_their_coupled_equations(
    tmp_path: Path, pair: Hydrodynamics, w: float
) -> None:
    plan = load(placed(tmp_path, pair, text(w))).plan
    given = system(msgspec.structs.replace(plan, fidelity=Fidelity(water="motion given")))
    want, waves = fitted_answer(pair, w), {drive.name: drive.wave for drive in given.drives}
    for name, each in zip(("big", "small"), want, strict=True):
        found = np.array([(x := waves[f"{name}.{m}.drive"]).amplitude * np.exp(1j * x.phase) for m in MODES])
        for kind in (slice(0, 3), slice(3, 6)):
            assert found[kind] == pytest.approx(each[kind], abs=CLOSE * np.abs(each[kind]).max())


def test_hulls_that_exchange_no_waves_move_as_two_single_vessels(tmp_path: Path, pair: Hydrodynamics) -> None:
    """Far apart, nothing couples them: a file of both with states of their own, and files of each alone."""
    second = pair.beside
    assert second
    F, rows = np.array(pair.radiation.F), np.array(pair.radiation.G)
    n, zero = len(F), np.zeros((len(F), len(F)))
    both = np.block([[F, zero], [zero, F]])
    G = [np.vstack([rows, 0.0 * rows]), np.vstack([0.0 * rows, np.array(second.hull.radiation.G)])]
    states = [msgspec.structs.replace(pair.radiation, F=tuple(map(tuple, A.tolist())), G=tuple(map(tuple, g.tolist())))
              for A, g in zip((both, np.zeros((0, 0))), G, strict=True)]  # fmt: skip
    other = msgspec.structs.replace(second.hull, radiation=states[1])
    none = tuple((0.0,) * 6 for _ in range(6))
    apart = msgspec.structs.replace(second, hull=other, added_mass=none)
    pair_of = msgspec.structs.replace(pair, radiation=states[0], beside=apart)
    found, _ = motions(placed(tmp_path, pair_of, text()), 0.8)
    own = msgspec.structs.replace(second.hull.radiation, F=pair.radiation.F)
    (tmp_path / "small.json").write_bytes(msgspec.json.encode(msgspec.structs.replace(second.hull, radiation=own)))
    alone = msgspec.structs.replace(pair, beside=None)
    single, _ = motions(placed(tmp_path, alone, text().replace("beside: big", "hydrodynamics: small.json")), 0.8)
    assert len(both) == 2 * n
    assert np.abs(found - single).max() < 1e-6 * np.abs(single).max()


def test_loads_of_long_waves_are_in_phase_with_the_wave_at_each_hull() -> None:
    """Heave loads tend to the stiffness of the waterplane, wherever the hull floats."""
    read = capytaine(DATA)
    for i, hull in enumerate(read.hulls):
        X = read.X[:, 0, 6 * i + 2] / hull.K[2, 2]
        assert np.abs(np.angle(X)).max() < LONG
        assert np.abs(np.abs(X) - 1.0).max() < 0.25
    k = read.w[0] ** 2 / 9.81 * BESIDE
    assert k > 2.0 * LONG, "the phase at the other hull would be seen"


def written(folder: Path, of: Coefficients, length: float = 10.0) -> Path:
    """Both hulls as WAMIT's manual has them, from Capytaine's: modes 7 to 12, phases at the common origin."""
    turns = np.arange(12) % 6 > 2
    both = of.density * length ** (3.0 + turns[:, None] + turns)
    rows = [f"0 {i + 1} {j + 1} {of.A_inf[i, j] / both[i, j]:.8e}" for i in range(12) for j in range(12)]
    A, B = of.A / both, of.B / both / of.w[:, None, None]
    rows += [f"{2 * np.pi / w:.10e} {i + 1} {j + 1} {A[n, i, j]:.8e} {B[n, i, j]:.8e}"
             for n, w in enumerate(of.w) for i in range(12) for j in range(12)]  # fmt: skip
    (folder / "two.1").write_text("\n".join(rows))
    delay = np.exp(-1j * np.outer(np.sin(of.headings), of.w**2 / 9.81) * BESIDE)
    X = of.X * np.concatenate([np.ones((*delay.shape, 6)), np.repeat(delay[..., None], 6, axis=2)], axis=2)
    X /= of.density * 9.81 * length ** (2.0 + turns)
    rows = [f"{2 * np.pi / w:.10e} {np.degrees(b):.8f} {i + 1} {abs(x):.8e} 0 {x.real:.8e} {x.imag:.8e}"
            for m, b in enumerate(of.headings) for n, w in enumerate(of.w) for i, x in enumerate(X[m, n])]  # fmt: skip
    (folder / "two.3").write_text("\n".join(rows))
    size = of.density * 9.81 * length ** (2.0 + (np.arange(6)[:, None] > 2) + (np.arange(6) > 2))
    rows = [f"{6 * b + i + 1} {6 * b + j + 1} {hull.K[i, j] / size[i, j]:.8e}"
            for b, hull in enumerate(of.hulls) for i in range(6) for j in range(6)]  # fmt: skip
    (folder / "two.hst").write_text("\n".join(rows))
    lines = []
    for hull in of.hulls:
        assert hull.buoyancy is not None
        lines += [f" XBODY =   {hull.at[0]:.4f} YBODY =  {hull.at[1]:.4f} ZBODY =  0.0000 PHIBODY =   0.0",
                  f" Volumes (VOLX,VOLY,VOLZ):     {hull.volume:.4f}   {hull.volume:.4f}   {hull.volume:.4f}",
                  " Center of Buoyancy (Xb,Yb,Zb): " + "".join(f"{x:12.6f}" for x in hull.buoyancy),
                  f" Center of Gravity  (Xg,Yg,Zg):     0.000000   0.000000  {hull.height:.6f}"]  # fmt: skip
    (folder / "two.out").write_text("\n".join(lines))
    return folder / "two.1"


def test_files_of_wamit_and_capytaine_of_two_hulls_give_the_same_coefficients(tmp_path: Path) -> None:
    of = capytaine(DATA)
    found = wamit(written(tmp_path, of), 0.0, 0.0, 10.0)
    for name in ("w", "A", "B", "A_inf", "headings", "X"):
        one, two = np.asarray(getattr(found, name)), np.asarray(getattr(of, name))
        assert np.abs(one - two).max() <= 1e-6 * np.abs(two).max(), name
    for one, two in zip(found.hulls, of.hulls, strict=True):
        assert np.abs(one.K - two.K).max() < 1e-6 * two.K.max()
        assert (one.volume, one.height, *one.at) == pytest.approx((two.volume, two.height, *two.at), rel=1e-6)
        assert one.buoyancy == pytest.approx(two.buoyancy, abs=1e-6)
    (tmp_path / "two.out").unlink()
    with pytest.raises(SceneError, match=r"for two hulls, add the file \.out"):
        wamit(tmp_path / "two.1", 3600.0, 0.0, 10.0)


def test_wave_frequencies_that_miss_a_resonance_of_the_gap_are_refused(tmp_path: Path) -> None:
    with netcdf_file(DATA, "r", mmap=False) as file, netcdf_file(tmp_path / "few.nc", "w") as few:
        size = file.variables["omega"].shape[0]
        kept = [*range(0, size - 1, 2), size - 1]
        for name, n in file.dimensions.items():
            few.createDimension(name, len(kept) if name == "omega" else n)
        for name, x in file.variables.items():
            axis = x.dimensions.index("omega") if "omega" in x.dimensions else None
            values = x.data if axis is None else np.take(x.data, kept, axis=axis)
            few.createVariable(name, x.typecode(), x.dimensions)[...] = values
    with pytest.raises(SceneError, match=r"resonance near 1.1 rad/s that its frequencies do not resolve"):
        hull_of(tmp_path / "few.nc")


BAD = {
    "its data are for the place .-7.5 m, 17.6506 m, 0 m. and heading 30 deg": ("17.650635 m", "19 m"),
    "its data are of two hulls near each other, and 0 vessels are": ("beside: big", "hydrodynamics: barge-75"),
    "there is no other vessel 'bog'": ("beside: big", "beside: bog"),
    "leave 'hydrodynamics' out": ("beside: big", "beside: big, hydrodynamics: pair.json"),
    "the data of big are not those of two hulls": ("hydrodynamics: pair.json", "hydrodynamics: barge-110"),
}  # fmt: skip


@pytest.mark.parametrize("sentence", BAD)
def test_pairs_of_vessels_that_do_not_fit_their_hull_data_are_refused(
    tmp_path: Path, pair: Hydrodynamics, sentence: str
) -> None:
    old, new = BAD[sentence]
    with pytest.raises(SceneError, match=sentence):
        load(placed(tmp_path, pair, text().replace(old, new)))


def test_wave_interaction_of_two_hulls_with_shared_data_is_not_listed_as_unchecked(
    tmp_path: Path, pair: Hydrodynamics
) -> None:
    both = checks_of(load(placed(tmp_path, pair, text())).plan, [], [], None, [])
    assert "interaction" not in {x.quantity for x in both}
    assert {x.subject for x in both if x.quantity == "mean drift"} == {"big", "small"}


def drifts(path: Path, modes: tuple[int, ...]) -> Path:
    """A file of mean drift by WAMIT with headings around the hulls."""
    rows = [f"{T} {b} {b} {i} 9 9 {0.01 * T * i * (1 + b / 360)} 0" for T in (8.0, 6.0) for b in range(-180, 180, 45)
            for i in modes]  # fmt: skip
    path.write_text("\n".join(rows))
    return path


def test_each_of_two_hulls_drifts_by_its_own_modes_in_a_file_of_wamit(tmp_path: Path, pair: Hydrodynamics) -> None:
    """Mean drift a^2 D at the period of a row; the second hull has modes 7, 8 and 12."""
    given = drift_of(drifts(tmp_path / "two.9", (1, 2, 6, 7, 8, 12)), RHO * 9.81, 10.0)
    both = with_drift(pair, *given, "two.9")
    scene = (
        text(2.0 * np.pi / 8.0).replace("height: 2 cm", "height: 1 m").replace("heading: 150 deg", "heading: 75 deg")
    )
    plan = load(placed(tmp_path, both, scene)).plan
    forces = {f.name: f.signal.wave for m in plan.machines for f in m.system.forces if " drift" in f.name}
    for name, modes in (("big", (1, 2, 6)), ("small", (7, 8, 12))):
        for mode, label, size in zip(modes, ("surge", "sway", "yaw"), (10.0, 10.0, 100.0), strict=True):
            want = 0.25 * RHO * 9.81 * size * 0.01 * 8.0 * mode * (1.0 + 45.0 / 360.0)
            assert forces[f"{name}.{label} drift"].amplitude == pytest.approx(want, rel=1e-6)
            assert forces[f"{name}.{label} drift"].frequency == 0.0
    assert not {x.quantity for x in checks_of(plan, [], [], None, [])} & {"mean drift"}
    seas = scene.replace("height: 1 m, period: 8.0 s", "seas: {a: {Hs: 1 m, Tp: 7 s, components: 20}}")
    plan = load(placed(tmp_path, both, seas)).plan
    slow = [f for m in plan.machines for f in m.system.forces if f.name == "small.sway drift"]
    assert slow[0].signal.waves.by[0], "slow drift"


def test_drift_coefficients_given_for_two_hulls_together_and_not_for_each_are_refused(
    tmp_path: Path, pair: Hydrodynamics
) -> None:
    given = drift_of(drifts(tmp_path / "two.8", (1, 2, 6)), RHO * 9.81, 10.0)
    with pytest.raises(
        SceneError, match=r"two.8: the file must contain the drift of each of two hulls, modes 1 to 12 of NAME.9"
    ):
        with_drift(pair, *given, "two.8")
    given = drift_of(drifts(tmp_path / "two.9", (1, 2, 6, 7, 8, 12)), RHO * 9.81, 10.0)
    with pytest.raises(SceneError, match=r"two.9: the file must contain the drift of a single hull"):
        with_drift(msgspec.structs.replace(pair, beside=None), *given, "two.9")


@pytest.mark.parametrize("ratio", [0.02, GAP_RATIO, 0.1])
def test_damping_of_a_gap_keeps_radiation_symmetric_and_lowers_its_own_response_by_the_damping_ratio(
    pair: Hydrodynamics, ratio: float
) -> None:
    """The highest response of the water in the gap is as 1 / (2 zeta); radiation takes no energy from the sea."""
    free, damped = (
        StateSpace(np.array(x.radiation.F), np.hstack([x.radiation.G, x.beside.hull.radiation.G]))
        for x in (pair, with_gap_damping(pair, ratio, "a model test"))
        if x.beside
    )
    K = damped.memory(np.linspace(0.3, 1.9, 33))
    assert np.abs(K - K.swapaxes(1, 2)).max() < 1e-9 * np.abs(K).max()
    assert np.linalg.eigvalsh(damped.F + damped.F.T).max() < 1e-12 * np.abs(damped.F).max(), "passive"
    values, V = np.linalg.eig(free.F)
    k = np.argmin(np.abs(values - 1j * RESONANCE))
    own = -values[k].real / np.abs(values[k])
    x, y = V[:, k], np.linalg.inv(V)[k]
    w = 1j * np.linspace(1.0, 1.25, 251)[:, None, None]
    before, after = (np.abs(y @ np.linalg.inv(w * np.eye(len(F)) - F) @ x).max() for F in (free.F, damped.F))
    assert after / before == pytest.approx(own / (own + ratio), rel=PISTON)
    values = np.linalg.eigvals(damped.F)
    k = np.argmin(np.abs(values - RESONANCE * (1j - own - ratio)))
    assert -values[k].real / np.abs(values[k]) == pytest.approx(own + ratio, rel=1e-8)


def test_a_stated_gap_damping_acts_on_two_hulls_in_a_wave_in_time_as_in_the_frequency_domain(
    tmp_path: Path, pair: Hydrodynamics
) -> None:
    """Without it, or if another resonance has less damping, the inputs are amber."""
    damped = with_gap_damping(pair, GAP_RATIO, "a model test")
    found, s = motions(placed(tmp_path, damped, text(RESONANCE)), RESONANCE)
    missing = [x.subject for x in load(tmp_path / "pair.yaml").checks if "gap damping" in x.subject]
    assert not missing
    assert_energy_closes(s, tmp_path / "pair.yaml")
    assert damped.beside
    h, away = HEADING - BOW, (PLACES[1] - PLACES[0]) @ (np.cos(HEADING), np.sin(HEADING))
    delay = np.exp(-1j * RESONANCE**2 / G * away)  # of the phases at the second hull
    X = np.array([*damped.load(RESONANCE, h), *(delay * np.array(damped.beside.hull.load(RESONANCE, h)))])
    want = fitted_answer(damped, RESONANCE, X)
    for kind in (slice(0, 3), slice(3, 6)):
        assert np.abs(found[:, kind] - want[:, kind]).max() < CLOSE * np.abs(want[:, kind]).max()
    for of in (pair, with_gap_damping(pair, 2.0 * GAP_RATIO, "a model test")):
        rows = load(placed(tmp_path, of, text())).checks
        assert [x.subject for x in rows if "gap damping" in x.subject] == ["gap damping beside big"]
