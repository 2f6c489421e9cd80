"""Shapes for viewers: machines by their collision shapes, rails of travelling cranes, lines of ropes.

A body without shapes is drawn by its contact shapes, its beam, or the box of its mass and inertia; a point mass as a
ball of steel. Thin rods lead from the body's frame to its centre of mass and to the joints that it carries.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

import numpy as np
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.kernel.description.contacts import Ball, Box, Plane, Shape
from heavylift.kernel.description.forces import MooringLine, Spring
from heavylift.kernel.description.mechanics import WORLD, Body, Line, Point, System, Vector, merge
from heavylift.kernel.forces.catenary import line_shape
from heavylift.nodes.devs import Event
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan.plan import Actuator, Plan, Shape as OwnShape
from heavylift.nodes.plan.shapes import Shapes, Solid
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.recordings import DrawnBox, RopeLine
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BLUE, GREY, ROD_COLOUR = (0.25, 0.45, 0.65, 1.0), (0.62, 0.64, 0.66, 1.0), (0.20, 0.26, 0.32, 1.0)
STEEL_DENSITY = 7850.0  # density of the ball that shows a point mass [kg/m3]
YELLOW = (0.93, 0.68, 0.13, 1.0)  # of bodies that are boxes of their own
SLENDER = 1 / 14  # least edge of a body against its largest
ROD = 1 / 90  # thickness of a link against its length
GLASS = 0.35  # opacity of planes: what they carry is seen from below, too
ANCHOR = 1 / 25  # edge of the block that shows where the world carries a joint, against the longest arm
PIECES = 12  # of the curve of a mooring line
SLAB = 8.0  # edge of the part of a plane that is drawn, against what touches it


def shapes_of(system: System, drawn: Sequence[OwnShape] = ()) -> list[DrawnBox]:
    """Return the boxes by which to draw the bodies of a mechanism and its contact shapes fixed in the world.

    `drawn`: shapes that some bodies have already.
    """
    touching: dict[str, list[Shape]] = {}
    for shape in (s for c in system.contacts for s in (c.a, c.b)):
        if shape not in touching.setdefault(shape.body, []):
            touching[shape.body].append(shape)
    edges = [max(s.size) if isinstance(s, Box) else 2 * s.radius for c in system.contacts for s in (c.a,)]
    slab = SLAB * (max(edges, default=1.0) or 1.0)
    out = [box for shape in touching.get(WORLD, []) for box in _contact(shape, GREY, slab)]
    arms = [*(b.com for b in system.bodies), *(j.p_PJ for j in system.joints)]
    edge = ANCHOR * max((float(np.linalg.norm(p)) for p in arms), default=1.0) or 0.1
    free = {shape.body for shape in drawn} | {j.child for j in system.joints if j.kind == "free"}
    anchors = dict.fromkeys(j.p_PJ for j in system.joints if j.parent == WORLD and j.child not in free)
    out += [DrawnBox(WORLD, p, (edge, edge, edge), GREY) for p in anchors]
    out += [DrawnBox(shape.body, shape.centre, shape.size, YELLOW) for shape in drawn]
    known = {shape.body for shape in drawn}
    for body in (body for body in system.bodies if body.name not in known):
        solid = [box for shape in touching.get(body.name, []) for box in _contact(shape, BLUE, slab)] or list(
            _solid(body)
        )
        ends = [j.p_PJ for j in system.joints if j.parent == body.name]
        ends += [body.com] if body.mass > 0.0 else []
        out += [*solid, *(rod for end in dict.fromkeys(ends) for rod in _rod(body.name, end))]
    return out


def _contact(shape: Shape, colour: tuple[float, float, float, float], slab: float) -> Iterator[DrawnBox]:
    match shape:
        case Ball():
            if shape.radius > 0.0:
                yield DrawnBox(shape.body, shape.p, (2 * shape.radius,) * 3, colour, kind="ball")
        case Box():
            yield DrawnBox(shape.body, shape.p, shape.size, colour, _quaternion(np.array(shape.R)))
        case Plane():
            n = np.array(shape.normal) / np.linalg.norm(shape.normal)
            thick = slab / 400
            x, y, z = np.array(shape.p) - n * thick / 2
            yield DrawnBox(
                shape.body, (float(x), float(y), float(z)), (slab, slab, thick), (*colour[:3], GLASS), _onto(n)
            )


def _solid(body: Body) -> Iterator[DrawnBox]:
    """Yield the shapes that represent the mass of a body."""
    if body.flexible is not None and body.flexible.beam is not None:
        length = body.flexible.beam.length
        yield DrawnBox(body.name, (length / 2, 0.0, 0.0), (length, length * SLENDER / 2, length * SLENDER / 2), BLUE)
    if body.flexible is not None and body.flexible.nodal is not None:
        nodes = np.array(body.flexible.nodal.nodes)
        edge = max(float(np.ptp(nodes, axis=0).max()), 1e-3) * SLENDER
        yield from (DrawnBox(body.name, (x, y, z), (edge,) * 3, BLUE) for x, y, z in nodes.tolist())
    if body.mass <= 0.0:
        return
    size, turn = equivalent_box(body)
    if max(size) == 0.0:
        diameter = (6.0 * body.mass / (np.pi * STEEL_DENSITY)) ** (1 / 3)
        yield DrawnBox(body.name, body.com, (diameter,) * 3, BLUE, kind="ball")
    else:
        x, y, z = (max(s, SLENDER * max(size)) for s in size)
        yield DrawnBox(body.name, body.com, (x, y, z), BLUE, turn)


def equivalent_box(body: Body) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    """Return edges [m] and rotation of the homogeneous box with a body's mass and inertia; edges may be 0."""
    inertia = np.array(body.inertia)
    if np.allclose(inertia, np.diag(np.diag(inertia)), rtol=0.0, atol=1e-9 * float(np.abs(inertia).max())):
        principal, axes = np.diag(inertia), np.eye(3)
    else:
        principal, axes = np.linalg.eigh(inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
    squares = 6.0 * (principal.sum() - 2.0 * principal) / body.mass
    x, y, z = (float(s) ** 0.5 if s > 1e-6 else 0.0 for s in squares)
    return (x, y, z), _quaternion(axes)


def _rod(body: str, end: Vector) -> Iterator[DrawnBox]:
    """Yield a thin cylinder from the origin of a body's frame to a point."""
    length = float(np.linalg.norm(end))
    if length > 1e-6:
        x, y, z = (v / 2 for v in end)
        yield DrawnBox(
            body, (x, y, z), (ROD * length, ROD * length, length), ROD_COLOUR, _onto(np.array(end) / length), "cylinder"
        )


def _onto(n: Floats) -> tuple[float, float, float, float]:
    """Return the shortest rotation (quaternion x y z w) that turns z to the unit vector `n`."""
    w = 1.0 + n[2]
    q = np.array([-n[1], n[0], 0.0, w]) if w > 1e-9 else np.array([1.0, 0.0, 0.0, 0.0])
    x, y, z, s = (q / np.linalg.norm(q)).tolist()
    return x, y, z, s


def _quaternion(R: Floats) -> tuple[float, float, float, float]:
    """Return the unit quaternion x y z w of a rotation matrix."""
    ((x, y, z, w),) = quaternions(R[None]).tolist()
    return x, y, z, w


DECK = 1.2  # height of a deck in the picture [m]
OVERHANG, RAIL = 17.0, 1.0  # of rails beyond the middle of a portal at their ends, edge of a rail [m]
DARK = (0.25, 0.09, 0.07, 1.0)
STEEL, CARRIED = (0.93, 0.68, 0.13, 1.0), (0.25, 0.45, 0.65, 1.0)  # what stands or travels; what it carries
COLOURS = {"hanging": (0.13, 0.48, 0.46, 1.0), "block": (0.72, 0.27, 0.20, 1.0)}


def boxes(plan: Plan) -> list[DrawnBox]:
    """Return all boxes to draw for a plan; machines and blocks are drawn as their collision shapes."""
    lifting = (m for m in plan.machines if m.girders or m.cargo or any(not tie.rigging for tie in m.ties))
    out, shapes, own = _rails(plan), Shapes(plan), {machine.name for machine in lifting}
    for solid in (solid for solid in shapes.solids if solid.machine in own):
        if solid.kind != "supports":
            colour = COLOURS.get(solid.kind, STEEL if shapes.depth(solid.body) == 1 else CARRIED)
            out.append(DrawnBox(solid.body, solid.centre, solid.size, colour))
        if solid.kind == "block":
            out.append(_deck(solid))
    return [*out, *(box for m in plan.machines if m.name not in own for box in shapes_of(m.system, m.shapes))]


def surroundings(plan: Plan) -> tuple[tuple[float, float, float], float]:
    """Return centre and radius [m] of the sphere that the 3D view of a plan shows first."""
    if cranes := _on_rails(plan):
        n, r = len(cranes), sum(c.main.com[1] for c in cranes) / len(cranes)
        x, y = sum(c.at[0] + c.gantry.start for c in cranes) / n, r + sum(c.at[1] for c in cranes) / n
        far = max(max(abs(c.at[0] + c.gantry.start - x), abs(c.at[1] + r - y)) for c in cranes)
        return (x, y, 0.6 * r), 1.3 * r + (far if plan.lists else 0.0)
    others = [m for m in plan.machines if not m.cargo]
    arms = [p for m in others for p in (*(b.com for b in m.system.bodies), *(j.p_PJ for j in m.system.joints))]
    reach = sum(hypot(*p) for p in arms) / max(1, len(others))
    return (0.0, 0.0, 0.0), max(reach, 1.0)


@dataclass(frozen=True)
class _DrawnPortal:
    """A crane on two rails along x, as drawn: origin of its coordinates, gantry, main body."""

    at: Vector
    gantry: Actuator
    main: Body


def _on_rails(plan: Plan) -> list[_DrawnPortal]:
    found = []
    for machine in (machine for machine in plan.machines if machine.girders):
        body = {x.name: x for x in machine.system.bodies}[machine.girders[0].body]
        joint = next(joint for joint in machine.system.joints if joint.child == body.name)
        drive = next(drive.name for drive in machine.system.drives if drive.joint == joint.name)
        found.append(_DrawnPortal(joint.p_PJ, next(a for a in machine.actuators if a.name == drive), body))
    return found


def _rails(plan: Plan) -> list[DrawnBox]:
    """Return two rails along x over the travel of the cranes; none without such cranes."""
    if not (cranes := _on_rails(plan)):
        return []
    low = min(c.at[0] + (c.gantry.lower or 0.0) for c in cranes) - OVERHANG
    high = max(c.at[0] + (c.gantry.upper or 0.0) for c in cranes) + OVERHANG
    spans = sorted({c.at[1] + y for c in cranes for y in (2.0 * c.main.com[1], 0.0)})
    return [DrawnBox("world", ((low + high) / 2, y, RAIL / 4), (high - low, RAIL, RAIL / 2), GREY) for y in spans]


def _deck(block: Solid) -> DrawnBox:
    """Return a dark deck on the face of the block that is its upper face at the start."""
    (x, y, z), (a, b, c) = block.centre, block.size
    return DrawnBox(block.body, (x, y, z + c / 2 - 0.48 * DECK), (1.002 * a, 1.002 * b, DECK), DARK)


def _catenary(line: MooringLine, gravity: float, at: kinematics.Poses) -> Iterator[Line]:
    """Yield the pieces of a mooring line's curve, in the pose of its fairlead at the start."""
    start, end = (kinematics.place(p, at) for p in (line.a, line.b))
    x, y, z = ((end - start) / line.length).tolist()
    far = hypot(x, y) or 1.0
    curve = line_shape(hypot(x, y), z, 0.5 * line.mass * gravity * line.length / line.EA, line.seabed, PIECES)[1]
    across = np.array([[line.length * s * x / far, line.length * s * y / far, line.length * h] for s, h in curve])
    points = [line.a, *(Point(WORLD, (u, v, w)) for u, v, w in (start + across)[1:-1].tolist()), line.b]
    yield from (Line(a, b) for a, b in pairwise(points))


class RopeLines:
    """The lines by which ropes are drawn at the present time of a run.

    If `bent`, points on beams refer to stations whose deflection the samples contain. Mooring lines keep the curve of
    the start, up to their last piece, which ends at the fairlead.
    """

    def __init__(self, systems: list[System], bent: bool = True) -> None:
        ropes = [r for s in systems for r in s.all_ropes]
        flexible = ((b.name, b.flexible) for s in systems for b in s.bodies if b.flexible)
        self._beams = {body for body, x in flexible if bent and x.beam and x.frame != "free"}
        self._lines = {r.name: tuple(Line(self._station(x.a), self._station(x.b)) for x in r.lines) for r in ropes}
        self._hooked = {r.name: r.hooked for r in ropes}
        self._over = {r.name: r for s in systems for r in s.reevings if r.edges}
        self._met: dict[str, set[float]] = {name: set() for name in self._over}
        self._lines |= {name: (Line(r.a, r.b),) for name, r in self._over.items()}
        if moored := [(x, s.gravity) for s in systems for x in s.mooring_lines]:
            at = kinematics.poses(merge(systems, moored[0][1]))
            self._lines |= {x.name: tuple(_catenary(x, gravity, at)) for x, gravity in moored}
        springs = [f for s in systems for f in s.forces if isinstance(f, Spring)]
        self._lines |= {f.name: (Line(f.a, f.b),) for f in springs}
        self._hooked |= {f.name: True for f in springs}

    def change(self, event: Event) -> bool:
        """Update the rope lines after an event; return whether the event hooked or unhooked a rope, or moved one over
        an edge."""
        value = event.value
        if isinstance(value, m.StateEvent) and value.name in self._over and value.what in ("found", "left"):
            self._met[value.name] ^= {value.value}
            self._bend(value.name)
            return True
        if isinstance(value, m.StateEvent) and value.what == "parted":
            self._hooked[value.name] = False
            return True
        if event.type not in ("Hook", "Unhook"):
            return False
        if isinstance(value, m.Unhook):
            self._hooked[value.rope] = False
        elif isinstance(value, m.Hook):
            first, *inner, last = [x for line in self._lines[value.rope] for x in (line.a, line.b)]
            ends = Point(first.body, value.a or first.p), *inner, Point(last.body, value.b or last.p)
            self._lines[value.rope] = tuple(Line(p, q) for p, q in zip(ends[::2], ends[1::2], strict=True))
            self._hooked[value.rope] = True
        return True

    def _station(self, point: Point) -> Point:
        """Return a point on a bending beam relative to the station for which the kernel computes the deflection; return
        a point on any other body unchanged."""
        x, y, z = point.p
        return Point(f"{point.body}@{x:.9g}", (0.0, y, z)) if point.body in self._beams else point

    def _bend(self, name: str) -> None:
        """Draw a rope over the edges that it touches, each at the point nearest to the rope's end on the same body."""
        rope, line = self._over[name], self._lines[name]
        a, b, at = line[0].a, line[-1].b, list[Point]()
        for number, s in enumerate(rope.edges, 1):
            if number in self._met[name]:
                end = b if b.body == s.at.body else a
                along = sum((p - q) * n for p, q, n in zip(end.p, s.at.p, s.axis, strict=True))
                along = min(max(along, s.span[0]), s.span[1])
                x, y, z = (p + along * n for p, n in zip(s.at.p, s.axis, strict=True))
                at.append(Point(s.at.body, (x, y, z)))
        self._lines[name] = tuple(Line(p, q) for p, q in pairwise([a, *at, b]))

    def resting(self, ties: Mapping[str, Point | None]) -> list[RopeLine]:
        """Return the lines of all ropes at the start of a run.

        `ties`: for each sling, the lug to which its line is drawn, or None if the sling is not hooked.
        """
        for rope, lug in ties.items():
            self._hooked[rope] = lug is not None
            if lug is not None:
                *upper, last = self._lines[rope]
                self._lines[rope] = (*upper, Line(last.a, lug))
        return self.drawn()

    def drawn(self) -> list[RopeLine]:
        """Return the lines of all hooked ropes."""
        lines = [(name, x) for name, lines in self._lines.items() if self._hooked[name] for x in lines]
        return [RopeLine(name, x.a.body, x.a.p, x.b.body, x.b.p) for name, x in lines]
