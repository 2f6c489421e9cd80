"""Every body alone: Newton's and Euler's equations before any joint is thought of (the paper's Fig. 6 (c)).

A body in water moves some of it along: its added mass, a symmetric 6x6 matrix in body axes, stands beside its own
inertia (Kirchhoff's equations; Newman, Marine Hydrodynamics, 1977, section 4.13), but gravity does not pull on it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import force_cross, mirror, skew, spatial_inertia
from heavylift.kernel.compiler.symbol import Array, named

from .kinematics import Kinematics
from .trees import Tree


def added_inertia(A: Array, r: Array, R: Array) -> Any:
    """(6, 6) added mass in world axes about the tree's point, r from it to the body's origin."""
    T = np.block([[R.T, np.zeros((3, 3))], [-(R.T @ skew(r)), R.T]])
    return mirror(T.T @ A @ T)


def body_inertia(tree: Tree, K: Kinematics, i: int) -> Any:
    """(6, 6) inertia of a rigid body about the tree's point, in world axes, its added mass included."""
    b = tree.bodies[i]
    J = spatial_inertia(b.mass, K.r[i] + K.R[i] @ b.com, mirror(K.R[i] @ b.inertia @ K.R[i].T))
    return J if b.added is None else J + added_inertia(b.added.A, K.r[i], K.R[i])


def newton_euler(tree: Tree, K: Kinematics, W: list[Array]) -> tuple[list[Array], list[Array]]:
    """Per body M (6, 6) and p (6,): M x + p is the wrench that its joints must bring together, where x (6,) is its
    acceleration beyond the bias K.A, in world axes about the tree's point; W: (6,) applied wrenches."""
    M, p = [], []
    for i, b in enumerate(tree.bodies):
        J = body_inertia(tree, K, i)
        f = J @ K.A[i] + force_cross(K.V[i]) @ (J @ K.V[i]) - W[i]
        if b.added is not None:
            f = f - K.g * added_inertia(b.added.A, K.r[i], K.R[i])[:, 5]  # K.A has gravity, which does not act on water
        M.append(J)
        p.append(named(f"f({b.name})", f))
    return M, p
