"""Edges of a scene as a rope of it meets them; ropes of the rigging that run over something, and how high what holds
them hangs above what they hold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from heavylift.kernel.algebra.dense import cross, dot, norm
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.kernel.description.units import Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.nodes.scene.keys.base import unit
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.kinematics import Poses, place
from heavylift.nodes.scene.keys.parts.rigging import Edge, Equaliser
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, Source

PLAIN = 1e-3  # sine below which it is not plain on which side of its edge a rope is
SPREAD = 1e-6  # [m] less: what holds a frame tells nothing of where it points
HALVINGS = 60


def along_edges(
    source: Source,
    path: Path,
    names: Sequence[str],
    edges: Mapping[str, Edge],
    ends: tuple[k.Point, k.Point],
    coms: Mapping[str, Vector],
    at: Callable[[], Poses],
) -> tuple[Sheave, ...]:
    """Edges that a rope between two ends may touch, sorted by name; `at`: positions of bodies at the start, for edges
    on other bodies.

    The rope passes an edge on the side that looks away from what is inside; what is wrong is added to the faults of the
    source.
    """
    found = []
    for i, name in enumerate(names):
        here: Path = (*path, "over edges", i)
        edge = edges.get(name)
        if edge is None:
            source.fault(here, f"there is no edge '{name}'", closest(name, edges))
            continue
        p, long = edge.start, _less(edge.end, edge.start)
        held, end = _held(ends, edge.on, at)
        inside = coms.get(edge.on) if edge.inside is None else edge.inside
        if held is None or inside is None or not any(long):
            source.fault(here, _why(name, edge, held is None, inside is None), on_key=True)
            continue
        axis, out = unit(long), _less(p, inside)
        distance = _less(held, p) if end else _less(p, held)
        sine = dot(cross(out, distance), axis) / (norm(out) * norm(distance) or 1.0)
        if abs(sine) < PLAIN:
            message = f"on which side of the edge '{name}' a rope from {held} passes is not plain: give it 'inside'"
            source.fault(here, message)
            continue
        x, y, z = axis if sine > 0.0 else (-axis[0], -axis[1], -axis[2])
        span = (0.0, norm(long)) if sine > 0.0 else (-norm(long), 0.0)
        found.append(Sheave(k.Point(edge.on, p), (x, y, z), edge.radius, edge.friction, edge=name, span=span))
    return tuple(found)


def _held(ends: tuple[k.Point, k.Point], body: str, at: Callable[[], Poses]) -> tuple[Vector | None, int]:
    """An end of a rope in the frame of a body, and which: the one on it, else the last known."""
    for i in (1, 0):
        if ends[i].body == body:
            return ends[i].p, i
    known = at()
    for i in (1, 0):
        if ends[i].body in known and body in known:
            d = place(ends[i], known) - known[body][0]
            x, y, z = (dot(column, d.tolist()) for column in known[body][1].T.tolist())
            return (x, y, z), i
    return None, 0


def _why(name: str, edge: Edge, apart: bool, open_: bool) -> str:
    """Why a rope cannot bend over an edge."""
    if apart:
        return f"the edge '{name}' is on '{edge.on}', which is not there yet: name edges of what the rope holds"
    if open_:
        return f"'{edge.on}' has no centre of mass: give the edge '{name}' a point 'inside'"
    return f"the edge '{name}' has no length: keep 'from' and 'to' apart"


def _less(p: Vector, q: Vector) -> Vector:
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


def equalising(
    name: str, given: Equaliser, sheave: k.Point, R: np.ndarray, ends: tuple[k.Point, k.Point], at: kinematics.Poses
) -> Reeving:
    """The rope of an equaliser over its sheave on a body of attitude R."""
    p, q = (kinematics.place(end, at).tolist() for end in ends)
    d = norm([q[0] - p[0], q[1] - p[1]])
    axis = [(p[1] - q[1]) / d, (q[0] - p[0]) / d, 0.0] if d > SPREAD else [0.0, 1.0, 0.0]
    x, y, z = (sum(float(R[j][i]) * axis[j] for j in range(3)) for i in range(3))
    over = Sheave(sheave, (x, y, z), given.radius, given.friction, given.efficiency)
    return Reeving(name, ends[0], (over,), ends[1], given.sling.EA, InputSignal(given.length))


def height_of(
    make: Callable[[float], Reeving], low: float, length: float, slack: float, at: kinematics.Poses, what: str
) -> float:
    """Height z above `low` of a suspended sheave or edge at which the rope has some slack [m]; raises ValueError if it
    cannot run or reach `what`."""

    def long(z: float) -> float:
        try:
            return ReevingLaw().start_length(make(z), lambda body: (at[body][1], at[body][0]))
        except KernelError as error:
            raise ValueError(str(error)) from None

    if long(low) > length - slack:
        raise ValueError(f"{length:g} m of rope with {slack:g} m of slack do not reach {what}")
    high = low + length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if long(middle) > length - slack else (middle, high)
    return low
