"""Recursive equations of motion of one tree: the paper's Fig. 6 (a)-(e), solved with CRBA and LTDL.

World axes about the root body's origin, so that with the path matrix T the recursions are sums along paths:
twists V = T^T S qd, composite inertias and wrenches likewise, H_kl = S_l^T I^c S_k for l on the path of k
(Featherstone 2008, ch. 5-6; H = L^T D L without fill-in, ch. 8).  Sign of (d) as corrected:
f_c,i = f_B,i - f_e,i + sum over children f_c,j.  The text runs on floats (oracle) and on symbols (machine code).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .errors import KernelError
from .flexible.attachment import carry, carry_along
from .flexible.inertia import FlexibleInertia, flexible_inertia
from .motion import columns, placement, rates
from .spatial import force_cross, join, mirror, motion_cross, skew, spatial_inertia
from .symbol import is_sym, named
from .trees import Tree

__all__ = [
    "Base", "Equations", "Factors", "Kinematics", "composites", "dynamics", "elastic", "energies",
    "equations_of_motion", "joint_forces", "joint_space_inertia", "kinematics", "ltdl", "seen_from",
]  # fmt: skip


@dataclass
class Kinematics:
    """Per body of a tree, in world axes: rotation R_WB, r from the tree's point o to the origin, twist V,
    bias acceleration A (gravity as upward acceleration of the ground), columns S and dq/dt per joint.

    A mode does not move the floating frame: its column in S is zero.  `modes`: coordinates, rates and accelerations of
    a flexible body (the latter 0, as those of the joints in A); `carried`: the columns of its modes at the joint of a
    body that it carries.
    """

    o: Any
    R: list[Any] = field(default_factory=list)
    r: list[Any] = field(default_factory=list)
    V: list[Any] = field(default_factory=list)
    A: list[Any] = field(default_factory=list)
    S: list[list[Any]] = field(default_factory=list)
    dq: list[Any] = field(default_factory=list)
    modes: dict[int, tuple[Any, Any, Any]] = field(default_factory=dict)
    carried: dict[int, list[Any]] = field(default_factory=dict)


Base = tuple[Any, Any, Any, Any]  # R, r, V, A of what a root stands on


def kinematics(tree: Tree, q: Any, v: Any, g: Any, a_ref: Any = (), base: Base | None = None) -> Kinematics:
    """Fig. 6 (a), (b) with zero acceleration except the prescribed joints' a_ref (n_prescribed,).

    `base`: the body that the root stands on if that is not the ground; r then counts from the point of its tree.
    """
    ground = (np.eye(3), np.zeros(3), np.zeros(6), join(np.zeros(3), [0.0, 0.0, g]))
    K = Kinematics(o=np.zeros(3))
    prescribed = iter(a_ref)
    for i, b in enumerate(tree.bodies):
        x, u = q[b.q], v[b.v]
        root, p = b.parent < 0, b.parent
        R_WP, r_P, V_P, A_P = (base or ground) if root else (K.R[p], K.r[p], K.V[p], K.A[p])
        if b.place is not None:
            flexible = (*K.modes[b.parent][:2], R_WP, r_P, V_P, A_P)
            slides = b.kind == "slider"
            on = carry_along(b.place, x[0], u[0], *flexible) if slides else carry(b.place, *flexible)
            R_WP, r_P, V_P, A_P, K.carried[i] = on.R, on.r, on.V, on.A, on.columns
        R_JB, p_JB = placement(b.kind, b.axes, b.pitch, x)
        R_WJ = R_WP @ b.R_PJ
        p_PB = R_WP @ b.p_PJ + R_WJ @ p_JB
        R = named(f"R({b.name})", R_WJ @ R_JB)
        if root and base is None:
            K.o, r = p_PB, np.zeros(3)
        else:
            r = named(f"r({b.name})", r_P + p_PB)
        S, bias = columns(b, x, u, R_WJ, R, r)
        if b.shifted:
            R = named(f"R({b.name})", R @ b.R_CJ.T)
            r = named(f"r({b.name})", r - R @ b.p_CJ)
        V_J = sum((s * w for s, w in zip(S, u, strict=True)), np.zeros(6))
        A = A_P + motion_cross(V_P) @ V_J
        if bias is not None:
            A = A + bias
        if b.kind == "slider":
            S = [on.along]  # already in V_P and A_P
        for n in b.prescribed:
            A = A + S[n] * next(prescribed)
        K.R.append(R)
        K.r.append(r)
        K.S.append(S)
        K.V.append(named(f"V({b.name})", V_P + V_J))
        K.A.append(named(f"A({b.name})", A))
        K.dq.append(rates(b.kind, x, u))
        if b.elastic is not None:
            K.modes[i] = q[b.q_modes], v[b.v_modes], np.zeros(b.n_modes)
            K.S[i] = [*S, *np.zeros((b.n_modes, 6))]
            K.dq[i] = join(K.dq[i], v[b.v_modes])
    return K


def seen_from(tree: Tree, K: Kinematics, k: int, i: int) -> Any:
    """(6,) column of degree of freedom k on the path of body i, as the motion that it gives to body i."""
    on = tree.body_of_dof[k]
    b = tree.bodies[on]
    mode = k - b.v_modes.start
    if mode < 0 or on == i:
        return K.S[on][k - b.v.start]
    while tree.bodies[i].parent != on:
        i = tree.bodies[i].parent
    return K.carried[i][mode]


def elastic(tree: Tree, K: Kinematics, i: int) -> FlexibleInertia:
    """The deformable part of flexible body i at these places and motions."""
    return flexible_inertia(tree.bodies[i].elastic, *K.modes[i], K.R[i], K.r[i], K.V[i], K.A[i])


@dataclass(frozen=True)
class Equations:
    """H a = rhs of one tree, with the motion that it was made from and the factors of H."""

    tree: Tree
    K: Kinematics
    H: dict[tuple[int, int], Any]
    rhs: list[Any]
    factors: Factors

    def accelerations(self, a: list[Any], a_ref: Any) -> Any:
        """(n_v,) from those of the free degrees of freedom and the given ones."""
        values = dict(zip(self.tree.free_dofs, a, strict=True)) | dict(
            zip(self.tree.prescribed_dofs, a_ref, strict=True)
        )
        return np.array([values[k] for k in range(len(self.rhs))])

    def solution(self, a_ref: Any) -> tuple[dict[int, Any], Any]:
        """Accelerations by degree of freedom where nothing else acts, and the forces of prescribed joints."""
        a = self.accelerations(self.factors.solve([self.rhs[k] for k in self.tree.free_dofs]), a_ref)
        reaction = [
            -self.rhs[k] + sum((h * a[l] for l, h in self.given(k).items()), 0.0) for k in self.tree.prescribed_dofs
        ]
        return dict(enumerate(a)), np.array(reaction)

    def given(self, k: int) -> dict[int, Any]:
        """Row k of H, of a prescribed degree of freedom, over the free ones."""
        free = self.tree.free_dofs
        return {l: self.H[max(k, l), min(k, l)] for l in free if (max(k, l), min(k, l)) in self.H}


def equations_of_motion(tree: Tree, q: Any, v: Any, tau: Any, W: list[Any], g: Any, a_ref: Any = ()) -> Equations:
    """Fig. 6 (a)-(e) up to the linear system for the joint accelerations; arguments as for `dynamics`."""
    K = kinematics(tree, q, v, g, a_ref)
    I, F = composites(tree, K, W)
    H = joint_space_inertia(tree, K, I)
    rhs = [t - f for t, f in zip(tau, joint_forces(tree, K, F), strict=False)]  # (e)
    return Equations(tree, K, H, rhs, ltdl(tree, dict(H)))


def dynamics(tree: Tree, q: Any, v: Any, tau: Any, W: list[Any], g: Any, a_ref: Any = ()) -> tuple[Any, Any, Any]:
    """dq/dt, dv/dt and the forces of prescribed joints; W: (6,) wrench on each body about the tree's point.

    tau: (n_v,) joint forces of springs, drives, brakes and stops [N or N m].
    """
    x = equations_of_motion(tree, q, v, tau, W, g, a_ref)
    motion, reaction = x.solution(a_ref)
    return join(*x.K.dq), np.array(list(motion.values())), reaction


def composites(tree: Tree, K: Kinematics, W: list[Any]) -> tuple[list[Any], list[Any]]:
    """Per body, with all that it carries: spatial inertia I^c and the wrench that its joint would have to transmit if
    no degree of freedom accelerated (Fig. 6 (c), (d))."""
    I, F = [], []
    for i, b in enumerate(tree.bodies):
        J = spatial_inertia(b.mass, K.r[i] + K.R[i] @ b.com, mirror(K.R[i] @ b.inertia @ K.R[i].T))
        f = J @ K.A[i] + force_cross(K.V[i]) @ (J @ K.V[i]) - W[i]
        if b.elastic is not None:
            own = elastic(tree, K, i)
            J, f = J + own.I, f + own.wrench
        I.append(J)
        F.append(named(f"f({b.name})", f))
    for i in reversed(range(len(tree.bodies))):
        p = tree.bodies[i].parent
        if p >= 0:
            I[p], F[p] = I[p] + I[i], F[p] + F[i]
    return I, F


def joint_forces(tree: Tree, K: Kinematics, F: list[Any]) -> Iterator[Any]:
    """(n_v,) S^T F: the forces along the degrees of freedom that hold all accelerations of `composites` at zero.

    A mode feels its own body (equation (8) of `flexible.inertia`) and what that carries.
    """
    for i, b in enumerate(tree.bodies):
        for S in K.S[i][: b.v.stop - b.v.start]:
            yield S @ F[i]
        if b.n_modes:
            on = [j for j, child in enumerate(tree.bodies) if child.parent == i]
            for k, own in enumerate(elastic(tree, K, i).forces):
                yield sum((K.carried[j][k] @ F[j] for j in on), own)


def joint_space_inertia(tree: Tree, K: Kinematics, I: list[Any]) -> dict[tuple[int, int], Any]:
    """H[k, l] = S_l^T I^c S_k for l on the path of k (CRBA); raises KernelError where nothing resists a motion."""
    H: dict[tuple[int, int], Any] = {}
    for k, (i, path) in enumerate(zip(tree.body_of_dof, tree.dof_paths, strict=True)):
        mode = k - tree.bodies[i].v_modes.start
        if mode >= 0:
            _mode_inertia(tree, K, I, H, k, mode)
            continue
        f = I[i] @ seen_from(tree, K, k, i)
        for l in (k, *path):
            H[k, l] = named(f"H({k},{l})", seen_from(tree, K, l, i) @ f)
    for k in tree.free_dofs:
        if not is_sym(H[k, k]) and H[k, k] == 0.0:
            name = tree.bodies[tree.body_of_dof[k]].name
            raise KernelError(
                f"body '{name}': nothing resists its motion; give it, or what it carries, mass or inertia"
            )
    return H


def _mode_inertia(tree: Tree, K: Kinematics, I: list[Any], H: dict[tuple[int, int], Any], k: int, mode: int) -> None:
    """The row of a mode: what the body's own deformation moves, and all that it carries."""
    i = tree.body_of_dof[k]
    b, own = tree.bodies[i], elastic(tree, K, i)
    moved = {j: I[j] @ K.carried[j][mode] for j, child in enumerate(tree.bodies) if child.parent == i}
    for l in range(b.v_modes.start, k + 1):
        other = l - b.v_modes.start
        alone = own.mass[mode] if l == k else 0.0
        H[k, l] = named(f"H({k},{l})", sum((K.carried[j][other] @ f for j, f in moved.items()), alone))
    f = sum(moved.values(), own.C[mode])
    for l in tree.dof_paths[k]:
        if l < b.v_modes.start:
            H[k, l] = named(f"H({k},{l})", seen_from(tree, K, l, i) @ f)


