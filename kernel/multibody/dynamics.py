"""Recursive equations of motion of one tree: the paper's Fig. 6 (c)-(e), solved with CRBA and LTDL.

World axes about the root body's origin, so that with the path matrix T the recursions are sums along paths: composite
inertias and wrenches as the twists of `kinematics`, H_kl = S_l^T I^c S_k for l on the path of k (Featherstone 2008,
chapters 5 and 6).  Sign of (d) as corrected: f_c,i = f_B,i - f_e,i + sum over children f_c,j.  The text runs on floats
(oracle) and on symbols (machine code).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import join, skew
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, is_sym, named
from heavylift.kernel.errors import KernelError

from .free_bodies import added_inertia, newton_euler
from .kinematics import Kinematics, elastic, kinematics, seen_from
from .ltdl import LtdlFactors, ltdl
from .trees import Tree


@dataclass(frozen=True)
class Equations:
    """H a = rhs of one tree, with the motion that it was made from and the factors of H."""

    tree: Tree
    K: Kinematics
    H: dict[tuple[int, int], Scalar]
    rhs: list[Scalar]
    factors: LtdlFactors

    def accelerations(self, a: list[Scalar], a_ref: Scalars) -> Array:
        """(n_v,) from those of the free degrees of freedom and the given ones."""
        values = dict(zip(self.tree.free_dofs, a, strict=True)) | dict(
            zip(self.tree.prescribed_dofs, a_ref, strict=True)
        )
        return np.array([values[k] for k in range(len(self.rhs))])

    def solution(self, a_ref: Scalars) -> tuple[dict[int, Scalar], Array]:
        """Accelerations by degree of freedom where nothing else acts, and the forces of prescribed joints."""
        a = self.accelerations(self.factors.solve([self.rhs[k] for k in self.tree.free_dofs]), a_ref)
        reaction = [
            -self.rhs[k] + sum((h * a[l] for l, h in self.given(k).items()), 0.0) for k in self.tree.prescribed_dofs
        ]
        return dict(enumerate(a)), np.array(reaction)

    def given(self, k: int) -> dict[int, Scalar]:
        """Row k of H, of a prescribed degree of freedom, over the free ones."""
        free = self.tree.free_dofs
        return {l: self.H[max(k, l), min(k, l)] for l in free if (max(k, l), min(k, l)) in self.H}


def equations_of_motion(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> Equations:
    """Fig. 6 (a)-(e) up to the linear system for the joint accelerations; arguments as for `dynamics`."""
    K = kinematics(tree, q, v, g, a_ref)
    I, F = composites(tree, K, W)
    H = joint_space_inertia(tree, K, I)
    rhs = [t - f for t, f in zip(tau, joint_forces(tree, K, F), strict=False)]  # (e)
    return Equations(tree, K, H, rhs, ltdl(tree, dict(H)))


def dynamics(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """dq/dt, dv/dt and the forces of prescribed joints; W: (6,) wrench on each body about the tree's point.

    tau: (n_v,) joint forces of springs, drives, brakes and stops [N or N m].
    """
    x = equations_of_motion(tree, q, v, tau, W, g, a_ref)
    motion, reaction = x.solution(a_ref)
    return join(*x.K.dq), np.array(list(motion.values())), reaction


def composites(tree: Tree, K: Kinematics, W: list[Array]) -> tuple[list[Array], list[Array]]:
    """Per body, with all that it carries: spatial inertia I^c and the wrench that its joint would have to transmit if
    no degree of freedom accelerated (Fig. 6 (c), (d))."""
    I, F = newton_euler(tree, K, W)
    for i, b in enumerate(tree.bodies):
        if b.elastic is not None:
            own = elastic(tree, K, i)
            I[i], F[i] = I[i] + own.I, F[i] + own.wrench
    for i in reversed(range(len(tree.bodies))):
        p = tree.bodies[i].parent
        if p >= 0:
            I[p], F[p] = I[p] + I[i], F[p] + F[i]
    return I, F


def joint_forces(tree: Tree, K: Kinematics, F: list[Array]) -> Iterator[Any]:
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


def joint_space_inertia(tree: Tree, K: Kinematics, I: list[Array]) -> dict[tuple[int, int], Scalar]:
    """H[k, l] = S_l^T I^c S_k for l on the path of k (CRBA); raises KernelError where nothing resists a motion."""
    H: dict[tuple[int, int], Scalar] = {}
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


def _mode_inertia(
    tree: Tree, K: Kinematics, I: list[Array], H: dict[tuple[int, int], Scalar], k: int, mode: int
) -> None:
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


def energies(tree: Tree, K: Kinematics, g: Scalar) -> tuple[Scalar, Scalar]:
    """Kinetic and gravitational energy of a tree [J]."""
    kinetic: Scalar = 0.0
    potential: Scalar = 0.0
    for i, b in enumerate(tree.bodies):
        c = K.r[i] + K.R[i] @ b.com
        v_C = K.V[i][3:] + skew(K.V[i][:3]) @ c
        w = K.R[i].T @ K.V[i][:3]
        kinetic = kinetic + 0.5 * (b.mass * (v_C @ v_C) + w @ (b.inertia @ w))
        potential = potential + b.mass * g * (K.o[2] + c[2])
        if b.added is not None:
            kinetic = kinetic + 0.5 * (K.V[i] @ (added_inertia(b.added.A, K.r[i], K.R[i]) @ K.V[i]))
        if b.elastic is not None:
            own = elastic(tree, K, i)
            kinetic = kinetic + own.kinetic
            potential = potential + g * (tree.bodies[i].elastic.J0[3, 3] * K.o[2] + own.moment[2])
    return kinetic, potential
