"""Mass and stiffness matrices of a straight Euler-Bernoulli beam (Przemieniecki 1968, sections 5.6 and 11.2).

Two-node elements, six degrees of freedom per node (ux uy uz rx ry rz), cubic Hermite bending, linear axial and
torsional displacements, consistent mass without rotatory inertia of bending.

The module also rounds modes and constants, and has the rigid motions of nodes.
"""

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.spatial import skew
from heavylift.kernel.description.flexible import Beam

# degrees of freedom of an element per kind of deformation, and the sign of its slopes
_AXIAL, _TORSION = (0, 6), (3, 9)
BENDING_Z, BENDING_Y = ((1, 5, 7, 11), 1.0), ((2, 4, 8, 10), -1.0)  # about z: uy' = rz, about y: uz' = -ry


def nodes_of(beam: Beam) -> np.ndarray:
    """Return the positions (n, 3) of the nodes of a beam's finite elements [m]."""
    x = beam.start + np.linspace(0.0, beam.length, beam.elements + 1)
    return np.stack([x, 0.0 * x, 0.0 * x], axis=1)


def beam_matrices(beam: Beam) -> tuple[np.ndarray, np.ndarray]:
    """Return the mass and stiffness matrices (6n, 6n) of a beam with n nodes."""
    h = beam.length / beam.elements
    m, k = np.zeros((12, 12)), np.zeros((12, 12))
    for line, mass, stiffness in ((_AXIAL, beam.mass_per_length, beam.EA), (_TORSION, beam.polar, beam.GJ)):
        m[np.ix_(line, line)] += mass * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        k[np.ix_(line, line)] += stiffness / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for (at, sign), EI in ((BENDING_Z, beam.EI_z), (BENDING_Y, beam.EI_y)):
        s = np.array([1.0, sign * h, 1.0, sign * h])
        inertia = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
        bending = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
        m[np.ix_(at, at)] += beam.mass_per_length * h / 420.0 * np.array(inertia) * np.outer(s, s)
        k[np.ix_(at, at)] += EI / (h * h * h) * np.array(bending) * np.outer(s, s)
    n = 6 * (beam.elements + 1)
    M, K = np.zeros((n, n)), np.zeros((n, n))
    for e in range(beam.elements):
        at_e = slice(6 * e, 6 * e + 12)
        M[at_e, at_e] += m
        K[at_e, at_e] += k
    return M, K


def rigid_directions(beam: Beam) -> list[int]:
    """Return the degrees of freedom of a beam's node that cannot deform because no stiffness is given for them."""
    given = ((beam.EA, (0,)), (beam.EI_z, (1, 5)), (beam.EI_y, (2, 4)), (beam.GJ, (3,)))
    return sorted(d for stiffness, at in given if stiffness == 0.0 for d in at)


def hermite(beam: Beam, x: float) -> np.ndarray:
    """Return the matrix (6, 6n) from a beam's nodal displacements to displacement and rotation at a station x [m]."""
    h = beam.length / beam.elements
    along = (x - beam.start) / h
    e = min(max(int(along), 0), beam.elements - 1)
    s = along - e
    s2, s3 = s * s, s * s * s
    N = np.array([1 - 3 * s2 + 2 * s3, h * (s - 2 * s2 + s3), 3 * s2 - 2 * s3, h * (s3 - s2)])
    dN = np.array([-6 * s + 6 * s2, h * (1 - 4 * s + 3 * s2), 6 * s - 6 * s2, h * (3 * s2 - 2 * s)]) / h
    out = np.zeros((6, 6 * (beam.elements + 1)))
    for line in (_AXIAL, _TORSION):
        out[line[0], [6 * e + i for i in line]] = [1 - s, s]
    for (at, sign), (u, r) in ((BENDING_Z, (1, 5)), (BENDING_Y, (2, 4))):
        slopes = np.array([1.0, sign, 1.0, sign])
        columns = [6 * e + i for i in at]
        out[u, columns] = N * slopes
        out[r, columns] = sign * dN * slopes
    return out


FREE = 1e-6  # of the largest stiffness, as a strain that is none
DIGITS = 12  # to which constants are rounded: beyond them they are noise


def rounded(x: np.ndarray) -> np.ndarray:
    """Return x rounded to DIGITS significant digits of its largest element, so that round-off becomes exact zeros."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0:
        return x
    digits, exponent = f"{largest:.17e}".split("e")
    scale = float(f"1e{int(exponent) + (float(digits) > 1.0)}")
    return np.asarray(np.round(x / scale, DIGITS) * scale + 0.0)  # no negative zeros


def rounded_each(x: np.ndarray) -> np.ndarray:
    """Return x with each element rounded to DIGITS significant digits."""
    return np.array([float(f"{e:.{DIGITS - 1}e}") for e in x])


def rigid_motions(nodes: np.ndarray) -> np.ndarray:
    """Return the velocities of nodes (n, 3) in the six rigid motions, as columns (6n, 6).

    B_0 of equation (2) in `tracks`.
    """
    B = np.zeros((len(nodes), 6, 6))
    for j, X in enumerate(nodes):
        B[j, :3, :3] = -skew(X)
    B[:, :3, 3:] = B[:, 3:, :3] = np.eye(3)
    return B.reshape(-1, 6)


def moves_freely(u: np.ndarray, K: np.ndarray, held: list[int]) -> bool:
    """Return whether a rigid motion u of the nodes is unconstrained and free of strain."""
    if not np.any(u) or np.any(u[held]):
        return False
    return bool(np.abs(times(K, u)).max() <= FREE * np.abs(K).max() * np.abs(u).max())
