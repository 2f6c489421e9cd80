"""Every body alone: Newton's and Euler's equations before any joint is thought of (the paper's Fig. 6 (c))."""

from __future__ import annotations

from heavylift.kernel.algebra.spatial import force_cross, mirror, spatial_inertia
from heavylift.kernel.compiler.symbol import Array, named
from heavylift.kernel.multibody.kinematics import Kinematics
from heavylift.kernel.multibody.trees import Tree

__all__ = ["newton_euler"]


def newton_euler(tree: Tree, K: Kinematics, W: list[Array]) -> tuple[list[Array], list[Array]]:
    """Per body M (6, 6) and p (6,): M x + p is the wrench that its joints must bring together, where x (6,) is its
    acceleration beyond the bias K.A, in world axes about the tree's point; W: (6,) applied wrenches."""
    M, p = [], []
    for i, b in enumerate(tree.bodies):
        J = spatial_inertia(b.mass, K.r[i] + K.R[i] @ b.com, mirror(K.R[i] @ b.inertia @ K.R[i].T))
        M.append(J)
        p.append(named(f"f({b.name})", J @ K.A[i] + force_cross(K.V[i]) @ (J @ K.V[i]) - W[i]))
    return M, p
