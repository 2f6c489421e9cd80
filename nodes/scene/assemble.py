"""The `mechanism:` of a scene file as its part of the plan.

Every joint, rope and law is checked against the bodies and joints there are; units are read again where
they depend on whether a joint slides or turns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any

from heavylift.kernel import describe as k
from heavylift.kernel.checks import check_inertia, check_joint
from heavylift.kernel.contact.describe import Contact
from heavylift.kernel.contact.pairs import check_contact
from heavylift.kernel.errors import KernelError
from heavylift.kernel.flexible.checks import check_flexible
from heavylift.kernel.forces import describe as forces
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.kernel.forces.table import check_force

from . import contacts, joints, kinematics, mechanics, plan, units
from .faults import closest
from .flexible import Beam
from .forces import Characteristic
from .source import Fault, Path, Source
from .units import Dimension

TOO_SHORT = 1e-6  # [m] that a rigid rope may lack at the start by rounding
TOUCH = 1e-9  # a rope or support this close carries [m]
# key of a law -> its dimension on a sliding and on a turning joint
_UNITS: dict[str, tuple[Dimension, Dimension]] = {
    "stiffness": (units.STIFFNESS, units.TURN_STIFFNESS),
    "damping": (units.DAMPING, units.TURN_DAMPING),
    "holds": (units.FORCE, units.MOMENT),
    "rest": (units.LENGTH, units.ANGLE),
    "range": (units.LENGTH, units.ANGLE),
    "dry": (units.FORCE, units.MOMENT),
    "viscous": (units.DAMPING, units.TURN_DAMPING),
    "ramp": (units.ACCELERATION, units.ANGULAR_ACCELERATION),
}


def build_mechanism(source: Source, given: mechanics.Mechanism, gravity: float) -> plan.Mechanism:
    """The mechanism of the plan; what is wrong is added to the faults of the source."""
    return _Assembly(source, given).build(gravity)


class _Assembly:
    def __init__(self, source: Source, given: mechanics.Mechanism) -> None:
        self.source, self.given = source, given
        self.bodies = [k.WORLD, *given.bodies]

    def build(self, gravity: float) -> plan.Mechanism:
        given = self.given
        self._tree()
        self._names()
        self._laws()
        made = tuple(self._joints())
        own = [law for name, joint in given.joints.items() for law in joint.laws(name)]
        plain = {name: rope for name, rope in given.ropes.items() if all(x.plain for x in rope.over)}
        ropes = [self._rope(name, rope) for name, rope in plain.items()]
        reevings = [self._reeving(name, rope) for name, rope in given.ropes.items() if name not in plain]
        for name, support in given.supports.items():
            self._known(("mechanism", "supports", name, "body"), support.body)
            self._on_beam(("mechanism", "supports", name, "at"), support.body, support.at[0])
        system = k.System(
            bodies=tuple(self._bodies()),
            joints=made,
            springs=tuple(
                k.JointSpring(n, x.joint, x.stiffness, x.damping, x.rest, x.coordinate)
                for n, x in given.springs.items()
            )
            + tuple(x for x in own if isinstance(x, k.JointSpring)),
            stops=tuple(
                k.Stop(n, x.joint, *x.range, x.stiffness, x.damping, x.coordinate) for n, x in given.stops.items()
            )
            + tuple(x for x in own if isinstance(x, k.Stop)),
            brakes=tuple(
                k.Brake(n, x.joint, x.holds, x.stiffness, x.damping, x.engaged, x.coordinate)
                for n, x in given.brakes.items()
            )
            + tuple(x for x in own if isinstance(x, k.Brake)),
            locks=tuple(k.Lock(n, x.joint, x.engaged) for n, x in given.locks.items()),
            drives=tuple(
                k.Drive(n, x.joint, x.type, x.stiffness, x.damping, x.coordinate) for n, x in given.drives.items()
            ),
            ropes=tuple(r for r in ropes if isinstance(r, k.Rope)),
            rigid_ropes=tuple(r for r in ropes if isinstance(r, k.RigidRope)),
            supports=tuple(_support(name, support) for name, support in given.supports.items()),
            forces=(*reevings, *self._forces()),
            contacts=tuple(self._contacts()),
            gravity=gravity,
        )
        taut, closed = self._carrying(system) if not self.source.faults else ((), ())
        return plan.Mechanism(
            name=given.name,
            system=system,
            actuators=tuple(self._actuators()),
            taut=taut,
            closed=closed,
            where=self.source.where(("mechanism",)),
        )

    def _body(self, name: str, body: mechanics.Body) -> k.Body:
        path: Path = ("mechanism", "bodies", name)
        flexible, made = body.beam or body.matrices, None
        if flexible is None and body.mass is None:
            self._fault((*path, "mass"), "the key 'mass' is missing", on_key=True)
        if body.beam and body.matrices:
            self._fault((*path, "matrices"), "a flexible body has either a 'beam' or 'matrices'", on_key=True)
        elif flexible:
            at: Path = (*path, "beam" if body.beam else "matrices")
            try:
                made = flexible.built(FilePath(self.source.mark(path).file).parent)
                check_flexible(name, made)
            except (KernelError, ValueError) as error:
                self._fault(at, str(error), on_key=True)
        return k.Body(name, body.mass or 0.0, body.com, _matrix(body.inertia), made)

    def _carrying(self, system: k.System) -> tuple[tuple[str, ...], tuple[str, ...]]:
        at = kinematics.poses(system)
        spans = {r.name: self._span(r, at) for r in system.reevings}
        reeved = [r.name for r in system.reevings if spans[r.name] > r.L0 + TOUCH]
        stretched = {r.name: kinematics.length(r, at) - r.L0 for r in system.straight_ropes if r.hooked}
        for rigid in system.rigid_ropes:
            if stretched.get(rigid.name, 0.0) > TOO_SHORT:
                told = f"the rope is rigid and {stretched[rigid.name] * 1e3:.3g} mm too short for its ends at the start"
                self._fault(("mechanism", "ropes", rigid.name, "length"), told)
        taut = [r.name for r in system.ropes if stretched.get(r.name, 0.0) > TOUCH]
        taut += [r.name for r in system.rigid_ropes if stretched.get(r.name, -1.0) > -TOUCH]
        closed = (s.name for s in system.supports if kinematics.place(s.point, at)[2] < s.height - TOUCH)
        touching = (c.name for c in system.contacts if contacts.touches(c, at, TOUCH))
        return (*taut, *reeved), (*closed, *touching)

    def _span(self, rope: forces.Reeving, at: kinematics.Poses) -> float:
        """The length of a rope over its sheaves at the start [m]."""
        try:
            return ReevingLaw().start_length(rope, lambda body: (at[body][1], at[body][0]))
        except KernelError as error:
            self._fault(("mechanism", "ropes", rope.name), str(error), on_key=True)
            return 0.0

    def _tree(self) -> None:
        """Each body is the child of one joint, and all hang together with the world."""
        carried: dict[str, str] = {}
        for name, joint in self.given.joints.items():
            path: Path = ("mechanism", "joints", name)
            self._known((*path, "parent"), joint.parent)
            if isinstance(joint, joints.Slider):
                if joint.parent in self.bodies and not self._beam(joint.parent):
                    self._fault((*path, "parent"), f"a slider needs a flexible beam, and '{joint.parent}' has none")
                self._on_beam((*path, "start"), joint.parent, joint.start)
            else:
                self._on_beam((*path, "at"), joint.parent, joint.at[0])
            self._known((*path, "child"), joint.child)
            if joint.child != k.WORLD:  # that closes a loop, as every further joint of a body does
                carried.setdefault(joint.child, name)
            if joint.type == "free" and joint.child in self.given.bodies and not self._solid(joint.child):
                told = f"the body '{joint.child}' moves freely and nothing resists its turning: give it moments"
                self._fault(("mechanism", "bodies", joint.child), f"{told} with 'inertia'", on_key=True)
        for body in self.given.bodies:
            above, seen = body, set[str]()
            while above in carried and above not in seen:
                seen.add(above)
                above = self.given.joints[carried[above]].parent
            if above == body and not seen:
                self._fault(("mechanism", "bodies", body), f"no joint carries the body '{body}'", on_key=True)
            elif above in seen:
                told = f"the joints of '{body}' go in a circle and never reach the world"
                self._fault(("mechanism", "bodies", body), told, on_key=True)

    def _bodies(self) -> Iterator[k.Body]:
        """The kernel's bodies, with inertias that a mass can have."""
        for name, body in self.given.bodies.items():
            made = self._body(name, body)
            self._checked(("mechanism", "bodies", name), check_inertia, made)
            yield made

    def _joints(self) -> Iterator[k.Joint]:
        """The kernel's joints; their axes have directions and stand as their type wants them."""
        for name, joint in self.given.joints.items():
            path: Path = ("mechanism", "joints", name)
            faults = len(self.source.faults)
            for key in joint.directions:
                axis = getattr(joint, key.replace(" ", "_"))
                if axis is not None and not any(axis):
                    self._fault((*path, key), "an axis needs a direction, such as [0, 0, 1]")
            if isinstance(joint, joints.Spherical | joints.Free) and not any(joint.attitude):
                self._fault((*path, "attitude"), "a quaternion x y z w must not be zero, [0, 0, 0, 1] is no turn")
            made = joint.built(name)
            if len(self.source.faults) == faults:
                self._checked(path, check_joint, made)
            yield made

    def _checked(self, path: Path, check: Callable[[Any], None], made: Any) -> None:
        """What the kernel would refuse is a fault of the scene."""
        try:
            check(made)
        except KernelError as error:
            self._fault(path, str(error), on_key=True)

    def _solid(self, body: str) -> bool:
        """Whether all moments of inertia are there, or other bodies or a beam may bring them."""
        carries = any(joint.parent == body for joint in self.given.joints.values())
        given = self.given.bodies[body]
        return carries or bool(given.beam or given.matrices) or all(given.inertia[:3])

    def _names(self) -> None:
        """Ropes, supports and laws share one set of names."""
        taken: dict[str, str] = {}
        kinds = ("joints", "ropes", "supports", "springs", "stops", "brakes", "locks", "drives", "forces", "contacts")
        for kind in kinds:
            for name in getattr(self.given, kind):
                if name in taken:
                    told = f"the name '{name}' is given twice: one of the {taken[name]} has it, too"
                    self._fault(("mechanism", kind, name), told, on_key=True)
                taken.setdefault(name, kind)

    def _laws(self) -> None:
        driven: dict[tuple[str, str], str] = {}
        for kind, laws in self.given.laws.items():
            for name, law in laws.items():
                path: Path = ("mechanism", kind, name)
                along = self._along(path, law.joint, law.coordinate)
                if along:
                    self._dimensions(path, turns=along[1])
                if kind == "drives" and along:
                    if other := driven.get((law.joint, along[0])):
                        told = f"the joint '{law.joint}' has two drives, '{other}' and '{name}'"
                        self._fault((*path, "joint"), f"{told}: keep one")
                    driven.setdefault((law.joint, along[0]), name)
                if kind in {"stops", "drives"} and law.range and law.range[0] >= law.range[1]:
                    self._fault((*path, "range"), "the first end must be below the second")
        for name, joint in self.given.joints.items():
            for key, given in (("limits", joint.limits), ("friction", joint.friction)):
                for coordinate in given:
                    path = ("mechanism", "joints", name, key, coordinate)
                    if coordinate in joint.coordinates:
                        self._dimensions(path, turns=joint.turns(coordinate))
                    else:
                        told = f"a {joint.type} joint has no coordinate '{coordinate}' to act on"
                        self._fault(path, told, closest(coordinate, joint.coordinates), on_key=True)
            for coordinate, x in joint.limits.items():
                if x.range[0] >= x.range[1]:
                    path = ("mechanism", "joints", name, "limits", coordinate, "range")
                    self._fault(path, "the first end must be below the second")
        for name, lock in self.given.locks.items():
            path = ("mechanism", "locks", name, "joint")
            if lock.joint not in self.given.joints:
                self._fault(path, f"there is no joint '{lock.joint}'", closest(lock.joint, self.given.joints))

    def _forces(self) -> Iterator[forces.Force]:
        """Each force acts on bodies or a joint that are there and is one that the kernel can build."""
        for name, force in self.given.forces.items():
            path: Path = ("mechanism", "forces", name)
            for keys, body in force.bodies:
                self._known((*path, *keys), body)
            joint = getattr(force, "joint", "")
            along = self._along(path, joint, getattr(force, "coordinate", "")) if joint else None
            if along and isinstance(force, Characteristic):
                self._curve(path, force, along[1])
            made = force.built(name, FilePath(self.source.mark(path).file).parent)
            self._checked(path, check_force, made)
            yield made

    def _contacts(self) -> Iterator[Contact]:
        """Each contact is between bodies that are there and shapes that the kernel can watch."""
        for name, given in self.given.contacts.items():
            path: Path = ("mechanism", "contacts", name)
            self._known((*path, "body"), given.body)
            self._known((*path, "against", "body"), given.against.body)
            made = contacts.built(name, given)
            self._checked(path, check_contact, made)
            yield made

    def _curve(self, path: Path, force: Characteristic, turns: bool) -> None:
        """The units of a curve fit the joint that it acts along."""
        place = (units.LENGTH, units.ANGLE) if force.over == "position" else (units.SPEED, units.RATE)
        for i, pair in enumerate(self.source.data["mechanism"]["forces"][path[-1]]["curve"]):
            for j, dimensions in enumerate((place, (units.FORCE, units.MOMENT))):
                try:
                    dimensions[turns].read(pair[j])
                except ValueError as error:
                    self._fault((*path, "curve", i, j), str(error))

    def _along(self, path: Path, name: str, coordinate: str) -> tuple[str, bool] | None:
        """The coordinate that a law acts along, and whether it is an angle."""
        joint = self.given.joints.get(name)
        if joint is None:
            self._fault((*path, "joint"), f"there is no joint '{name}'", closest(name, self.given.joints))
        elif not joint.coordinates:
            self._fault((*path, "joint"), f"a {joint.type} joint has no single coordinate to act on: '{name}'")
        elif not coordinate and len(joint.coordinates) > 1:
            words = " or ".join(f"'coordinate: {c}'" for c in joint.coordinates)
            self._fault((*path, "joint"), f"the {joint.type} joint '{name}' has several coordinates: add {words}")
        elif coordinate and coordinate not in joint.coordinates:
            told = f"a {joint.type} joint has no coordinate '{coordinate}'"
            self._fault((*path, "coordinate"), told, closest(coordinate, joint.coordinates))
        else:
            along = coordinate or joint.coordinates[0]
            return along, joint.turns(along)
        return None

    def _dimensions(self, path: Path, *, turns: bool) -> None:
        """The units of a law fit the coordinate that it acts on."""
        written: Any = self.source.data
        for part in path:
            written = written[part]
        for key, dimensions in _UNITS.items():
            values = written.get(key)
            dimension = dimensions[turns]
            many = isinstance(values, list)
            for i, value in enumerate(values if isinstance(values, list) else [values]):
                if value is not None:
                    try:
                        dimension.read(value)
                    except ValueError as error:
                        self._fault((*path, key, i) if many else (*path, key), str(error))

    def _rope(self, name: str, rope: mechanics.Rope) -> k.Rope | k.RigidRope:
        path: Path = ("mechanism", "ropes", name)
        lines = [(line.start, line.end, line.share, (*path, "lines", i)) for i, line in enumerate(rope.lines)]
        for start, end, _, at in lines:
            self._known((*at, "start", "body"), start.body)
            self._known((*at, "end", "body"), end.body)
            self._on_beam((*at, "start", "at"), start.body, start.at[0])
            self._on_beam((*at, "end", "at"), end.body, end.at[0])
        if rope.start and rope.end and not rope.lines:
            nodes = self._nodes(path, rope.start, rope.over, rope.end)
            lines = [(a, b, 1.0, path) for a, b in pairwise(nodes)]
        elif rope.start or rope.end or rope.over or not rope.lines:
            self._fault(path, "a rope has either 'start' and 'end' or 'lines'", on_key=True)
        self._wound(path, rope)
        self._stretch(path, rope)
        made = tuple(k.Line(k.Point(a.body, a.at), k.Point(b.body, b.at), share) for a, b, share, _ in lines)
        winch = rope.winch is not None
        if rope.rigid:
            return k.RigidRope(name, made, rope.length, winch, rope.hooked)
        return k.Rope(name, made, rope.EA or 1.0, rope.length, rope.damping or 0.0, winch, rope.hooked)

    def _stretch(self, path: Path, rope: mechanics.Rope) -> None:
        """An elastic rope has a stiffness, a rigid one none, no damping and no contacts beside it."""
        if not rope.rigid:
            if rope.EA is None:
                self._fault(path, "the key 'EA' is missing; a rope that cannot stretch is 'rigid: true'", on_key=True)
            return
        for key in ("EA", "damping"):
            if getattr(rope, key) is not None:
                self._fault((*path, key), f"a rigid rope cannot stretch: leave '{key}' or 'rigid' away", on_key=True)
        if self.given.contacts:
            told = "contacts go with elastic ropes only: give the rope its 'EA' instead"
            self._fault((*path, "rigid"), told, on_key=True)

    def _reeving(self, name: str, rope: mechanics.Rope) -> forces.Reeving:
        """A rope over sheaves with a radius or friction."""
        path: Path = ("mechanism", "ropes", name)
        if rope.start is None or rope.end is None or rope.lines or not rope.hooked:
            told = "a rope over sheaves has 'start' and 'end', no 'lines', and is never taken off"
            self._fault(path, told, on_key=True)
        start, end = (x or mechanics.End(body=k.WORLD) for x in (rope.start, rope.end))
        self._nodes(path, start, rope.over, end)
        self._wound(path, rope)
        self._stretch(path, rope)
        if rope.rigid:
            told = "a rigid rope runs over points only: leave 'radius', 'friction' and 'efficiency' of its sheaves away"
            self._fault((*path, "rigid"), told, on_key=True)
        sheaves = tuple(
            forces.Sheave(k.Point(s.body, s.at), joints.unit(s.axis), s.radius, s.friction, s.efficiency)
            for s in rope.over
        )
        signal = forces.Signal(rope.length, driven=rope.winch is not None)
        ends = k.Point(start.body, start.at), k.Point(end.body, end.at)
        made = forces.Reeving(name, ends[0], sheaves, ends[1], rope.EA or 1.0, signal, rope.damping or 0.0)
        self._checked(path, check_force, made)
        return made

    def _nodes(
        self, path: Path, start: mechanics.End, over: list[mechanics.Over], end: mechanics.End
    ) -> list[mechanics.End]:
        """Start, what lies between, end; their bodies are checked."""
        placed: list[tuple[Path, mechanics.End]] = [((*path, "start"), start)]
        placed += [((*path, "over", i), node) for i, node in enumerate(over)]
        for at, node in [*placed, ((*path, "end"), end)]:
            self._known((*at, "body"), node.body)
            self._on_beam((*at, "at"), node.body, node.at[0])
        return [start, *over, end]

    def _wound(self, path: Path, rope: mechanics.Rope) -> None:
        """The length of a rope lies between those that its winch allows."""
        if rope.winch and not rope.winch.shortest <= rope.length <= rope.winch.longest:
            ends = f"{rope.winch.shortest:g} and {rope.winch.longest:g} m"
            self._fault((*path, "length"), f"{rope.length:g} m of rope is not between {ends}")

    def _actuators(self) -> list[plan.Actuator]:
        found = []
        for name, drive in self.given.drives.items():
            lower, upper = drive.range or (None, None)
            where = self.source.where(("mechanism", "drives", name))
            start = self._start(drive)
            found.append(plan.Actuator(name=name, start=start, accel=drive.ramp, lower=lower, upper=upper, where=where))
        for name, rope in self.given.ropes.items():
            if rope.winch:
                where = self.source.where(("mechanism", "ropes", name, "winch"))
                ends = {"lower": rope.winch.shortest, "upper": rope.winch.longest}
                found.append(plan.Actuator(name=name, start=rope.length, accel=rope.winch.ramp, where=where, **ends))
        return found

    def _start(self, drive: mechanics.Drive) -> float:
        """Where the coordinate of a drive begins."""
        joint = self.given.joints.get(drive.joint)
        named = dict(zip(joint.coordinates, joint.state()[0], strict=False)) if joint else {}
        return named.get(drive.coordinate, next(iter(named.values()), 0.0))

    def _known(self, path: Path, body: str) -> None:
        if body not in self.bodies:
            self._fault(path, f"there is no body '{body}'", closest(body, self.bodies))

    def _beam(self, body: str) -> Beam | None:
        return self.given.bodies[body].beam if body in self.given.bodies else None

    def _on_beam(self, path: Path, body: str, x: float) -> None:
        """What stands on a beam stands between its ends."""
        beam = self._beam(body)
        if beam and not 0.0 <= x <= beam.length:
            self._fault(path, f"{x:g} m is not on the beam of '{body}', which reaches from 0 to {beam.length:g} m")

    def _fault(self, path: Path, sentence: str, hint: str = "", *, on_key: bool = False) -> None:
        self.source.faults.append(Fault(path, sentence, hint, on_key))


def _matrix(i: tuple[float, ...]) -> k.Matrix:
    xx, yy, zz, xy, xz, yz = (*i, 0.0, 0.0, 0.0)[:6]
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def _support(name: str, s: mechanics.Support) -> k.Support:
    at = k.Point(s.body, s.at)
    kt, dt = s.tangential_stiffness, s.tangential_damping
    return k.Support(name, at, s.height, s.stiffness, s.damping, s.friction, kt, dt)
