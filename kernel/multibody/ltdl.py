"""Sparse factorisation H = L^T D L of the joint-space inertia of one tree, without fill-in along its paths.

Featherstone 2008, sections 6.5 and 8.6.  The paths of `trees` are its sparsity: what is zero is never written down.
"""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.kernel.compiler.symbol import Scalar

from .trees import Tree


@dataclass(frozen=True)
class LtdlFactors:
    """H = L^T D L over the free degrees of freedom of a tree, without fill-in along the paths.

    L[k, i] for i on the path of k (its unit diagonal is not stored), D_inverse[k] = 1/D_k.
    """

    dofs: list[int]
    paths: list[list[int]]
    L: dict[tuple[int, int], Scalar]
    D_inverse: dict[int, Scalar]

    def half(self, b: list[Scalar]) -> list[Scalar]:
        """L^-T b, so that b^T H^-1 c = half(b)^T D^-1 half(c)."""
        y = dict(zip(self.dofs, b, strict=True))
        for k in reversed(self.dofs):
            for i in self.paths[k]:
                y[i] = y[i] - self.L[k, i] * y[k]
        return [y[k] for k in self.dofs]

    def back(self, y: list[Scalar]) -> list[Scalar]:
        """L^-1 D^-1 y: the second half of a solution."""
        x: dict[int, Scalar] = {}
        for k, y_k in zip(self.dofs, y, strict=True):
            t = y_k * self.D_inverse[k]
            for i in self.paths[k]:
                t = t - self.L[k, i] * x[i]
            x[k] = t
        return [x[k] for k in self.dofs]

    def solve(self, b: list[Scalar]) -> list[Scalar]:
        """H^-1 b over the free degrees of freedom."""
        return self.back(self.half(b))


def ltdl(tree: Tree, H: dict[tuple[int, int], Scalar]) -> LtdlFactors:
    """Factorise H in place (Featherstone 2008, sections 6.5 and 8.6)."""
    dofs, paths = tree.free_dofs, tree.free_paths
    D_inverse: dict[int, Scalar] = {}
    for k in reversed(dofs):
        D_inverse[k] = 1.0 / H[k, k]
        for n, i in enumerate(paths[k]):
            a = H[k, i] * D_inverse[k]
            for j in paths[k][n:]:
                H[i, j] = H[i, j] - a * H[k, j]
            H[k, i] = a
    return LtdlFactors(dofs, paths, H, D_inverse)
