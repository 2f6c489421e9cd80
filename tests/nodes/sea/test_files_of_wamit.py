"""Coefficients in files of WAMIT: conventions against physics, and against the same hull in a file of Capytaine."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Hydrodynamics, MeanDrift, hull_of, read_hydrodynamics
from msgspec.structs import replace

ROUNDED = 2e-6  # relative: six digits are written
EVERY = 3  # of its frequencies, to make the fit short
LENGTH, HEIGHT = 10.0, 1.5  # [m] ULEN, and of the centre of mass


def bundled() -> Hydrodynamics:
    path = vessels_folder() / "barge-110.json"
    return read_hydrodynamics(path.read_bytes(), path.name)


def written(folder: Path, of: Hydrodynamics) -> Path:
    """The hull as WAMIT's manual has it: relative to rho, g and ULEN, for exp(iwt), by periods and degrees."""
    w, rho, g = np.array(of.loads.frequencies)[::EVERY], 1025.0, 9.81
    F, R = np.array(of.radiation.F), np.array(of.radiation.G)
    K = R.T @ np.linalg.solve(1j * w[:, None, None] * np.eye(len(F)) - F, R.astype(complex))
    A, B = K.imag / w[:, None, None] + np.array(of.added_mass), K.real
    turns = np.arange(6) > 2
    both = LENGTH ** (3.0 + turns[:, None] + turns)
    rows = [f"0 {i + 1} {j + 1} {of.added_mass[i][j] / rho / both[i, j]:.6e}" for i in range(6) for j in range(6)]
    rows += [
        f"{2 * np.pi / w[n]:.8e} {i + 1} {j + 1} {A[n, i, j] / rho / both[i, j]:.6e}"
        f" {B[n, i, j] / rho / both[i, j] / w[n]:.6e}"
        for n in range(len(w)) for i in range(6) for j in range(6)
    ]  # fmt: skip
    (folder / "barge.1").write_text("\n".join(rows))
    X = (np.array(of.loads.real) + 1j * np.array(of.loads.imaginary))[:, ::EVERY]
    X /= rho * g * LENGTH ** (2.0 + turns)
    rows = [
        f"{2 * np.pi / w[n]:.8e} {np.degrees(b):.6f} {i + 1} {abs(x):.6e} {np.degrees(np.angle(x)):.4f}"
        f" {x.real:.6e} {x.imag:.6e}"
        for m, b in enumerate(of.loads.headings) for n in range(len(w)) for i, x in enumerate(X[m, n])
    ]  # fmt: skip
    (folder / "barge.3").write_text("PER BETA I MOD PHASE RE IM\n" + "\n".join(rows))
    heave = of.waterplane / LENGTH**2
    tilts = [of.volume * (z - HEIGHT) / LENGTH**4 for z in of.metacentres]
    rows = [f"{i} {i} {x:.8e}" for i, x in zip((3, 4, 5), (heave, *tilts), strict=True)]
    (folder / "barge.hst").write_text("\n".join(rows))
    return folder / "barge.1"


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Hydrodynamics:
    of = bundled()
    return hull_of(written(tmp_path_factory.mktemp("wamit"), of), of.volume, HEIGHT, LENGTH)


def test_a_hull_is_read_from_files_of_wamit_whose_hash_is_recorded(found: Hydrodynamics) -> None:
    of = bundled()
    assert found.waterplane == pytest.approx(of.waterplane, rel=ROUNDED)
    assert found.metacentres == pytest.approx(of.metacentres, rel=ROUNDED)
    largest = np.sqrt(np.outer(*2 * [np.diag(of.added_mass)]))
    assert np.abs((np.array(found.added_mass) - np.array(of.added_mass)) / largest).max() < ROUNDED
    for w, heading in zip(of.loads.frequencies[: 3 * EVERY : EVERY], (0.3, 2.0, -1.0), strict=True):
        want = np.array(of.load(w, heading))
        assert np.abs(np.array(found.load(w, heading)) - want).max() < 1e-4 * np.abs(want).max()
    name, digest = found.source.split(", SHA-256 ")
    assert (name, len(digest)) == ("barge.1", 64)


def test_heave_loads_in_long_waves_tend_to_the_waterplane_stiffness_and_surge_loads_lead_the_crest(
    found: Hydrodynamics,
) -> None:
    """X3 tends to rho g Aw, in phase with the elevation; a following wave pushes ahead before its crest: X1 is +i."""
    X = found.load(found.loads.frequencies[0], 0.0)
    assert X[2].real == pytest.approx(1025.0 * 9.81 * found.waterplane, rel=0.1)
    assert abs(X[2].imag) < 0.1 * X[2].real
    assert X[0].imag > 5.0 * abs(X[0].real)