@dataclass(frozen=True)
class Factors:
    """H = L^T D L over the free degrees of freedom of a tree, without fill-in along the paths.

    L[k, i] for i on the path of k (its unit diagonal is not stored), D_inverse[k] = 1/D_k.
    """

    dofs: list[int]
    paths: list[list[int]]
    L: dict[tuple[int, int], Any]
    D_inverse: dict[int, Any]

    def half(self, b: list[Any]) -> list[Any]:
        """L^-T b, so that b^T H^-1 c = half(b)^T D^-1 half(c)."""
        y = dict(zip(self.dofs, b, strict=True))
        for k in reversed(self.dofs):
            for i in self.paths[k]:
                y[i] = y[i] - self.L[k, i] * y[k]
        return [y[k] for k in self.dofs]

    def back(self, y: list[Any]) -> list[Any]:
        """L^-1 D^-1 y: the second half of a solution."""
        x: dict[int, Any] = {}
        for k, y_k in zip(self.dofs, y, strict=True):
            t = y_k * self.D_inverse[k]
            for i in self.paths[k]:
                t = t - self.L[k, i] * x[i]
            x[k] = t
        return [x[k] for k in self.dofs]

    def solve(self, b: list[Any]) -> list[Any]:
        """H^-1 b over the free degrees of freedom."""
        return self.back(self.half(b))


