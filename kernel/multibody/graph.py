"""Graph of a system's bodies and joints (Ku et al. 2012): regular numbering, path matrix T, trees.

T (rows bodies, columns joints) has T_ki = 1 where joint i lies on the path from the ground to body k: the paper's eq.
(5), the unsigned transpose of Wittenburg's (2008), T = (I - P)^-1 for parents before children. The joints whose
constraint forces act on body i with a minus sign are the *set* of first ones to the right of column i over the rows k
with T_ki = 1 (the paper's steps d-h); as a matrix, row i of T^-T.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Body, Joint, System, Vector
from heavylift.kernel.errors import KernelError

from .spanning_tree import spanning_tree

if TYPE_CHECKING:
    from heavylift.kernel.multibody.flexible.modes import FlexibleModes


class Freedoms(ABC):
    """Base class of a body with its coordinates q and velocities v: those of its joint, then those of its modes."""

    q: slice
    v: slice

    @property
    @abstractmethod
    def n_modes(self) -> int:
        """The number of elastic modes of the body; 0 for a rigid body."""

    @property
    def q_modes(self) -> slice:
        return slice(self.q.stop, self.q.stop + self.n_modes)

    @property
    def v_modes(self) -> slice:
        return slice(self.v.stop, self.v.stop + self.n_modes)


@dataclass(frozen=True)
class Link(Freedoms):
    """A numbered body with the joint that carries it; parent: link number, -1 for the ground; q and v are its positions
    in the state."""

    body: Body
    joint: Joint
    parent: int
    q: slice
    v: slice
    modes: "FlexibleModes | None" = None

    @property
    def q0(self) -> tuple[float, ...]:
        """Coordinates of the link at the start: those of the joint, then those of the modes."""
        modes = self.modes.flexible.start or (0.0,) * self.n_modes if self.modes else ()
        return (*(self.joint.q0 or JOINTS[self.joint.kind].rest), *modes)

    @property
    def n_modes(self) -> int:
        return len(self.modes.mass) if self.modes else 0


@dataclass(frozen=True)
class Graph:
    """The numbered spanning tree of a system; each tree's links are consecutive, parents before children."""

    links: tuple[Link, ...]
    T: np.ndarray  # (n_bodies, n_bodies) path matrix
    nq: int
    nv: int
    loops: tuple[Joint, ...] = ()  # joints that close loops

    def number(self, body: str) -> int:
        """Return the link number of a body, -1 for the ground; raises KeyError for an unknown body."""
        return -1 if body == WORLD else self._numbers[body]

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {k.body.name: i for i, k in enumerate(self.links)}

    @cached_property
    def q0(self) -> list[float]:
        """Coordinates (nq,) of all links at the start."""
        return [x for k in self.links for x in k.q0]

    def joint(self, name: str) -> Link:
        """Return the link that a joint carries; raises KernelError for an unknown joint."""
        for link in self.links:
            if link.joint.name == name:
                return link
        raise KernelError(
            f"joint '{name}': there is no such joint; joints are {', '.join(k.joint.name for k in self.links)}"
        )

    def in_frame(self, where: str, body: str, p: Vector) -> Vector:
        """Return a point of a body, in the frame of the body if this is a station (see `flexible.tracks`).

        Raises KernelError if the point belongs to another station, as stations are part of the compiled scene.
        """
        link = self.links[self.number(body)] if body != WORLD else None
        on = self.links[link.parent] if link and link.parent >= 0 else None
        if not link or not on or not on.modes or not body.startswith(f"{on.body.name}@"):
            return p
        x, X = on.modes.station(p)
        if f"{on.body.name}@{x:.9g}" != body:
            at = ", ".join(f"{e:g}" for e in link.joint.p_PJ)
            raise KernelError(
                f"{where}: its end is fixed to the station ({at}) of the flexible body "
                f"'{on.body.name}'; use one rope for each station, and hook the other rope"
            )
        return (p[0] - X[0], p[1] - X[1], p[2] - X[2])

    def above(self, body: str) -> Iterator[Link]:
        """Yield the links of a body and of those between it and the ground, its own first."""
        i = self.number(body)
        while i >= 0:
            yield self.links[i]
            i = self.links[i].parent

    def coordinate(self, law: str, joint: str, name: str = "") -> tuple[int, int]:
        """Return the index of a joint coordinate in q and that of its rate in v.

        The name may be omitted if the joint has only one coordinate. Raises KernelError, naming the law, if nothing can
        act along it.
        """
        link = self.joint(joint)
        kind, has = link.joint.kind, JOINTS[link.joint.kind].actable
        if not has:
            why = "nothing moves in it" if kind == "fixed" else "no velocity of it is the rate of a coordinate"
            raise KernelError(f"'{law}': nothing can act along joint '{joint}', which is {kind}: {why}")
        if not name and len(has) > 1:
            raise KernelError(f"'{law}': name the coordinate of the {kind} joint '{joint}': {' or '.join(has)}")
        if name and name not in has:
            raise KernelError(
                f"'{law}': joint '{joint}' is {kind}; it does not have the coordinate '{name}', only {', '.join(has)}"
            )
        i = has.index(name) if name else 0
        return link.q.start + i, link.v.start + i

    def trees(self) -> list[range]:
        """Return the range of link numbers of each kinematic tree; trees that share added mass count as one tree."""
        roots = [i for i, k in enumerate(self.links) if k.parent < 0 and not k.body.shared] + [len(self.links)]
        return [range(a, b) for a, b in pairwise(roots)]


