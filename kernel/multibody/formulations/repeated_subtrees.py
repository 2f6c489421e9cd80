"""Equal branches (limbs) that occur several times on the trunk of one tree, such as trolleys on a block, share their
code.

A limb is one traced function, called for every instance, so that equal limbs run side by side (see `simd_batches`) and
large trees have small code. It gives its articulated inertia and force to the trunk (Featherstone 2008, section 7.3),
whose bodies are then solved as usual; the limbs follow from the acceleration of the body that carries them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function, Outputs, flatten
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars
from heavylift.kernel.multibody.dynamics import Equations, composites, joint_forces, joint_space_inertia, ltdl
from heavylift.kernel.multibody.kinematics import Base, Kinematics, kinematics, newton_euler
from heavylift.kernel.multibody.trees import Tree, TreeBody, all_numbers, in_order, structural, with_numbers

from .augmented import inwards, outwards

FEWEST = 3  # equal limbs that are worth functions of their own
_UPPER = [(i, j) for i in range(6) for j in range(i, 6)]


@dataclass(frozen=True)
class Limb:
    """A branch of a tree: its bodies, root first, and the trunk body `on` that carries it."""

    bodies: tuple[int, ...]
    on: int


@dataclass(frozen=True)
class Kind:
    """Equal branches of a tree, which share traced functions and differ in their parameters.

    place(q, v, P, base): bodies at the `ends`; bend(q, v, tau, P, base, w...): articulated inertia and force on the
    trunk, dq, and intermediate results m; swing(x, m): dv for the acceleration x of the carrying body.
    """

    tree: Tree
    limbs: tuple[Limb, ...]
    ends: tuple[int, ...]
    place: Function
    bend: Function
    swing: Function


class Limbs:
    """A tree divided into a trunk and equal branches; `place` and `dynamics` give the motion of the whole tree."""

    def __init__(self, tree: Tree, kinds: Sequence[Kind]) -> None:
        self._tree, self._kinds = tree, kinds
        gone = {i for kind in kinds for limb in kind.limbs for i in limb.bodies}
        self._trunk = [i for i in range(len(tree.bodies)) if i not in gone]

    def place(self, tree: Tree, q: Array, v: Array, ends: Sequence[int], a_ref: Scalars) -> dict[int, Array]:
        """Return pose and velocity of each body on which laws act, as 21 numbers (see `attachment`).

        `tree` has the numerical values.
        """
        trunk = _part(tree, self._trunk)
        K = kinematics(trunk, _of(tree, "q", self._trunk, q), _of(tree, "v", self._trunk, v), 0.0, a_ref)
        at = {i: n for n, i in enumerate(self._trunk)}
        out = {i: join(K.R[at[i]].ravel(), K.o, K.r[at[i]], K.V[at[i]]) for i in ends if i in at}
        for kind in self._kinds if len(out) < len(ends) else ():
            for limb in kind.limbs:
                x = kind.place(**self._state(kind, limb, tree, q, v), base=_base(K, at[limb.on])[:18])
                for n in kind.ends:
                    e = getattr(x, f"b{n}")
                    out[limb.bodies[n]] = join(e[:9], K.o, e[9:])
        return out

    def dynamics(
        self, tree: Tree, q: Array, v: Array, tau: Array, W: list[Array], g: Scalar, a_ref: Scalars
    ) -> tuple[Array, Array, Array]:
        """Return dq/dt, dv/dt and forces in prescribed joints of the whole tree, as `dynamics.dynamics` does."""
        trunk = _part(tree, self._trunk)
        at = {i: n for n, i in enumerate(self._trunk)}
        K = kinematics(trunk, _of(tree, "q", self._trunk, q), _of(tree, "v", self._trunk, v), g, a_ref)
        w, J = [W[i] for i in self._trunk], [np.zeros((6, 6)) for _ in self._trunk]
        bent = []
        for kind in self._kinds:
            for limb in kind.limbs:
                forces = {f"w{n}": W[limb.bodies[n]] for n in kind.ends}
                state = self._state(kind, limb, tree, q, v)
                own = _of(tree, "v", limb.bodies, tau)
                x = kind.bend(**state, tau=own, base=_base(K, at[limb.on]), **forces)
                bent.append((kind, limb, x))
        for _, limb, x in bent:
            n = at[limb.on]
            w[n] = w[n] - x.force
            J[n] = J[n] + _symmetric(x.inertia)
        I, F = composites(trunk, K, w)
        for n in reversed(range(len(trunk.bodies))):
            I[n] = I[n] + J[n]
            if (p := trunk.bodies[n].parent) >= 0:
                J[p] = J[p] + J[n]
        H = joint_space_inertia(trunk, K, I)
        own = _of(tree, "v", self._trunk, tau)
        rhs = [t - f for t, f in zip(own, joint_forces(trunk, K, F), strict=False)]
        dv, reaction = Equations(trunk, K, H, rhs, ltdl(trunk, dict(H))).solution(a_ref)
        X = _beyond_the_bias(trunk, K, dv)
        dq = _spread(tree, "q", self._trunk, join(*K.dq))
        all_dv = _spread(tree, "v", self._trunk, [*dv.values()])
        for kind, limb, x in bent:
            dq |= _spread(tree, "q", limb.bodies, x.dq)
            all_dv |= _spread(tree, "v", limb.bodies, kind.swing(x=X[at[limb.on]], m=x.m).dv)
        return (np.array([dq[i] for i in range(len(dq))]), np.array([all_dv[i] for i in range(len(all_dv))]), reaction)

    def _state(self, kind: Kind, limb: Limb, tree: Tree, q: Array, v: Array) -> Outputs:
        values = in_order(kind.tree, all_numbers([tree.bodies[i] for i in limb.bodies]))
        return {"q": _of(tree, "q", limb.bodies, q), "v": _of(tree, "v", limb.bodies, v), "P": values}


def _beyond_the_bias(trunk: Tree, K: Kinematics, dv: dict[int, Scalar]) -> list[Array]:
    """Return the accelerations (6,) of the bodies caused by the free degrees of freedom."""
    X: list[Array] = []
    given = set(trunk.prescribed_dofs)
    for i, b in enumerate(trunk.bodies):
        x = X[b.parent] if b.parent >= 0 else np.zeros(6)
        for k, s in enumerate(K.S[i], b.v.start):
            x = x if k in given else x + s * dv[k]
        X.append(x)
    return X


def _base(K: Kinematics, i: int) -> list[Scalar]:
    """Return R, r, V, A of a body in one row."""
    return [*K.R[i].ravel(), *K.r[i], *K.V[i], *K.A[i]]


def _of(tree: Tree, what: str, bodies: Sequence[int], x: Array) -> Any:
    """Return the coordinates (`what` = "q") or velocities ("v") of some bodies in order."""
    return [e for i in bodies for e in list(x[getattr(tree.bodies[i], what)])]


def _spread(tree: Tree, what: str, bodies: Sequence[int], x: Scalars) -> dict[int, Any]:
    """Return the inverse of `_of`: place in the tree -> value."""
    slices = (getattr(tree.bodies[i], what) for i in bodies)
    return dict(zip((k for s in slices for k in range(s.start, s.stop)), x, strict=True))


def _symmetric(upper: Array) -> Any:
    """Return the symmetric (6, 6) matrix of the 21 numbers of its upper triangle."""
    A = np.zeros((6, 6), dtype=object)
    for (i, j), x in zip(_UPPER, upper, strict=True):
        A[i, j] = A[j, i] = x
    return A


def _part(tree: Tree, bodies: Sequence[int]) -> Tree:
    """Return some bodies as a tree of their own."""
    at = {i: n for n, i in enumerate(bodies)}
    out: list[TreeBody] = []
    q = v = 0
    for i in bodies:
        b = tree.bodies[i]
        n_q, n_v = b.q.stop - b.q.start, b.v.stop - b.v.start
        out.append(replace(b, parent=at.get(b.parent, -1), q=slice(q, q + n_q), v=slice(v, v + n_v)))
        q, v = q + n_q, v + n_v
    return Tree(tuple(out), 0, slice(0, q), slice(0, v))


def limbs_of(name: str, tree: Tree, ends: Sequence[int]) -> Limbs | None:
    """Return a rigid tree divided into a trunk and equal branches, or None; `name`: prefix of function names."""
    if any(x is not None for b in tree.bodies for x in (b.elastic, b.place, b.shared)):
        return None
    below = [[i] for i in range(len(tree.bodies))]
    for i in reversed(range(1, len(tree.bodies))):
        below[tree.bodies[i].parent] += below[i]
    groups: dict[str, list[Limb]] = {}
    for i, b in enumerate(tree.bodies):
        bodies = tuple(sorted(below[i]))
        part = _part(tree, bodies)
        if b.parent >= 0 and not part.prescribed_dofs and part.free_dofs and all(map(_resists, part.bodies)):
            key = _unplaced(part).kind + str([n for n, k in enumerate(bodies) if k in ends])
            groups.setdefault(key, []).append(Limb(bodies, b.parent))
    kinds: list[Kind] = []
    taken: set[int] = set()
    for found in sorted((g for g in groups.values() if len(g) >= FEWEST), key=lambda g: -len(g[0].bodies)):
        free = [limb for limb in found if not taken & {*limb.bodies, limb.on}]
        if len(free) >= FEWEST:
            taken |= {i for limb in free for i in limb.bodies}
            kinds.append(_kind(f"{name}.{len(kinds)}", tree, tuple(free), ends))
    return Limbs(tree, kinds) if kinds else None


def _resists(b: TreeBody) -> bool:
    """Return whether a body alone has inertia against every motion; others are checked in the whole tree."""
    return bool(b.mass != 0.0 and (np.diag(b.inertia) != 0.0).all() and b.added is None)


def _unplaced(part: Tree) -> Tree:
    """Return a limb with a standard position on the trunk, so that limbs at different positions compare as equal."""
    return replace(part, bodies=(replace(part.bodies[0], p_PJ=np.full(3, 0.5)), *part.bodies[1:]))


def _common(tree: Tree, limbs: Sequence[Limb]) -> Tree:
    """Return the common tree of limbs: numbers that are equal in all of them stay constants of the code."""
    part = _part(tree, limbs[0].bodies)
    places = np.array([tree.bodies[limb.bodies[0]].p_PJ for limb in limbs])
    p = [x[0] if structural(x[0]) and (x == x[0]).all() else 0.5 for x in places.T]
    return replace(part, bodies=(replace(part.bodies[0], p_PJ=np.array(p)), *part.bodies[1:]))


def _kind(name: str, tree: Tree, limbs: tuple[Limb, ...], ends: Sequence[int]) -> Kind:
    common = _common(tree, limbs)
    own = tuple(n for n, i in enumerate(limbs[0].bodies) if i in ends)
    n_v = common.v.stop
    held = range(n_v - 1)  # columns of degrees of freedom that others follow

    def standing(base: Array, bias: Array) -> Base:
        return np.reshape(base[:9], (3, 3)), base[9:12], base[12:18], bias

    def place(q: Array, v: Array, P: Array, base: Array) -> Outputs:
        K = kinematics(with_numbers(common, P), q, v, 0.0, (), standing(base, np.zeros(6)))
        return {f"b{n}": join(K.R[n].ravel(), K.r[n], K.V[n]) for n in own}

    def bend(q: Array, v: Array, tau: Array, P: Array, base: Array, **w: Array) -> Outputs:
        t = with_numbers(common, P)
        K = kinematics(t, q, v, 0.0, (), standing(base, base[18:24]))
        I, p = newton_euler(t, K, [w.get(f"w{n}", np.zeros(6)) for n in range(len(t.bodies))])
        U, (inertia, force) = inwards(t, K, tau, I, p)
        S = [s for columns in K.S for s in columns]
        memory = [[*U[k][0], U[k][1], U[k][2]] for k in range(n_v)] + [S[k] for k in held]
        upper = [inertia[i, j] for i, j in _UPPER]
        return {"inertia": upper, "force": force, "dq": join(*K.dq), "m": flatten(memory)}

    def swing(x: Array, m: Array) -> Outputs:
        rows = [m[8 * k : 8 * k + 8] for k in range(n_v)]
        S = {k: m[8 * n_v + 6 * k : 8 * n_v + 6 * k + 6] for k in held}
        columns = [[S.get(k, np.zeros(6)) for k in range(b.v.start, b.v.stop)] for b in common.bodies]
        K = Kinematics(o=np.zeros(3), S=columns)
        dv, _ = outwards(common, K, {k: (u[:6], u[6], u[7]) for k, u in enumerate(rows)}, x, {})
        return {"dv": [dv[k] for k in range(n_v)]}

    state = {"q": common.q.stop, "v": n_v, "P": len(common.numbers)}
    wrenches = {f"w{n}": 6 for n in own}
    return Kind(
        common,
        limbs,
        own,
        Function(f"{name}.place", place, {**state, "base": 18}),
        Function(f"{name}.bend", bend, {**state, "tau": n_v, "base": 24, **wrenches}),
        Function(f"{name}.swing", swing, {"x": 6, "m": 8 * n_v + 6 * len(held)}),
    )
