"""Structure of the constraint rows of a scene: its rows, the bodies on which each row acts, and which rows are coupled.

Rows of loop joints come first, in their listed order, then one per rigid rope, then those of contacts. Rows couple
where the paths from the ground to their bodies share a degree of freedom.

A row is a wrench on each body that it connects: the twists V fulfil sum(w . V) = 0, the accelerations sum(w . A) + bias
= 0, and multiplier * w acts on the bodies.

A rigid rope is a length that cannot be exceeded: its row pulls while the rope is taut and is absent while it is slack.
Residual: slack = L0 - sum(share |a - b|), never negative; multiplier: the tension, never negative. Which ropes are taut
is a discrete state; `rope_impacts` changes it at events.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Protocol

from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, select, sqrt
from heavylift.kernel.description.mechanics import Joint, RigidRope
from heavylift.kernel.forces.force_law import BODY, attachment
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.trees import Tree

from .block_matrix import Blockwise, Unsymmetric
from .loop_closures import CLOSURES, closure_function, residual_unit

SLACK = 1e-9  # [m] used up by less, a rope still counts as slack, so that round-off does not pull it taut
TOUCHING = 2e-9  # [m] slack below which a rope may become taut
LINE = 7  # numbers of a line: a(3), b(3), share


class RigidAt:
    """Indices into the parameters of a rigid rope.

    Each straight part has its end points a (3), b (3) and its share of the length.
    """

    HOOKED, TAUT, LINES = range(3)
    A, B = slice(2, 5), slice(5, 8)


def rigid_numbers(rope: RigidRope) -> list[float]:
    """Return the parameters of a rigid rope: whether it is hooked, whether it is taut, and its straight parts."""
    return [float(rope.hooked), 0.0, *(x for line in rope.lines for x in (*line.a.p, *line.b.p, line.share))]


def rigid_rope(n: int) -> Function:
    """Return the traced function for the constraint row of a rigid rope with n straight parts.

    L (L0, L0', L0''), parameters p, bodies -> gap, rate, bias, and wrenches wa, wb (6,) for each part.
    """

    def body(L: Array, p: Array, **ends: Array) -> Outputs:
        gap, rate, bias = L[0], L[1], L[2]
        out: dict[str, Array] = {}
        for i in range(n):
            q = p[RigidAt.LINES + LINE * i : RigidAt.LINES + LINE * (i + 1)]
            A, B = ends[f"a{i}"], ends[f"b{i}"]
            (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(A, q[:3]), attachment(B, q[3:6])
            d, dv = p_b - p_a, v_b - v_a
            l = sqrt(d @ d)
            u = d * (1.0 / l)
            dl = u @ dv
            du = (dv - dl * u) * (1.0 / l)
            gap, rate = gap - q[6] * l, rate - q[6] * dl
            for e, x, v, V, sign in (("a", x_a, v_a, A[15:], 1.0), ("b", x_b, v_b, B[15:], -1.0)):
                s = sign * q[6]
                out[f"w{e}{i}"] = s * join(cross(x, u), u)
                bias = bias + s * (join(cross(v, u) + cross(x, du), du) @ V)
        return {"gap": [gap], "rate": [rate], "bias": [bias], **out}

    blocks = {f"{e}{i}": BODY for i in range(n) for e in "ab"}
    return Function(f"rigid{n}", body, {"L": 3, "p": RigidAt.LINES + LINE * n, **blocks})


BLOCK = 6  # rows of a block at most


class ContactRows(Protocol):
    """Interface of the constraint rows of contacts, implemented in `contact.contact_points`."""

    @property
    def names(self) -> list[str]: ...
    @property
    def held(self) -> Sequence[tuple[int, ...]]: ...
    @property
    def sites(self) -> Sequence[Any]: ...
    def slots(self, numbers: Callable[[str, str], Array], ends: Mapping[int, Array]) -> list[SimpleNamespace]: ...
    def rows(self, slots: list[SimpleNamespace]) -> list[Any]: ...


class Constraints:
    """All constraint rows of a scene (loops, rigid ropes and contacts) with the functions that they share."""

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
        """Determine the trees on which constraint rows act and the rows that couple; create the functions for them."""
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
        """Return the matrix pattern in blocks: up to six consecutive loop rows between the same bodies, or one rope."""
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
        """Return the coupled sets of rows and trees."""
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


Numbers = Callable[[str, str], Array]  # kind, name -> its part of P
Lengths = Mapping[str, tuple[Scalar, Scalar, Scalar]]  # of rigid ropes, with two rates


class CompiledScene(Protocol):
    """Interface of a compiled scene for its constraint rows."""

    @property
    def graph(self) -> Graph: ...
    @property
    def constraints(self) -> Constraints: ...
    @property
    def instances(self) -> Sequence[tuple[Tree, Any]]: ...


@dataclass(frozen=True)
class ConstraintRow:
    """A constraint row at one instant.

    `wrenches`: body numbers, each with the wrench (6,) of a unit multiplier about the reference point of the body's
    tree.
    """

    wrenches: list[tuple[int, Array]]
    gap: Scalar
    rate: Scalar
    bias: Scalar
    on: Scalar = 1.0  # 0: absent, as of a slack rope
    push: list[tuple[int, Array]] | None = None  # what it does where it senses otherwise: sliding friction
    soft: Scalar = 1.0  # factor of its regularisation: of redundant rows, a soft one carries less
    prior: Scalar = 0.0  # force next to which that of a redundant row is


def held_rows(
    scene: CompiledScene, ends: Mapping[int, Array], numbers: Numbers, lengths: Lengths
) -> list[ConstraintRow]:
    """Return the constraint rows of all loop joints, then those of all rigid ropes.

    `ends`: poses and twists of the bodies by number; other arguments as in `ConstraintRows`.
    """
    rows = [row for j in scene.constraints.loops for row in _loop(scene, j, ends, numbers("loop", j.name))]
    ropes = scene.constraints.ropes
    return rows + [_rope(scene, r, ends, numbers("rigid", r.name), lengths[r.name]) for r in ropes]


def _loop(scene: CompiledScene, j: Joint, ends: Mapping[int, Array], p: Array) -> list[ConstraintRow]:
    a, b = (scene.graph.number(x) for x in (j.parent, j.child))
    x = scene.constraints.closures[j.kind](p=p, A=ends[a], B=ends[b])
    return [
        ConstraintRow([(a, -x.wa[6 * i : 6 * i + 6]), (b, x.wb[6 * i : 6 * i + 6])], x.gap[i], x.rate[i], x.bias[i])
        for i in range(len(CLOSURES[j.kind]))
    ]


def _rope(
    scene: CompiledScene, r: RigidRope, ends: Mapping[int, Array], p: Array, L: tuple[Scalar, Scalar, Scalar]
) -> ConstraintRow:
    bodies = [(scene.graph.number(line.a.body), scene.graph.number(line.b.body)) for line in r.lines]
    at = {f"{e}{n}": ends[i] for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)}
    x = scene.constraints.pulls[len(r.lines)](L=list(L), p=p, **at)
    wrenches = [(i, getattr(x, f"w{e}{n}")) for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)]
    on = select(p[RigidAt.HOOKED] > 0.0, p[RigidAt.TAUT], 0.0)
    return ConstraintRow(wrenches, x.gap[0], x.rate[0], x.bias[0], on)
