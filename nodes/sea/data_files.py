"""Hydrodynamic coefficients of a hull from files of other codes, with their conventions turned into those used here.

WAMIT (user manual, version 7, chapter 4): NAME.1 has periods [s], modes, added mass and damping relative to rho L^k and
rho L^k w, k = 3 for two translations, 4 for mixed modes, 5 for two rotations; the period 0 is infinite frequency, a
negative one infinitely long. NAME.3 has periods, headings [deg] to which the waves travel, modes, modulus, phase, and
the real and imaginary part of the load relative to rho g L^m, m = 2 or 3, for the time factor exp(+iwt) as here.
NAME.hst has the hydrostatic stiffness relative to rho g L^k, k = 2, 3 or 4. All refer to the origin of the body's axes.

Capytaine (Ancellin, Dias, Journal of Open Source Software 4 (2019) 1341): netCDF in SI units, for exp(-iwt), so the
conjugates of its loads are those used here; rotations are about `rotation_center`.
"""

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import SceneError, error_text, extra

NEEDED = (
    "omega",
    "wave_direction",
    "added_mass",
    "radiation_damping",
    "excitation_force",
    "hydrostatic_stiffness",
    "disp_mass",
)
MODES = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
HDF5 = b"\x89HDF"  # how such a file begins
DENSITY, GRAVITY = 1025.0, 9.81  # [kg/m3], [m/s2] where a file does not give them


@dataclass(frozen=True)
class Coefficients:
    """Coefficients by frequency w (n,) [rad/s], in ascending order: added mass A and damping B (n, 6, 6), added mass at
    infinite frequency (6, 6), loads X (headings, n, 6) by heading [rad] for exp(+iwt), hydrostatic stiffness K (6, 6),
    displaced volume [m3], height of the centre of mass to which K belongs [m], density [kg/m3], gravity [m/s2], depth
    of the water [m] and the centre of buoyancy [m], if it is known."""

    w: np.ndarray
    A: np.ndarray
    B: np.ndarray
    A_inf: np.ndarray
    headings: np.ndarray
    X: np.ndarray
    K: np.ndarray
    volume: float
    height: float
    density: float = DENSITY
    gravity: float = GRAVITY
    depth: float = inf
    buoyancy: np.ndarray | None = None

    def about(self, z: float) -> "Coefficients":
        """Return the coefficients transformed to rotations and moments about the origin, if the present ones are about
        a point at the height z [m]."""
        T = np.eye(6)  # velocities there, of those at the origin
        T[0, 4], T[1, 3] = z, -z
        A, B, A_inf = (T.T @ x @ T for x in (self.A, self.B, self.A_inf))
        return replace(self, A=A, B=B, A_inf=A_inf, X=self.X @ T)


def capytaine(path: Path) -> Coefficients:
    """Return the coefficients in a netCDF file of Capytaine; raises SceneError for any other file."""
    data = _netcdf(path)
    if missing := [name for name in NEEDED if name not in data]:
        raise SceneError(f"{path}: it has no '{missing[0]}'; let Capytaine export radiation, diffraction, hydrostatics")
    modes, point = _named(data, path), data.get("rotation_center", np.zeros(3)).ravel()
    if point[:2].any():
        raise SceneError(f"{path}: its rotations are about {point.tolist()}; compute them about a point of the z axis")
    w, both = data["omega"], np.ix_(modes, modes)
    try:
        A, B = (data[key].reshape(len(w), 6, 6)[:, both[0], both[1]] for key in ("added_mass", "radiation_damping"))
        X = data["excitation_force"].reshape(2, len(w), len(data["wave_direction"]), 6)[..., modes]
        K = data["hydrostatic_stiffness"].reshape(6, 6)[both]
    except (ValueError, TypeError):
        raise SceneError(
            f"{path}: its arrays must be those of a single body at rest in water of a single depth"
        ) from None
    solved = np.isfinite(A).all(axis=(1, 2))  # Capytaine writes NaN where it finds no solution
    finite = np.isfinite(w) & (w > 0.0) & solved & np.isfinite(X).all(axis=(0, 2, 3))
    infinite = np.isinf(w) & solved
    if not infinite.any():
        raise SceneError(f"{path}: it has no infinite frequency, whose added mass is needed; add it to 'omega'")
    order = np.argsort(w[finite])
    X = X[:, finite][:, order].swapaxes(1, 2)
    given = {"rho": DENSITY, "g": GRAVITY, "water_depth": inf}
    rho, g, depth = (float(data[key].ravel()[0]) if key in data else x for key, x in given.items())
    z = float(data["center_of_mass"].ravel()[2]) if "center_of_mass" in data else 0.0
    return Coefficients(
        w[finite][order], A[finite][order], B[finite][order], A[infinite][0], data["wave_direction"], X[0] - 1j * X[1],
        K, float(data["disp_mass"].ravel()[0]) / rho, z, rho, g, depth,
        data.get("center_of_buoyancy"),
    ).about(float(point[2]))  # fmt: skip


