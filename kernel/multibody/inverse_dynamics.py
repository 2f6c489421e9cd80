"""Inverse dynamics of one tree: which forces give these accelerations (recursive Newton-Euler, the paper's Fig. 6).

(a), (b) are `kinematics` plus the accelerations along the paths, (c), (d) are `composites`, (e) projects on the joints
(Featherstone 2008, section 5.3).  The text runs on floats and on symbols, like the forward dynamics that it inverts.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.symbol import Array, Scalar

from .dynamics import composites, joint_forces
from .kinematics import Kinematics, kinematics
from .trees import Tree


def accelerated(tree: Tree, q: Array, v: Array, dv: Array, g: Scalar) -> Kinematics:
    """Places, twists and the true accelerations of all bodies (gravity as upward acceleration of the ground)."""
    K = kinematics(tree, q, v, g, [0.0] * len(tree.prescribed_dofs))
    X: list[Array] = []  # what the accelerations of the joints add
    for i, (b, S) in enumerate(zip(tree.bodies, K.S, strict=True)):
        columns, a = [*S], [*dv[b.v.start : b.v_modes.stop]]
        if i in K.carried:  # by the modes of its parent
            columns, a = columns + K.carried[i], [*a, *dv[tree.bodies[b.parent].v_modes]]
        if i in K.modes:
            K.modes[i] = (*K.modes[i][:2], dv[b.v_modes])
        own = sum((s * x for s, x in zip(columns, a, strict=True)), np.zeros(6))
        X.append(own if b.parent < 0 else X[b.parent] + own)
    K.A = [A + x for A, x in zip(K.A, X, strict=True)]
    return K


def axial_loads(tree: Tree, q: Array, v: Array, dv: Array, W: list[Array], g: Scalar) -> Array:
    """Of every flexible body, in its own axes: the force (3,) of each body that it carries on it [N], the acceleration
    (3,) of its frame less gravity [m/s2], and its angular velocity (3,) [rad/s]; arguments as of `inverse_dynamics`."""
    K = accelerated(tree, q, v, dv, g)
    _, F = composites(tree, K, W)
    out: list[Array] = []
    for i, b in enumerate(tree.bodies):
        if b.n_modes:
            r, w, A, R = K.r[i], K.V[i][:3], K.A[i], K.R[i]
            a = A[3:] + cross(A[:3], r) + cross(w, K.V[i][3:] + cross(w, r))
            out += [-(R.T @ F[j][3:]) for j, child in enumerate(tree.bodies) if child.parent == i]
            out += [R.T @ a, R.T @ w]
    return join(*out)


def inverse_dynamics(tree: Tree, q: Array, v: Array, dv: Array, W: list[Array], g: Scalar) -> tuple[Array, list[Array]]:
    """Forces tau (n_v,) of the joints that give the accelerations dv, and what each joint transmits to its body.

    W: (6,) wrench on each body, the result likewise (6,) per body, [moment; force] in world axes about the tree's
    point [N m, N].  Prescribed joints count like all others: tau is what their drives must bring.
    """
    K = accelerated(tree, q, v, dv, g)
    _, F = composites(tree, K, W)
    return np.array(list(joint_forces(tree, K, F))), F
