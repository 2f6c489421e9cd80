"""Edges of a scene as a rope of it meets them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import Sheave
from heavylift.kernel.description.points import Vector
from heavylift.nodes.scene.keys.base import unit
from heavylift.nodes.scene.keys.parts.rigging import Edge
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, Source

PLAIN = 1e-3  # sine below which it is not plain on which side of its edge a rope is


def along_edges(
    source: Source,
    path: Path,
    names: Sequence[str],
    edges: Mapping[str, Edge],
    ends: tuple[k.Point, k.Point],
    coms: Mapping[str, Vector],
) -> tuple[Sheave, ...]:
    """The edges that a rope between two ends may lie on, in the order of their names; one end is on their body.

    The rope passes an edge on the side that looks away from what is inside; what is wrong is added to the faults of the
    source.
    """
    found = []
    for i, name in enumerate(names):
        at: Path = (*path, "over edges", i)
        edge = edges.get(name)
        if edge is None:
            source.fault(at, f"there is no edge '{name}'", closest(name, edges))
            continue
        p, long = edge.start, _less(edge.end, edge.start)
        held = next((x.p for x in reversed(ends) if x.body == edge.on), None)
        inside = coms.get(edge.on) if edge.inside is None else edge.inside
        if held is None or inside is None or not any(long):
            source.fault(at, _why(name, edge, held is None, inside is None), on_key=True)
            continue
        axis, out = unit(long), _less(p, inside)
        way = _less(held, p) if ends[1].body == edge.on else _less(p, held)
        sine = _dot(_cross(out, way), axis) / (norm(list(out)) * norm(list(way)) or 1.0)
        if abs(sine) < PLAIN:
            message = f"on which side of the edge '{name}' a rope from {held} passes is not plain: give it 'inside'"
            source.fault(at, message)
            continue
        x, y, z = axis if sine > 0.0 else (-axis[0], -axis[1], -axis[2])
        span = (0.0, norm(list(long))) if sine > 0.0 else (-norm(list(long)), 0.0)
        found.append(Sheave(k.Point(edge.on, p), (x, y, z), edge.radius, edge.friction, edge=name, span=span))
    return tuple(found)


def _why(name: str, edge: Edge, apart: bool, open_: bool) -> str:
    """Why a rope cannot bend over an edge."""
    if apart:
        return f"the edge '{name}' is on '{edge.on}', where the rope has no end: name edges of what it holds"
    if open_:
        return f"'{edge.on}' has no centre of mass: give the edge '{name}' a point 'inside'"
    return f"the edge '{name}' has no length: keep 'from' and 'to' apart"


def _less(p: Vector, q: Vector) -> Vector:
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


def _dot(p: Vector, q: Vector) -> float:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _cross(p: Vector, q: Vector) -> Vector:
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
