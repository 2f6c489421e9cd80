"""The generic machine: declared bodies, joints, laws and hooks as one coupled model.

Every joint and every body becomes a coupled model (Fig. 7 of the paper); each force law belongs to the actor of the
joint or body on which it acts. A rope or force belongs to the first body (other than the ground) at its ends, a support
or contact to its body; a rope wound in pieces is one actor. Forces on a joint or body of the lift form a group of their
own. Actors have the names of their mechanical elements, and send in the alphabetical order of these names.
"""

import re
from dataclasses import replace

from heavylift.kernel.description.forces import Force, RopeForce, TuggerLine
from heavylift.kernel.description.mechanics import GROUPS, JOINTS, WORLD, AnyRope, RigidRope, Rope, System, Threshold
from heavylift.kernel.errors import ModelError
from heavylift.nodes.models.parts.drive import DriveActor, HeldActor
from heavylift.nodes.models.parts.gauges import Inclinometer, LoadCell
from heavylift.nodes.models.parts.messages import Latch as Latched
from heavylift.nodes.models.parts.parts import Actor, BodyCoupled, Group, JointCoupled, LawModel, RealObject
from heavylift.nodes.models.parts.rigging import BlockSupports, BrakeActor, JointLockActor, LatchActor, SlingActor
from heavylift.nodes.models.parts.winch import SLACK, TuggerActor, WinchActor
from heavylift.nodes.plan.mechanism import Actuator, BrakeLatch, Cargo, Mechanism


