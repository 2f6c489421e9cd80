"""Kinematics of one tree: poses, twists and bias accelerations from the root outwards (Ku et al. 2012, Fig. 6 (a),
(b)).

World axes about the root body's origin, so that sums along paths need no transformations: V = T^T S qd with the path
matrix T (Featherstone 2008, chapter 5). A flexible body carries its children at deformed stations. The code runs on
floats (reference) and on symbols (machine code).

Single bodies: Newton's and Euler's equations without joints (the paper's Fig. 6 (c)).

A body in water moves some of it along: its added mass, a symmetric 6x6 matrix in body axes, is added to its own inertia
(Kirchhoff's equations; Newman, Marine Hydrodynamics, 1977, section 4.13), but has no weight.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import exact, force_cross, join, mirror, motion_cross, skew, spatial_inertia
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named
from heavylift.kernel.multibody.flexible.attachment import FlexibleInertia, carry, carry_along, flexible_inertia

from .motion import columns, placement, rates
from .trees import Tree


@dataclass
class Kinematics:
    """Motion of all bodies of a tree in world axes.

    Rotation R_WB, r from the tree's reference point o to the body's origin, twist V, bias acceleration A (gravity as
    upward acceleration of the ground), columns S and dq/dt of each joint. A mode does not move the floating frame, so
    its column in S is zero. `modes`: coordinates, rates and accelerations of a flexible body (accelerations 0, as for
    the joints in A); `carried`: the columns of the parent's modes at the joint of a body that a flexible body carries.
    """

    o: Array
    R: list[Array] = field(default_factory=list)
    r: list[Array] = field(default_factory=list)
    V: list[Array] = field(default_factory=list)
    A: list[Array] = field(default_factory=list)
    S: list[list[Any]] = field(default_factory=list)
    dq: list[Array] = field(default_factory=list)
    modes: dict[int, tuple[Array, Array, Array]] = field(default_factory=dict)
    carried: dict[int, list[Any]] = field(default_factory=dict)
    g: Scalar = 0.0  # gravity in A


Base = tuple[Array, Array, Array, Array]  # R, r, V, A of what a root stands on


def kinematics(tree: Tree, q: Array, v: Array, g: Scalar, a_ref: Scalars = (), base: Base | None = None) -> Kinematics:
    """Return the motion of all bodies of a tree with zero accelerations of the free joints.

    Ku et al. 2012, Fig. 6 (a), (b).

    a_ref (n_prescribed,): accelerations of the prescribed joints. `base`: the body that carries the root, if that is
    not the ground; r then counts from the reference point of its tree.
    """
    # gravity as upward acceleration of the ground, so that no weight has to be applied to any body (Featherstone, 5.3)
    ground = (exact(np.eye(3)), np.zeros(3), np.zeros(6), join(np.zeros(3), [0.0, 0.0, g]))
    K = Kinematics(o=np.zeros(3), g=g)
    prescribed = iter(a_ref)
    for i, b in enumerate(tree.bodies):
        x, u = q[b.q], v[b.v]
        root, p = b.parent < 0, b.parent
        R_WP, r_P, V_P, A_P = (base or ground) if root else (K.R[p], K.r[p], K.V[p], K.A[p])
        if b.beside is not None:
            r_P = -K.o
        if b.place is not None:
            # a child of a flexible body stands on the deformed station, which moves with the modes
            flexible = (*K.modes[b.parent][:2], R_WP, r_P, V_P, A_P)
            slides = b.kind == "slider"
            on = carry_along(b.place, x[0], u[0], *flexible) if slides else carry(b.place, *flexible)
            R_WP, r_P, V_P, A_P, K.carried[i] = on.R, on.r, on.V, on.A, on.columns
        R_JB, p_JB = placement(b.kind, b.axes, b.pitch, x)
        R_WJ = R_WP @ b.R_PJ
        p_PB = R_WP @ b.p_PJ + R_WJ @ p_JB
        R = named(f"R({b.name})", R_WJ @ R_JB)
        if root and base is None and b.beside is None:
            # the tree's point follows the root body: positions stay small and digits are kept far from the origin
            K.o, r = p_PB, np.zeros(3)
        else:
            r = named(f"r({b.name})", r_P + p_PB)
        S, bias = columns(b, x, u, R_WJ, R, r)
        if b.shifted:
            # the joint's frame on the child is not the child's own: shift back to the body's frame
            R = named(f"R({b.name})", R @ b.R_CJ.T)
            r = named(f"r({b.name})", r - R @ b.p_CJ)
        V_J = sum((s * w for s, w in zip(S, u, strict=True)), np.zeros(6))
        # V_P x V_J: the velocity-product term of the acceleration, V_P being the twist of the parent
        A = A_P + motion_cross(V_P) @ V_J
        if bias is not None:
            A = A + bias
        if b.kind == "slider":
            S = [on.along]  # already in V_P and A_P
        for n in b.prescribed:
            # prescribed accelerations are known, so that they belong to the bias
            A = A + S[n] * next(prescribed)
        K.R.append(R)
        K.r.append(r)
        K.S.append(S)
        K.V.append(named(f"V({b.name})", V_P + V_J))
        K.A.append(named(f"A({b.name})", A))
        K.dq.append(rates(b.kind, x, u))
        if b.elastic is not None:
            K.modes[i] = q[b.q_modes], v[b.v_modes], np.zeros(b.n_modes)
            # a mode does not move the floating frame; its effect on children is in `carried`
            K.S[i] = [*S, *np.zeros((b.n_modes, 6))]
            K.dq[i] = join(K.dq[i], v[b.v_modes])
    return K


def seen_from(tree: Tree, K: Kinematics, k: int, i: int) -> Any:
    """Return the velocity (6,) of body i at unit speed of degree of freedom k, which lies on its path to the ground."""
    on = tree.body_of_dof[k]
    b = tree.bodies[on]
    mode = k - b.v_modes.start
    if mode < 0 or on == i:
        # below a flexible body, a mode acts through the child that leads to body i
        return K.S[on][k - b.v.start]
    while tree.bodies[i].parent != on:
        i = tree.bodies[i].parent
    return K.carried[i][mode]


def elastic(tree: Tree, K: Kinematics, i: int) -> FlexibleInertia:
    """Return the inertia and inertia forces of flexible body i in the motion K of its tree."""
    return flexible_inertia(tree.bodies[i].elastic, *K.modes[i], K.R[i], K.r[i], K.V[i], K.A[i])


def added_inertia(A: Array, r: Array, R: Array) -> Any:
    """Return the added mass (6, 6) of a body in world axes about the tree's reference point; r: from this point to the
    body's origin."""
    T = _to_body(r, R)
    return mirror(T.T @ A @ T)


