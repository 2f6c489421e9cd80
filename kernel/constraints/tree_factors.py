"""One kind of tree, opened up for constraint rows: factorise once, apply rows to it, finish.

With H = L^T D L, a row of Jacobian G contributes Y = L^-T G^T: its part of the Delassus matrix is Y D^-1 Y^T, the
accelerations are L^-1 D^-1 (L^-T rhs + Y lambda) (Carpentier, Budhiraja, Mansard 2021, eq. 12 ff.).  A row that acts
on one body touches only the degrees of freedom between that body and the ground.
"""

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.multibody.dynamics import equations_of_motion
from heavylift.kernel.multibody.kinematics import seen_from
from heavylift.kernel.multibody.trees import Tree, with_numbers


@dataclass(frozen=True)
class OpenTree:
    """`factor` -> F (L, D^-1), half (L^-T rhs), dq, given and cross (rows of prescribed dofs), and per end b its
    columns S{b} and bias acceleration A{b}.

    `half[b]`: F, S, w -> y, f: of a wrench on body b, L^-T S^T w over `paths[b]` and S^T w over `given[b]`.
    `back`: F, half, a, given, cross -> dv, reaction.
    """

    factor: Function
    half: dict[int, Function]
    back: Function
    paths: dict[int, list[int]]
    given: dict[int, list[int]]


def open_tree(k: int, tree: Tree, inputs: dict[str, int], ends: tuple[int, ...]) -> OpenTree:
    """The functions of the k-th kind of tree; `inputs`: sizes of what its accelerations depend on."""
    n, free, fixed = tree.v.stop - tree.v.start, tree.free_dofs, tree.prescribed_dofs
    below = [(i, j) for i, path in enumerate(tree.free_paths) if i in free for j in path]
    cross = [(i, j) for i in fixed for j in free if i in tree.dof_paths[j] or j in tree.dof_paths[i]]
    size = len(below) + len(free)

    def unpack(F: Array) -> tuple[dict[tuple[int, int], Scalar], dict[int, Scalar]]:
        return dict(zip(below, F[: len(below)], strict=True)), dict(zip(free, F[len(below) :], strict=True))

    def factor(q: Array, v: Array, tau: Array, P: Array, g: Array, a: Array, **w: Array) -> Outputs:
        W = [w.get(f"w{i}", np.zeros(6)) for i in range(len(tree.bodies))]
        x = equations_of_motion(with_numbers(tree, P), q, v, tau, W, g[0], list(a)[: len(fixed)])
        falling = join(np.zeros(5), [g[0]])
        return {
            "F": [*(x.factors.L[ij] for ij in below), *(x.factors.D_inverse[i] for i in free)],
            **{f"S{b}": [seen_from(tree, x.K, i, b) for i in on_path[b]] for b in ends},
            "half": x.factors.half([x.rhs[i] for i in free]),
            "dq": join(*x.K.dq),
            "given": [x.rhs[i] for i in fixed],
            "cross": [x.H[max(ij), min(ij)] for ij in cross],
            **{f"A{b}": x.K.A[b] - falling for b in ends},
        }

    def half(b: int) -> Function:
        def body(F: Array, S: Array, w: Array) -> Outputs:
            L, _ = unpack(F)
            columns = dict(zip(on_path[b], np.reshape(S, (len(on_path[b]), 6)), strict=True))
            y = {i: columns[i] @ w for i in paths[b]}
            for i in reversed(paths[b]):
                for j in paths[b]:
                    if (i, j) in L:
                        y[j] = y[j] - L[i, j] * y[i]
            return {"y": [y[i] for i in paths[b]], "f": [columns[i] @ w for i in given[b]]}

        return Function(f"half{k}_{b}", body, {"F": size, "S": 6 * len(on_path[b]), "w": 6})

    def back(F: Array, half: Array, a: Array, given: Array, cross_: Array) -> Outputs:
        L, D_inverse = unpack(F)
        x: dict[int, Scalar] = dict(zip(fixed, a, strict=False))
        for i, y in zip(free, half, strict=True):
            x[i] = y * D_inverse[i] - sum((L[i, j] * x[j] for j in tree.free_paths[i]), 0.0)
        pull = {i: -f for i, f in zip(fixed, given, strict=False)}
        for (i, j), h in zip(cross, cross_, strict=False):
            pull[i] = pull[i] + h * x[j]
        return {"dv": [x[i] for i in range(n)], "reaction": [pull[i] for i in fixed]}

    on_path = {b: _path(tree, b) for b in ends}
    paths = {b: [i for i in p if i in free] for b, p in on_path.items()}
    given = {b: [i for i in p if i in fixed] for b, p in on_path.items()}
    one = max(1, len(fixed))
    sizes = {"F": size, "half": len(free), "a": one, "given": one, "cross_": max(1, len(cross))}
    halves = {b: half(b) for b in ends}
    return OpenTree(Function(f"factor{k}", factor, inputs), halves, Function(f"back{k}", back, sizes), paths, given)


def _path(tree: Tree, body: int) -> list[int]:
    """Degrees of freedom between a body and the ground, those nearest to the ground first."""
    path: list[int] = list(range(tree.bodies[body].v.start, tree.bodies[body].v.stop))
    b = tree.bodies[body].parent
    while b >= 0:
        path = [*range(tree.bodies[b].v.start, tree.bodies[b].v_modes.stop), *path]
        b = tree.bodies[b].parent
    return path
