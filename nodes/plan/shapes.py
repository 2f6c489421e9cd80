"""The shapes of a scene for collision checks and drawings, made from the numbers of the plan alone, without a geometry
library.

A `Solid` is a box or a ball fixed on a body; a `Strand` is a straight piece of rope, as thick as a steel rope of its
stiffness. Solids and strands with the same `thing` belong to one object that a planner names, such as the block, a
portal, a hook block or a boom. How two objects may meet follows from the joints, ropes and contacts between their
bodies: they must keep a clearance, may touch without passing through each other, or are joined. `may touch` in a scene
refers to the names of objects.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Literal

from heavylift.kernel.description.contacts import Ball, Box, Contact, Plane
from heavylift.kernel.description.laws import Support
from heavylift.kernel.description.units import IDENTITY, WORLD, Matrix, Vector

from .plan import Mechanism, Plan

Kind = Literal["rope", "sling", "hanging", "block", "mechanism", "machine", "supports"]
Relation = Literal["apart", "through", "joined"]

GROUND, SUPPORTS, HULL = "ground", "supports", "hull"
OTHERS = "heavylift checks that of straight hook ropes and slings; look at it"
SUPPORT = 1.0  # edge of a support [m]
E_STEEL, FILL = 105e9, 0.586  # of a wire rope [Pa], and its metal over the circle around it: 44 mm 6x36, 890.6 mm2


@dataclass(frozen=True)
class Solid:
    """A box with edges `size` along the columns of R, or a ball of diameter size[0].

    `centre` in the frame of its body [m]; `machine`: name of the machine that it belongs to."""

    thing: str
    part: str
    kind: Kind
    body: str
    centre: Vector
    size: Vector
    R: Matrix = IDENTITY
    form: Literal["box", "ball"] = "box"
    machine: str = ""


@dataclass(frozen=True)
class Strand:
    """The straight lines of a rope as cylinders with this radius [m]; `ends`: names of the bodies at its ends."""

    thing: str
    kind: Kind
    rope: str
    radius: float
    ends: tuple[str, ...]


class Shapes:
    """The shapes of all bodies and ropes of a plan, and the pairs of them that must keep a clearance."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.machines = plan, plan.machines
        joints = [joint for machine in self.machines for joint in machine.system.joints]
        self._carried = {joint.child: joint for joint in reversed(joints)}
        self._pairs = {frozenset((joint.parent, joint.child)) for joint in joints}
        self.cargo = {cargo.body: cargo for machine in self.machines for cargo in machine.cargo}
        self.lifts = bool(self.cargo) or any(machine.hooks for machine in self.machines)
        self._contacts: dict[frozenset[str], list[Contact]] = {}
        for contact in (c for machine in self.machines for c in machine.system.contacts):
            self._contacts.setdefault(frozenset((contact.a.body, contact.b.body)), []).append(contact)
        hooks = [hook for machine in self.machines for hook in machine.hooks]
        self.hooks = {hook.rope: hook for hook in hooks}
        self.slings = {tie.rope for machine in self.machines for tie in machine.ties}
        held = [hook.eye.body for hook in hooks] + [t.upper.body for m in self.machines for t in m.ties]
        self._hanging = {self.root(body) for body in held} - {self.root(hook.on) for hook in hooks} - {*self.cargo}
        self._stand_on = {(s.point.body, self.root(s.on)) for m in self.machines for s in m.system.supports if s.on}

    @cached_property
    def roots(self) -> list[str]:
        """The lowest body of each crane that travels and has hooks, each body once."""
        found = dict.fromkeys(self.root(hook.on) for hook in self.hooks.values())
        return [body for body in found if body in self._carried and self._carried[body].kind == "prismatic"]

    def root(self, body: str) -> str:
        """Return the body nearest to the ground that carries a body through its joints.

        The body may be given as a station of a flexible body, such as `boom@40`."""
        body = body.partition("@")[0]
        while (joint := self._carried.get(body)) is not None and joint.parent != WORLD:
            body = joint.parent
        return body

    def depth(self, body: str) -> int:
        """Return the number of joints between a body and the ground."""
        joint = self._carried.get(body)
        return 0 if joint is None else 1 + self.depth(joint.parent)

    def hanging(self, body: str) -> bool:
        """Return whether a body is suspended by ropes and is not a load, as hook blocks and frames are."""
        return self.root(body) in self._hanging

    @property
    def afloat(self) -> bool:
        """Whether a vessel floats, so that the plane z = 0 is the water surface."""
        return any(shape.part == HULL for machine in self.machines for shape in machine.shapes)

    def supports(self, body: str) -> list[Support]:
        """Return the supports on which a body stands on the ground."""
        return [s for m in self.machines for s in m.system.supports if s.point.body == body and not s.on]

    # ---- shapes -------------------------------------------------------------------------------------------

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """The shapes of all bodies that have one."""
        found = [solid for machine in self.machines for solid in self._boxes(machine)]
        shaped = {solid.body for solid in found}
        touching = (solid for machine in self.machines for solid in _contacts(machine))
        return (*found, *(solid for solid in touching if solid.body not in shaped))

    def _boxes(self, machine: Mechanism) -> Iterator[Solid]:
        for x in machine.shapes:
            kind: Kind = "block" if x.body in self.cargo else "hanging" if self.hanging(x.body) else "machine"
            yield Solid(x.thing or x.body, x.part, kind, x.body, x.centre, x.size, machine=machine.name)
        for cargo in machine.cargo:
            pose = self._carried[cargo.body].q0
            for support in machine.system.supports:
                if support.name in machine.closed and not support.on and support.point.body == cargo.body:
                    (u, v, _), h = support.point.p, support.height
                    place = pose[0] + u, pose[1] + v, h / 2
                    yield Solid(
                        SUPPORTS, support.name, "supports", WORLD, place, (SUPPORT, SUPPORT, h), machine=machine.name
                    )

    @cached_property
    def strands(self) -> dict[str, Strand]:
        """Hook ropes and straight slings, by the name of the rope; ropes over edges and sheaves are not included."""
        found = {}
        for rope in (rope for machine in self.machines for rope in machine.system.ropes):
            if rope.name not in self.hooks and rope.name not in self.slings:
                continue
            kind: Kind = "rope" if rope.name in self.hooks else "sling"
            thing = f"rope {rope.name}" if kind == "rope" else rope.name
            ends = tuple(dict.fromkeys(point.body for line in rope.lines for point in (line.a, line.b)))
            radius = wire_radius(rope.EA / (len(rope.lines) if kind == "rope" else 1))
            found[rope.name] = Strand(thing, kind, rope.name, radius, ends)
        return found

    # ---- how they meet ------------------------------------------------------------------------------------

    def called(self, x: Solid | Strand) -> set[str]:
        """Return all names by which a scene can refer to a shape."""
        if isinstance(x, Solid):
            return {x.thing, x.body, x.machine} - {"", WORLD}
        rigging = (tie.rigging for machine in self.machines for tie in machine.ties if tie.rope == x.rope)
        return {x.thing, x.rope, *rigging} - {""}

    def meeting(self, a: Solid | Strand, b: Solid | Strand) -> tuple[bool, bool]:
        """Return whether a contact keeps two shapes from penetrating, and whether they touch at the start."""
        one, other = (getattr(x, "body", "") for x in (a, b))
        found = self._contacts.get(frozenset((one, other)), [])
        begins = any(contact.name in machine.closed for contact in found for machine in self.machines)
        return bool(found) and not self.by_corners(one, other), begins

    def relation(self, a: Solid | Strand, b: Solid | Strand) -> Relation:
        """Return the relation between two shapes of different objects: "apart" (a clearance must be kept), "through"
        (only penetration is checked) or "joined" (not checked)."""
        if isinstance(a, Solid) and isinstance(b, Solid):
            return self._of_solids(a, b)
        kinds = {a.kind, b.kind}
        if self._ends(a) & self._ends(b) and kinds != {"rope"}:
            return "joined"
        return "through" if kinds <= {"sling", "block", "supports"} else "apart"

    def _ends(self, x: Solid | Strand) -> set[str]:
        """Return the lowest bodies of the objects that a shape belongs to or is attached to, without loads."""
        bodies = (x.body,) if isinstance(x, Solid) else x.ends
        return {self.root(body) for body in bodies if body != WORLD and body not in self.cargo}

    def _of_solids(self, a: Solid, b: Solid) -> Relation:
        kinds, bodies = {a.kind, b.kind}, frozenset((a.body, b.body))
        if "supports" in kinds:
            return "joined" if "block" in kinds else "apart"
        if bodies in self._pairs:
            return "joined"
        if bodies in self._contacts and "block" not in kinds:
            return "through" if self.by_corners(a.body, b.body) else "joined"
        if "mechanism" in kinds:
            return "joined" if a.kind != b.kind else "through"
        if self.root(a.body) == self.root(b.body):
            return "apart" if self._siblings(a.body, b.body) else "joined"
        if {(a.body, self.root(b.body)), (b.body, self.root(a.body))} & self._stand_on:
            return "joined"
        return "joined" if self._still(a.body) and self._still(b.body) else "apart"

    def overlap(self, a: Solid | Strand, b: Solid | Strand) -> float:
        """Return the depth [m] to which two shapes may overlap without a finding, for example slings at lugs."""
        if isinstance(a, Strand) or isinstance(b, Strand):
            strand, solid = (a, b) if isinstance(a, Strand) else (b, a)
            cargo = self.cargo.get(solid.body) if isinstance(solid, Solid) else None
            if not isinstance(strand, Strand) or not isinstance(solid, Solid) or cargo is None:
                return 0.0
            proud = [_distance(p, solid) for p in cargo.lugs.values()] if solid.body in strand.ends else []
            return 2.0 * max((max(strand.radius - x, 0.0) for x in proud), default=0.0)
        meant = {x.body: x.overlap for machine in self.machines for x in machine.shapes if x.overlap}
        return max(meant.get(a.body, 0.0), meant.get(b.body, 0.0))

    def _siblings(self, a: str, b: str) -> bool:
        """Return whether two bodies slide on the same third body."""
        one, two = self._carried[a], self._carried[b]
        return one.parent == two.parent and one.kind == two.kind == "prismatic"

    def _still(self, body: str) -> bool:
        joint = self._carried.get(body)
        return joint is None or (joint.kind == "fixed" and self._still(joint.parent))

    def by_corners(self, a: str, b: str) -> bool:
        """Return whether all contacts between two bodies are at points, so that the bodies may penetrate elsewhere."""
        found = self._contacts.get(frozenset((a, b)), [])
        return bool(found) and all(getattr(c.a, "radius", 1.0) == 0.0 for c in found)

    @cached_property
    def not_modelled(self) -> tuple[str, ...]:
        """The clearances and tensions that no check includes, as phrases for reports."""
        found, plan = [], self.plan
        if self.hooks:
            found.append("clearance of ropes to parts of their own crane, since scenes do not state its openings")
            found.append(f"motion too fast for the samples of places and speeds, {plan.samples_hz:g} a second")
        if self.slings:
            found.append("clearance of slings while they are slack")
        reeved = [rope.name for machine in self.machines for rope in machine.system.reevings]
        if any(rope in self.slings for rope in reeved):
            found.append("clearance of slings that bend over edges")
        for machine in self.machines:
            if any(rope.name not in self.slings for rope in machine.system.reevings):
                found.append("tension of ropes over sheaves between samples")
            apart = [s.body for s in self.solids if s.machine == machine.name and s.kind == "machine"]
            if self.lifts and len({*apart}) > 1:
                found.append(f"clearance between parts of {machine.name}")
        return tuple(dict.fromkeys(found))

    @cached_property
    def shapeless(self) -> tuple[str, ...]:
        """The clearances that are not checked because objects have no shapes, as phrases for reports."""
        shaped, found = {solid.body for solid in self.solids}, []
        for machine in self.machines:
            heavy = (body.name for body in machine.system.bodies if body.mass or body.flexible)
            bare = [name for name in heavy if name not in shaped]
            if bare:
                more = f" and {len(bare) - 3} more" if len(bare) > 3 else ""
                message = f"clearance of {', '.join(bare[:3])}{more} of {machine.name}, which have no shapes"
                found.append(f"{message}: write 'shapes'")
            meets = [(contact.b, contact.a.body) for contact in machine.system.contacts if isinstance(contact.b, Plane)]
            movable = {body.name for each in self.machines for body in each.system.bodies}
            if any((plane, body) not in meets for plane, _ in meets for body in movable):
                found.append(f"clearance of planes of {machine.name}: write 'contacts' for all that may meet them")
            if any(rope.name not in self.strands for rope in machine.system.straight_ropes):
                found.append(f"clearance of ropes of {machine.name}: {OTHERS}")
            if any(rope.name not in self.slings for rope in machine.system.reevings):
                found.append(f"clearance of ropes over sheaves of {machine.name}: {OTHERS}")
        return tuple(found)


