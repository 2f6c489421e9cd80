"""A hemisphere in files of NEMOH, as its manual has them, and in netCDF of version 4: the same coefficients as in the
files of Capytaine and WAMIT, and conventions by physics.

NEMOH's own example of a sphere has the surge of a wave along x at the phase -pi/2, so its loads are for exp(-iwt).
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.sea import Coefficients, capytaine, hull_of, nemoh, wamit
from scipy.io import netcdf_file

DATA = Path(__file__).parents[2] / "data"
RHO, G, VOLUME, ZG = 1025.0, 9.81, 2.026395382746873, -0.2
WRITTEN = 1e-6  # relative: as many digits
SPHERE = 0.03  # relative: moments of flat panels inscribed in a sphere
POINT = -0.7  # [m] height of the point about which NEMOH turns
MODES = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
CAL = """--- Environment ---
1025.0 ! RHO ! KG/M**3
9.81 ! G ! M/S**2
%s ! DEPTH ! M
0. 0. ! XEFF YEFF
--- Description of floating bodies ---
%s ! Number of bodies
--- Body 1 ---
hemisphere.dat ! Name of mesh file
500 480 ! Number of points and number of panels
6 ! Number of degrees of freedom
1 1. 0. 0. 0. 0. 0. ! Surge
1 0. 1. 0. 0. 0. 0. ! Sway
1 0. 0. 1. 0. 0. 0. ! Heave
2 1. 0. 0. 0. 0. -0.7 ! Roll about a point
2 0. 1. 0. 0. 0. -0.7 ! Pitch about a point
2 0. 0. 1. 0. 0. -0.7 ! Yaw about a point
6 ! Number of resulting generalised forces
"""


@pytest.fixture(scope="module")
def hull() -> Coefficients:
    return wamit(DATA / "hemisphere.1", VOLUME, ZG, 1.0)


def around(of: Coefficients, step: float = 15.0) -> Coefficients:
    """The same loads between headings, every 15 degrees."""
    headings = np.radians(np.arange(0.0, 181.0, step))
    X = np.array([[np.interp(headings, of.headings, row) for row in x] for x in of.X.transpose(1, 2, 0)])
    return replace(of, headings=headings, X=X.transpose(2, 0, 1))


def table(title: str, first: np.ndarray, pairs: np.ndarray) -> str:
    """A zone with rows of `first` and pairs (n, 6, 2)."""
    rows = np.column_stack([first, pairs.reshape(len(first), -1)])
    lines = [" ".join(f"{x:14.7E}" for x in row) for row in rows]
    return f'Zone t="{title}",I={len(first):6d},F=POINT\n' + "\n".join(lines) + "\n"


def written(folder: Path, of: Coefficients, depth: str = "0.", bodies: int = 1, irf: bool = True) -> Path:
    """The hull about POINT: the load on a moving point M (forces, then moments) is T^-T of that at the origin."""
    T = np.eye(6)
    T[0, 4], T[1, 3] = -POINT, POINT
    A, B, A_inf = (T.T @ x @ T for x in (of.A, of.B, of.A_inf))
    X = of.X @ T
    for name in ("Results", "Mesh"):
        (folder / name).mkdir()
    heads = "".join(f'"A   1   {i}" "B   1   {i}"\n' for i in range(1, 7))
    zones = [table(f"Motion of body    1 in DoF   {i + 1}", of.w, np.stack([A[:, i], B[:, i]], -1)) for i in range(6)]
    (folder / "Results/RadiationCoefficients.tec").write_text('VARIABLES="w (rad/s)"\n' + heads + "".join(zones))
    waves = [
        table(f"Diffraction force - beta = {np.degrees(b):9.5f} deg", of.w, np.stack([abs(x), -np.angle(x)], -1))
        for b, x in zip(of.headings, X, strict=True)
    ]
    (folder / "Results/ExcitationForce.tec").write_text('VARIABLES="w (rad/s)"\n' + heads + "".join(waves))
    times = np.array([0.0, 0.1])
    memory = [table(f"DoF {i}", times, np.stack([np.stack([x, 0.0 * x], -1)] * 2)) for i, x in enumerate(A_inf)]
    if irf:
        (folder / "Results/IRF.tec").write_text('VARIABLES="Time (s)"\n' + heads + "".join(memory))
    np.savetxt(folder / "Mesh/KH.dat", of.hulls[0].K, fmt="%1.7E")
    (folder / "Mesh/Hydrostatics.dat").write_text(
        " XF =   0.000 - XG =   0.000\n YF =   0.000 - YG =   0.000\n ZF =  -0.370 - ZG =  -0.200\n"
        f" Displacement =  {VOLUME:.8E}\n Waterplane area =  0.3100000E+01\n"
    )
    (folder / "Nemoh.cal").write_text(CAL % (depth, bodies))
    return folder / "Nemoh.cal"


def test_nemoh_files_give_the_hull_coefficients_of_wamit_and_capytaine_files(
    tmp_path: Path, hull: Coefficients
) -> None:
    other = nemoh(written(tmp_path, hull))
    for name in ("w", "A", "B", "A_inf", "headings", "X", "K", "volume", "height", "density", "gravity", "depth"):
        of = (hull, other) if hasattr(hull, name) else (hull.hulls[0], other.hulls[0])
        one, two = (np.asarray(getattr(x, name)) for x in of)
        if np.isfinite(one).all():
            assert np.abs(one - two).max() <= 30.0 * WRITTEN * max(float(np.abs(one).max()), 1.0), name
        assert (np.isinf(one) == np.isinf(two)).all(), name


def test_nemoh_moments_about_another_point_are_transferred_to_the_centre_of_a_sphere(
    tmp_path: Path, hull: Coefficients
) -> None:
    """Pressure on a sphere passes through its centre, here the origin: all moments vanish against force times POINT."""
    of = nemoh(written(tmp_path, hull))
    force = np.abs(of.X[0, :, 0]).max()
    assert np.abs(of.X[0, :, 4]).max() < SPHERE * abs(POINT) * force
    assert np.abs(of.A[:, 4, 4]).max() < SPHERE * POINT**2 * of.A[:, 0, 0].max()


def test_a_recording_states_the_file_hash_and_the_water_depth_of_its_nemoh_data(
    tmp_path: Path, hull: Coefficients
) -> None:
    found = hull_of(written(tmp_path, around(hull), "12."))
    assert found.depth == 12.0
    assert found.buoyancy == (0.0, 0.0, -0.37)
    name, digest = found.source.split(", SHA-256 ")
    assert (name, len(digest)) == ("Nemoh.cal", 64)
    path = tmp_path / "Mesh/KH.dat"
    path.write_text(path.read_text() + "\n")
    assert hull_of(tmp_path / "Nemoh.cal").source != found.source


BAD = {
    "bodies": "compute one body, with all rotations about one point",
    "irf": "IRF.tec: .*impulse responses",
    "Results/ExcitationForce.tec": "its zones are missing or differ in size",
    "Mesh/KH.dat": "it is not a matrix for six motions",
    "Mesh/Hydrostatics.dat": "it has no 'ZG' and 'Displacement'",
    "Nemoh.cal": "it is not a Nemoh.cal of a body with six degrees of freedom",
}


@pytest.mark.parametrize("what", BAD)
def test_incomplete_files_of_nemoh_are_refused_in_one_sentence(tmp_path: Path, hull: Coefficients, what: str) -> None:
    path = written(tmp_path, hull, bodies=1 + (what == "bodies"), irf=what != "irf")
    if "." in what:
        (tmp_path / what).write_text("1 2 3\n")
    with pytest.raises(SceneError, match=BAD[what]):
        nemoh(path)


EDITS = {
    "its phases refer to XEFF, YEFF": ("Nemoh.cal", "0. 0. ! XEFF", "0. 3. ! XEFF"),
    "its output frequencies are not in rad/s": (
        "Nemoh.cal",
        "6 ! Number of res",
        "2 ! output freq type\n6 ! Number of res",
    ),
    "frequencies must ascend, and be the same": ("Results/ExcitationForce.tec", " 9.9045442E-01", " 9.8045442E-01"),
}


@pytest.mark.parametrize("sentence", EDITS)
def test_nemoh_files_with_other_conventions_are_refused(tmp_path: Path, hull: Coefficients, sentence: str) -> None:
    path, (file, old, new) = written(tmp_path, hull), EDITS[sentence]
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    with pytest.raises(SceneError, match=sentence):
        nemoh(path)


@pytest.mark.parametrize("wrong", ["cut", "two depths", "no loads", "one heading"])
def test_netcdf_files_with_missing_or_wrong_arrays_are_refused_in_one_sentence(tmp_path: Path, wrong: str) -> None:
    import h5py

    path = tmp_path / "bad.nc"
    if wrong == "cut":
        path.write_bytes(b"CDF\1")
    else:
        with h5py.File(hdf5(path, [*range(6)]), "r+") as tree:
            changed = {
                "two depths": {"added_mass": np.repeat(tree["added_mass"][:][:, None], 2, 1)},
                "no loads": {"excitation_force": np.nan * tree["excitation_force"][:]},
                "one heading": {
                    "wave_direction": np.zeros(1), "excitation_force": tree["excitation_force"][:][:, :, :1]
                },
            }[wrong]  # fmt: skip
            for name, x in changed.items():
                del tree[name]
                tree[name] = x
    sentences = {"cut": "not a netCDF file", "two depths": "or of two, at rest in water of a single depth",
                 "no loads": "it needs two or more frequencies", "one heading": "at least two of each"}  # fmt: skip
    with pytest.raises(SceneError, match=rf"bad.nc: .*{sentences[wrong]}"):
        hull_of(path)


def hdf5(path: Path, order: list[int], point: float = 0.0, modes: tuple[str, ...] = MODES) -> Path:
    """The netCDF file of the hemisphere as version 4, with its motions in another order."""
    import h5py

    with netcdf_file(DATA / "hemisphere.nc", "r", mmap=False) as file:
        data = {name: np.array(x.data) for name, x in file.variables.items()}
    n = len(data["omega"])
    with h5py.File(path, "w") as tree:
        for name, x in data.items():
            if name in ("added_mass", "radiation_damping", "hydrostatic_stiffness"):
                whole = x.reshape(-1, 6, 6)[:, order][:, :, order]
                tree[name] = whole[0] if name == "hydrostatic_stiffness" else whole
            elif name == "excitation_force":
                tree[name] = x.reshape(2, n, -1, 6)[..., order]
            elif name in ("influenced_dof", "radiating_dof"):
                tree[name] = [modes[i] for i in order]
            elif x.dtype.kind == "f" and name != "rotation_center":
                tree[name] = x
        tree["rotation_center"] = [point, 0.0, 0.0]
    return path


def test_netcdf_4_files_with_motions_in_any_order_give_the_same_hull_coefficients(
    tmp_path: Path, hull: Coefficients
) -> None:
    other = capytaine(hdf5(tmp_path / "four.nc", [2, 4, 3, 0, 1, 5]))
    pairs = [(name, getattr(hull, name), getattr(other, name)) for name in ("w", "A", "B", "A_inf", "X")]
    for name, one, two in (*pairs, ("K", hull.hulls[0].K, other.hulls[0].K)):
        assert np.abs(one - two).max() <= 30.0 * WRITTEN * max(float(np.abs(one).max()), 1.0), name


def test_netcdf_hull_data_are_read_without_the_wave_frequencies_that_have_no_solution(
    tmp_path: Path, hull: Coefficients
) -> None:
    """Capytaine writes NaN for long waves on shallow water."""
    import h5py

    with h5py.File(hdf5(tmp_path / "four.nc", [*range(6)]), "r+") as tree:
        first = int(np.argmin(tree["omega"][:]))
        tree["added_mass"][first] = np.nan
    other = capytaine(tmp_path / "four.nc")
    assert other.w == pytest.approx(hull.w[1:])
    assert np.isfinite(other.A).all()
    assert np.abs(other.X - hull.X[:, 1:]).max() <= 30.0 * WRITTEN * np.abs(hull.X).max()


def test_netcdf_data_of_three_bodies_or_of_rotations_about_another_axis_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"its rotations are about .* compute them about a point of the z axis"):
        capytaine(hdf5(tmp_path / "off.nc", [*range(6)], 2.0))
    named = tuple(f"{'abc'[i // 2]}__{mode}" for i, mode in enumerate(MODES))
    with pytest.raises(SceneError, match=r"one body or two with motions Surge, .* it has a__Surge"):
        capytaine(hdf5(tmp_path / "two.nc", [*range(6)], 0.0, named))


def test_reading_netcdf_4_without_h5py_is_refused_with_the_name_of_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = hdf5(tmp_path / "four.nc", [*range(6)])
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(SceneError, match=r"netCDF of version 4 needs h5py: pip install 'heavylift\[sea\]'"):
        capytaine(path)
