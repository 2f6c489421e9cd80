"""Hydrodynamic coefficients of a hull from Capytaine: read from its netCDF files, or computed once from a mesh.

Capytaine (Ancellin, Dias, Journal of Open Source Software 4 (2019) 1341) gives loads for the time factor exp(-iwt);
their conjugates are those for exp(+iwt), which is used here. Its headings are the directions to which the waves travel,
as here. The frequencies must include infinity, which gives the added mass of the body.
"""

from pathlib import Path
from typing import Any, cast

import numpy as np
from heavylift.kernel.errors import SceneError, error_text, extra

from .hydrodynamics import VERSION, WORST, FitError, Hydrodynamics, RadiationStates, WaveLoads
from .radiation_fit import fitted

MODES = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
NEEDED = ("omega", "wave_direction", "added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness")
DIGITS, EXACT = 7, 12  # of data, and of states, which must stay passive
NOTHING = 1e-9  # of the largest number of a matrix: rounding
FINEST, STEP = 3.0, 0.1  # [rad/s] of the frequencies that are computed
PANELS, GRAVITY = 4.0, 9.81  # [m/s2]: panels along the shortest wave
DIRECTIONS = 13  # from following to head waves


def hull_of(path: Path) -> Hydrodynamics:
    """Return the hydrodynamics of a hull from a netCDF file (classic format) of Capytaine; raises SceneError if the
    file is not one."""
    from scipy.io import netcdf_file

    try:
        with netcdf_file(path, "r", mmap=False) as file:
            data = {name: np.array(x.data) for name, x in file.variables.items()}
    except TypeError:
        raise SceneError(
            f"{path}: it is not a netCDF file of the classic format; write it with NETCDF3_64BIT"
        ) from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {error_text(error)}") from None
    if missing := [name for name in NEEDED if name not in data]:
        raise SceneError(f"{path}: it has no '{missing[0]}'; let Capytaine export radiation, diffraction, hydrostatics")
    found = _hull(data, path.stem, f"Capytaine, {path.name}")
    if (worst := max(found.radiation.error.added_mass, found.radiation.error.damping)) > WORST:
        advice = f"more than {WORST:.0%}; compute finer panels with a lid, or no frequencies whose waves they miss"
        raise SceneError(f"{path}: the error of the radiation fit is {worst:.1%} of the largest coefficient, {advice}")
    return found


def computed(mesh: Path) -> Path:
    """Compute the hydrodynamic coefficients of a mesh (waterline at z = 0, bow along x) with Capytaine, write a netCDF
    file next to the mesh, and return its path. Raises SceneError if that fails."""
    missing = SceneError("coefficients of a mesh are computed by Capytaine: pip install 'heavylift[sea]'")
    cpt, xr = extra("capytaine", missing), extra("xarray", missing)
    try:
        whole = cpt.load_mesh(str(mesh)).immersed_part()
    except Exception as error:  # whatever a library of meshes raises
        raise SceneError(f"{mesh}: {error_text(error)}") from None
    origin = {"rotation_center": (0.0, 0.0, 0.0)}
    body = cpt.FloatingBody(
        mesh=whole, lid_mesh=whole.generate_lid(), dofs=cpt.rigid_body_dofs(**origin), center_of_mass=(0.0, 0.0, 0.0)
    )
    w = np.arange(STEP, _finest(whole), STEP)
    common = {"radiating_dof": list(body.dofs), "water_depth": [np.inf], "rho": [1025.0]}
    solver, waves = cpt.BEMSolver(), np.linspace(0.0, np.pi, DIRECTIONS)
    radiation = solver.fill_dataset(xr.Dataset(coords={"omega": [*w, np.inf], **common}), body)
    diffraction = solver.fill_dataset(xr.Dataset(coords={"omega": w, "wave_direction": waves, **common}), body)
    out = mesh.with_suffix(".nc")
    cpt.export_dataset(str(out), xr.merge([radiation, diffraction], compat="no_conflicts"), format="netcdf")
    return out


def _finest(mesh: Any) -> float:
    """Return the frequency [rad/s] of waves that are PANELS mesh panels long."""
    edges = np.diff(np.asarray(mesh.vertices)[np.asarray(mesh.faces)], axis=1)
    return min(FINEST, float(np.sqrt(2.0 * np.pi * GRAVITY / (PANELS * np.linalg.norm(edges, axis=2).max()))))


def _hull(data: dict[str, np.ndarray], name: str, source: str) -> Hydrodynamics:
    w = data["omega"]
    finite = np.isfinite(w)
    if finite.all():
        raise SceneError(f"{source}: it has no infinite frequency, whose added mass is needed; add it to 'omega'")
    order = np.argsort(w[finite])
    A, B = (_symmetric(data[key].reshape(len(w), 6, 6)) for key in ("added_mass", "radiation_damping"))
    A_inf, A, B, w = A[~finite][0], A[finite][order], B[finite][order], w[finite][order]
    space, error = fitted(w, A, B, A_inf)
    X = data["excitation_force"].reshape(2, len(finite), -1, 6)[:, finite][:, order].swapaxes(1, 2)
    rho, g = (float(data[key].ravel()[0]) if key in data else x for key, x in (("rho", 1025.0), ("g", 9.81)))
    K = data["hydrostatic_stiffness"].reshape(6, 6)
    mass = float(data["disp_mass"].ravel()[0])
    z = float(data["center_of_mass"].ravel()[2]) if "center_of_mass" in data else 0.0
    heights = [float(_short(K[i, i] / (mass * g) + z)) for i in (3, 4)]
    return Hydrodynamics(
        version=VERSION, name=name, source=source, density=rho,
        volume=float(_short(mass / rho)), waterplane=float(_short(K[2, 2] / (rho * g))),
        metacentres=(heights[0], heights[1]),
        added_mass=_rows(_short(A_inf)),
        radiation=RadiationStates(_rows(_short(space.F, EXACT)), _rows(_short(space.G, EXACT)),
                                  FitError(*(float(_short(x, 3)) for x in (error.added_mass, error.damping)))),
        loads=WaveLoads(tuple(_short(w).tolist()), tuple(data["wave_direction"].tolist()),
                        *(tuple(_rows(x) for x in _short(part)) for part in (X[0], -X[1]))),
    )  # fmt: skip


def _symmetric(x: np.ndarray) -> np.ndarray:
    return np.asarray(0.5 * (x + x.swapaxes(-1, -2)))


def _short(x: Any, digits: int = DIGITS) -> np.ndarray:
    """Return numbers rounded to this many significant digits; numbers that are only rounding errors become 0."""
    values = np.asarray(x, float)
    small = np.abs(values) < NOTHING * np.abs(values).max()
    return np.asarray(np.vectorize(lambda y: float(f"{y:.{digits}g}"))(np.where(small, 0.0, values)))


def _rows(A: np.ndarray) -> Any:
    return cast(Any, tuple(map(tuple, A.tolist())))
