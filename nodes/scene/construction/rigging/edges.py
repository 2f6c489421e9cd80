"""Edges over which ropes bend; ropes over edges or sheaves, and the height at which they suspend something above the
load.

Names of the ropes in rigging entries, and of the lugs of blocks to which they are hooked.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from heavylift.kernel.algebra.dense import cross, dot, norm
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.kernel.description.units import Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.nodes.limits.standards import Terms, at_rest
from heavylift.nodes.scene.keys.base import unit
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.kinematics import Poses, place
from heavylift.nodes.scene.keys.parts.rigging import Edge, Equaliser, Frame, SlingKeys, SlingType
from heavylift.nodes.scene.keys.schema import Scene
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, SourceText

PLAIN = 1e-3  # sine below which it is not plain on which side of its edge a rope is
SPREAD = 1e-6  # [m] less: what holds a frame tells nothing of where it points
HALVINGS = 60


def along_edges(
    source: SourceText,
    path: Path,
    names: Sequence[str],
    edges: Mapping[str, Edge],
    ends: tuple[k.Point, k.Point],
    coms: Mapping[str, Vector],
    at: Callable[[], Poses],
) -> tuple[Sheave, ...]:
    """Return the edges that a rope between two ends may touch, sorted by name.

    `at` returns the poses of bodies at the start, which edges on other bodies need. The rope passes an edge on the side
    away from the point `inside`; errors are added to the scene.
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
    """Return an end of a rope in the frame of a body, and the number (0 or 1) of this end: the end on the body or, if
    there is none, the last end whose position is known."""
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
    """Return the reason why a rope cannot bend over an edge."""
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
    """Return the rope of an equaliser over its sheave.

    The sheave is on a body with the rotation R; `ends`: lower ends of the rope."""
    p, q = (kinematics.place(end, at).tolist() for end in ends)
    d = norm([q[0] - p[0], q[1] - p[1]])
    axis = [(p[1] - q[1]) / d, (q[0] - p[0]) / d, 0.0] if d > SPREAD else [0.0, 1.0, 0.0]
    x, y, z = (sum(float(R[j][i]) * axis[j] for j in range(3)) for i in range(3))
    over = Sheave(sheave, (x, y, z), given.radius, given.friction, given.efficiency)
    return Reeving(name, ends[0], (over,), ends[1], given.sling.EA, InputSignal(given.length))


def height_of(
    make: Callable[[float], Reeving], low: float, length: float, slack: float, at: kinematics.Poses, what: str
) -> float:
    """Return the height z > `low` [m] of a sheave or edge at which its rope has the specified slack [m].

    Raises ValueError if the rope cannot run over the sheave or is too short to reach `what`."""

    def long(z: float) -> float:
        try:
            return ReevingLaw().start_length(make(z), lambda body: (at[body][1], at[body][0]))
        except KernelError as error:
            raise ValueError(str(error)) from None

    if long(low) > length - slack:
        raise ValueError(f"{length:g} m of rope with {slack:g} m of slack do not reach {what}; use a longer rope")
    high = low + length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if long(middle) > length - slack else (middle, high)
    return low


class Sling(NamedTuple):
    """One rope of a rigging entry: number of its sling, lower attachment point, and whether it starts hooked.

    A sling that is hooked to another lug later has one more rope for that lug, such as `legs.sling-1.B-N1`."""

    number: int
    holds: str
    hooked: bool = True


def slings_of(scene: Scene, name: str) -> dict[str, Sling]:
    """Return the ropes of a rigging entry by name; there are none if the entry is a frame."""
    given = scene.rigging[name]
    if isinstance(given, Frame):
        return {}
    names = [f"{name}.sling-{i + 1}" for i in range(len(given.to) if isinstance(given, SlingKeys) else 1)]
    found = {sling: Sling(i, given.to[i]) for i, sling in enumerate(names)}
    for action in scene.actions if isinstance(given, SlingKeys) else ():
        for target, phrase in action.orders.items():
            asked = names if target == name else [target] if target in names else []
            for sling, lug in zip(asked, phrase.lugs, strict=False):
                if lug != found[sling].holds:
                    found[f"{sling}.{lug.replace('.', '-')}"] = Sling(found[sling].number, lug, hooked=False)
    return found


def key_of(lug: str, at: k.Point) -> str:
    """Return the name of a lug in the plan: `N1` if the scene has one block, `B.N1` if it has several."""
    return lug if at.body == "block" or "." in lug else f"{at.body}.{lug}"


def lugs_of(scene: Scene) -> dict[str, k.Point]:
    """Return the lugs of all blocks by name: `N1` if the name is unique, and also `B.N1`."""
    blocks = scene.all_blocks
    named = [lug for block in blocks.values() for lug in block.lugs]
    found = {lug: k.Point(name, p) for name, x in blocks.items() for lug, p in x.lugs.items() if named.count(lug) == 1}
    return found | {f"{name}.{lug}": k.Point(name, p) for name, x in scene.blocks.items() for lug, p in x.lugs.items()}


def terms(given: SlingType, item: str = "") -> Terms:
    """Return the properties of a sling that determine its strength; `item`: description of its gear item, if any."""
    chosen, single = "breaking" in given.model_fields_set, given.legs == "single"
    return Terms(
        given.breaking, given.WLL, item, given.termination, given.diameter, given.pin, given.wear, chosen, single
    )


def rated(given: SlingType, gravity: float) -> float:
    """Return the rated tension of a sling [N], which is 100 % utilisation."""
    own = "factor" in given.model_fields_set
    return given.breaking / (given.factor if own else at_rest(terms(given), gravity).factor)
