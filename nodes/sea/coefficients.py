"""The file of a hull made from hydrodynamic coefficients, which are read from files or computed once from a mesh.

The frequencies must include infinity, which gives the added mass of the body.
"""

from hashlib import sha256
from math import inf, isfinite
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np
from heavylift.kernel.errors import SceneError, error_text, extra

from .data_files import Coefficients, capytaine, drift_of, wamit
from .hydrodynamics import (
    EXACTLY,
    VERSION,
    FitError,
    Hydrodynamics,
    MeanDrift,
    RadiationStates,
    SecondHull,
    WaveLoads,
    check,
    one_sided,
)  # fmt: skip
from .hydrostatics import hydrostatics_of
from .nemoh_data import nemoh, nemoh_files
from .radiation_fit import fitted

DIGITS, EXACT = 7, 12  # of data, and of states, which must stay passive
RESOLVED = (
    0.25  # of the largest damping, by which it may leave the line between two frequencies: loads are interpolated
)
NOTHING = 1e-9  # of the largest number of a matrix: rounding
FINEST, STEP = 3.0, 0.1  # [rad/s] of the frequencies that are computed
PANELS, GRAVITY = 4.0, 9.81  # [m/s2]: panels along the shortest wave
DIRECTIONS = 13  # from following to head waves


def hull_of(
    path: Path,
    volume: float = 0.0,
    height: float = 0.0,
    length: float = 1.0,
    depth: float | None = None,
    drift: Path | None = None,
) -> Hydrodynamics:
    """Return the hydrodynamics of a hull from files of Capytaine (.nc), NEMOH (Nemoh.cal) or WAMIT (.1, .3 and .hst).

    WAMIT needs the displaced volume [m3], the height of the centre of mass above the waterline [m], ULEN [m] and the
    depth of the water [m]; `drift`: a file of mean drift of WAMIT.

    Raises SceneError if a file cannot be read, or if the radiation fit is too inaccurate.
    """
    if path.suffix == ".nc":
        read, files = capytaine(path), [path]
    elif path.suffix == ".cal":
        read, files = nemoh(path), nemoh_files(path)
    else:
        read = wamit(path, volume, height, length, depth or inf)
        files = [file for end in (".1", ".3", ".hst", ".out") if (file := path.with_suffix(end)).exists()]
    numbers = (read.w, read.A, read.B, read.A_inf, read.headings, read.X, *(x.K for x in read.hulls))
    if len(read.w) < 2 or not all(np.isfinite(x).all() for x in numbers):
        raise SceneError(f"{path}: it needs two or more frequencies, without gaps in radiation, loads and hydrostatics")
    given = drift and drift_of(drift, read.density * read.gravity, length)
    files += [drift] if drift else []
    digest = sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
    if len(read.hulls) > 1 and (coarse := _unresolved(read)):
        raise SceneError(f"{path}: the waves between the hulls have a resonance near {coarse:.3g} rad/s that its "
                         "frequencies do not resolve; compute more of them there, or damp it by a lid")  # fmt: skip
    found = _whole(read, path.stem, f"{path.name}, SHA-256 {digest}")
    if given:
        found = with_drift(found, *given, str(drift))
    check(found, str(path))
    return found


