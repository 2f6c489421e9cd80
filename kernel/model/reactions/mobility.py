"""Degrees of freedom of a compiled scene: those of its joints less the rank of its constraint Jacobian.

Counting conditions (Gruebler, Kutzbach) fails wherever conditions are redundant: planar linkages in space, those of
Bennett and Sarrus, a door on two hinges. The rank gives the degrees of freedom at one pose; at a singular pose they are
more than those of the motion. So the rank is also evaluated at nearby poses that the conditions allow, reached by
Newton's method in the form of Levenberg and Marquardt with a damping as large as the squared residual, which converges
quadratically although rows are redundant (Yamashita, Fukushima 2001).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from heavylift.kernel.algebra.dense import dot, norm
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.graph import Link

from .jacobian import Pose, RowGroup, pose_of

CLOSED = 1e-9  # scaled residual of a pose whose loops are closed
ITERATIONS = 40
NEAR = 0.03  # scaled length of a motion to a pose near by
KEPT = 0.3  # part of it that must be left once loops are closed again: else only an infinitesimal motion is possible
ENOUGH = 8  # poses near by
NAMED = 4  # of redundant joints or ropes
DIRECTIONS = 3  # poses near by that are tried besides those along each motion


@dataclass(frozen=True)
class Redundant:
    """Joints and rigid ropes with redundant constraints: names, numbers of all constraints and of redundant ones."""

    names: tuple[str, ...]
    conditions: int
    redundant: int


@dataclass(frozen=True)
class Mobility:
    """Number of bodies and degrees of freedom of a scene.

    Of the bodies, `massless` have neither mass nor inertia, `fixed` are rigid and held by fixed joints, `stations` are
    places on flexible bodies; the `modes` of flexible bodies count as `joint_freedoms`. Subtracting the `driven`
    (prescribed by drives), the `locked` and the `rank` of the `conditions` of loops and taut rigid ropes leaves the
    degrees of freedom `at_start`, in that pose; `dof` are those of the motion that starts from it.
    """

    bodies: int
    flexible: int
    massless: int
    fixed: int
    stations: int
    joint_freedoms: int
    modes: int
    driven: int
    locked: int
    conditions: int
    rank: int
    at_start: int
    dof: int
    redundant: tuple[Redundant, ...]
    open: tuple[str, ...]  # joints whose loops do not close near the pose

    @property
    def _kinds(self) -> list[tuple[int, str]]:
        others = self.bodies - self.flexible - self.massless - self.fixed - self.stations
        if others == self.bodies:
            return []
        return [
            (others, "rigid"),
            (self.flexible, "flexible"),
            (self.massless, "without mass between joints"),
            (self.fixed, "fixed to others"),
            (self.stations, f"{_many(self.stations, 'station')} on flexible bodies"),
        ]

    @property
    def lines(self) -> list[str]:
        """The numbers of bodies and degrees of freedom of a scene, and notes on redundant constraints, as sentences."""
        out = []
        if bodies := [f"{n} {what}" for n, what in self._kinds if n]:
            out.append(f"bodies: {', '.join(bodies)}")
        taken = [
            (self.driven, "prescribed by drives"),
            (self.locked, "locked"),
            (
                self.rank,
                f"taken by {self.conditions} {_many(self.conditions, 'condition')} of loops and taut rigid ropes",
            ),
        ]
        if self.modes or any(n for n, _ in taken) or self.conditions:
            joints = f"{self.joint_freedoms - self.modes} of joints"
            own = [joints, *([f"{self.modes} {_many(self.modes, 'mode')} of flexible bodies"] if self.modes else ())]
            out.append(f"degrees of freedom: {', '.join([*own, *(f'less {n} {what}' for n, what in taken if n)])}")
        out += [
            f"{x.redundant} of the {x.conditions} conditions of {_some(x.names)} "
            f"{'is' if x.redundant == 1 else 'are'} redundant: reactions are partly indeterminate"
            for x in self.redundant
        ]
        if self.at_start != self.dof and not self.open:
            free = f"{self.at_start} {_many(self.at_start, 'degree')} of freedom at that instant"
            out.append(f"the start pose is singular: {free}, {self.dof} in motion")
        if self.open:
            out.append(f"{', '.join(self.open)}: loops do not close near the start pose; counted as they stand")
        return out


def _is_station(k: Link, links: tuple[Link, ...]) -> bool:
    """Return whether a link represents a place on a flexible body."""
    return k.parent >= 0 and bool(links[k.parent].modes) and k.body.name.startswith(f"{links[k.parent].body.name}@")


def _some(names: tuple[str, ...]) -> str:
    shown = ", ".join(names[:NAMED])
    return f"{shown} and {len(names) - NAMED} more" if len(names) > NAMED else shown


def _many(n: int, word: str) -> str:
    return word if n == 1 else f"{word}s"


def mobility(program: Program, y: Array | None = None, P: Array | None = None, t: float = 0.0) -> Mobility:
    """Return the numbers of bodies and degrees of freedom of a scene with closed loops, at a state or the start."""
    given = pose_of(program, y, P, t)
    closed = _closed(given)
    pose = closed or given
    links, trees = program.graph.links, [tree for tree, _ in program.instances]
    stations = [k for k in links if _is_station(k, links)]
    rigid = [k for k in links if not k.modes and k not in stations]
    fixed = [k for k in rigid if k.joint.kind == "fixed"]
    moving = [k for k in rigid if k.joint.kind != "fixed"]
    massless = [k for k in moving if not k.body.mass and not any(map(any, k.body.inertia))]
    locked = sum(len(tree.locked_dofs) for tree in trees)
    driven = sum(len(tree.prescribed_dofs) for tree in trees) - locked
    free = program.nv - driven - locked
    groups = pose.groups
    ranks = [g.rank for g in groups]
    here = free - sum(ranks)
    generic = here
    if closed is not None:
        generic = free - sum(_generic(pose, n, g, rank) for n, (g, rank) in enumerate(zip(groups, ranks, strict=True)))
    redundant = tuple(
        Redundant(_names(pose, g), len(g.rows), len(g.rows) - rank)
        for g, rank in zip(groups, ranks, strict=True)
        if rank < len(g.rows)
    )
    gaping = [] if closed is not None else [n for n, g in zip(pose.names, given.gaps, strict=True) if abs(g) > CLOSED]
    return Mobility(
        bodies=len(links),
        flexible=sum(1 for k in links if k.modes),
        massless=len(massless),
        fixed=len(fixed),
        stations=len(stations),
        joint_freedoms=program.nv,
        modes=sum(k.n_modes for k in links),
        driven=driven,
        locked=locked,
        conditions=sum(len(g.rows) for g in groups),
        rank=sum(ranks),
        at_start=here,
        dof=generic,
        redundant=redundant,
        open=tuple(dict.fromkeys(gaping)),
    )


def _names(pose: Pose, g: RowGroup) -> tuple[str, ...]:
    """Return the names of joints and ropes with redundant conditions."""
    return tuple(dict.fromkeys(pose.names[r] for r in g.repeated))


def _residual(pose: Pose, g: RowGroup) -> list[float]:
    gaps = pose.gaps
    return [gaps[r] / by for r, by in zip(g.rows, g.rows_by, strict=True)]


def _closed(pose: Pose) -> Pose | None:
    """Return the nearest pose with closed loops, None if Newton's method finds none."""
    for _ in range(ITERATIONS):
        groups = pose.groups
        residuals = [_residual(pose, g) for g in groups]
        size = max((norm(r) for r in residuals), default=0.0)
        if size <= CLOSED:
            return pose
        nearer = pose.moved([(g, g.towards(r)) for g, r in zip(groups, residuals, strict=True)])
        if not max((norm(_residual(nearer, g)) for g in nearer.groups), default=0.0) < 4.0 * size:
            return None
        pose = nearer
    return None


