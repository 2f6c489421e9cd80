"""Embedding formulation: the constraint forces vanish by projection on the velocities that the joints allow.

The path matrix T and the joint columns S give the velocity transformation of the whole system, V = R qd with
R = T^T S: row i holds the columns of all joints on the path of body i.  Then R^T M R qdd = tau - R^T p, dense
(Haug 1992, Shabana 2005: generalised coordinate partitioning with joint coordinates).
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.ldlt import LDLT
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named
from heavylift.kernel.multibody.free_bodies import newton_euler
from heavylift.kernel.multibody.kinematics import Kinematics, kinematics
from heavylift.kernel.multibody.trees import Tree


def embedding(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """dq/dt, dv/dt and the forces of prescribed joints; arguments as for `dynamics`."""
    K = kinematics(tree, q, v, g, a_ref)
    M, p = newton_euler(tree, K, W)
    R = velocity_transformation(tree, K)
    n = tree.v.stop - tree.v.start
    free, given = tree.free_dofs, tree.prescribed_dofs
    full = sum((r.T @ m @ r for r, m in zip(R, M, strict=True)), np.zeros((n, n)))
    lower = {(k, l): named(f"H({k},{l})", full[k, l]) for k in range(n) for l in range(k + 1)}
    reduced = {(k, l): lower[max(k, l), min(k, l)] for k in range(n) for l in range(n)}
    force = sum((r.T @ f for r, f in zip(R, p, strict=True)), np.zeros(n))
    rhs = [tau[k] - force[k] for k in range(n)]
    a = LDLT([[reduced[k, l] for l in free] for k in free]).solve([rhs[k] for k in free])
    dv = dict(zip(free, a, strict=True)) | dict(zip(given, a_ref, strict=True))
    reaction = [sum((reduced[k, l] * dv[l] for l in free), -rhs[k]) for k in given]
    return join(*K.dq), np.array([dv[k] for k in range(n)]), np.array(reaction)


def velocity_transformation(tree: Tree, K: Kinematics) -> list[Array]:
    """R: per body (6, n_v), the columns of joints and modes on its path; all others are zero."""
    R: list[Array] = []
    k = 0
    for i, (b, columns) in enumerate(zip(tree.bodies, K.S, strict=True)):
        own = [np.zeros(6)] * (tree.v.stop - tree.v.start) if b.parent < 0 else list(R[b.parent].T)
        own[k : k + len(columns)] = columns
        if i in K.carried:
            own[tree.bodies[b.parent].v_modes] = K.carried[i]
        k += len(columns)
        R.append(np.array(own).T if own else np.zeros((6, 0)))
    return R
