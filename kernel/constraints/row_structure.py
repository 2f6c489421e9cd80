"""Which constraint rows a scene has, what they hold, and which of them couple: all that is structure.

First those of the joints that close loops, in the order of the list, then one per rigid rope, then those of contacts.
Rows couple where the paths of what they hold, from the ground, share a degree of freedom.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, Protocol

from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.description.mechanics import RigidRope
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.trees import Tree

from .block_matrix import Blockwise
from .loop_closures import CLOSURES, closure_function, residual_unit
from .rigid_ropes import rigid_rope
from .unsymmetric_matrix import Unsymmetric

BLOCK = 6  # rows of a block at most


class ContactRows(Protocol):
    """The rows of contacts, as `contact.contact_points` makes them."""

    @property
    def names(self) -> list[str]: ...
    @property
    def held(self) -> Sequence[tuple[int, ...]]: ...
    @property
    def sites(self) -> Sequence[Any]: ...
    def slots(self, numbers: Callable[[str, str], Array], ends: Mapping[int, Array]) -> list[SimpleNamespace]: ...
    def rows(self, slots: list[SimpleNamespace]) -> list[Any]: ...


class Constraints:
    """The rows of a scene's loops, then those of its rigid ropes and contacts, and the functions that they share."""

    def __init__(self, graph: Graph, ropes: tuple[RigidRope, ...], contacts: ContactRows) -> None:
        self.loops, self.ropes, self.contacts = graph.loops, ropes, contacts
        self.of = [(j, i) for j in self.loops for i in range(len(CLOSURES[j.kind]))]
        self.names = [*(f"joint '{j.name}'" for j, _ in self.of), *(f"rope '{r.name}'" for r in ropes)]
        self.names += [f"contact '{name}'" for name in contacts.names]
        self.units = [*(residual_unit(j.kind, i) for j, i in self.of), *("m" for _ in (*ropes, *contacts.names))]
        ends: list[tuple[str, ...]] = [(j.parent, j.child) for j, _ in self.of]
        ends += [tuple(p.body for line in r.lines for p in (line.a, line.b)) for r in ropes]
        self.held = [*(tuple(graph.number(b) for b in bodies) for bodies in ends), *contacts.held]
        self.bodies = sorted({b for pair in self.held for b in pair if b >= 0})
        self.closures = {kind: closure_function(kind) for kind in sorted({j.kind for j in self.loops})}
        self.pulls = {n: rigid_rope(n) for n in sorted({len(r.lines) for r in ropes})}
        self.linked: list[int] = []
        self.paths: list[dict[tuple[int, int], None]] = []

    def __len__(self) -> int:
        return len(self.held)

    def link(self, instances: Sequence[tuple[Tree, Any]]) -> None:
        """Once the trees are known, with the functions of each: which of them rows touch, and which rows couple."""
        self.instance = {
            tree.first + b: (i, b) for i, (tree, _) in enumerate(instances) for b in range(len(tree.bodies))
        }
        self.linked = sorted({self.instance[b][0] for b in self.bodies})
        self.paths = []
        for pair in self.held:
            path: dict[tuple[int, int], None] = {}
            for i, b in (self.instance[body] for body in pair if body >= 0):
                opened = instances[i][1].opened
                assert opened is not None, "a tree that rows touch is open"
                path |= dict.fromkeys((i, k) for k in opened.paths[b])
            self.paths.append(path)
        n = len(self)
        couples = [(r, s) for r in range(n) for s in range(r) if self.paths[r].keys() & self.paths[s].keys()]
        self.groups = self._groups()
        first = len(self.of)
        ropes = [[r for r in rows if first <= r < first + len(self.ropes)] for rows, _ in self.groups]
        equal = [x for x in ropes if x]
        self.delassus = Unsymmetric(n, couples) if self.contacts.sites else self._blockwise(equal)

    def _blockwise(self, equal: list[list[int]]) -> Blockwise:
        """The matrix in blocks of up to six loop rows in turn between the same bodies, or of one rope."""
        sizes: list[int] = []
        for r, _ in enumerate(self.of):
            if r and self.held[r] == self.held[r - 1] and sizes[-1] < BLOCK:
                sizes[-1] += 1
            else:
                sizes.append(1)
        sizes += [1 for _ in self.ropes]
        paths = [self.paths[sum(sizes[:r])] for r in range(len(sizes))]
        couples = [(s, r) for r in range(len(sizes)) for s in range(r) if paths[r].keys() & paths[s].keys()]
        return Blockwise(sizes, couples, equal)

    def _groups(self) -> list[tuple[list[int], list[int]]]:
        """Rows and trees that hang together."""
        groups: list[tuple[list[int], list[int]]] = []
        for r, path in enumerate(self.paths):
            trees = list(dict.fromkeys(i for i, _ in path))
            touched = [g for g in groups if set(g[1]) & set(trees)]
            merged = (
                [x for g in touched for x in g[0]] + [r],
                list(dict.fromkeys([*(i for g in touched for i in g[1]), *trees])),
            )
            groups = [g for g in groups if g not in touched] + [merged]
        return groups
