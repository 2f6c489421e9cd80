"""Modes of a beam for sliders, as Chebyshev polynomials that approximate the mode shapes smoothly.

Stations: the point of a law on a flexible body becomes a massless body, so that laws need not consider bending.

Points at the same place share a station: `girder@30` is at x = 30 m of `girder`; the point's other coordinates form a
rigid arm. Joints carried by a flexible body are at stations as well, except sliders.

Constants of the kinetic energy of a flexible body, from the modes of a finite-element model.

With U_j = (velocity, angular velocity) of node j in body axes, nu = (w; v) the twist of the floating frame and eta the
mode coordinates,
    U = B(eta) nu + Phi eta',   B(eta) = B_0 + sum_k eta_k B_k,                                                  (1)
    B_0 = [[-skew(X_j), 1], [1, 0]] of node j at X_j,   B_k = [[-skew(Phi_kj), 0], [0, 0]],                        (2)
    T = 1/2 U^T M U = 1/2 nu^T I(eta) nu + nu^T C(eta) eta' + 1/2 eta'^T m eta'.                                  (3)
The constants follow from M and Phi alone, as in the nodal-based floating frame of reference formulation (Zwoelfer,
Gerstmayr 2019) and with the meaning of the standard input data (Wallrapp 1994; Shabana 2013, chapter 5):
    I = J0 + sum_k eta_k J1_k + 1/2 sum_kl eta_k eta_l J2_kl,   C_l = G0_l + sum_k eta_k G1_kl,                    (4)
    J0 = B_0^T M B_0,  J1_k = B_0^T M B_k + (..)^T,  J2_kl = B_k^T M B_l + (..)^T,  G0_l = B_0^T M Phi_l,
    G1_kl = B_k^T M Phi_l.                                                                                        (5)
The shortening of a bent beam (equation (9) of `attachment`) is a displacement of second order; it contributes
to G1 and J2 as those of first order do to G0 and J1, which gives the geometric stiffness.
The modes are M-orthogonal, so that m and the reduced stiffness are diagonal.  The momentum is that of the
moving centre of mass (so that acceleration of the ground and gravity are equivalent) if the first moments in
J1 are the forces in G0: for matrices that interpolate displacements with slopes, (5) fulfils this to the order
of the elements; the code sets it exactly.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache, lru_cache
from operator import is_
from typing import Any

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.eigenvalues import derivative, integral, polynomials, product, roots, series, spline
from heavylift.kernel.algebra.spatial import skew
from heavylift.kernel.description.mechanics import Body, Joint, Point, System
from heavylift.kernel.errors import KernelError
from msgspec import Struct, structs

from .attachment import Track
from .beam import rigid_motions, rounded
from .modes import FlexibleModes, modes_of

PLAIN = (str, float, int, bool, type(None))
SMOOTH, NOT_SMOOTH = 1e-6, 1e-2  # errors of polynomials, sought and refused; shapes are 1 at most


@lru_cache(maxsize=64)
def track(modes: FlexibleModes, joint: str) -> Track:
    """Return displacements and rotations (slopes) of a beam's modes as polynomials along the beam.

    Raises KernelError naming the slider joint if the body is no beam or a mode is not smooth.
    """
    beam, m = modes.flexible.beam, len(modes.mass)
    if beam is None or beam.start:
        raise KernelError(
            f"joint '{joint}': body '{modes.name}' is not a beam that begins at its origin, as a slider needs"
        )
    x = roots(4 * beam.elements)
    places = (1.0 + x) * beam.length / 2.0
    nodal = modes.shapes.reshape(-1, 6, m)[:, :4].reshape(-1, 4 * m)  # ux uy uz rx; ry and rz are slopes
    # where elements are most accurate, at their nodes, and smooth between them, as the modes are
    moved = spline(modes.nodes[:, 0], nodal, min(7, (beam.elements - 1) | 1), places)
    whole = series(moved, min(beam.elements + 8, len(x) - 1))
    T = polynomials(x, len(whole) - 1)
    fits = {n: whole[: n + 1] for n in range(8, beam.elements + 9, 2)}
    errors = {n: float(np.abs(times(T[:, : n + 1], c) - moved).max(initial=0.0)) for n, c in fits.items()}
    least = min(errors.values())
    if least > NOT_SMOOTH:
        raise KernelError(
            f"joint '{joint}': the error of polynomials for the modes of '{modes.name}' is {least:.1g}; "
            "give its beam fewer modes or loads, or more elements"
        )
    fit = fits[next(n for n, error in errors.items() if error <= max(SMOOTH, 2.0 * least))]
    fit = fit.reshape(-1, 4, m)
    slopes = derivative(fit) * (2.0 / beam.length)
    coefficients = rounded(np.concatenate([fit, -slopes[:, 2:3], slopes[:, 1:2]], axis=1))
    turned = coefficients[:, 4:]
    y, z = (product(turned[:, d, :, None], turned[:, d, None, :]) for d in (0, 1))
    g = integral(y + z) * (beam.length / 2.0)
    g[0] += modes.shortening(0.0)
    return Track(np.zeros(3), 2.0 / beam.length, coefficients, rounded(g))


def with_stations(system: System) -> tuple[System, dict[str, FlexibleModes]]:
    """Return a system with a massless body (station) at each attachment point of flexible bodies, and their modes."""
    modes = {b.name: modes_of(b.name, b.flexible) for b in system.bodies if b.flexible}
    if not modes:
        return system, modes
    stations: dict[str, Joint] = {}

    def on_station(x: Any) -> Any:
        if type(x) in PLAIN:
            return x
        if isinstance(x, tuple):
            parts = tuple(map(on_station, x))
            return x if all(map(is_, parts, x)) else parts
        if isinstance(x, Point) and x.body in modes:
            station, place = modes[x.body].station(x.p)
            name = f"{x.body}@{station:.9g}"
            X = tuple(float(e) for e in place)
            stations.setdefault(name, Joint(name, "fixed", x.body, name, (X[0], X[1], X[2])))
            return Point(name, (x.p[0] - X[0], x.p[1] - X[1], x.p[2] - X[2]))
        if isinstance(x, Joint) and x.parent in modes and x.kind != "slider":
            point = on_station(Point(x.parent, x.p_PJ))
            return replace(x, parent=point.body, p_PJ=point.p)
        kind: Any = type(x)
        names, change = (x.__struct_fields__, structs.replace) if isinstance(x, Struct) else (_names(kind), replace)
        moved = {name: new for name in names if (new := on_station(old := getattr(x, name))) is not old}
        return change(x, **moved) if moved else x

    laws = [f.name for f in fields(System) if f.name not in ("bodies", "joints", "gravity")]
    joints = on_station(system.joints)
    changed = {name: on_station(getattr(system, name)) for name in laws}
    bodies = (*system.bodies, *(Body(name, 0.0) for name in stations))
    return replace(system, bodies=bodies, joints=(*joints, *stations.values()), **changed), modes


@cache
def _names(kind: Any) -> tuple[str, ...]:
    """Return the field names of a class of data; () for any other class."""
    return tuple(f.name for f in fields(kind)) if is_dataclass(kind) else ()


@dataclass(frozen=True)
class ReducedBody:
    """The constants of the kinetic energy of a flexible body, equations (4) of the module."""

    J0: np.ndarray  # (6, 6)
    J1: np.ndarray  # (m, 6, 6)
    J2: np.ndarray  # (m, m, 6, 6)
    G0: np.ndarray  # (m, 6)
    G1: np.ndarray  # (m, m, 6)
    mass: np.ndarray  # (m,) of the modes


@lru_cache(maxsize=64)
def reduced(modes: FlexibleModes) -> ReducedBody:
    """Return the constants that determine the kinetic energy of a flexible body, by equations (5) of the module."""
    n, m = modes.shapes.shape
    B0 = rigid_motions(modes.nodes)
    B = np.zeros((m, n, 6))
    for k in range(m):
        B[k, :, :3] = _turning(modes.shapes[:, k])
    flat = B[..., :3].transpose(1, 0, 2).reshape(n, 3 * m)
    M_B0 = times(modes.M, B0)
    half = np.zeros((m, 6, 6))
    half[..., :3] = times(M_B0.T, flat).reshape(6, m, 3).transpose(1, 0, 2)
    second = times(flat.T, times(modes.M, flat)).reshape(m, 3, m, 3).transpose(0, 2, 1, 3)
    blocks = [slice(0, 3), slice(3, 6)]
    J0, J1, G0 = times(B0.T, M_B0), half + half.transpose(0, 2, 1), times(M_B0.T, modes.shapes).T
    for a in blocks:  # moments, first moments and masses have units of their own
        G0[:, a] = rounded(G0[:, a])
        for b in blocks:
            J0[a, b] = rounded(J0[a, b])
    J1[:, :3, :3] = rounded(J1[:, :3, :3])
    for k in range(m):
        J1[k, :3, 3:] = skew(G0[k, 3:])
        J1[k, 3:, :3] = -skew(G0[k, 3:])
    shorter = np.zeros((m, m, n))
    shorter[:, :, 0::6] = -modes.nodal_shortening.transpose(1, 2, 0)
    G1 = times(shorter.reshape(m * m, n), M_B0).reshape(m, m, 6)
    G1[:, :, :3] += times(flat.T, times(modes.M, modes.shapes)).reshape(m, 3, m).transpose(0, 2, 1)
    G1[:, :, :3], G1[:, :, 3:] = rounded(G1[:, :, :3]), rounded(G1[:, :, 3:])
    J2 = np.zeros((m, m, 6, 6))
    J2[:, :, :3, :3] = second + second.transpose(0, 1, 3, 2)
    for k in range(m):
        for l in range(m):
            cut = times(M_B0[:, :3].T, _turning(shorter[k, l]))
            J2[k, l, :3, :3] += cut + cut.T
            J2[k, l, :3, 3:], J2[k, l, 3:, :3] = skew(G1[k, l, 3:]), -skew(G1[k, l, 3:])
    J2[:, :, :3, :3] = rounded(J2[:, :, :3, :3])
    return ReducedBody(J0, J1, J2, G0, G1, modes.mass)


def _turning(u: np.ndarray) -> np.ndarray:
    """Return the velocities (n, 3) of displaced nodes by rotation of the frame, B_k of equation (2)."""
    B = np.zeros((len(u), 3))
    for j in range(0, len(u), 6):
        B[j : j + 3] = -skew(u[j : j + 3])
    return B