def with_drift(
    hull: Hydrodynamics, w: np.ndarray, headings: np.ndarray, values: np.ndarray, file: str
) -> Hydrodynamics:
    """Return the hydrodynamics of one hull or of two with the mean drift forces of each added."""
    turned, around = _around(headings, values)
    each = np.split(_short(around), values.shape[2] // 3, axis=2)
    tables = [MeanDrift(_rows(w), _rows(turned), tuple(map(_rows, x))) for x in each]
    second = hull.beside
    if len(tables) != 1 + (second is not None):
        needed = "the drift of each of two hulls, modes 1 to 12 of NAME.9" if second else "the drift of a single hull"
        raise SceneError(f"{file}: the file must contain {needed}")
    if second:
        second = msgspec.structs.replace(second, hull=msgspec.structs.replace(second.hull, drift=tables[1]))
    return msgspec.structs.replace(hull, drift=tables[0], beside=second)


def computed(mesh: Path, depth: float | None = None) -> Path:
    """Compute the hydrodynamic coefficients of a mesh with Capytaine, and return the path of their netCDF file.

    The mesh has its waterline at z = 0 and its bow along x; the file is written beside it. `depth`: of the water [m].
    Raises SceneError if the computation fails."""
    missing = SceneError("coefficients of a mesh are computed by Capytaine: pip install 'heavylift[sea]'")
    cpt, xr = extra("capytaine", missing), extra("xarray", missing)
    try:
        hull = cpt.load_mesh(str(mesh)).immersed_part()
    except Exception as error:  # whatever a library of meshes raises
        raise SceneError(f"{mesh}: {error_text(error)}") from None
    origin = {"rotation_center": (0.0, 0.0, 0.0)}
    body = cpt.FloatingBody(
        mesh=hull, lid_mesh=hull.generate_lid(), dofs=cpt.rigid_body_dofs(**origin), center_of_mass=(0.0, 0.0, 0.0)
    )
    w = np.arange(STEP, _finest(hull), STEP)
    common = {"radiating_dof": list(body.dofs), "water_depth": [depth or inf], "rho": [1025.0]}
    still = hydrostatics_of(np.asarray(hull.vertices)[np.asarray(hull.faces)])
    alike = abs(still.first[1]) < EXACTLY * still.waterplane**1.5  # port and starboard
    solver, waves = cpt.BEMSolver(), np.linspace(0.0 if alike else -np.pi, np.pi, DIRECTIONS)
    radiation = solver.fill_dataset(xr.Dataset(coords={"omega": [*w, np.inf], **common}), body)
    diffraction = solver.fill_dataset(xr.Dataset(coords={"omega": w, "wave_direction": waves, **common}), body)
    out = mesh.with_suffix(".nc")
    whole = cpt.io.xarray.separate_complex_values(
        xr.merge([radiation, diffraction], compat="no_conflicts", join="outer")
    )
    for modes in ("radiating_dof", "influenced_dof"):
        whole[modes] = whole[modes].astype("str")
    # in place of those by the centres of panels
    whole["hydrostatic_stiffness"] = (("influenced_dof", "radiating_dof"), still.stiffness(1025.0 * GRAVITY))
    whole["center_of_buoyancy"], whole["disp_mass"] = ("space_coordinate", still.buoyancy), 1025.0 * still.volume
    # the classic format, which needs no other library
    whole.to_netcdf(out, engine="scipy", format="NETCDF3_64BIT")
    return out


def _finest(mesh: Any) -> float:
    """Return the frequency [rad/s] of waves that are PANELS mesh panels long."""
    edges = np.diff(np.asarray(mesh.vertices)[np.asarray(mesh.faces)], axis=1)
    return min(FINEST, float(np.sqrt(2.0 * np.pi * GRAVITY / (PANELS * np.linalg.norm(edges, axis=2).max()))))


def _whole(read: Coefficients, name: str, source: str) -> Hydrodynamics:
    A, B, A_inf = map(_symmetric, (read.A, read.B, read.A_inf))
    space, error = fitted(read.w, A, B, A_inf)
    missed = FitError(*(float(_short(x, 3)) for x in (error.added_mass, error.damping)))
    F = _rows(_short(space.F, EXACT))
    states = [RadiationStates(() if i else F, _rows(_short(space.G[:, 6 * i : 6 * i + 6], EXACT)), missed)
              for i in range(len(read.hulls))]  # fmt: skip
    first, *others = (_hull(read, i, name, source, x, A_inf) for i, x in enumerate(states))
    if not others:
        return first
    (x, y), (a, b) = (hull.at for hull in read.hulls)
    second = SecondHull(others[0], (a - x, b - y, 0.0), _rows(_short(A_inf[6:, :6])))
    return msgspec.structs.replace(first, beside=second)


def _hull(
    read: Coefficients, i: int, name: str, source: str, states: RadiationStates, A_inf: np.ndarray
) -> Hydrodynamics:
    """Return the data of hull i; two hulls are not symmetric."""
    own, still = slice(6 * i, 6 * i + 6), read.hulls[i]
    headings, X = _around(read.headings, read.X[..., own])
    rho, g, K, volume = read.density, read.gravity, still.K, still.volume
    heights = [float(_short(K[j, j] / (rho * volume * g) + still.height)) for j in (3, 4)]
    return Hydrodynamics(
        version=VERSION, name=name, source=source, density=rho,
        volume=float(_short(volume)), waterplane=float(_short(K[2, 2] / (rho * g))),
        metacentres=(heights[0], heights[1]),
        moments=_rows(_short(np.array([K[4, 4], -K[2, 4], K[2, 3], -K[3, 4]]) / (rho * g))[1:]),
        buoyancy=None if still.buoyancy is None else _rows(_short(still.buoyancy)),
        added_mass=_rows(_short(A_inf[own, own])),
        depth=read.depth if isfinite(read.depth) else None,
        radiation=states,
        loads=WaveLoads(tuple(_short(read.w).tolist()), tuple(headings.tolist()),
                        *(tuple(_rows(x) for x in _short(part)) for part in (X.real, X.imag))),
        symmetric=len(headings) == len(read.headings) and len(read.hulls) == 1,
    )  # fmt: skip


def _unresolved(read: Coefficients) -> float:
    """Return the frequency [rad/s] at which some damping differs most from the straight line between its neighbours, if
    that is more than RESOLVED of its largest value; otherwise 0."""
    B = np.abs(read.B.diagonal(axis1=1, axis2=2))
    w, B = read.w, B / np.maximum(B.max(axis=0), NOTHING)
    share = ((w[1:-1] - w[:-2]) / (w[2:] - w[:-2]))[:, None]
    off = np.abs(B[1:-1] - (1.0 - share) * B[:-2] - share * B[2:]).max(axis=1)
    return float(w[1 + np.argmax(off)]) if off.max(initial=0.0) > RESOLVED else 0.0


def _symmetric(x: np.ndarray) -> np.ndarray:
    return np.asarray(0.5 * (x + x.swapaxes(-1, -2)))


def _short(x: Any, digits: int = DIGITS) -> np.ndarray:
    """Return numbers rounded to this many significant digits; numbers that are only rounding errors become 0."""
    values = np.asarray(x, float)
    small = np.abs(values) < NOTHING * np.abs(values).max()
    return np.asarray(np.vectorize(lambda y: float(f"{y:.{digits}g}"))(np.where(small, 0.0, values)))


def _rows(A: np.ndarray) -> Any:
    return cast(Any, tuple(map(tuple, A.tolist())) if A.ndim > 1 else tuple(A.tolist()))


def _around(headings: np.ndarray, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return headings and loads, extended to a closed turn around the hull unless the headings cover just one side."""
    if one_sided(headings.tolist()):
        return headings, X
    turned, at = np.unique((headings % (2.0 * np.pi)).round(DIGITS), return_index=True)
    turned[turned > np.pi] -= 2.0 * np.pi
    order = np.argsort(turned)
    turned, at = turned[order], at[order]
    return np.array([turned[-1] - 2.0 * np.pi, *turned, turned[0] + 2.0 * np.pi]), X[[at[-1], *at, at[0]]]
