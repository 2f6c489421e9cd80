"""Traced functions shared by equal parts of a scene: speed profiles, and trees of one kind (for laws see
`forces.table`).

Each instance calls them with its own numbers.
"""

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select
from heavylift.kernel.constraints.block_matrix import OpenTree, open_tree
from heavylift.kernel.multibody.dynamics import energies
from heavylift.kernel.multibody.formulations import formulated
from heavylift.kernel.multibody.formulations.repeated_subtrees import limbs_of
from heavylift.kernel.multibody.joint_locking import halt_function
from heavylift.kernel.multibody.kinematics import kinematics
from heavylift.kernel.multibody.trees import Tree, with_numbers


@dataclass(frozen=True)
class SharedTree:
    """The traced functions that kinematic trees of one kind share.

    `ends`: bodies on which laws act; `opened`: functions for constraint rows on the bodies `held`.
    """

    ends: tuple[int, ...]
    held: tuple[int, ...]
    place: Function
    accelerate: Function
    pose: Function
    halt: Function
    axial: Function | None
    opened: OpenTree | None


_made: dict[tuple[int, str, str], SharedTree] = {}  # by number, formulation and what is equal, the oldest first
MOST = 64


def shared_tree(
    key: str, k: int, tree: Tree, ends: tuple[int, ...], held: tuple[int, ...], formulation: str
) -> SharedTree:
    """Return the traced functions of trees with equal `key`, also of other scenes; the most recent ones are cached."""
    made = k, formulation, key
    found = _made.pop(made, None) or tree_functions(k, tree, ends, held, formulation)
    _made[made] = found
    for old in list(_made)[: max(0, len(_made) - MOST)]:
        _made.pop(old, None)
    return found


def profile(t: Array, p: Array) -> Outputs:
    """Return reference, rate and acceleration of a speed profile; p = (start, x0, v0, a1, d1, cruise, a2, d2), see
    `description.profile`.

    t: the present time, and a time within the present step, which selects the piece where two pieces meet, since the
    acceleration jumps there.
    """
    now, inside = t
    start, x0, v0, a1, d1, cruise, a2, d2 = p

    def ramp(s: Scalar, among: Scalar, d: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        c = minimum(maximum(s, 0.0), d)
        on = select(among > 0.0, select(d > among, 1.0, 0.0), 0.0)
        return c * (maximum(s, 0.0) - 0.5 * c), c, on

    s, among = now - start, inside - start
    x1, c1, b1 = ramp(s, among, d1)
    x2, c2, b2 = ramp(s - d1 - cruise, among - d1 - cruise, d2)
    x = x0 + v0 * maximum(s, 0.0) + a1 * x1 + a2 * x2
    return {"x": [x], "v": [v0 + a1 * c1 + a2 * c2], "a": [a1 * b1 + a2 * b2]}


def tree_functions(k: int, tree: Tree, ends: tuple[int, ...], held: tuple[int, ...], formulation: str) -> SharedTree:
    """Trace the functions of one kind of tree: poses of bodies with laws, accelerations, poses with energies."""
    nv, fixed = tree.v.stop - tree.v.start, len(tree.prescribed_dofs)
    dynamics = formulated(formulation)
    limbs = limbs_of(f"limb{k}", tree, ends) if formulation == "recursive" else None
    bends = any(b.n_modes for b in tree.bodies)
    state = {"q": tree.q.stop - tree.q.start, "v": nv, "P": len(tree.numbers)}

    def place(q: Array, v: Array, P: Array) -> Outputs:
        t = with_numbers(tree, P)
        if limbs:
            return {f"b{i}": x for i, x in sorted(limbs.place(t, q, v, ends, [0.0] * fixed).items())}
        K = kinematics(t, q, v, 0.0, [0.0] * fixed)
        return {f"b{i}": join(K.R[i].ravel(), K.o, K.r[i], K.V[i]) for i in ends}

    def accelerate(q: Array, v: Array, tau: Array, P: Array, g: Array, a: Array, **w: Array) -> Outputs:
        W = [w.get(f"w{i}", np.zeros(6)) for i in range(len(tree.bodies))]
        text = limbs.dynamics if limbs else dynamics
        dq, dv, reaction = text(with_numbers(tree, P), q, v, tau, W, g[0], list(a)[:fixed])
        return {"dq": dq, "dv": dv, "reaction": reaction}

    def pose(q: Array, v: Array, P: Array, g: Array) -> Outputs:
        t = with_numbers(tree, P)
        K = kinematics(t, q, v, 0.0, [0.0] * fixed)
        poses = [join(K.o + K.r[i], K.R[i].ravel()) for i in range(len(t.bodies))]
        return {"poses": poses, "energy": list(energies(t, K, g[0]))}

    def axial(q: Array, v: Array, dv: Array, P: Array, g: Array, **w: Array) -> Outputs:
        from heavylift.kernel.multibody.dynamics import axial_loads

        W = [w.get(f"w{i}", np.zeros(6)) for i in range(len(tree.bodies))]
        return {"loads": axial_loads(with_numbers(tree, P), q, v, dv, W, g[0])}

    wrenches = {f"w{i}": 6 for i in ends}
    forced = {**state, "tau": max(1, nv), "g": 1, "a": max(1, fixed), **wrenches}
    return SharedTree(
        ends,
        held,
        Function(f"place{k}", place, state),
        Function(f"accelerate{k}", accelerate, forced),
        Function(f"pose{k}", pose, {**state, "g": 1}),
        halt_function(k, tree),
        Function(f"axial{k}", axial, {**state, "dv": nv, "g": 1, **wrenches}) if bends else None,
        open_tree(k, tree, forced, held) if held else None,
    )