class MachineModel(RealObject):
    """A machine of the plan as a coupled model."""

    def __init__(self, mechanism: Mechanism) -> None:
        super().__init__(mechanism.name)
        self.adopt(mechanism)
        self.actuators = {actuator.name: actuator for actuator in mechanism.actuators}
        names, own = (x.name for group in GROUPS for x in getattr(self.system, group)), f"{self.name}."
        self.common = own if all(name.startswith(own) for name in names) else ""
        self.inner = {piece for rope, parts in mechanism.pieces.items() for piece in parts if piece != rope}
        for joint in self.system.joints:
            actors = self._joint_actors(joint.name) or [LawModel("free")]
            self.take(JointCoupled(f"{self._name(joint.name)}-joint", joint, *actors))
        for body in self.system.bodies:
            self.take(
                BodyCoupled(f"{self._name(body.name)}-body", body, LawModel("weight"), *self._body_actors(body.name))
            )
        bodies, joints = self.system.outside
        for name in joints:
            self._act_on(name, self._joint_actors(name))
        for name in bodies:
            self._act_on(name, self._body_actors(name))
        for master in self.system.masters:
            self.take(self._drive(f"{self._name(master.name)}-master", master.name, System(masters=(master,))))
        if measured := self.system.measured:
            self.take(LawModel("measured", System(measured=measured)))
        for held in (actuator for actuator in mechanism.actuators if actuator.held):
            self.take(HeldActor(self._name(held.name), held.name, held.held))
        for latch in mechanism.latches:
            self._latch(latch)

    def adopt(self, mechanism: Mechanism) -> None:
        """Take a mechanism as the machine's own; its parts are left as they are."""
        self.mechanism, self.system = mechanism, mechanism.system
        self.ropes = {rope.name: rope for rope in self.system.all_ropes}

    def _latch(self, latch: BrakeLatch) -> None:
        """Connect the slings of a latch with the brake of the latch."""
        groups = [group for group in self.children.values() if isinstance(group, Group)]
        actors = [(group, actor) for group in groups for actor in group.children.values()]
        locks = ((of, x) for of, x in actors if isinstance(x, LatchActor) and x.element == latch.brake)
        name, (of, lock) = f"latch-{self._name(latch.brake)}", next(locks, (None, None))
        if lock is None or of is None:  # its joint is not modelled
            into = self.take(
                LatchActor(self._name(latch.brake), latch.brake, System(), hooked=self._hooked(latch))
            ).latch
        else:
            into = of.add_in(name, Latched)
            of.connect(into, lock.latch)
        for group in groups:
            ties = [x for of, x in actors if of is group and isinstance(x, SlingActor) and x.element in latch.ties]
            if ties:
                out = group.add_out(name, Latched)
                self.connect(out, into)
                for tie in ties:
                    group.connect(tie.latch, out)

    def _hooked(self, latch: BrakeLatch) -> frozenset[str]:
        return frozenset(rope.name for rope in self.system.all_ropes if rope.hooked and rope.name in latch.ties)

    def _name(self, element: str) -> str:
        """Return the model name of a mechanical element, without the machine's name as prefix."""
        return re.sub(r"[^A-Za-z0-9_-]", "-", element.removeprefix(self.common))

    def _act_on(self, name: str, actors: list[Actor]) -> None:
        """Add the actors of forces that act on a joint or body of the lift."""
        if actors:
            group = self.take(Group(f"{self._name(name)}-acted-on"))
            for actor in actors:
                group.take(actor)

    def _joint_actors(self, joint: str) -> list[Actor]:
        system, actors = self.system, list[Actor]()
        for drive in (d for d in system.drives if d.joint == joint):
            laws = System(drives=(drive,))
            name = self._name(drive.name)
            actors.append(LawModel(name, laws) if drive.wave or drive.waves else self._drive(name, drive.name, laws))
        latches = {latch.brake: latch for latch in self.mechanism.latches}
        for brake in (b for b in system.brakes if b.joint == joint):
            name, laws = self._name(brake.name), System(brakes=(brake,))
            if brake.name in latches:
                actors.append(LatchActor(name, brake.name, laws, hooked=self._hooked(latches[brake.name])))
            else:
                actors.append(BrakeActor(name, brake.name, laws, engaged=brake.engaged))
        for lock in (x for x in system.locks if x.joint == joint):
            actors.append(JointLockActor(self._name(lock.name), lock.name, System(locks=(lock,)), engaged=lock.engaged))
        actors += [LawModel(self._name(x.name), System(springs=(x,))) for x in system.springs if x.joint == joint]
        actors += [LawModel(self._name(x.name), System(stops=(x,))) for x in system.stops if x.joint == joint]
        actors += [
            LawModel(self._name(f.name), System(forces=(f,))) for f in system.forces if f.along and f.along[0] == joint
        ]
        return actors

    def _body_actors(self, body: str) -> list[Actor]:
        system, actors = self.system, list[Actor]()
        for rope in (r for r in system.all_ropes if self._holds(r) == body):
            if rope.name in self.inner:
                continue
            parts = self.mechanism.pieces.get(rope.name, {})
            actors.append(self._rope(rope, tuple(r for r in system.all_ropes if r is rope or r.name in parts)))
        for hook in (h for h in self.mechanism.hooks if h.capacity and self._holds(self.ropes[h.rope]) == body):
            rated = (hook.capacity + hook.block_mass) * system.gravity
            actors.append(LoadCell(f"{self._name(hook.rope)}-load", f"{hook.rope}.load", (hook.rope,), rated))
        for cell in (cell for cell in self.mechanism.cells if cell.body == body):
            actors.append(LoadCell(self._name(cell.name), cell.name, cell.ropes, cell.rated))
        for force in (f for f in system.forces if not isinstance(f, RopeForce) and _first(f) == body):
            actors.append(LawModel(self._name(force.name), System(forces=(force,))))
        supports = tuple(s for s in system.supports if s.point.body == body)
        contacts = tuple(c for c in system.contacts if c.a.body == body)
        cargo = next((c for c in self.mechanism.cargo if c.body == body), Cargo(body=body))
        if supports or contacts:
            names = [*(s.name for s in supports), *(c.name for c in contacts)]
            faces = {name: cargo.faces.get(name, body) for name in names}
            closed = frozenset(self.mechanism.closed) & frozenset(faces)
            laws = System(supports=supports, contacts=contacts)
            stands = self.mechanism.standing(body)
            actors.append(BlockSupports("supports", stands, laws, faces=faces, closed=closed))
        if cargo.turned is not None:
            actors.append(Inclinometer("attitude", body, cargo.turned))
        return actors

    def _rope(self, rope: AnyRope, parts: tuple[AnyRope, ...]) -> Actor:
        """Return the actor of a rope; `parts`: the pieces of the rope, which are wound together."""
        laws = System(
            ropes=tuple(r for r in parts if isinstance(r, Rope)),
            rigid_ropes=tuple(r for r in parts if isinstance(r, RigidRope)),
            forces=tuple(r for r in parts if isinstance(r, RopeForce)),
        )
        if isinstance(rope, TuggerLine) and rope.rate:
            at = self._actuator(rope.name)
            return TuggerActor(self._name(rope.name), rope.name, laws, start=at.start, lower=at.lower, limits=SLACK)
        if not rope.winch:
            return SlingActor(self._name(rope.name), rope.name, laws)
        at, eye = self._actuator(rope.name), next((h.eye for h in self.mechanism.hooks if h.rope == rope.name), None)
        switch = None
        if at.highest is not None and eye is not None:
            guard = Threshold(f"{rope.name}.highest", "height", point=eye)
            laws, switch = replace(laws, thresholds=(guard,)), (guard, at.highest)
        return WinchActor(
            self._name(rope.name), rope.name, laws, start=at.start, lower=at.lower, upper=at.upper, switch=switch,
            pieces=self.mechanism.pieces.get(rope.name), emergency=at.emergency,
        )  # fmt: skip

    def _holds(self, rope: AnyRope) -> str:
        """Return the body to whose actor a rope belongs: the first body at its first piece."""
        first = next(iter(self.mechanism.pieces.get(rope.name, {})), "")
        return _body(self.ropes.get(first, rope))

    def _drive(self, name: str, element: str, laws: System) -> DriveActor:
        at = self._actuator(element)
        return DriveActor(name, element, laws, start=at.start, lower=at.lower, upper=at.upper, emergency=at.emergency)

    def _actuator(self, name: str) -> Actuator:
        """Return the start position and the limits of an actuator; a rope starts at its length, any other at 0."""
        if name in self.actuators:
            return self.actuators[name]
        lengths = {rope.name: rope.L0 for rope in self.system.all_ropes}
        return Actuator(name=name, start=lengths.get(name, 0.0), accel=0.0)


def _body(rope: AnyRope) -> str:
    """Return the body to whose actor a rope belongs."""
    for line in rope.lines:
        for point in (line.a, line.b):
            if point.body != WORLD:
                return point.body
    raise ModelError(f"rope {rope.name} has both ends on the ground; attach one end to a body")


def _first(force: Force) -> str:
    """Return the body to whose actor a force belongs: the first one at its ends that is not the ground."""
    return next((p.body for p in force.points if p.body != WORLD), "")


def turning(system: System) -> list[str]:
    """Return the drives and virtual master drives of a machine whose coordinates are angles."""
    joints = {joint.name: JOINTS[joint.kind] for joint in system.joints}
    of = ((d.name, joints[d.joint], d.coordinate) for d in system.drives)
    found = [name for name, joint, at in of if joint.turns(joint.actable.index(at) if at else 0)]
    return found + [master.name for master in system.masters]
