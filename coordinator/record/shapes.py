"""How a body looks that nobody has drawn: its contact shapes, its beam, or the box of its mass and inertia; its links.

A point mass is a ball of steel; a slender body gets a thickness.  Thin rods lead from the body's frame to its centre of
mass and to the joints that it carries, so that a mechanism is seen as it is connected.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.kernel.description import contacts as contact
from heavylift.kernel.description.mechanics import WORLD, Body, System, Vector
from heavylift.nodes.plan.plan import Shape
from heavylift.recordings import Box
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BLUE, GREY, DARK = (0.25, 0.45, 0.65, 1.0), (0.62, 0.64, 0.66, 1.0), (0.20, 0.26, 0.32, 1.0)
STEEL = 7850.0  # density of the ball that shows a point mass [kg/m3]
YELLOW = (0.93, 0.68, 0.13, 1.0)  # of bodies that are boxes of their own
SLENDER = 1 / 14  # least edge of a body against its largest
ROD = 1 / 90  # thickness of a link against its length
GLASS = 0.35  # opacity of planes: what they carry is seen from below, too
ANCHOR = 1 / 25  # edge of the block that shows where the world carries a joint, against the longest arm
SLAB = 8.0  # edge of the part of a plane that is drawn, against what touches it


def shapes_of(system: System, drawn: Sequence[Shape] = ()) -> list[Box]:
    """All bodies of a mechanism, and what of the world they can touch; `drawn`: bodies that are boxes of their own."""
    touching: dict[str, list[contact.Shape]] = {}
    for shape in (s for c in system.contacts for s in (c.a, c.b)):
        if shape not in touching.setdefault(shape.body, []):
            touching[shape.body].append(shape)
    edges = [max(s.size) if isinstance(s, contact.Box) else 2 * s.radius for c in system.contacts for s in (c.a,)]
    slab = SLAB * (max(edges, default=1.0) or 1.0)
    out = [box for shape in touching.get(WORLD, []) for box in _contact(shape, GREY, slab)]
    arms = [*(b.com for b in system.bodies), *(j.p_PJ for j in system.joints)]
    edge = ANCHOR * max((float(np.linalg.norm(p)) for p in arms), default=1.0) or 0.1
    free = {shape.body for shape in drawn} | {j.child for j in system.joints if j.kind == "free"}
    anchors = dict.fromkeys(j.p_PJ for j in system.joints if j.parent == WORLD and j.child not in free)
    out += [Box(WORLD, p, (edge, edge, edge), GREY) for p in anchors]
    out += [Box(shape.body, shape.centre, shape.size, YELLOW) for shape in drawn]
    known = {shape.body for shape in drawn}
    for body in (body for body in system.bodies if body.name not in known):
        solid = [box for shape in touching.get(body.name, []) for box in _contact(shape, BLUE, slab)] or list(
            _solid(body)
        )
        ends = [j.p_PJ for j in system.joints if j.parent == body.name]
        ends += [body.com] if body.mass > 0.0 else []
        out += [*solid, *(rod for end in dict.fromkeys(ends) for rod in _rod(body.name, end))]
    return out


def _contact(shape: contact.Shape, colour: tuple[float, float, float, float], slab: float) -> Iterator[Box]:
    match shape:
        case contact.Ball():
            if shape.radius > 0.0:
                yield Box(shape.body, shape.p, (2 * shape.radius,) * 3, colour, kind="ball")
        case contact.Box():
            yield Box(shape.body, shape.p, shape.size, colour, _quaternion(np.array(shape.R)))
        case contact.Plane():
            n = np.array(shape.normal) / np.linalg.norm(shape.normal)
            thick = slab / 400
            x, y, z = np.array(shape.p) - n * thick / 2
            yield Box(shape.body, (float(x), float(y), float(z)), (slab, slab, thick), (*colour[:3], GLASS), _onto(n))


def _solid(body: Body) -> Iterator[Box]:
    """What shows the mass of a body."""
    if body.flexible is not None and body.flexible.beam is not None:
        length = body.flexible.beam.length
        yield Box(body.name, (length / 2, 0.0, 0.0), (length, length * SLENDER / 2, length * SLENDER / 2), BLUE)
    if body.flexible is not None and body.flexible.nodal is not None:
        nodes = np.array(body.flexible.nodal.nodes)
        edge = max(float(np.ptp(nodes, axis=0).max()), 1e-3) * SLENDER
        yield from (Box(body.name, (x, y, z), (edge,) * 3, BLUE) for x, y, z in nodes.tolist())
    if body.mass <= 0.0:
        return
    size, turn = equivalent_box(body)
    if max(size) == 0.0:
        diameter = (6.0 * body.mass / (np.pi * STEEL)) ** (1 / 3)
        yield Box(body.name, body.com, (diameter,) * 3, BLUE, kind="ball")
    else:
        x, y, z = (max(s, SLENDER * max(size)) for s in size)
        yield Box(body.name, body.com, (x, y, z), BLUE, turn)


def equivalent_box(body: Body) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    """Edges and turn of the homogeneous box of a body's mass and inertia; 0 where it has no extent."""
    inertia = np.array(body.inertia)
    if np.allclose(inertia, np.diag(np.diag(inertia)), rtol=0.0, atol=1e-9 * float(np.abs(inertia).max())):
        principal, axes = np.diag(inertia), np.eye(3)
    else:
        principal, axes = np.linalg.eigh(inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
    squares = 6.0 * (principal.sum() - 2.0 * principal) / body.mass
    x, y, z = (float(s) ** 0.5 if s > 1e-6 else 0.0 for s in squares)
    return (x, y, z), _quaternion(axes)


def _rod(body: str, end: Vector) -> Iterator[Box]:
    """A thin cylinder from the origin of a body's frame to a point of it."""
    length = float(np.linalg.norm(end))
    if length > 1e-6:
        x, y, z = (v / 2 for v in end)
        yield Box(
            body, (x, y, z), (ROD * length, ROD * length, length), DARK, _onto(np.array(end) / length), "cylinder"
        )


def _onto(n: Floats) -> tuple[float, float, float, float]:
    """The shortest turn (quaternion) that brings z onto a unit vector."""
    w = 1.0 + n[2]
    q = np.array([-n[1], n[0], 0.0, w]) if w > 1e-9 else np.array([1.0, 0.0, 0.0, 0.0])
    x, y, z, s = (q / np.linalg.norm(q)).tolist()
    return x, y, z, s


def _quaternion(R: Floats) -> tuple[float, float, float, float]:
    """Unit quaternion x y z w of a rotation."""
    ((x, y, z, w),) = quaternions(R[None]).tolist()
    return x, y, z, w