def _netcdf(path: Path) -> dict[str, np.ndarray]:
    """Return the variables of a netCDF file, classic or of version 4, which is HDF5."""
    from scipy.io import netcdf_file

    try:
        with path.open("rb") as file:
            if file.read(len(HDF5)) == HDF5:
                h5py = extra(
                    "h5py", SceneError(f"{path}: netCDF of version 4 needs h5py: pip install 'heavylift[sea]'")
                )
                with h5py.File(path) as tree:
                    return {name: np.array(x) for name, x in tree.items()}
        with netcdf_file(path, "r", mmap=False) as classic:
            return {name: np.array(x.data) for name, x in classic.variables.items()}
    except (TypeError, IndexError, KeyError):
        raise SceneError(f"{path}: it is not a netCDF file") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {error_text(error)}") from None


def _named(data: dict[str, np.ndarray], path: Path) -> list[int]:
    """Return the places of the six modes in the order of a file, which names them."""
    found = []
    for key in ("influenced_dof", "radiating_dof"):
        if key in data:
            rows = [b"".join(x) if isinstance(x, np.ndarray) else x for x in data[key]]
            found.append([x.decode().strip("\0 ") for x in rows])
    names = found[0] if found else list(MODES)
    if any(sorted(x) != sorted(MODES) or x != names for x in found):
        raise SceneError(f"{path}: one body with motions {', '.join(MODES)} is needed; it has {', '.join(names)}")
    return [names.index(mode) for mode in MODES]


def wamit(path: Path, volume: float, height: float, length: float, depth: float = inf) -> Coefficients:
    """Return the coefficients in the files NAME.1, NAME.3 and NAME.hst of WAMIT.

    `volume`: displaced [m3]; `height`: of the centre of mass for which WAMIT computed NAME.hst [m]; `length`: ULEN [m].
    Raises SceneError if a file is missing or has other columns.
    """
    radiation, loads, stiffness = (_table(path.with_suffix(end), n) for end, n in ((".1", 4), (".3", 7), (".hst", 3)))
    i, j = _modes(radiation, path.with_suffix(".1"), 1, 2)
    row, w, periods = _by(radiation[:, 0])
    added, damping = (np.full((len(periods), 6, 6), np.nan) for _ in range(2))
    size = DENSITY * length ** (3.0 + (i > 2) + (j > 2))
    added[row, i, j], damping[row, i, j] = size * radiation[:, 3], size * radiation[:, 4] * w
    for x in (added, damping):
        x[:, np.isnan(x).all(axis=0)] = 0.0  # symmetry makes them vanish, and WAMIT leaves them out
    if np.isnan(added[periods >= 0.0]).any():
        raise SceneError(f"{path.with_suffix('.1')}: it needs the same pairs of modes at each period")
    if 0.0 not in periods:
        raise SceneError(
            f"{path.with_suffix('.1')}: it has no infinite frequency, whose added mass is needed: period 0"
        )
    at, _, waves = _by(loads[:, 0])
    headings, of = np.unique(np.radians(loads[:, 1]), return_inverse=True)
    (mode,) = _modes(loads, path.with_suffix(".3"), 2)
    X = np.full((len(headings), len(waves), 6), np.nan + 0j)
    X[of, at, mode] = DENSITY * GRAVITY * length ** (2.0 + (mode > 2)) * (loads[:, 5] + 1j * loads[:, 6])
    if waves.tolist() != periods[periods > 0.0].tolist():
        raise SceneError(f"{path.with_suffix('.3')}: its periods differ from those of {path.stem}.1")
    if np.isnan(X).any():
        raise SceneError(f"{path.with_suffix('.3')}: it needs all six modes at each heading and period")
    i, j = _modes(stiffness, path.with_suffix(".hst"), 0, 1)
    K = np.zeros((6, 6))
    K[i, j] = DENSITY * GRAVITY * length ** (2.0 + (i > 2) + (j > 2)) * stiffness[:, 2]
    w = 2.0 * np.pi / periods[periods > 0.0]
    up = np.argsort(w)
    some = np.flatnonzero(periods > 0.0)[up]
    return Coefficients(
        w[up], added[some], damping[some], added[periods == 0.0][0], headings, X[:, up], K, volume, height, depth=depth
    )


