"""Recursive equations of motion of one tree (Ku et al. 2012, Fig. 6 (c)-(e)), solved by composite inertias and LTDL
factors, and their inverse.

World axes about the root body's origin, so that with the path matrix T the recursions are sums along paths: composite
inertias and wrenches as the twists of `kinematics`, H_kl = S_l^T I^c S_k for l on the path of k (Featherstone 2008,
chapters 5 and 6). Sign of (d) as corrected: f_c,i = f_B,i - f_e,i + sum over children f_c,j. H = L^T D L without
fill-in along the paths (sections 6.5 and 8.6): structural zeros do not appear in the code. Inverse dynamics (section
5.3): (a), (b) are `kinematics` plus the accelerations along the paths, (c), (d) are `composites`, (e) projects on the
joints. The code runs on floats (reference) and on symbols (machine code).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join, skew
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, is_sym, named
from heavylift.kernel.errors import KernelError

from .kinematics import Kinematics, added_inertia, elastic, kinematics, newton_euler, seen_from, shared_inertia
from .trees import Tree


@dataclass(frozen=True)
class LtdlFactors:
    """Factors H = L^T D L of a tree's joint-space inertia over its free degrees of freedom, without fill-in.

    L[k, i] for i on the path of k (its unit diagonal is not stored), D_inverse[k] = 1/D_k.
    """

    dofs: list[int]
    paths: list[list[int]]
    L: dict[tuple[int, int], Scalar]
    D_inverse: dict[int, Scalar]

    def half(self, b: list[Scalar]) -> list[Scalar]:
        """Return L^-T b, the first half of solving H x = b; b^T H^-1 c = half(b)^T D^-1 half(c)."""
        y = dict(zip(self.dofs, b, strict=True))
        for k in reversed(self.dofs):
            for i in self.paths[k]:
                y[i] = y[i] - self.L[k, i] * y[k]
        return [y[k] for k in self.dofs]

    def back(self, y: list[Scalar]) -> list[Scalar]:
        """Return L^-1 D^-1 y, the second half of solving H x = b, with y from `half`."""
        x: dict[int, Scalar] = {}
        for k, y_k in zip(self.dofs, y, strict=True):
            t = y_k * self.D_inverse[k]
            for i in self.paths[k]:
                t = t - self.L[k, i] * x[i]
            x[k] = t
        return [x[k] for k in self.dofs]

    def solve(self, b: list[Scalar]) -> list[Scalar]:
        """Return H^-1 b over the free degrees of freedom, with the joint-space inertia H."""
        return self.back(self.half(b))


def ltdl(tree: Tree, H: dict[tuple[int, int], Scalar]) -> LtdlFactors:
    """Factorise the joint-space inertia H into L^T D L in place (Featherstone 2008, sections 6.5 and 8.6)."""
    dofs, paths = tree.free_dofs, tree.free_paths
    D_inverse: dict[int, Scalar] = {}
    # from the tips to the root: eliminating degree of freedom k touches its path only, so that no fill-in arises
    for k in reversed(dofs):
        D_inverse[k] = 1.0 / H[k, k]
        for n, i in enumerate(paths[k]):
            a = H[k, i] * D_inverse[k]
            # only pairs on the path of k: all other products are structurally zero
            for j in paths[k][n:]:
                H[i, j] = H[i, j] - a * H[k, j]
            H[k, i] = a
    return LtdlFactors(dofs, paths, H, D_inverse)


@dataclass(frozen=True)
class Equations:
    """The linear system H a = rhs for the accelerations of one tree, with the tree's motion and the factors of H."""

    tree: Tree
    K: Kinematics
    H: dict[tuple[int, int], Scalar]
    rhs: list[Scalar]
    factors: LtdlFactors

    def accelerations(self, a: list[Scalar], a_ref: Scalars) -> Array:
        """Return all accelerations (n_v,) of the tree, given those of free and of prescribed degrees of freedom."""
        values = dict(zip(self.tree.free_dofs, a, strict=True)) | dict(
            zip(self.tree.prescribed_dofs, a_ref, strict=True)
        )
        return np.array([values[k] for k in range(len(self.rhs))])

    def solution(self, a_ref: Scalars) -> tuple[dict[int, Scalar], Array]:
        """Return the accelerations of the tree under the forces applied so far, and the forces of prescribed joints."""
        a = self.accelerations(self.factors.solve([self.rhs[k] for k in self.tree.free_dofs]), a_ref)
        reaction = [
            # row k of H a - rhs: the effort that holds a prescribed degree of freedom on its given acceleration
            -self.rhs[k] + sum((h * a[l] for l, h in self.given(k).items()), 0.0)
            for k in self.tree.prescribed_dofs
        ]
        return dict(enumerate(a)), np.array(reaction)

    def given(self, k: int) -> dict[int, Scalar]:
        """Return the entries of joint-space inertia H that couple a prescribed degree of freedom k to free ones."""
        free = self.tree.free_dofs
        return {l: self.H[max(k, l), min(k, l)] for l in free if (max(k, l), min(k, l)) in self.H}


