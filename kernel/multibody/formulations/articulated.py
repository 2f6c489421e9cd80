"""Recursive formulation with articulated-body inertias: one pass inwards, one outwards, O(n) for trees of any depth.

Featherstone 2008, section 7.3, in world axes about one point, where no transformation stands between two bodies.
A joint of several degrees of freedom is eliminated column by column, so only scalars are ever inverted.
"""

from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import join, mirror
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named
from heavylift.kernel.multibody.kinematics import Kinematics, kinematics, newton_euler
from heavylift.kernel.multibody.trees import Tree

Eliminated = dict[int, tuple[Array, Scalar, Scalar]]  # degree of freedom -> U, 1/D, acceleration that x = 0 leaves


def articulated(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """dq/dt, dv/dt and the forces of prescribed joints; arguments as for `dynamics`."""
    K = kinematics(tree, q, v, g, a_ref)
    I, p = newton_euler(tree, K, W)
    given = dict(zip(tree.prescribed_dofs, a_ref, strict=True))
    U, _ = inwards(tree, K, tau, I, p)
    dv, X = outwards(tree, K, U, np.zeros(6), given)
    reaction = [
        K.S[i][k - b.v.start] @ (I[i] @ X[i] + p[i]) - tau[k]
        for i, b in enumerate(tree.bodies)
        for k in range(b.v.start, b.v.stop)
        if k in given
    ]
    return join(*K.dq), np.array([dv[k] for k in range(len(dv))]), np.array(reaction)


def inwards(
    tree: Tree, K: Kinematics, tau: Array, I: list[Array], p: list[Array]
) -> tuple[Eliminated, tuple[Array, Array]]:
    """Eliminate the free degrees of freedom from the tips to the roots: (7.44) to (7.48).

    I (6, 6) and p (6,) of the bodies become the articulated ones; also what the last root hands to what it stands on.
    """
    given = set(tree.prescribed_dofs)
    U: Eliminated = {}
    inertia, force = np.zeros((6, 6)), np.zeros(6)
    for i in reversed(range(len(tree.bodies))):
        inertia, force = I[i], p[i]
        for k, s in reversed(list(enumerate(K.S[i], tree.bodies[i].v.start))):
            if k not in given:
                u = named(f"U({k})", inertia @ s)
                d = 1.0 / named(f"D({k})", s @ u)
                rest = (tau[k] - s @ force) * d
                U[k] = u, d, rest
                inertia = mirror(inertia - np.array([[a * b for b in u] for a in u * d]))
                force = force + u * rest
        if (parent := tree.bodies[i].parent) >= 0:
            I[parent], p[parent] = I[parent] + inertia, p[parent] + force
    return U, (inertia, force)


def outwards(
    tree: Tree, K: Kinematics, U: Eliminated, base: Array, given: dict[int, Scalar]
) -> tuple[dict[int, Scalar], list[Array]]:
    """Accelerations of the degrees of freedom, and those of the bodies beyond the bias; base (6,): of the ground."""
    X: list[Array] = []
    dv = dict(given)
    for i, b in enumerate(tree.bodies):
        x: Any = X[b.parent] if b.parent >= 0 else base
        for k, s in enumerate(K.S[i], b.v.start):
            if k not in given:
                u, d, rest = U[k]
                dv[k] = rest - (u @ x) * d
                x = x + s * dv[k]
        X.append(x)
    return dv, X
