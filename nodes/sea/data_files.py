"""Hydrodynamic coefficients of a hull from files of other codes, with their conventions turned into those used here.

WAMIT (user manual, version 7, chapter 4): NAME.1 has periods [s], modes, added mass and damping relative to rho L^k and
rho L^k w, k = 3 for two translations, 4 for mixed modes, 5 for two rotations; the period 0 is infinite frequency, a
negative one infinitely long. NAME.3 has periods, headings [deg] to which the waves travel, modes, modulus, phase, and
the real and imaginary part of the load relative to rho g L^m, m = 2 or 3, for the time factor exp(+iwt) as here.
NAME.hst has the hydrostatic stiffness relative to rho g L^k, k = 2, 3 or 4. All refer to the origin of the body's axes.

Capytaine (Ancellin, Dias, Journal of Open Source Software 4 (2019) 1341): netCDF in SI units, for exp(-iwt), so the
conjugates of its loads are those used here; rotations are about `rotation_center`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import SceneError, error_text, extra

from .spectra import wave_number

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
class Still:
    """A hull at rest: hydrostatic stiffness K (6, 6), displaced volume [m3], and centre of buoyancy, if it is known.

    Also the height of the centre of mass to which K belongs [m], and the place x, y [m] of its axes."""

    K: np.ndarray
    volume: float
    height: float
    buoyancy: np.ndarray | None = None
    at: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Coefficients:
    """Added mass, damping and wave loads of one or two hulls at rest by frequency w (n,) [rad/s], in ascending order.

    Added mass A and damping B (n, m, m), added mass at infinite frequency (m, m), loads X (headings, n, m) by heading
    [rad] for exp(+iwt), with six modes for each hull; density [kg/m3], gravity [m/s2] and depth of the water [m]."""

    w: np.ndarray
    A: np.ndarray
    B: np.ndarray
    A_inf: np.ndarray
    headings: np.ndarray
    X: np.ndarray
    hulls: tuple[Still, ...]
    density: float = DENSITY
    gravity: float = GRAVITY
    depth: float = inf

    def about(self, *points: Sequence[float]) -> "Coefficients":
        """Return the coefficients about new reference points, on the waterline vertically above or below the old ones.

        The coefficients refer to the given points, the phases of the loads to the origin of the file, before this."""
        T, X = np.eye(6 * len(points)), self.X.copy()  # velocities there, of those on the waterline
        k = np.array([wave_number(w, self.gravity, self.depth if isfinite(self.depth) else None) for w in self.w])
        for i, (x, y, z) in enumerate(points):
            T[6 * i, 6 * i + 4], T[6 * i + 1, 6 * i + 3] = z, -z
            away = np.cos(self.headings) * x + np.sin(self.headings) * y
            X[..., 6 * i : 6 * i + 6] *= np.exp(1j * away[:, None] * k)[..., None]
        A, B, A_inf = (T.T @ x @ T for x in (self.A, self.B, self.A_inf))
        return replace(self, A=A, B=B, A_inf=A_inf, X=X @ T)


def capytaine(path: Path) -> Coefficients:
    """Return the coefficients of one hull or two in a netCDF file of Capytaine; raises SceneError for other files."""
    data = _netcdf(path)
    if missing := [name for name in NEEDED if name not in data]:
        raise SceneError(f"{path}: it has no '{missing[0]}'; let Capytaine export radiation, diffraction, hydrostatics")
    modes = _named(data, path)
    m, w, both = len(modes), data["omega"], np.ix_(modes, modes)
    try:
        points, centres = (
            data[key].reshape(-1, 3) if key in data else np.zeros((m // 6, 3))
            for key in ("rotation_center", "center_of_mass")
        )
        A, B = (data[key].reshape(len(w), m, m)[:, both[0], both[1]] for key in ("added_mass", "radiation_damping"))
        X = data["excitation_force"].reshape(2, len(w), len(data["wave_direction"]), m)[..., modes]
        K, masses = data["hydrostatic_stiffness"].reshape(m, m)[both], data["disp_mass"].reshape(m // 6)
    except (ValueError, TypeError):
        raise SceneError(
            f"{path}: its arrays must be those of a single body, or of two, at rest in water of a single depth"
        ) from None
    if m == 6 and points[0, :2].any():
        turned = points[0].tolist()
        raise SceneError(f"{path}: its rotations are about {turned}; compute them about a point of the z axis")
    solved = np.isfinite(A).all(axis=(1, 2))  # Capytaine writes NaN where it finds no solution
    finite = np.isfinite(w) & (w > 0.0) & solved & np.isfinite(X).all(axis=(0, 2, 3))
    infinite = np.isinf(w) & solved
    if not infinite.any():
        raise SceneError(f"{path}: the added mass at infinite frequency is missing; add it to 'omega'")
    order = np.argsort(w[finite])
    X = X[:, finite][:, order].swapaxes(1, 2)
    given = {"rho": DENSITY, "g": GRAVITY, "water_depth": inf}
    rho, g, depth = (float(data[key].ravel()[0]) if key in data else x for key, x in given.items())
    buoyancy = data["center_of_buoyancy"].reshape(-1, 3) if "center_of_buoyancy" in data else None
    hulls = tuple(
        Still(K[6 * i : 6 * i + 6, 6 * i : 6 * i + 6], float(masses[i]) / rho, float(centres[i, 2]),
              None if buoyancy is None else buoyancy[i] - (*p[:2], 0.0), (float(p[0]), float(p[1])))
        for i, p in enumerate(points)
    )  # fmt: skip
    return Coefficients(
        w[finite][order], A[finite][order], B[finite][order], A[infinite][0], data["wave_direction"], X[0] - 1j * X[1],
        hulls, rho, g, depth,
    ).about(*points.tolist())  # fmt: skip


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
    bodies = list(dict.fromkeys(name.rpartition("__")[0] for name in names))
    needed = [f"{body}__{mode}" if body else mode for body in bodies for mode in MODES]
    if len(bodies) > 2 or any(sorted(x) != sorted(needed) or x != names for x in found):
        wanted = f"one body or two with motions {', '.join(MODES)} are needed"
        raise SceneError(f"{path}: {wanted}; it has {', '.join(names)}")
    return [names.index(mode) for mode in needed]


def wamit(path: Path, volume: float, height: float, length: float, depth: float = inf) -> Coefficients:
    """Return the coefficients of a hull, or of two, in the files NAME.1, NAME.3 and NAME.hst of WAMIT.

    Volume, centres and places of the hulls are those in NAME.out if it is there. Without it: `volume`: displaced [m3];
    `height`: of the centre of mass for which WAMIT computed NAME.hst [m]. `length`: ULEN [m]. Raises SceneError if a
    file is missing or has other columns.
    """
    radiation, loads, stiffness = (_table(path.with_suffix(end), n) for end, n in ((".1", 4), (".3", 7), (".hst", 3)))
    out = path.with_suffix(".out")
    hulls, points = _described(out) if out.exists() else ([Still(np.zeros(0), volume, height)], [(0.0, 0.0, 0.0)])
    m = 6 * len(hulls)
    if not hulls[0].volume > 0.0:
        raise SceneError(
            f"{path}: files of WAMIT do not contain the displaced volume; give it with --volume, or add {out.name}"
        )
    i, j = _modes(radiation, path.with_suffix(".1"), m, 1, 2)
    row, w, periods = _by(radiation[:, 0])
    added, damping = (np.full((len(periods), m, m), np.nan) for _ in range(2))
    size = DENSITY * length ** (3.0 + (i % 6 > 2) + (j % 6 > 2))
    added[row, i, j], damping[row, i, j] = size * radiation[:, 3], size * radiation[:, 4] * w
    for x in (added, damping):
        x[:, np.isnan(x).all(axis=0)] = 0.0  # symmetry makes them vanish, and WAMIT leaves them out
    if np.isnan(added[periods >= 0.0]).any():
        raise SceneError(
            f"{path.with_suffix('.1')}: its pairs of modes differ between periods; compute the same pairs for each"
        )
    if 0.0 not in periods:
        raise SceneError(f"{path.with_suffix('.1')}: the added mass at infinite frequency is missing; compute period 0")
    at, _, waves = _by(loads[:, 0])
    headings, of = np.unique(np.radians(loads[:, 1]), return_inverse=True)
    (mode,) = _modes(loads, path.with_suffix(".3"), m, 2)
    X = np.full((len(headings), len(waves), m), np.nan + 0j)
    X[of, at, mode] = DENSITY * GRAVITY * length ** (2.0 + (mode % 6 > 2)) * (loads[:, 5] + 1j * loads[:, 6])
    if waves.tolist() != periods[periods > 0.0].tolist():
        raise SceneError(f"{path.with_suffix('.3')}: its periods differ from those of {path.stem}.1")
    if np.isnan(X).any():
        count = "six" if m == 6 else "twelve"
        raise SceneError(f"{path.with_suffix('.3')}: it needs all {count} modes at each heading and period")
    i, j = _modes(stiffness, path.with_suffix(".hst"), m, 0, 1)
    K = np.zeros((m, m))
    K[i, j] = DENSITY * GRAVITY * length ** (2.0 + (i % 6 > 2) + (j % 6 > 2)) * stiffness[:, 2]
    w = 2.0 * np.pi / periods[periods > 0.0]
    up = np.argsort(w)
    some = np.flatnonzero(periods > 0.0)[up]
    still = tuple(replace(x, K=K[6 * n : 6 * n + 6, 6 * n : 6 * n + 6]) for n, x in enumerate(hulls))
    return Coefficients(
        w[up], added[some], damping[some], added[periods == 0.0][0], headings, X[:, up], still, depth=depth
    ).about(*points)


def _described(path: Path) -> tuple[list[Still], list[tuple[float, float, float]]]:
    """Return the hulls in a file NAME.out of WAMIT, still without stiffness, and the origins of their axes [m]."""
    text = text_of(path)
    number, rows = r"\s+([-+.\dEe]+)", []
    for title, n in (("Volumes .*?:", 3), ("Center of Buoyancy .*?:", 3), ("Center of Gravity .*?:", 3)):
        rows.append([tuple(map(float, found)) for found in re.findall(title + n * number, text)])
    places = [re.findall(rf"{axis}BODY\s*=" + number, text) for axis in "XYZ"]
    origins = [(float(x), float(y), float(z)) for x, y, z in zip(*places, strict=False)]
    turned = any(map(float, re.findall(r"PHIBODY\s*=" + number, text)))
    counts = {len(origins), *map(len, rows)}
    if counts not in ({1}, {2}) or turned:
        raise SceneError(f"{path}: it must give volume, centres and position of one body, or of two with parallel axes")
    hulls = [
        Still(np.zeros(0), sorted(V)[1], g[2] + o[2], np.array([b[0], b[1], b[2] + o[2]]), (o[0], o[1]))
        for V, b, g, o in zip(*rows, origins, strict=True)
    ]
    return hulls, origins


def drift_of(path: Path, weight: float, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean drift forces in surge, sway and yaw of one hull or of each of two from a WAMIT file NAME.8 or
    NAME.9.

    They are (headings, frequencies, 3 or 6), after the frequencies [rad/s] and headings [rad]. `weight`: specific
    weight of the water [N/m3]; `length`: ULEN [m].

    Its columns are period [s], two headings [deg] of which equal ones count, mode, modulus, phase, real and imaginary
    part relative to rho g L^m, m = 1 or 2. Raises SceneError if the file has other contents.
    """
    rows = _table(path, 7)
    rows = rows[(rows[:, 1] == rows[:, 2]) & np.isin(rows[:, 3], (1.0, 2.0, 6.0, 7.0, 8.0, 12.0))]
    m = 12 if rows[:, 3].max(initial=0.0) > 6.0 else 6
    (mode,) = _modes(rows, path, m, 3)
    w, at = np.unique(2.0 * np.pi / rows[:, 0], return_inverse=True)
    headings, of = np.unique(np.radians(rows[:, 1]), return_inverse=True)
    values = np.full((len(headings), len(w), m), np.nan)
    values[of, at, mode] = weight * length ** (1.0 + (mode % 6 > 2)) * rows[:, 6]
    values = values[..., [0, 1, 5, 6, 7, 11][: m // 2]]
    if np.isnan(values).any() or min(len(w), len(headings)) < 2:
        raise SceneError(f"{path}: it needs surge, sway and yaw at each of two or more headings and periods")
    return w, headings, values


def _by(periods: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the index of each row's period, the frequency of each row (0 where it has none), and the periods."""
    known, at = np.unique(periods, return_inverse=True)
    return at, np.divide(2.0 * np.pi, periods, out=np.zeros(len(periods)), where=periods > 0.0), known


def _modes(table: np.ndarray, path: Path, m: int, *columns: int) -> list[np.ndarray]:
    """Return columns of modes 1 to m as indices."""
    found = [table[:, k].astype(int) - 1 for k in columns]
    if any((x < 0).any() or (x >= m).any() for x in found):
        raise SceneError(f"{path}: it has more than {m} modes; for two hulls, add the file .out of WAMIT")
    return found


def text_of(path: Path, needed: str = "") -> str:
    """Return the text of a file; raises SceneError, with what is `needed`, if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SceneError(f"{path}: {error_text(error)}{needed}") from None


def _table(path: Path, least: int) -> np.ndarray:
    """Return the rows of numbers in a text file, filled with zeros to equal length; a header is left out."""
    rows = []
    for line in text_of(path).splitlines():
        try:
            rows.append([float(x.replace("D", "E")) for x in line.split()])
        except ValueError:
            if rows:
                raise SceneError(f"{path}: '{line.strip()[:40]}' is not a row of numbers") from None
    if not (rows := [row for row in rows if row]) or min(map(len, rows)) < least:
        raise SceneError(f"{path}: its rows need at least {least} numbers")
    width = max(map(len, rows))
    return np.array([row + [0.0] * (width - len(row)) for row in rows])
