"""Augmented formulation: accelerations of all bodies in absolute coordinates and a multiplier for every constraint.

[M J^T; J 0] [x; -lambda] = [f; 0] (Orlandea, Chace, Calahan 1977; Haug 1992): x (6,) per body is its acceleration
beyond the bias of its joints, J holds 6 - n rows for a joint of n free degrees of freedom, orthonormal to its columns
about the child's origin. Solved by the Schur complement J M^-1 J^T in the order from the tips to the ground, without
fill-in (Baraff 1996). A slender or massless body has no M^-1: a small multiple of the inertia that it carries is added,
and iterative refinement removes its effect.

Embedding formulation: the constraint forces vanish by projection on the velocities that the joints allow.

The path matrix T and the joint columns S give the velocity transformation of the whole system, V = R qd with R = T^T S:
row i holds the columns of all joints on the path of body i. Then R^T M R qdd = tau - R^T p, dense (Haug 1992, Shabana
2005: generalised coordinate partitioning with joint coordinates).

Recursive formulation with articulated-body inertias: one pass inwards, one outwards, O(n) for trees of any depth.

Featherstone 2008, section 7.3, in world axes about one point, so that no transformations between bodies are needed. A
joint of several degrees of freedom is eliminated column by column, so only scalars are ever inverted.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.small_blocks import LDLT, frame
from heavylift.kernel.algebra.spatial import join, mirror, skew
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named
from heavylift.kernel.multibody.kinematics import Kinematics, kinematics, newton_euler
from heavylift.kernel.multibody.trees import Tree

REGULAR = 1e-10  # added inertia, relative to mass and moment of what a body carries
PASSES = 2  # of refinement: each takes the error down by REGULAR times the ratio of inertias


@dataclass(frozen=True)
class _Joint:
    """A joint between body and parent; (6,) and (6, n) in world axes about the tree's point.

    S: the columns of all degrees of freedom by number, `free` the numbers of those that are not prescribed.
    Q, R: orthonormal motions about the child's origin with free columns = Q R; B: the wrenches of the constraints.
    """

    S: dict[int, Array]
    free: list[int]
    X: Array
    Q: Array
    R: Array

    @property
    def B(self) -> Array:
        return self.X.T @ self.Q[:, len(self.free) :]

    def applied(self, tau: Array) -> Array:
        """Return the wrench (6,) on a joint's child that exerts the joint forces tau, without constraint forces."""
        y: list[Scalar] = []
        for n, k in enumerate(self.free):
            # R is triangular: forward substitution for the wrench that does the work of tau along each free motion
            y.append((tau[k] - sum((self.R[m][n] * y[m] for m in range(n)), 0.0)) * (1.0 / self.R[n][n]))
        return self.X.T @ sum((e * w for e, w in zip(self.Q.T, y, strict=False)), np.zeros(6))

    def accelerations(self, x: Array) -> dict[int, Array]:
        """Return a joint's free accelerations by number, given the relative acceleration x (6,) of its bodies."""
        a: dict[int, Array] = {}
        for n, k in reversed(list(enumerate(self.free))):
            # back substitution, from the last column of R
            rest = sum((self.R[n][m] * a[self.free[m]] for m in range(n + 1, len(self.free))), 0.0)
            a[k] = (self.Q[:, n] @ (self.X @ x) - rest) * (1.0 / self.R[n][n])
        return a