def _distance(p: Vector, solid: Solid) -> float:
    """Return the distance [m] from a point to a box on the same body."""
    lateral = [max(0.0, abs(x - c) - size / 2) for x, c, size in zip(p, solid.centre, solid.size, strict=True)]
    return sqrt(sum(d * d for d in lateral))


def _contacts(machine: Mechanism) -> Iterator[Solid]:
    """Yield the boxes and balls that the contacts of a machine define."""
    for shape in dict.fromkeys(s for c in machine.system.contacts for s in (c.a, c.b)):
        match shape:
            case Box():
                yield Solid(shape.body, "", "mechanism", shape.body, shape.p, shape.size, shape.R)
            case Ball() if shape.radius > 0.0:
                size = (2.0 * shape.radius,) * 3
                yield Solid(shape.body, "", "mechanism", shape.body, shape.p, size, form="ball")


def wire_radius(EA: float) -> float:
    """Return the radius [m] of a steel wire rope with the stiffness EA [N], or of its bundle of falls."""
    return sqrt(EA / (pi * FILL * E_STEEL))


def around(boxes: Sequence[tuple[Vector, Vector]]) -> tuple[Vector, Vector]:
    """Return the centre and edges [m] of the box that encloses several parallel boxes."""
    if len(boxes) == 1:
        return boxes[0]
    low = [min(c[i] - s[i] / 2 for c, s in boxes) for i in range(3)]
    high = [max(c[i] + s[i] / 2 for c, s in boxes) for i in range(3)]
    x, y, z = ((p + q) / 2 for p, q in zip(low, high, strict=True))
    a, b, c = (q - p for p, q in zip(low, high, strict=True))
    return (x, y, z), (a, b, c)