def _to_body(r: Array, R: Array) -> Any:
    """Return the motion transform (6, 6) from the tree's point in world axes to a body's origin in body axes."""
    return np.block([[R.T, np.zeros((3, 3))], [-(R.T @ skew(r)), R.T]])


def shared_inertia(tree: Tree, K: Kinematics) -> Iterator[tuple[int, int, Any]]:
    """Yield the numbers of two bodies that share water, and the added mass (6, 6) between them.

    From the twist of the second to the momentum of the water at the first, in world axes about the tree's reference
    point.
    """
    for i, b in enumerate(tree.bodies):
        if b.shared is not None and b.beside is not None:
            yield i, b.beside, _to_body(K.r[i], K.R[i]).T @ b.shared.A @ _to_body(K.r[b.beside], K.R[b.beside])


def body_inertia(tree: Tree, K: Kinematics, i: int) -> Any:
    """Return the inertia (6, 6) of a rigid body with added mass, in world axes about the tree's reference point."""
    b = tree.bodies[i]
    J = spatial_inertia(b.mass, K.r[i] + K.R[i] @ b.com, mirror(K.R[i] @ b.inertia @ K.R[i].T))
    return J if b.added is None else J + added_inertia(b.added.A, K.r[i], K.R[i])


def newton_euler(tree: Tree, K: Kinematics, W: list[Array]) -> tuple[list[Array], list[Array]]:
    """Return mass matrix M (6, 6) and force p (6,) of each body such that M x + p is the sum of its joint wrenches.

    x (6,): acceleration of the body less its bias K.A; world axes about the tree's reference point; W: applied wrenches
    (6,).
    """
    M, p = [], []
    for i, b in enumerate(tree.bodies):
        J = body_inertia(tree, K, i)
        # Newton-Euler in spatial form: I a + v x* I v, less what is applied
        f = J @ K.A[i] + force_cross(K.V[i]) @ (J @ K.V[i]) - W[i]
        if b.added is not None:
            f = f - K.g * added_inertia(b.added.A, K.r[i], K.R[i])[:, 5]  # K.A has gravity, which does not act on water
        M.append(J)
        p.append(named(f"f({b.name})", f))
    for i, j, C in shared_inertia(tree, K):
        weight = join(np.zeros(5), [K.g])  # does not act on water
        p[i] = p[i] + C @ (K.A[j] - weight) + force_cross(K.V[i]) @ (C @ K.V[j])
        p[j] = p[j] + C.T @ (K.A[i] - weight) + force_cross(K.V[j]) @ (C.T @ K.V[i])
    return M, p