def ltdl(tree: Tree, H: dict[tuple[int, int], Any]) -> Factors:
    """Factorise H in place (Featherstone 2008, sections 6.5 and 8.6)."""
    dofs, paths = tree.free_dofs, tree.free_paths
    D_inverse: dict[int, Any] = {}
    for k in reversed(dofs):
        D_inverse[k] = 1.0 / H[k, k]
        for n, i in enumerate(paths[k]):
            a = H[k, i] * D_inverse[k]
            for j in paths[k][n:]:
                H[i, j] = H[i, j] - a * H[k, j]
            H[k, i] = a
    return Factors(dofs, paths, H, D_inverse)


def energies(tree: Tree, K: Kinematics, g: Any) -> tuple[Any, Any]:
    """Kinetic and gravitational energy of a tree [J]."""
    kinetic: Any = 0.0
    potential: Any = 0.0
    for i, b in enumerate(tree.bodies):
        c = K.r[i] + K.R[i] @ b.com
        v_C = K.V[i][3:] + skew(K.V[i][:3]) @ c
        w = K.R[i].T @ K.V[i][:3]
        kinetic = kinetic + 0.5 * (b.mass * (v_C @ v_C) + w @ (b.inertia @ w))
        potential = potential + b.mass * g * (K.o[2] + c[2])
        if b.elastic is not None:
            own = elastic(tree, K, i)
            kinetic = kinetic + own.kinetic
            potential = potential + g * (tree.bodies[i].elastic.J0[3, 3] * K.o[2] + own.moment[2])
    return kinetic, potential
