"""What the mass of a flexible body adds to the recursion: the equations of its floating frame and of its modes.

From the kinetic energy (3) of `reduction`, with momentum P = I nu + C eta' in body axes, Poincare's equations are
    dP/dt + nu x* P = wrench,     d/dt (C_l^T nu + m_l eta'_l) - dT/deta_l = force on mode l,                      (6)
and with D_k = dI/deta_k = J1_k + sum_l eta_l J2_kl, I' = sum_k eta'_k D_k, C'_l = sum_k eta'_k G1_kl:
    wrench  = I a + C eta'' + I' nu + C' eta' + nu x* (I nu + C eta'),                                             (7)
    force_l = C_l^T a + m_l eta''_l + C'_l^T nu - 1/2 nu^T D_l nu - sum_k eta'_k G1_lk^T nu.                        (8)
a is the acceleration of the frame in body axes; that of the ground, upwards, is gravity.  The terms follow from T
alone, so that energy and momentum are kept exactly for any constants.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import force_cross, mirror, skew
from heavylift.kernel.compiler.symbol import Array, Scalar


@dataclass(frozen=True)
class FlexibleInertia:
    """A flexible body at one instant, in world axes about the tree's point.

    I: (6, 6) inertia; C: (m, 6) momentum per mode rate; wrench (6,) and forces (m,): the right sides of (7) and (8);
    momentum (6,); kinetic energy [J]; moment: first moment of mass about the tree's point [kg m].
    """

    I: Array
    C: list[Array]
    mass: list[Scalar]
    wrench: Array
    forces: list[Array]
    momentum: Array
    kinetic: Scalar
    moment: Array


def flexible_inertia(
    e: Any, eta: Array, rates: Array, accelerations: Array, R: Array, r: Array, V: Array, A: Array
) -> FlexibleInertia:
    """e: `reduction.Elastic` of floats or symbols; mode coordinates (m,); pose R_WB, r and V, A (6,) in world axes."""
    m = range(len(eta))
    to_body = np.block([[R.T, np.zeros((3, 3))], [-(R.T @ skew(r)), R.T]])
    nu, a = to_body @ V, to_body @ A
    none = np.zeros(6)
    D = [e.J1[k] + sum((e.J2[k, l] * eta[l] for l in m), np.zeros((6, 6))) for k in m]
    I = mirror(e.J0 + 0.5 * sum(((e.J1[k] + D[k]) * eta[k] for k in m), np.zeros((6, 6))))
    C = [e.G0[l] + sum((e.G1[k, l] * eta[k] for k in m), none) for l in m]
    C_rate = [sum((e.G1[k, l] * rates[k] for k in m), none) for l in m]
    I_rate = sum((D[k] * rates[k] for k in m), np.zeros((6, 6)))
    moving = sum((C[l] * rates[l] for l in m), none)
    P = I @ nu + moving
    speeding = sum((C[l] * accelerations[l] for l in m), none)
    turning = I_rate @ nu + sum((C_rate[l] * rates[l] for l in m), none) + force_cross(nu) @ P
    forces = [
        C[l] @ a
        + e.mass[l] * accelerations[l]
        + C_rate[l] @ nu
        - 0.5 * (nu @ (D[l] @ nu))
        - sum((e.G1[l, k] * rates[k] for k in m), none) @ nu
        for l in m
    ]
    return FlexibleInertia(
        I=mirror(to_body.T @ I @ to_body),
        C=[to_body.T @ c for c in C],
        mass=e.mass,
        wrench=to_body.T @ (I @ a + speeding + turning),
        forces=forces,
        momentum=to_body.T @ P,
        kinetic=0.5 * (nu @ (P + moving) + sum((e.mass[l] * rates[l] * rates[l] for l in m), 0.0)),
        moment=e.J0[3, 3] * r + R @ np.array([I[2, 4], I[0, 5], I[1, 3]]),
    )
