"""Coefficients of a hull in the files of NEMOH 2 and 3 (LHEEA, Centrale Nantes), with their conventions.

Nemoh.cal has density, gravity, depth (0: deep) and the points of rotations. RadiationCoefficients.tec has a zone for
each motion, with rows of frequency [rad/s] and pairs of added mass and damping in SI units; ExcitationForce.tec has a
zone for each direction [deg] to which waves travel, with rows of modulus and phase [rad] for exp(-iwt), so the negative
phases are those used here; IRF.tec has the added mass at infinite frequency. KH.dat and Hydrostatics.dat of the mesh
belong to its centre of mass.
"""

import re
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import SceneError

from .data_files import Coefficients, Still, text_of

NUMBER = r"[-+]?\d*\.?\d+(?:[eEdD][-+]?\d+)?\.?"


def nemoh_files(case: Path) -> list[Path]:
    """Return the paths of the files of a NEMOH case, given the path of its Nemoh.cal."""
    results = case.parent / ("Results" if (case.parent / "Results").is_dir() else "results")
    mesh = next((d for x in ("Mesh", "mesh", "Mechanics") if (d := case.parent / x).is_dir()), case.parent)
    numbered = "_0" if (mesh / "KH_0.dat").exists() else ""
    names = ("RadiationCoefficients", "ExcitationForce", "IRF")
    return [
        case,
        *(results / f"{x}.tec" for x in names),
        *(mesh / f"{x}{numbered}.dat" for x in ("KH", "Hydrostatics")),
    ]


def nemoh(case: Path) -> Coefficients:
    """Return the coefficients of a NEMOH case with a single body, given the path of its Nemoh.cal.

    Raises SceneError if a file is missing or invalid."""
    cal, radiation, excitation, infinite, stiffness, bodies = nemoh_files(case)
    rows = [x.split("!")[0].split() for x in _text(cal).splitlines()]
    try:
        rho, g, depth, count = (float(rows[i][0]) for i in (1, 2, 3, 6))
        away = any(map(float, rows[4][:2]))
        points = {tuple(map(float, row[4:7])) for row in rows[10:16] if float(row[0]) == 2.0}
    except (IndexError, ValueError):
        raise SceneError(f"{cal}: it is not a Nemoh.cal of a body with six degrees of freedom") from None
    if count != 1 or len(points) != 1 or any((point := points.pop())[:2]):
        raise SceneError(f"{cal}: compute one body, with all rotations about one point above or below the origin")
    if away:
        raise SceneError(f"{cal}: its phases refer to XEFF, YEFF; compute them for the point 0, 0")
    if re.search(r"(?im)^\s*[^1\s][^!\n]*!\s*output freq", _text(cal)):
        raise SceneError(f"{cal}: its output frequencies are not in rad/s; set the type of the output frequency to 1")
    motions, loads, memory = (_zones(path) for path in (radiation, excitation, infinite))
    if len(motions) != 6 or any(x.shape[1] != 13 for _, x in (*motions, *loads)):
        raise SceneError(
            f"{radiation}: it does not have six motions with six loads each; compute all degrees of freedom"
        )
    w = motions[0][1][:, 0]
    if (np.diff(w) <= 0.0).any() or any(len(x) != len(w) or (x[:, 0] != w).any() for _, x in (*motions, *loads)):
        raise SceneError(f"{radiation}: frequencies must ascend, and be the same in {excitation.name}")
    A, B = (np.array([x[:, k::2] for _, x in motions]).swapaxes(0, 1) for k in (1, 2))
    A_inf = np.array([x[0, 1::2] for _, x in memory])
    headings = np.radians([float(re.findall(NUMBER, zone.split("beta")[-1])[0]) for zone, _ in loads])
    order = np.argsort(headings)
    X = np.array([x[:, 1::2] * np.exp(-1j * x[:, 2::2]) for _, x in loads])[order]
    given = dict(re.findall(rf"(ZG|Displacement|[XYZ]F)\s*=\s*({NUMBER})", _text(bodies)))
    if not {"ZG", "Displacement"} <= {*given}:
        raise SceneError(f"{bodies}: it has no 'ZG' and 'Displacement'")
    K = np.array([[float(x) for x in line.split()] for line in _text(stiffness).splitlines() if line.strip()])
    if K.shape != (6, 6) or A_inf.shape != (6, 6):
        raise SceneError(f"{stiffness if A_inf.shape == (6, 6) else infinite}: it is not a matrix for six motions")
    return Coefficients(
        w, A, B, A_inf, headings[order], X,
        (Still(K, float(given["Displacement"]), float(given["ZG"]),
               np.array([float(given[x]) for x in ("XF", "YF", "ZF")]) if {"XF", "YF", "ZF"} <= {*given} else None),),
        rho, g, depth or np.inf,
    ).about(point)  # fmt: skip


def _text(path: Path) -> str:
    needed = "; let NEMOH compute the impulse responses, which give it" if path.name == "IRF.tec" else ""
    return text_of(path, needed)


def _zones(path: Path) -> list[tuple[str, np.ndarray]]:
    """Return the title and the table of each zone."""
    found = re.split(r"(?im)^\s*zone\s+t\s*=\s*", _text(path))[1:]
    try:
        tables = [np.array([list(map(float, x.split())) for x in zone.splitlines()[1:] if x.strip()]) for zone in found]
    except ValueError as error:
        raise SceneError(f"{path}: {error}") from None
    if not tables or any(x.ndim != 2 or x.shape != tables[0].shape for x in tables):
        raise SceneError(f"{path}: its zones are missing or differ in size; write the file again with NEMOH")
    return [(zone.splitlines()[0], table) for zone, table in zip(found, tables, strict=True)]
