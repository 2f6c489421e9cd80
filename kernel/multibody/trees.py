"""One tree of bodies with its numbers; trees of one kind share machine code.

Numbers of a body that are 0, 1 or -1 are structure (they fold away in the traced code); all others are parameters of
the run, so that one object file serves all variations of a scene and all equal trees of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, is_sym
from heavylift.kernel.description.forces import Matrix6
from heavylift.kernel.description.mechanics import JointKind
from heavylift.kernel.errors import KernelError

from .graph import Freedoms, Graph, Link
from .motion import axes_of

_FIELDS = ("mass", "com", "inertia", "p_PJ", "R_PJ", "axes", "pitch", "p_CJ", "R_CJ")
_PARTS = (
    "elastic",
    "place",
    "added",
    "shared",
)  # of numbers of their own, where a body is or stands on a flexible one, or floats


@dataclass(frozen=True)
class AddedMass:
    """Added mass A (6, 6) of a body about its origin, in its axes: twist -> momentum of water [angular; linear]."""

    A: Array


@dataclass(frozen=True)
class TreeBody(Freedoms):
    """A body of a tree, with its joint and its numbers as floats or symbols; parent, q and v are counted within the
    tree.

    `axes`: (1, 3), or (3, 3) if the joint has a second axis; `prescribed`: which of its velocities are given, by a
    drive or, if `locked`, as zero; `elastic`: `flexible.tracks.ReducedBody` of a flexible body; `place`: position of
    its joint on a flexible parent (`flexible.attachment.Place`, or `Track` of a slider).
    """

    name: str
    kind: JointKind
    parent: int
    q: slice
    v: slice
    mass: Scalar
    com: Array
    inertia: Array
    p_PJ: Array
    R_PJ: Array
    axes: Array
    pitch: Scalar
    p_CJ: Array
    R_CJ: Array
    prescribed: tuple[int, ...]
    locked: bool
    elastic: Any = None
    place: Any = None
    added: AddedMass | None = None
    beside: int | None = None  # number of the body with which it shares water
    shared: AddedMass | None = None  # from the twist of that body

    @property
    def n_modes(self) -> int:
        return len(self.elastic.mass) if self.elastic else 0

    @property
    def shifted(self) -> bool:
        """Whether the body's frame differs from that of its joint."""
        p, R = np.ravel(self.p_CJ), np.ravel(self.R_CJ)
        return any(is_sym(x) or x != 0.0 for x in p) or any(is_sym(x) or x != (i % 4 == 0) for i, x in enumerate(R))


@dataclass(frozen=True)
class Tree:
    """A connected set of bodies above the ground with their joints; q and v are its parts of the scene's state."""

    bodies: tuple[TreeBody, ...]
    first: int
    q: slice
    v: slice

    @cached_property
    def kind(self) -> str:
        """Key that is equal for trees which share machine code: joints, numbering and the positions of 0, 1 and -1
        among the numbers."""
        bodies = self.bodies
        return repr([(b.kind, b.parent, b.prescribed, b.locked, b.n_modes, b.beside, _pattern(b)) for b in bodies])

    @cached_property
    def numbers(self) -> list[Any]:
        """The parameters of the tree's bodies and joints, in the order of `with_numbers`."""
        return in_order(self, all_numbers(self.bodies))

    @cached_property
    def places(self) -> list[int]:
        """Positions of the changeable parameters among all numbers that describe a kinematic tree.

        Interleaved for equal bodies, so that vector calls load them at once (see `simd_batches`).
        """
        depths: list[int] = []
        leaders: dict[tuple[int, str, int], int] = {}
        places: list[tuple[int, int, int, int]] = []
        first = 0
        for i, b in enumerate(self.bodies):
            depths.append(depths[b.parent] + 1 if b.parent >= 0 else 0)
            values = all_numbers([b])
            leader = leaders.setdefault((depths[i], b.kind, len(values)), i)
            places += [(leader, k, i, first + k) for k, x in enumerate(values) if not structural(x)]
            first += len(values)
        return [place for *_, place in sorted(places)]

    @property
    def body_of_dof(self) -> list[int]:
        return [i for i, b in enumerate(self.bodies) for _ in range(b.v.start, b.v_modes.stop)]

    @property
    def dof_paths(self) -> list[list[int]]:
        """Sparsity pattern of H: for each degree of freedom, those between it and the ground, nearest first.

        They are followed by those of a body with which the root shares water.
        """
        paths: list[list[int]] = []
        last: list[int | None] = []
        for b in self.bodies:
            up = last[on] if (on := b.parent if b.beside is None else b.beside) >= 0 else None
            for k in range(b.v.start, b.v_modes.stop):
                paths.append([] if up is None else [up, *paths[up]])
                up = k
            last.append(up)
        return paths

    @cached_property
    def roots(self) -> list[int]:
        """For each body of the tree, the body on the ground that carries it."""
        found: list[int] = []
        for i, b in enumerate(self.bodies):
            found.append(i if b.parent < 0 else found[b.parent])
        return found

    @property
    def prescribed_dofs(self) -> list[int]:
        return [b.v.start + i for b in self.bodies for i in b.prescribed]

    @property
    def locked_dofs(self) -> list[int]:
        return [b.v.start + i for b in self.bodies if b.locked for i in b.prescribed]

    @property
    def free_dofs(self) -> list[int]:
        fixed = set(self.prescribed_dofs)
        return [k for k in range(self.v.stop - self.v.start) if k not in fixed]

    @property
    def free_paths(self) -> list[list[int]]:
        fixed = set(self.prescribed_dofs)
        return [[k for k in path if k not in fixed] for path in self.dof_paths]


