"""The traced functions that equal parts of a scene share: profiles, supports, ropes of n lines, trees of one kind.

Each instance calls them with its own numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.constraints.tree_factors import OpenTree, open_tree
from heavylift.kernel.forces import laws
from heavylift.kernel.multibody.dynamics import energies
from heavylift.kernel.multibody.formulations import formulated
from heavylift.kernel.multibody.formulations.repeated_subtrees import limbs_of
from heavylift.kernel.multibody.joint_locking import halt_function
from heavylift.kernel.multibody.kinematics import kinematics
from heavylift.kernel.multibody.trees import Tree, numbers, with_numbers

from .parameters import ROPE_HEAD, ROPE_LINE

__all__ = ["SharedTree", "profile", "rope_function", "support", "tree_functions"]


@dataclass(frozen=True)
class SharedTree:
    """The functions of one kind of tree; `ends`: bodies that laws act on; `opened`: for constraint rows on `held`."""

    ends: tuple[int, ...]
    held: tuple[int, ...]
    place: Function
    accelerate: Function
    pose: Function
    halt: Function
    axial: Function | None
    opened: OpenTree | None


def profile(t: Any, p: Any) -> dict[str, Any]:
    """Value, rate and acceleration of a profile."""
    x, v, a = laws.profile(t[0], t[1], p)
    return {"x": [x], "v": [v], "a": [a]}


def support(clamped: bool, at_rest: bool, p: Any, body: Any) -> dict[str, Any]:
    """A point on a pad."""
    x = laws.support(p, body, clamped, at_rest)
    one = {k: [getattr(x, k)] for k in ("normal", "heat", "stored")}
    return {**one, **{k: getattr(x, k) for k in ("wrench", "guards", "place", "velocity")}}


def rope_function(n: int, clamped: bool, calm: bool = False, heavy: bool = False) -> Function:
    """A rope of n lines; `calm`: without events between taut and slack; `heavy`: with a mass of its own."""
    law = partial(laws.rope, calm=calm, heavy=heavy) if calm or heavy else laws.rope

    def body(L: Any, p: Any, **ends: Any) -> dict[str, Any]:
        bodies = [(ends[f"a{i}"], ends[f"b{i}"]) for i in range(n)]
        x = law(p, L[0], L[1], bodies, clamped)
        out = {f"w{e}{i}": w for i, ab in enumerate(x.wrenches) for e, w in zip("ab", ab, strict=True)}
        names = ("tension", "elongation", "guard", "heat", "work", "stored")
        return {**{k: [getattr(x, k)] for k in names}, **out}

    blocks = {f"{e}{i}": laws.BODY for i in range(n) for e in "ab"}
    name = f"{'calm' if calm else ''}{'heavy' if heavy else ''}rope{n}"
    return Function(name, body, {"L": 2, "p": ROPE_HEAD + ROPE_LINE * n + heavy, **blocks})


def tree_functions(k: int, tree: Tree, ends: tuple[int, ...], held: tuple[int, ...], formulation: str) -> SharedTree:
    """Placement of the bodies that laws act on, accelerations, and poses with energies of one kind of tree."""
    nv, fixed = tree.v.stop - tree.v.start, len(tree.prescribed_dofs)
    dynamics = formulated(formulation)
    limbs = limbs_of(f"limb{k}", tree, ends) if formulation == "recursive" else None
    bends = any(b.n_modes for b in tree.bodies)
    state = {"q": tree.q.stop - tree.q.start, "v": nv, "P": len(numbers(tree))}

    def place(q: Any, v: Any, P: Any) -> dict[str, Any]:
        t = with_numbers(tree, P)
        if limbs:
            return {f"b{i}": x for i, x in sorted(limbs.place(t, q, v, ends, [0.0] * fixed).items())}
        K = kinematics(t, q, v, 0.0, [0.0] * fixed)
        return {f"b{i}": join(K.R[i].ravel(), K.o, K.r[i], K.V[i]) for i in ends}

    def accelerate(q: Any, v: Any, tau: Any, P: Any, g: Any, a: Any, **w: Any) -> dict[str, Any]:
        W = [w.get(f"w{i}", np.zeros(6)) for i in range(len(tree.bodies))]
        text = limbs.dynamics if limbs else dynamics
        dq, dv, reaction = text(with_numbers(tree, P), q, v, tau, W, g[0], list(a)[:fixed])
        return {"dq": dq, "dv": dv, "reaction": reaction}

    def pose(q: Any, v: Any, P: Any, g: Any) -> dict[str, Any]:
        t = with_numbers(tree, P)
        K = kinematics(t, q, v, 0.0, [0.0] * fixed)
        poses = [join(K.o + K.r[i], K.R[i].ravel()) for i in range(len(t.bodies))]
        return {"poses": poses, "energy": list(energies(t, K, g[0]))}

    def axial(q: Any, v: Any, dv: Any, P: Any, g: Any, **w: Any) -> dict[str, Any]:
        from heavylift.kernel.multibody.inverse_dynamics import axial_loads  # whose package needs what this one makes

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
