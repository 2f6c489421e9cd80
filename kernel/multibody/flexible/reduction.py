"""From the modes of a finite-element model to the constants of the kinetic energy of a flexible body.

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
The shortening of a bent beam (equation (9) of `attachment`) is a displacement of second order; it adds to G1 and J2 as
those of first order add to G0 and J1, which is the geometric stiffness.
The modes are M-orthogonal, so that m and the reduced stiffness are diagonal.  The momentum is that of the moving centre
of mass (so that acceleration of the ground and gravity are one) if the first moments in J1 are the forces in G0: for
matrices that interpolate displacements with slopes, (5) fulfils this to the order of the elements; it is set exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.spatial import skew

from .modes import FlexibleModes
from .rounding import rigid_motions, rounded


@dataclass(frozen=True)
class ReducedBody:
    """The constants of equations (4)."""

    J0: np.ndarray  # (6, 6)
    J1: np.ndarray  # (m, 6, 6)
    J2: np.ndarray  # (m, m, 6, 6)
    G0: np.ndarray  # (m, 6)
    G1: np.ndarray  # (m, m, 6)
    mass: np.ndarray  # (m,) of the modes


@lru_cache(maxsize=64)
def reduced(modes: FlexibleModes) -> ReducedBody:
    """The constants (5) of a body."""
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
    """(n, 3) what turning the frame adds to the velocity of displaced nodes, B_k of equation (2)."""
    B = np.zeros((len(u), 3))
    for j in range(0, len(u), 6):
        B[j : j + 3] = -skew(u[j : j + 3])
    return B