def augmented(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """Return dq/dt, dv/dt and forces of prescribed joints by the augmented formulation, as `dynamics.dynamics` does."""
    K = kinematics(tree, q, v, g, a_ref)
    M, p = newton_euler(tree, K, W)
    joints = _joints(tree, K)
    parents = [b.parent for b in tree.bodies]
    applied = [j.applied(tau) for j in joints]
    f = _on_bodies(parents, applied)
    x, forces = _solve(M, _regularised(tree, K, M), joints, parents, [a - b for a, b in zip(f, p, strict=True)])
    dv = dict(zip(tree.prescribed_dofs, a_ref, strict=True))
    reaction = {}
    for i, j in enumerate(joints):
        dv |= j.accelerations(_against_parent(parents, x, i))
        for k in set(j.S) - set(j.free):
            reaction[k] = j.S[k] @ (applied[i] + forces[i]) - tau[k]
    return (
        join(*K.dq),
        np.array([dv[k] for k in range(tree.v.stop - tree.v.start)]),
        np.array([reaction[k] for k in tree.prescribed_dofs]),
    )


def _joints(tree: Tree, K: Kinematics) -> list[_Joint]:
    out, k, fixed = [], 0, set(tree.prescribed_dofs)
    for S, r in zip(K.S, K.r, strict=True):
        columns = dict(enumerate(S, k))
        k += len(S)
        free = [n for n in columns if n not in fixed]
        X = np.block([[np.eye(3), np.zeros((3, 3))], [-skew(r), np.eye(3)]])  # from the tree's point to the child's
        out.append(_Joint(columns, free, X, *frame([X @ columns[n] for n in free])))
    return out


def _named(i: int, B: Array) -> Array:
    return np.array([named(f"B({i},{k})", b) for k, b in enumerate(B.T)]).T if B.shape[1] else B


def _on_bodies(parents: list[int], F: list[Array]) -> list[Array]:
    """Return the force (6,) on each body: that of its joint minus those of the joints on it (eqs (1)-(4))."""
    out = list(F)
    # each joint force acts on its child and, reversed, on its parent: Newton's third law
    for i, p in enumerate(parents):
        if p >= 0:
            out[p] = out[p] - F[i]
    return out


def _against_parent(parents: list[int], x: list[Array], i: int) -> Array:
    return x[i] - x[parents[i]] if parents[i] >= 0 else x[i]


def _regularised(tree: Tree, K: Kinematics, M: list[Array]) -> list[LDLT]:
    """Return the factors of M per body, regularised by a part of the carried mass and inertia [kg, kg m2]."""
    carried = list(M)
    for i in reversed(range(len(M))):
        if (p := tree.bodies[i].parent) >= 0:
            carried[p] = carried[p] + carried[i]
    out = []
    for m, c, r in zip(M, carried, K.r, strict=True):
        X = np.block([[np.eye(3), np.zeros((3, 3))], [-skew(r), np.eye(3)]])
        # moments are compared about the body's own origin, or distance from the tree's point would count as inertia
        size = c[3, 3] + sum((X[:3, k] @ c[:3, :3] @ X[:3, k] for k in range(3)), 0.0)
        out.append(LDLT(m + X.T @ X * (REGULAR * size)))
    return out


def _solve(
    M: list[Array], A: list[LDLT], joints: list[_Joint], parents: list[int], f: list[Array]
) -> tuple[list[Array], list[Array]]:
    """Return x (6,) per body and the constraint wrench (6,) of its joint from M x = f + wrenches and B^T (x - x_parent)
    = 0. A: factors of the regularised M."""
    n = len(M)
    B = [_named(i, j.B) for i, j in enumerate(joints)]
    rows, at = {}, 0
    # numbering the rows from the tips avoids fill-in in the elimination (Baraff 1996)
    for i in reversed(range(n)):  # from the tips to the ground: no fill-in
        rows[i] = range(at, at + B[i].shape[1])
        at += B[i].shape[1]
    complement: list[list[Scalar]] = [[0.0] * at for _ in range(at)]
    for i in range(n):  # what body i adds between the joints that meet at it
        meeting = [(i, 1.0)] + [(c, -1.0) for c in range(n) if parents[c] == i]
        for c, sign in meeting:
            for k, b in zip(rows[c], B[c].T, strict=True):
                z = np.array(A[i].solve(b))
                for d, other in meeting:
                    for l, e in zip(rows[d], B[d].T, strict=True):
                        # the lower triangle alone, as the complement is symmetric
                        if l >= k:
                            complement[l][k] = complement[l][k] + sign * other * (e @ z)
    factors = LDLT(complement)
    x: list[Array] = [np.zeros(6)] * n
    F: list[Array] = [np.zeros(6)] * n
    # refinement with the true M removes the effect of the added inertia
    for _ in range(PASSES):
        rest = [b - m @ a + c for b, m, a, c in zip(f, M, x, _on_bodies(parents, F), strict=True)]
        free = [np.array(a.solve(e)) for a, e in zip(A, rest, strict=True)]
        gap = [a + b for a, b in zip(x, free, strict=True)]
        rhs: list[Scalar] = [0.0] * at
        for i in range(n):
            for k, e in zip(rows[i], B[i].T @ _against_parent(parents, gap, i), strict=True):
                rhs[k] = -e
        multipliers = factors.solve(rhs)
        more = [b @ np.array([multipliers[k] for k in rows[i]]) for i, b in enumerate(B)]
        F = [a + b for a, b in zip(F, more, strict=True)]
        answer = [np.array(a.solve(e)) for a, e in zip(A, _on_bodies(parents, more), strict=True)]
        x = [a + b for a, b in zip(gap, answer, strict=True)]
    return x, F


def embedding(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """Return dq/dt, dv/dt and forces of prescribed joints by the embedding formulation, as `dynamics.dynamics` does."""
    K = kinematics(tree, q, v, g, a_ref)
    M, p = newton_euler(tree, K, W)
    R = velocity_transformation(tree, K)
    n = tree.v.stop - tree.v.start
    free, given = tree.free_dofs, tree.prescribed_dofs
    # R^T M R: the projected mass matrix; constraint forces do no work on R and vanish
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
    """Return the velocity transformation R of a tree: for each body, velocity columns (6, n_v).

    The columns of joints and modes outside the body's path are zero.
    """
    R: list[Array] = []
    # a body moves with all joints on its path: copy the parent's columns, then add its own
    k = 0
    for i, (b, columns) in enumerate(zip(tree.bodies, K.S, strict=True)):
        own = [np.zeros(6)] * (tree.v.stop - tree.v.start) if b.parent < 0 else list(R[b.parent].T)
        own[k : k + len(columns)] = columns
        if i in K.carried:
            own[tree.bodies[b.parent].v_modes] = K.carried[i]
        k += len(columns)
        R.append(np.array(own).T if own else np.zeros((6, 0)))
    return R


Eliminated = dict[int, tuple[Array, Scalar, Scalar]]  # degree of freedom -> U, 1/D, acceleration that x = 0 leaves


def articulated(
    tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars = ()
) -> tuple[Array, Array, Array]:
    """Return dq/dt, dv/dt and forces of prescribed joints by articulated-body inertias, as `dynamics.dynamics` does."""
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
    """Eliminate the free degrees of freedom from the tips to the roots (Featherstone 2008, (7.44) to (7.48)).

    I (6, 6) and p (6,) of the bodies become the articulated ones; those of the last root are also returned, for the
    body or ground that carries it.
    """
    given = set(tree.prescribed_dofs)
    U: Eliminated = {}
    inertia, force = np.zeros((6, 6)), np.zeros(6)
    for i in reversed(range(len(tree.bodies))):
        inertia, force = I[i], p[i]
        # degrees of freedom of one joint are eliminated one by one: only scalars are inverted
        for k, s in reversed(list(enumerate(K.S[i], tree.bodies[i].v.start))):
            if k not in given:
                u = named(f"U({k})", inertia @ s)
                d = 1.0 / named(f"D({k})", s @ u)
                rest = (tau[k] - s @ force) * d
                U[k] = u, d, rest
                # (7.47): the articulated inertia loses what the free joint cannot transmit
                inertia = mirror(inertia - np.array([[a * b for b in u] for a in u * d]))
                force = force + u * rest
        if (parent := tree.bodies[i].parent) >= 0:
            I[parent], p[parent] = I[parent] + inertia, p[parent] + force
    return U, (inertia, force)


def outwards(
    tree: Tree, K: Kinematics, U: Eliminated, base: Array, given: dict[int, Scalar]
) -> tuple[dict[int, Scalar], list[Array]]:
    """Return the accelerations of all degrees of freedom and bodies, from the roots to the tips (outward pass).

    Second pass of the articulated-body algorithm: accelerations of bodies less their velocity-dependent part; `base`:
    acceleration (6,) of the ground.
    """
    X: list[Array] = []
    dv = dict(given)
    for i, b in enumerate(tree.bodies):
        x: Any = X[b.parent] if b.parent >= 0 else base
        for k, s in enumerate(K.S[i], b.v.start):
            if k not in given:
                u, d, rest = U[k]
                # acceleration of the joint once that of its parent is known, (7.48)
                dv[k] = rest - (u @ x) * d
                x = x + s * dv[k]
        X.append(x)
    return dv, X