def test_volume_and_centres_of_a_hull_are_read_from_the_output_of_wamit(tmp_path: Path, found: Hydrodynamics) -> None:
    """As WAMIT prints them: the same hull without options, and the centre of buoyancy for its trim."""
    of = bundled()
    path = written(tmp_path, of)
    rows = [" XBODY =    0.0000 YBODY =    0.0000 ZBODY =    0.0000 PHIBODY =   0.0",
            f" Volumes (VOLX,VOLY,VOLZ):    {of.volume + 3.0:.3f}      {of.volume:.3f}      {of.volume - 4.0:.3f}",
            " Center of Buoyancy (Xb,Yb,Zb):     0.500000      0.000000     -2.000000",
            f" Center of Gravity  (Xg,Yg,Zg):     0.000000      0.000000      {HEIGHT:.6f}"]  # fmt: skip
    path.with_suffix(".out").write_text("\n".join(["  WAMIT  Version 7.0", *rows]))
    other = hull_of(path, length=LENGTH)
    assert other.buoyancy == (0.5, 0.0, -2.0)
    assert (other.volume, other.metacentres) == (found.volume, found.metacentres)
    path.with_suffix(".out").write_text("\n".join(rows[:2]))
    with pytest.raises(SceneError, match=r"barge.out: it must give volume, centres and position"):
        hull_of(path, length=LENGTH)


MISSING = {
    "barge.3": ("", "its rows need at least 7 numbers"),
    "barge.1": ("6 1 1 0.2 0.1", "the added mass at infinite frequency is missing; compute period 0"),
    "barge.hst": ("7 7 1", "it has more than 6 modes"),
}


@pytest.mark.parametrize("file", MISSING)
def test_incomplete_files_of_wamit_are_refused_in_one_sentence(tmp_path: Path, file: str) -> None:
    path = written(tmp_path, bundled())
    text, sentence = MISSING[file]
    (tmp_path / file).write_text(text)
    with pytest.raises(SceneError, match=sentence):
        hull_of(path, 14080.0)


@pytest.mark.parametrize(("file", "sentence"), [
    ("barge.3", "it needs all six modes at each heading"), ("barge.1", "its pairs of modes differ between periods"),
])  # fmt: skip
def test_a_missing_load_row_in_a_wamit_file_is_refused_and_not_read_as_zero(
    tmp_path: Path, file: str, sentence: str
) -> None:
    path = written(tmp_path, bundled())
    rows = (tmp_path / file).read_text().splitlines()
    (tmp_path / file).write_text("\n".join(rows[:50] + rows[51:]))
    with pytest.raises(SceneError, match=sentence):
        hull_of(path, 14080.0)


HEADINGS = {
    (0.0,): "at least two",
    (-30.0, 0.0, 30.0): "cover",
    (0.0, 45.0, 90.0): "cover",
    (0.0, 90.0, 180.0): "cover",
}
HEADINGS |= {(200.0,): "gaps of at most 45 deg", (*np.arange(-180.0, 200.0, 60.0),): "gaps of at most 45 deg"}


@pytest.mark.parametrize("degrees", HEADINGS)
def test_wave_headings_that_do_not_cover_all_directions_around_a_hull_are_refused(
    tmp_path: Path, degrees: tuple[float, ...]
) -> None:
    of = bundled()
    n, loads = len(degrees), of.loads
    headings = tuple(np.radians(degrees).tolist())
    cut = replace(loads, headings=headings, real=loads.real[:n], imaginary=loads.imaginary[:n])
    with pytest.raises(SceneError, match=HEADINGS[degrees]):
        hull_of(written(tmp_path, replace(of, loads=cut)), of.volume, HEIGHT, LENGTH)
    if n > 1:
        with pytest.raises(SceneError, match="must cover"):
            read_hydrodynamics(msgspec.json.encode(replace(of, loads=cut)), "barge.json")


def test_data_for_one_side_of_an_asymmetric_hull_and_negative_depths_are_refused() -> None:
    for wrong, sentence in (({"symmetric": False}, "must cover"), ({"depth": -5.0}, "depth .* must be positive")):
        with pytest.raises(SceneError, match=sentence):
            read_hydrodynamics(msgspec.json.encode(replace(bundled(), **wrong)), "barge.json")


def test_drift_forces_of_one_side_are_mirrored_for_wave_loads_of_both_sides() -> None:
    """The sign of sway and yaw is another on the other side, whatever the headings of the wave loads are."""
    of = bundled()
    turns = tuple(x for x in of.loads.headings)
    both = tuple(-x for x in turns[:0:-1]) + turns
    rows = [[of.load(w, b) for w in of.loads.frequencies] for b in both]
    loads = replace(of.loads, headings=both, real=tuple(tuple(tuple(x.real for x in X) for X in row) for row in rows),
                    imaginary=tuple(tuple(tuple(x.imag for x in X) for X in row) for row in rows))  # fmt: skip
    values = tuple(((100.0 * b, 10.0 * b, b),) * 2 for b in turns)
    whole = replace(of, loads=loads, symmetric=False, drift=MeanDrift((0.5, 1.0), turns, values))
    for angle in (0.4, 1.5, 2.9):
        x, y, yaw = whole.drifting(0.7, angle)
        assert whole.drifting(0.7, -angle) == pytest.approx([x, -y, -yaw])
        assert whole.load(0.7, -angle) == pytest.approx(of.load(0.7, -angle))


def test_files_of_wamit_without_a_displaced_volume_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="give it with --volume"):
        hull_of(written(tmp_path, bundled()))