def cut(graph: Graph, prescribed: set[int], locked: frozenset[str] = frozenset()) -> list[Tree]:
    """Return the trees of a graph with their numbers; `prescribed`: indices in v of the velocities given by drives;
    `locked`: names of locked joints."""
    out = []
    for numbers_ in graph.trees():
        links = [graph.links[i] for i in numbers_]
        q0, v0 = links[0].q.start, links[0].v.start
        bodies = tuple(
            TreeBody(
                name=k.body.name,
                kind=k.joint.kind,
                parent=k.parent - numbers_.start if k.parent >= 0 else -1,
                q=slice(k.q.start - q0, k.q.stop - q0),
                v=slice(k.v.start - v0, k.v.stop - v0),
                mass=float(k.body.mass),
                com=np.array(k.body.com, float),
                inertia=np.array(k.body.inertia, float),
                p_PJ=np.array(k.joint.p_PJ, float) - (place.X if place else 0.0),
                R_PJ=np.array(k.joint.R_PJ, float),
                axes=axes_of(k.joint),
                pitch=float(k.joint.pitch),
                p_CJ=np.array(k.joint.p_CJ, float),
                R_CJ=np.array(k.joint.R_CJ, float),
                prescribed=tuple(
                    i for i, n in enumerate(range(k.v.start, k.v.stop)) if n in prescribed or k.joint.name in locked
                ),
                locked=k.joint.name in locked,
                elastic=_elastic(k),
                place=place,
                added=_added(k.body.added),
                beside=graph.number(k.body.shared.beside) - numbers_.start if k.body.shared else None,
                shared=_added(k.body.shared.added) if k.body.shared else None,
            )
            for k in links
            for place in [_place(graph, k)]
        )
        q, v = slice(q0, links[-1].q_modes.stop), slice(v0, links[-1].v_modes.stop)
        out.append(Tree(bodies, numbers_.start, q, v))
    return out


def _added(given: Matrix6 | None) -> AddedMass | None:
    """Return added mass with angular before linear components."""
    if given is None:
        return None
    A = np.array(given, float)
    return AddedMass(np.block([[A[3:, 3:], A[3:, :3]], [A[:3, 3:], A[:3, :3]]]))


def _elastic(link: Link) -> Any:
    if link.modes is None:
        return None
    from heavylift.kernel.multibody.flexible.tracks import reduced

    return reduced(link.modes)


def _place(graph: Graph, link: Link) -> Any:
    """Return the place of a joint on a flexible parent; raises KernelError for a slider on anything but a beam."""
    joint = link.joint
    on = graph.links[link.parent].modes if link.parent >= 0 else None
    if on is None:
        if joint.kind == "slider":
            raise KernelError(f"joint '{joint.name}': a slider needs a flexible beam; '{joint.parent}' is rigid")
        return None
    if joint.kind == "slider":
        from heavylift.kernel.multibody.flexible.tracks import track

        return track(on, joint.name)
    from heavylift.kernel.multibody.flexible.attachment import Place

    station, X = on.station(joint.p_PJ)
    return Place(X, on.at(station), on.shortening(station))


def _values(body: TreeBody) -> list[Any]:
    """Return all numbers of a body, field by field."""
    parts = [p for name in _PARTS if (p := getattr(body, name)) is not None]
    return [getattr(body, f) for f in _FIELDS] + [getattr(p, f.name) for p in parts for f in fields(p)]


def all_numbers(bodies: Sequence[TreeBody]) -> list[Any]:
    """Return all numbers of bodies and their joints (0, 1 and -1 as well as parameters) in a fixed order."""
    return [x for b in bodies for value in _values(b) for x in np.ravel(value).tolist()]


def in_order(tree: Tree, every: Sequence[Scalar]) -> list[Any]:
    """Return the parameters of a tree in the order of `with_numbers`, selected from all its numbers."""
    return [every[i] for i in tree.places]


def with_numbers(tree: Tree, values: Any) -> Tree:
    """Return a tree with other values for its parameters, which are symbols in traced code."""
    given = iter([x for _, x in sorted(zip(tree.places, values, strict=True), key=lambda pair: pair[0])])

    def replaced(x: Any) -> Any:
        if np.ndim(x) == 0:
            return x if structural(x) else next(given)
        flat = [e if structural(e) else next(given) for e in np.ravel(x).tolist()]
        return np.array([*flat, None], dtype=object)[:-1].reshape(np.shape(x))

    def body(b: TreeBody) -> TreeBody:
        new: dict[str, Any] = {f: replaced(getattr(b, f)) for f in _FIELDS}
        for name in _PARTS:
            if (part := getattr(b, name)) is not None:
                new[name] = replace(part, **{f.name: replaced(getattr(part, f.name)) for f in fields(part)})
        return replace(b, **new)

    return replace(tree, bodies=tuple(map(body, tree.bodies)))


def _pattern(body: TreeBody) -> list[str]:
    """Return the positions of 0, 1 and -1 among the numbers of each field."""
    fields_ = (np.ravel(value).tolist() for value in _values(body))
    return ["".join(f"{x:+.0f}" if structural(x) else "x" for x in field) for field in fields_]


def structural(x: float) -> bool:
    """Return whether a number is 0, 1 or -1 and so belongs to the structure of the code, not to the parameters."""
    return x in (0.0, 1.0, -1.0)
