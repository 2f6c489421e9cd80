"""Factorisation of the Delassus matrix G H^-1 G^T by blocks or by entries, and of trees on which constraint rows act.

Loops and rigid ropes: symmetric, one block per joint or rope. Blocks that share no tree do not couple, and only blocks
that can be non-zero exist, so that a chain of loops costs in proportion to its length. A row of a block is a vector of
the processor.

With contacts: the matrix G H^-1 F is unsymmetric, since the wrenches F that rows exert differ from the directions G
that they sense; it is factorised entry by entry, with the same sparsity. For redundant rows see `complementarity`.

Trees: one kind of tree is factorised once, rows are applied to it, and its accelerations follow. With H = L^T D L, a
row of Jacobian G contributes Y = L^-T G^T: its part of the Delassus matrix is Y D^-1 Y^T, the accelerations are L^-1
D^-1 (L^-T rhs + Y lambda) (Carpentier, Budhiraja, Mansard 2021, eq. 12 ff.). A row that acts on one body touches only
the degrees of freedom between that body and the ground.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.small_blocks import Blocks
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.constraints.complementarity import MU, MU_SHARED, TINY, Proximal, fill_in
from heavylift.kernel.multibody.dynamics import equations_of_motion
from heavylift.kernel.multibody.kinematics import seen_from
from heavylift.kernel.multibody.trees import Tree, with_numbers


class Blockwise(Proximal):
    """Factorisation of a symmetric Delassus matrix that consists of blocks, most of which are structurally zero.

    Traced functions `factorise` (A, size -> C, mu, pivot) and `multipliers` (C, mu, b -> x). `sizes`: rows of each
    block; `couples`: pairs (s, r), s <= r, of blocks that share a degree of freedom; `equal`: groups of rows with the
    same unit, such as rope tensions, which are regularised alike; other rows are regularised by their own diagonals.
    """

    def __init__(
        self, sizes: Sequence[int], couples: Sequence[tuple[int, int]], equal: Sequence[Sequence[int]] = ()
    ) -> None:
        self.sizes, self.equal = sizes, equal
        self.starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int).tolist()
        self.n = self.starts[-1]
        self.couples = [(r, r) for r in range(len(sizes))] + sorted(couples)
        self.after = fill_in(len(sizes), couples)  # blocks right of the diagonal
        self.filled = [(s, r) for s in range(len(sizes)) for r in self.after[s]]
        self.blocks = Blocks()
        n_A = sum(sizes[r] * sizes[s] for r, s in self.couples)
        n_C = sum(sizes[r] * sizes[s] for r, s in self.filled) + sum(m * m for m in sizes)
        self.factorise = Function("factorise_rows", self._factorise, {"A": n_A, "size": self.n})
        self.multipliers = Function("multipliers", self._multipliers, {"C": n_C, "mu": self.n, "b": self.n})
        self._substitute = Function("substitute", self._substituted, {"C": n_C, "b": self.n})

    def rows(self, r: int) -> range:
        """Return the range of matrix rows that block r occupies."""
        return range(self.starts[r], self.starts[r + 1])

    def _cut(self, flat: Array, pairs: Sequence[tuple[int, int]]) -> dict[tuple[int, int], list[Scalar]]:
        """Return the numbers of each block (r, s) of `pairs`, row by row; `flat` holds these blocks in order."""
        out, at = {}, 0
        for r, s in pairs:
            n = self.sizes[r] * self.sizes[s]
            out[r, s] = list(flat[at : at + n])
            at += n
        return out

    def _regularisation(self, diagonal: list[Scalar], size: Array) -> list[Scalar]:
        """Return the regularisation mu (n,) of all rows."""
        floor = sum(size, 0.0) * (MU_SHARED / self.n) + TINY
        mu = [MU * a + floor for a in diagonal]
        for rows in self.equal:
            mean = sum((size[r] for r in rows), 0.0) * (MU / len(rows))
            for r in rows:
                mu[r] = mean + floor
        return mu

    def _factorise(self, A: Array, size: Array) -> Outputs:
        """Factorise A + mu into C (W = D^-1 M right of the diagonal, factors of D); `pivot`: each pivot over its
        diagonal element, near zero for a redundant row."""
        M: dict[tuple[int, int], list[Scalar]] = self._cut(A, self.couples)
        m = self.sizes
        diagonal = [M[r, r][i * (m[r] + 1)] for r in range(len(m)) for i in range(m[r])]
        mu = self._regularisation(diagonal, size)
        for r in range(len(m)):
            for i, row in enumerate(self.rows(r)):
                M[r, r][i * (m[r] + 1)] = diagonal[row] + mu[row]
        W: dict[tuple[int, int], list[Scalar]] = {}
        D: list[list[Scalar]] = []
        pivot: list[Scalar] = []
        for s in range(len(m)):
            x = self.blocks.factor(m[s])(M=M[s, s])
            D.append(list(x.C))
            pivot += [(p - mu[r]) / (diagonal[r] + mu[r]) for p, r in zip(x.pivot, self.rows(s), strict=True)]
            for r in self.after[s]:
                W[s, r] = list(self.blocks.under(m[s], m[r])(C=D[s], U=M[s, r]).W)
            for i, r in enumerate(self.after[s]):
                for t in self.after[s][i:]:
                    old = M.get((r, t), [0.0] * (m[r] * m[t]))
                    M[r, t] = list(self.blocks.less(m[r], m[t], m[s])(M=old, U=M[s, r], W=W[s, t]).M_)
        return {"C": [*(e for sr in self.filled for e in W[sr]), *(e for C in D for e in C)], "mu": mu, "pivot": pivot}

    def _substituted(self, C: Array, b: Array) -> Outputs:
        m = self.sizes
        own = [(s, s) for s in range(len(m))]
        parts: Mapping[tuple[int, int], list[Scalar]] = self._cut(C, [*self.filled, *own])
        x = [list(b[self.starts[s] : self.starts[s + 1]]) for s in range(len(m))]
        for s in range(len(m)):
            for r in self.after[s]:
                x[r] = list(self.blocks.minus_transposed(m[r], m[s])(x=x[r], W=parts[s, r], y=x[s]).x_)
        x = [list(self.blocks.solve(m[s])(C=parts[s, s], b=x[s]).x) for s in range(len(m))]
        for s in reversed(range(len(m))):
            for r in self.after[s]:
                x[s] = list(self.blocks.minus(m[s], m[r])(x=x[s], W=parts[s, r], y=x[r]).x_)
        return {"x": [e for block in x for e in block]}


class Unsymmetric(Proximal):
    """Factorisation of an unsymmetric Delassus matrix, as in friction, where wrenches do not follow from the Jacobian.

    Traced functions `factorise` (A, size, soft -> C, mu, pivot) and `multipliers` (C, mu, b, prior -> x). `couples`:
    pairs (r, s), r > s, of rows that share a degree of freedom; entries stand for (r, s) and (s, r).
    """

    def __init__(self, n: int, couples: Sequence[tuple[int, int]]) -> None:
        self.n = n
        pairs = sorted(couples)
        self.entries = [*((r, r) for r in range(n)), *pairs, *((s, r) for r, s in pairs)]
        self.lower = fill_in(n, [(s, r) for r, s in couples])
        self.filled = [(r, s) for s in range(n) for r in self.lower[s]]
        size = 2 * len(self.filled) + n
        self.factorise = Function("factorise_rows", self._factorise, {"A": len(self.entries), "size": n, "soft": n})
        self.multipliers = Function("multipliers", self._multipliers, {"C": size, "mu": n, "b": n, "prior": n})
        self._substitute = Function("substitute", self._substituted, {"C": size, "b": n})

    def _factorise(self, A: Array, size: Array, soft: Array) -> Outputs:
        """Factorise A + mu into C (L, U above the diagonal, 1/D)."""
        M = {rs: 0.0 for r, s in self.filled for rs in ((r, s), (s, r))} | dict(zip(self.entries, A, strict=True))
        floor = sum(size, 0.0) * (MU_SHARED / self.n) + TINY
        mu = [(MU * a + floor) * k for k, a in zip(soft, size, strict=True)]
        diagonal = [M[r, r] for r in range(self.n)]
        for r in range(self.n):
            M[r, r] = diagonal[r] + mu[r]
        inverse: list[Scalar] = []
        for s in range(self.n):
            inverse.append(1.0 / M[s, s])
            for r in self.lower[s]:
                M[r, s] = M[r, s] * inverse[s]
                for t in self.lower[s]:
                    M[r, t] = M[r, t] - M[r, s] * M[s, t]
        return {
            "C": [*(M[r, s] for r, s in self.filled), *(M[s, r] for r, s in self.filled), *inverse],
            "mu": mu,
            "pivot": [(M[r, r] - mu[r]) / (diagonal[r] + mu[r]) for r in range(self.n)],
        }

    def _substituted(self, C: Array, b: Array) -> Outputs:
        n = len(self.filled)
        L, U = (dict(zip(self.filled, c, strict=True)) for c in (C[:n], C[n : 2 * n]))
        x = list(b)
        for s in range(self.n):
            for r in self.lower[s]:
                x[r] = x[r] - L[r, s] * x[s]
        for s in reversed(range(self.n)):
            y = x[s]
            for r in self.lower[s]:
                y = y - U[r, s] * x[r]
            x[s] = y * C[2 * n + s]
        return {"x": x}


@dataclass(frozen=True)
class OpenTree:
    """Traced functions for trees of one kind with constraint rows: factors of inertia, response to wrenches.

    `factor` returns F (L and D^-1), half (L^-T rhs), dq, given and cross (rows of H for prescribed degrees of freedom),
    and for each body b with rows its columns S{b} and bias acceleration A{b}. `half[b]`: F, S, w -> y, f: for a wrench
    w on body b, L^-T S^T w over `paths[b]` and S^T w over `given[b]`. `back`: F, half, a, given, cross -> dv, reaction.
    """

    factor: Function
    half: dict[int, Function]
    back: Function
    paths: dict[int, list[int]]
    given: dict[int, list[int]]


def open_tree(k: int, tree: Tree, inputs: dict[str, int], ends: tuple[int, ...]) -> OpenTree:
    """Return the traced functions of one kind of kinematic tree, for constraint rows that act on its bodies `ends`.

    `inputs`: sizes of the arguments of its acceleration function."""
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
            y = {i: columns[i] @ w if i in columns else 0.0 for i in paths[b]}
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
    # those of a body that shares water with the root come first
    shared = {b: [] if (c := tree.bodies[tree.roots[b]].beside) is None else _path(tree, c) for b in ends}
    paths = {b: [i for i in [*shared[b], *p] if i in free] for b, p in on_path.items()}
    given = {b: [i for i in p if i in fixed] for b, p in on_path.items()}
    one = max(1, len(fixed))
    sizes = {"F": size, "half": len(free), "a": one, "given": one, "cross_": max(1, len(cross))}
    halves = {b: half(b) for b in ends}
    return OpenTree(Function(f"factor{k}", factor, inputs), halves, Function(f"back{k}", back, sizes), paths, given)


def _path(tree: Tree, body: int) -> list[int]:
    """Return the degrees of freedom between a body and the ground, those nearest to the ground first."""
    path: list[int] = list(range(tree.bodies[body].v.start, tree.bodies[body].v.stop))
    b = tree.bodies[body].parent
    while b >= 0:
        path = [*range(tree.bodies[b].v.start, tree.bodies[b].v_modes.stop), *path]
        b = tree.bodies[b].parent
    return path