def drift_of(path: Path, weight: float, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequencies [rad/s], headings [rad] and mean drift (headings, frequencies, 3) in surge, sway and yaw from
    a WAMIT file NAME.8 or NAME.9. `weight`: specific weight of the water [N/m3]; `length`: ULEN [m].

    Its columns are period [s], two headings [deg] of which equal ones count, mode, modulus, phase, real and imaginary
    part relative to rho g L^m, m = 1 or 2. Raises SceneError if the file has other contents.
    """
    rows = _table(path, 7)
    rows = rows[(rows[:, 1] == rows[:, 2]) & np.isin(rows[:, 3], (1.0, 2.0, 6.0))]
    (mode,) = _modes(rows, path, 3)
    w, at = np.unique(2.0 * np.pi / rows[:, 0], return_inverse=True)
    headings, of = np.unique(np.radians(rows[:, 1]), return_inverse=True)
    values = np.full((len(headings), len(w), 6), np.nan)
    values[of, at, mode] = weight * length ** (1.0 + (mode > 2)) * rows[:, 6]
    values = values[..., [0, 1, 5]]
    if np.isnan(values).any() or min(len(w), len(headings)) < 2:
        raise SceneError(f"{path}: it needs surge, sway and yaw at each of two or more headings and periods")
    return w, headings, values


def _by(periods: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the index of each row's period, the frequency of each row (0 where it has none), and the periods."""
    known, at = np.unique(periods, return_inverse=True)
    return at, np.divide(2.0 * np.pi, periods, out=np.zeros(len(periods)), where=periods > 0.0), known


def _modes(table: np.ndarray, path: Path, *columns: int) -> list[np.ndarray]:
    """Return columns of modes 1 to 6 as indices."""
    found = [table[:, k].astype(int) - 1 for k in columns]
    if any((x < 0).any() or (x > 5).any() for x in found):
        raise SceneError(f"{path}: it has modes beyond the six of one body; write a file for each body alone")
    return found


def _table(path: Path, least: int) -> np.ndarray:
    """Return the rows of numbers in a text file, filled with zeros to equal length; a header is left out."""
    rows = []
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            words = line.split()
            try:
                rows.append([float(x.replace("D", "E")) for x in words])
            except ValueError:
                if rows:
                    raise SceneError(f"{path}: '{line.strip()[:40]}' is not a row of numbers") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: {error_text(error)}") from None
    if not (rows := [row for row in rows if row]) or min(map(len, rows)) < least:
        raise SceneError(f"{path}: its rows need at least {least} numbers")
    width = max(map(len, rows))
    return np.array([row + [0.0] * (width - len(row)) for row in rows])
