"""Nodes of a rope over sheaves or edges: their parameters, and the path of the rope over them, also at the start."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import pi

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.algebra.spatial import cross, exact
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.description.forces import Reeving, Sheave
from heavylift.kernel.forces.force_law import Poses, attachment

from .sheaves import RopePath, RopeSegment, SheavePoint, Unrolled

NODE = 14  # numbers of a node: centre, axis, dividing direction, radius, friction, 1/efficiency, ends of an edge
MOST_WRAP = 1.5 * pi  # a larger one means that the axis points the wrong way
BESIDE = pi / 4.0  # a negative wrap of a sheave that the rope does not touch yet; more means the same as MOST_WRAP
PARALLEL = 0.99  # cosine between the axes of neighbouring sheaves
ALIGNED = 1e-9  # sine between those of edges
ALONG = 0.9  # sine of a fleet angle at which a rope no longer lies in its sheave
MEETS = 1e-2  # part of a radius or length, near which a rope loses its direction in steps that become too small

Demand = Callable[[str, bool, str], None]  # field, whether it is good, what is wrong with it


def all_nodes(f: Reeving) -> list[Sheave]:
    """Return all nodes of a rope as sheaves: its first end, its sheaves, its second end."""
    return [Sheave(f.a), *f.sheaves, Sheave(f.b)]


def leavable(f: Reeving) -> list[int]:
    """Return the indices of the sheaves that the rope can leave."""
    return [i for i, s in enumerate(f.sheaves) if s.radius > 0.0]


def turning(f: Reeving) -> list[bool]:
    """Return, for each node of a rope, whether the rope law needs its wrap angle, due to friction or a radius."""
    return [False, *(s.friction > 0.0 or s.radius > 0.0 for s in f.sheaves), False]


def node_of(s: Sheave, q: Array, body: Array, label: str = "a") -> SheavePoint:
    """Return position and motion of a sheave or rope end, from its parameters q and the motion of its body."""
    x, c, v = attachment(body, q[:3], label)
    R = np.reshape(body[:9], (3, 3))
    needed = s.radius > 0.0 or s.friction > 0.0
    axis, divide = (R @ q[3:6], R @ q[6:9]) if needed else (None, None)
    return SheavePoint(x, c, v, body[15:18], axis, divide, q[9] if s.radius > 0.0 else None)


def way_over(
    f: Reeving, nodes: Sequence[SheavePoint], on: Sequence[Scalar | None], counted: Array | None = None
) -> RopePath | Unrolled:
    """Return the path of a rope over its nodes: over planar sheaves, or along edges."""
    if f.edges:
        return Unrolled(nodes, turning(f), on, counted, f.apart)
    return RopePath(nodes, turning(f), on, counted)


def _there(f: Reeving, poses: Poses) -> tuple[list[list[float]], list[Array], list[SheavePoint]]:
    """Return, in a given pose: numbers of all nodes, their bodies at rest, and the nodes, with arcs not yet divided."""
    given = [[*s.at.p, *s.axis, 1.0, 0.0, 0.0, s.radius, s.friction, 1.0 / s.efficiency, *s.span] for s in all_nodes(f)]
    bodies = [_body(*poses(p.body)) for p in f.points]
    nodes = [node_of(x, exact(q), body) for x, q, body in zip(all_nodes(f), given, bodies, strict=True)]
    return given, bodies, nodes


def placed(f: Reeving, poses: Poses, demand: Demand) -> tuple[list[list[float]], list[bool | None]]:
    """Return the parameters of a rope's sheaves and ends in a given pose, and whether the rope touches each of them.

    None: the rope always touches it. The dividing direction of a sheave halves its wrap arc.
    """
    given, bodies, nodes = _there(f, poses)
    _check_places(f, nodes, demand)
    lies: list[bool | None] = [None, *(True if s.radius > 0.0 else None for s in f.sheaves), None]
    other = pi if f.edges else BESIDE  # a rope may hang far from an edge, and never winds round it
    while True:
        made = way_over(f, nodes, lies).parts
        arcs = {i: _divide(nodes[i], made[i - 1], made[i]) for i, turns in enumerate(turning(f)) if turns}
        off = {2.0 * pi - wrap: i for i, (_, wrap) in arcs.items() if lies[i] and wrap > 2.0 * pi - other}
        if not off:
            break
        lies[off[max(off)]] = False  # the farthest one first
    for i, (here, wrap) in arcs.items():
        message = f"is wrapped by {np.degrees(wrap):.0f} degrees; turn its axis round"
        demand(f"sheave {i}", wrap <= MOST_WRAP or lies[i] is False, message)
        given[i][6:9] = (bodies[i][:9].reshape(3, 3).T @ here).tolist()
    return given, lies


def laid(f: Reeving, poses: Poses, demand: Demand) -> RopePath | Unrolled:
    """Return the path of a rope over its sheaves or edges in a given pose of the bodies."""
    given, lies = placed(f, poses, demand)
    bodies = [_body(*poses(p.body)) for p in f.points]
    nodes = [node_of(x, exact(q), body) for x, q, body in zip(all_nodes(f), given, bodies, strict=True)]
    return way_over(f, nodes, lies)


def lost(f: Reeving, poses: Poses, wraps: Sequence[float]) -> str:
    """Describe where a rope has left its sheave or runs around it the wrong way; "" if neither is the case.

    `wraps`: wrap angle [rad] of each sheave that the rope can leave.
    """
    _, _, nodes = _there(f, poses)
    left = {i + 1 for i, wrap in zip(leavable(f), wraps, strict=True) if wrap == 0.0}
    met = [i for i in range(len(nodes)) if i not in left]
    for i, j in pairwise(met):
        a, b = nodes[i], nodes[j]
        axis, D = b.axis if a.axis is None else a.axis, b.c - a.c
        if axis is None:
            continue
        across = norm((D - (D @ axis) * axis).tolist())
        if across < (1.0 + MEETS) * abs(float((a.radius or 0.0) - (b.radius or 0.0))):
            return f"part {j} comes within its sheave; keep its ends apart"
        if across < MEETS * norm(D.tolist()):
            return f"part {j} runs along the axis of its sheave; turn the axis across the rope"
    return ""


def _check_places(f: Reeving, nodes: list[SheavePoint], demand: Demand) -> None:
    for i, (a, b) in enumerate(pairwise(nodes), 1):
        bias = float((a.radius or 0.0) - (b.radius or 0.0))
        D = b.c - a.c
        if f.edges:
            n = nodes[1].axis
            D = D - (D @ n) * n
        demand(f"part {i}", float(D @ D) > bias * bias, "has no length; keep its ends apart")
        for x in (a, b):
            if x.axis is not None:
                message = "runs along the axis of its sheave; turn the axis across the rope"
                demand(f"part {i}", abs(float(D @ x.axis)) < ALONG * norm(D.tolist()), message)
        if a.radius is not None and b.radius is not None:
            demand(f"part {i}", abs(float(a.axis @ b.axis)) > PARALLEL, "joins sheaves whose axes are not parallel")
            if f.edges:
                sine = norm(cross(a.axis, b.axis).tolist())
                demand(f"part {i}", sine < ALIGNED, "joins edges that are not parallel; name parallel ones only")


def _divide(node: SheavePoint, before: RopeSegment, after: RopeSegment) -> tuple[Array, float]:
    """Return the direction to the middle of an arc, in world axes, and the wrap [rad] at the start."""
    first, last = (cross(x.plane, node.axis) for x in (before, after))
    wrap = float(atan2(float(node.axis @ cross(first, last)), float(first @ last))) % (2.0 * pi)
    half = 0.5 * wrap
    return cos(half) * first + sin(half) * cross(node.axis, first), wrap


def _body(R: Array, p: Array) -> Array:
    """Return a body at rest in the form that laws take, with its tree's point at the world's origin."""
    return exact(np.concatenate([np.ravel(R), np.zeros(3), p, np.zeros(6)]))