def equations_of_motion(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> Equations:
    """Set up the recursive equations of Ku et al. (2012) as a linear system for the joint accelerations.

    Fig. 6 (a)-(e); arguments as of `dynamics`.
    """
    K = kinematics(tree, q, v, g, a_ref)
    I, F = composites(tree, K, W)
    H = joint_space_inertia(tree, K, I)
    # without accelerations of the free joints, F contains all inertia and gravity forces: rhs = tau - S^T F
    rhs = [t - f for t, f in zip(tau, joint_forces(tree, K, F), strict=False)]  # (e)
    return Equations(tree, K, H, rhs, ltdl(tree, dict(H)))


def dynamics(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """Return dq/dt, dv/dt and the forces in the prescribed joints of a tree.

    W: wrench (6,) applied to each body, about the tree's reference point; tau: (n_v,) joint forces from springs,
    drives, brakes and stops [N or N m].
    """
    x = equations_of_motion(tree, q, v, tau, W, g, a_ref)
    motion, reaction = x.solution(a_ref)
    return join(*x.K.dq), np.array(list(motion.values())), reaction


def composites(tree: Tree, K: Kinematics, W: list[Array]) -> tuple[list[Array], list[Array]]:
    """Return, for each body of a tree, its composite inertia I^c and its joint wrench at zero accelerations.

    Ku et al. 2012, Fig. 6 (c), (d).
    """
    I, F = newton_euler(tree, K, W)
    for i, b in enumerate(tree.bodies):
        if b.elastic is not None:
            own = elastic(tree, K, i)
            I[i], F[i] = I[i] + own.I, F[i] + own.wrench
    # children come after their parents, so that one backward sweep adds all subtrees
    for i in reversed(range(len(tree.bodies))):
        p = tree.bodies[i].parent
        if p >= 0:
            I[p], F[p] = I[p] + I[i], F[p] + F[i]
    return I, F


def joint_forces(tree: Tree, K: Kinematics, F: list[Array]) -> Iterator[Any]:
    """Yield S^T F (n_v,): the joint forces [N or N m] that would keep all joint accelerations at zero.

    The force on a mode has contributions from its own body (equation (8) of `flexible.attachment`) and from the bodies
    that this body carries.
    """
    for i, b in enumerate(tree.bodies):
        for S in K.S[i][: b.v.stop - b.v.start]:
            # joints in the order of their columns, then the modes of the same body
            yield S @ F[i]
        if b.n_modes:
            on = [j for j, child in enumerate(tree.bodies) if child.parent == i]
            for k, own in enumerate(elastic(tree, K, i).forces):
                yield sum((K.carried[j][k] @ F[j] for j in on), own)


def joint_space_inertia(tree: Tree, K: Kinematics, I: list[Array]) -> dict[tuple[int, int], Scalar]:
    """Return the joint-space inertia H[k, l] of a tree, l on the path of k; KernelError for a motion without inertia.

    H[k, l] = S_l^T I^c S_k (composite rigid-body algorithm).
    """
    H: dict[tuple[int, int], Scalar] = {}
    of = tree.body_of_dof
    for k, (i, path) in enumerate(zip(of, tree.dof_paths, strict=True)):
        mode = k - tree.bodies[i].v_modes.start
        if mode >= 0:
            _mode_inertia(tree, K, I, H, k, mode)
            # a mode's inertia couples its own body and what that carries: see `_mode_inertia`
            continue
        f = I[i] @ seen_from(tree, K, k, i)
        for l in (k, *path):
            apart = tree.roots[of[l]] != tree.roots[i]
            H[k, l] = 0.0 if apart else named(f"H({k},{l})", seen_from(tree, K, l, i) @ f)
    for i, j, C in shared_inertia(tree, K):
        for k, S in enumerate(K.S[i], tree.bodies[i].v.start):
            for l, other in enumerate(K.S[j], tree.bodies[j].v.start):
                H[k, l] = named(f"H({k},{l})", S @ C @ other)
    for k in tree.free_dofs:
        # only a number can be tested while tracing; a parameter may still become zero, which a run reports
        if not is_sym(H[k, k]) and H[k, k] == 0.0:
            name = tree.bodies[tree.body_of_dof[k]].name
            raise KernelError(
                f"body '{name}': it can move without inertia; give it, or the bodies that it carries, mass or inertia"
            )
    return H


def _mode_inertia(
    tree: Tree, K: Kinematics, I: list[Array], H: dict[tuple[int, int], Scalar], k: int, mode: int
) -> None:
    """Fill the row of a mode in H: entries from the deformation of its body, and from bodies on this body."""
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
            apart = tree.roots[tree.body_of_dof[l]] != tree.roots[i]
            H[k, l] = 0.0 if apart else named(f"H({k},{l})", seen_from(tree, K, l, i) @ f)


def energies(tree: Tree, K: Kinematics, g: Scalar) -> tuple[Scalar, Scalar]:
    """Return the kinetic and the gravitational energy of a tree [J]."""
    kinetic: Scalar = 0.0
    potential: Scalar = 0.0
    for i, b in enumerate(tree.bodies):
        c = K.r[i] + K.R[i] @ b.com
        v_C = K.V[i][3:] + skew(K.V[i][:3]) @ c
        w = K.R[i].T @ K.V[i][:3]
        # rotational energy in body axes, where the inertia is constant
        kinetic = kinetic + 0.5 * (b.mass * (v_C @ v_C) + w @ (b.inertia @ w))
        potential = potential + b.mass * g * (K.o[2] + c[2])
        if b.added is not None:
            kinetic = kinetic + 0.5 * (K.V[i] @ (added_inertia(b.added.A, K.r[i], K.R[i]) @ K.V[i]))
        if b.elastic is not None:
            own = elastic(tree, K, i)
            kinetic = kinetic + own.kinetic
            # J0[3, 3] is the mass: potential of the frame's origin plus the first moment of mass
            potential = potential + g * (tree.bodies[i].elastic.J0[3, 3] * K.o[2] + own.moment[2])
    for i, j, C in shared_inertia(tree, K):
        kinetic = kinetic + K.V[i] @ (C @ K.V[j])
    return kinetic, potential


def accelerated(tree: Tree, q: Array, v: Array, dv: Array, g: Scalar) -> Kinematics:
    """Return poses, twists and accelerations of a tree's bodies, with gravity as upward acceleration of the ground."""
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
    # the bias A already contains gravity and the centripetal terms: joint accelerations add to it linearly
    K.A = [A + x for A, x in zip(K.A, X, strict=True)]
    return K


def axial_loads(tree: Tree, q: Array, v: Array, dv: Array, W: list[Array], g: Scalar) -> Array:
    """Return the forces on each flexible body, and the motion of its frame, that load the body along its axis.

    The forces (3,) of other bodies on it [N], the acceleration (3,) of its frame less gravity [m/s2], and its angular
    velocity (3,) [rad/s]; arguments as in `inverse_dynamics`.
    """
    K = accelerated(tree, q, v, dv, g)
    _, F = composites(tree, K, W)
    out: list[Array] = []
    for i, b in enumerate(tree.bodies):
        if b.n_modes:
            r, w, A, R = K.r[i], K.V[i][:3], K.A[i], K.R[i]
            # acceleration of the frame's origin: spatial acceleration plus the centripetal terms of its twist
            a = A[3:] + cross(A[:3], r) + cross(w, K.V[i][3:] + cross(w, r))
            out += [-(R.T @ F[j][3:]) for j, child in enumerate(tree.bodies) if child.parent == i]
            out += [R.T @ a, R.T @ w]
    return join(*out)


def inverse_dynamics(tree: Tree, q: Array, v: Array, dv: Array, W: list[Array], g: Scalar) -> tuple[Array, list[Array]]:
    """Return the joint forces tau (n_v,) that cause the accelerations dv of a tree, and the joints' wrenches on bodies.

    W: wrench (6,) applied to each body; the result also has a wrench (6,) per body, [moment; force] in world axes about
    the tree's point [N m, N]. Prescribed joints are treated like all others: tau is then the effort required of their
    drives.
    """
    K = accelerated(tree, q, v, dv, g)
    _, F = composites(tree, K, W)
    return np.array(list(joint_forces(tree, K, F))), F