def build_graph(system: System, modes: "Mapping[str, FlexibleModes] | None" = None) -> Graph:
    """Return the spanning tree of a system, its bodies numbered depth-first from the ground in the given order.

    `modes`: those of flexible bodies. Raises KernelError naming the body or joint for duplicate, missing or unreachable
    bodies.
    """
    bodies = _by_name(system.bodies, "body")
    joints = _by_name(system.joints, "joint")
    for name, joint in joints.items():
        for end in (joint.child, joint.parent):
            if end != WORLD and end not in bodies:
                raise KernelError(f"joint '{name}': there is no body '{end}'")
    carrier, loops = spanning_tree(system, joints)
    order = _depth_first(bodies, carrier)
    if len(order) < len(bodies):
        raise KernelError(_lost(bodies, carrier, {name for name, _ in order}))
    for joint in joints.values():
        _check_start(joint)
    links, nq, nv = [], 0, 0
    for name, parent in order:
        joint = carrier[name]
        kind = JOINTS[joint.kind]
        _check(bodies[name])
        q, v = slice(nq, nq + kind.n_q), slice(nv, nv + kind.n_v)
        links.append(Link(bodies[name], joint, parent, q, v, (modes or {}).get(name)))
        nq, nv = links[-1].q_modes.stop, links[-1].v_modes.stop
    return Graph(tuple(links), path_matrix([p for _, p in order]), nq, nv, loops)


def _depth_first(bodies: Mapping[str, Body], carrier: Mapping[str, Joint]) -> list[tuple[str, int]]:
    """Return the bodies reachable from the ground with the numbers of their parents, without recursion."""
    children: dict[str, list[str]] = {}
    for body in bodies:
        if body in carrier:
            children.setdefault(carrier[body].parent, []).append(body)
    order: list[tuple[str, int]] = []
    waiting = [(body, -1) for body in reversed(_beside(children.get(WORLD, []), bodies))]
    while waiting:
        body, parent = waiting.pop()
        waiting += [(child, len(order)) for child in reversed(children.get(body, []))]
        order.append((body, parent))
    return order


def _beside(roots: list[str], bodies: Mapping[str, Body]) -> list[str]:
    """Return the bodies on the ground, each followed by the one that shares water with it; raises KernelError for
    bodies that other bodies carry."""
    follower = {x.beside: name for name, b in bodies.items() if (x := b.shared)}
    for pair in follower.items():
        if lost := next((b for b in pair if b not in roots or (b == pair[1] and b in follower)), None):
            raise KernelError(f"body '{lost}': only two bodies that no other body carries can share water")
    alone = [b for b in roots if b not in follower.values()]
    return [x for b in alone for x in ([b, follower[b]] if b in follower else [b])]


def _lost(bodies: Mapping[str, Body], carrier: Mapping[str, Joint], found: set[str]) -> str:
    """Describe why an unreachable body, the first one, is not connected to the ground: no joint carries it, or its
    joints form a circle."""
    body = next(b for b in bodies if b not in found)
    above: list[str] = []
    while body in carrier and body not in above:
        above.append(body)
        body = carrier[body].parent
    if body not in above:
        return f"body '{body}': no joint connects it to the ground; add one (kind free if it floats)"
    circle = above[above.index(body) :]
    joints = ", ".join(f"'{carrier[b].name}'" for b in circle)
    return f"body '{body}': the joints that carry it form a loop that is not connected to the ground: {joints}"


def path_matrix(parents: list[int]) -> np.ndarray:
    """Return the path matrix T (n, n): T_ki = 1 where joint i lies on the path from the ground to body k.

    The numbering must be regular: parents[i] < i, -1 is the ground.
    """
    n = len(parents)
    T = np.eye(n, dtype=int)
    for i, p in enumerate(parents):
        if p >= 0:
            T[i] += T[p]
    return T


def children_of(T: np.ndarray, i: int) -> list[int]:
    """Return the child joints of body i from the path matrix T.

    They are the first joints to the right of column i in the rows k with T_ki = 1.
    """
    first = {next((j for j in range(i + 1, len(T)) if T[k, j]), None) for k in range(len(T)) if T[k, i]}
    return sorted(j for j in first if j is not None)


def _by_name(items: tuple, what: str) -> dict:  # type: ignore[type-arg]
    out = {x.name: x for x in items}
    if len(out) < len(items):
        names = [x.name for x in items]
        twice = next(n for n in names if names.count(n) > 1)
        raise KernelError(f"{what} '{twice}': this name is used twice; names must be unique")
    return out


def _check(body: Body) -> None:
    if body.mass < 0.0:
        raise KernelError(f"body '{body.name}': mass {body.mass:g} kg; a mass cannot be negative")


def _check_start(joint: Joint) -> None:
    kind = JOINTS[joint.kind]
    for given, n, what in ((joint.q0, kind.n_q, "coordinates"), (joint.v0, kind.n_v, "velocities")):
        if given and len(given) != n:
            raise KernelError(f"joint '{joint.name}': {len(given)} initial {what}; a {joint.kind} joint has {n}")


def coordinate_names(graph: Graph) -> tuple[list[str], list[str]]:
    """Return the names of all coordinates q and of all velocities v: joint and component, or body and mode."""
    q: list[str] = []
    v: list[str] = []
    for k in graph.links:
        modes = [f"{k.body.name}.mode{i + 1}" for i in range(k.n_modes)]
        q += [*(f"{k.joint.name}.{c}" for c in JOINTS[k.joint.kind].coordinates), *modes]
        v += [*(f"{k.joint.name}.{c}" for c in JOINTS[k.joint.kind].velocities), *modes]
    return q, v