def _generic(pose: Pose, n: int, g: RowGroup, rank: int) -> int:
    """Return the generic rank of a group of rows: also evaluated at nearby poses if this pose may be singular."""
    if rank == len(g.rows) or rank == len(g.columns):
        return rank  # a regular pose: the rank cannot be less, and near by it cannot be more
    motions = g.motions
    directions = [[s * x for x in m] for m in motions for s in (1.0, -1.0)]
    for k in range(DIRECTIONS if len(motions) > 1 else 0):
        weights = [(-1.0 if (i + 1) * (k + 1) % 3 == 2 else 1.0) / (1 + (i + k) % 3) for i in range(len(motions))]
        mixed = [dot(weights, [m[c] for m in motions]) for c in range(len(g.columns))]
        size = norm(mixed)
        directions.append([x / size for x in mixed])
    found = []
    for direction in directions:
        near = _closed(pose.moved([(g, [NEAR * x for x in direction])]))
        if near is None or _distance(pose, near, g) < KEPT * NEAR:
            continue
        found.append(near.groups[n].rank)
        if found[-1] == rank or len(found) == ENOUGH:
            break  # near by it cannot be less
    return min(found, default=len(g.columns))


def _distance(a: Pose, b: Pose, g: RowGroup) -> float:
    """Return the distance of two poses in the scaled coordinates of a group."""
    squares = []
    by = dict(zip(g.columns, g.columns_by, strict=True))
    for i in sorted({i for i, _ in g.columns}):
        tree = a.tree(i)
        for body in tree.bodies:
            q = slice(tree.q.start + body.q.start, tree.q.start + body.q.stop)
            scale = [by.get((i, k), 1.0) for k in range(body.v.start, body.v.stop)]
            for n, (x, y) in enumerate(zip(a.q[q], b.q[q], strict=True)):
                d = (float(x) - float(y)) / (scale[n] if n < len(scale) else 1.0)
                squares.append(d * d)
    total = 0.0
    for x in squares:
        total += x
    return sqrt(total)
