"""Recursive formulation with articulated-body inertias: one pass inwards, one outwards, O(n) for trees of any depth.

Featherstone 2008, section 7.3, in world axes about one point, where no transformation stands between two bodies.
A joint of several degrees of freedom is eliminated column by column, so only scalars are ever inverted.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..dynamics import kinematics
from ..spatial import join, mirror
from ..trees import Tree
from .bodies import newton_euler

__all__ = ["articulated"]


def articulated(tree: Tree, q: Any, v: Any, tau: Any, W: list[Any], g: Any, a_ref: Any = ()) -> tuple[Any, Any, Any]:
    """dq/dt, dv/dt and the forces of prescribed joints; arguments as for `dynamics`."""
    K = kinematics(tree, q, v, g, a_ref)
    I, p = newton_euler(tree, K, W)
    given = dict(zip(tree.prescribed_dofs, a_ref, strict=True))
    first = np.cumsum([0, *map(len, K.S)]).tolist()
    U: dict[int, tuple[Any, Any, Any]] = {}
    reaction = {}
    for i in reversed(range(len(tree.bodies))):
        inertia, force = I[i], p[i]
        for k, s in reversed(list(enumerate(K.S[i], first[i]))):
            if k not in given:
                u = inertia @ s
                d = 1.0 / (s @ u)
                rest = (tau[k] - s @ force) * d
                U[k] = u, d, rest
                inertia = mirror(inertia - np.array([[a * b for b in u] for a in u * d]))
                force = force + u * rest
        if (parent := tree.bodies[i].parent) >= 0:
            I[parent], p[parent] = I[parent] + inertia, p[parent] + force
    X: list[Any] = []  # accelerations beyond the bias
    dv = dict(given)
    for i, b in enumerate(tree.bodies):
        x = X[b.parent] if b.parent >= 0 else np.zeros(6)
        for k, s in enumerate(K.S[i], first[i]):
            if k not in given:
                u, d, rest = U[k]
                dv[k] = rest - (u @ x) * d
                x = x + s * dv[k]
        X.append(x)
        for k, s in enumerate(K.S[i], first[i]):
            if k in given:
                reaction[k] = s @ (I[i] @ x + p[i]) - tau[k]
    return join(*K.dq), np.array([dv[k] for k in range(first[-1])]), np.array([reaction[k] for k in given])
