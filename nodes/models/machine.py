"""The generic machine: bodies, joints, laws and hooks that are declared, as one coupled model.

A researcher's mechanism is one, and every crane that its type makes of parts; goliaths, loaders and the block have
models of their own, for how much of them is modelled is theirs.

Every joint becomes a joint coupled and every body a body coupled model (Fig. 7); each law goes to the actor
of the joint or body that it acts on.  A rope and a force belong to the first body (not the ground) at their
ends, a support or contact to its body.  What acts on a joint or body of the lift stands in a group of its own.
"""

from __future__ import annotations

import re
from dataclasses import replace

from heavylift.kernel.description.forces import Force, Reeving
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.description.mechanics import WORLD, RigidRope, Rope, System, Threshold
from heavylift.kernel.errors import ModelError
from heavylift.nodes.models.parts.drive import DriveActor
from heavylift.nodes.models.parts.gauges import LoadCell
from heavylift.nodes.models.parts.parts import Actor, BodyCoupled, Group, JointCoupled, Law, Machine
from heavylift.nodes.models.parts.rigging import BrakeActor, JointLockActor, SlingActor, Stools
from heavylift.nodes.models.parts.winch import WinchActor
from heavylift.nodes.plan.plan import Actuator, Mechanism


class MachineModel(Machine):
    """One mechanism of the plan, or a crane made of parts."""

    def __init__(self, mechanism: Mechanism) -> None:
        super().__init__(mechanism.name)
        self.mechanism, self.system = mechanism, mechanism.system
        self.actuators = {actuator.name: actuator for actuator in mechanism.actuators}
        for joint in self.system.joints:
            actors = self._joint_actors(joint.name) or [Law("free")]
            self.take(JointCoupled(f"joint-{_name(joint.name)}", joint, *actors))
        for body in self.system.bodies:
            self.take(BodyCoupled(f"body-{_name(body.name)}", body, Law("weight"), *self._body_actors(body.name)))
        bodies, joints = self.system.outside
        for name in joints:
            self._act_on(name, self._joint_actors(name))
        for name in bodies:
            self._act_on(name, self._body_actors(name))
        for master in self.system.masters:
            self.take(self._drive(f"master-{_name(master.name)}", master.name, System(masters=(master,))))
        if measured := self.system.measured:
            self.take(Law("measured", System(measured=measured)))

    def _act_on(self, name: str, actors: list[Actor]) -> None:
        """What acts on a joint or body of the lift, if there is anything."""
        if actors:
            group = self.take(Group(f"on-{_name(name)}"))
            for actor in actors:
                group.take(actor)

    def _joint_actors(self, joint: str) -> list[Actor]:
        system, actors = self.system, list[Actor]()
        for drive in (d for d in system.drives if d.joint == joint):
            laws = System(drives=(drive,))
            name = _name(drive.name)
            actors.append(Law(name, laws) if drive.wave else self._drive(name, drive.name, laws))
        for brake in (b for b in system.brakes if b.joint == joint):
            laws = System(brakes=(brake,))
            actors.append(BrakeActor(_name(brake.name), brake.name, laws, engaged=brake.engaged))
        for lock in (x for x in system.locks if x.joint == joint):
            actors.append(JointLockActor(_name(lock.name), lock.name, System(locks=(lock,)), engaged=lock.engaged))
        actors += [Law(_name(x.name), System(springs=(x,))) for x in system.springs if x.joint == joint]
        actors += [Law(_name(x.name), System(stops=(x,))) for x in system.stops if x.joint == joint]
        actors += [Law(_name(f.name), System(forces=(f,))) for f in system.forces if f.along and f.along[0] == joint]
        return actors

    def _body_actors(self, body: str) -> list[Actor]:
        actors: list[Actor] = []
        for rope in (r for r in self.system.ropes if _body(r) == body):
            actors.append(self._rope(rope, System(ropes=(rope,))))
        for rigid in (r for r in self.system.rigid_ropes if _body(r) == body):
            actors.append(self._rope(rigid, System(rigid_ropes=(rigid,))))
        for hook in (h for h in self.mechanism.hooks if h.capacity and self._holds(h.rope) == body):
            rated = (hook.capacity + hook.block_mass) * self.system.gravity
            actors.append(LoadCell(f"{_name(hook.rope)}-load", f"{hook.rope}.load", (hook.rope,), rated))
        for force in (f for f in self.system.forces if _first(f) == body):
            laws = System(forces=(force,))
            actors.append(self._rope(force, laws) if isinstance(force, Reeving) else Law(_name(force.name), laws))
        supports = tuple(s for s in self.system.supports if s.point.body == body)
        contacts = tuple(c for c in self.system.contacts if c.a.body == body)
        if supports or contacts:
            faces = dict.fromkeys([*(s.name for s in supports), *(c.name for c in contacts)], body)
            closed = frozenset(self.mechanism.closed) & frozenset(faces)
            laws = System(supports=supports, contacts=contacts)
            stands = self.mechanism.standing(body)
            actors.append(Stools("supports", stands, laws, faces=faces, closed=closed))
        return actors

    def _rope(self, rope: Rope | RigidRope | Reeving, laws: System) -> Actor:
        if not rope.winch:
            return SlingActor(_name(rope.name), rope.name, laws)
        at, eye = self._actuator(rope.name), next((h.eye for h in self.mechanism.hooks if h.rope == rope.name), None)
        switch = None
        if at.highest is not None and eye is not None:
            guard = Threshold(f"{rope.name}.highest", "height", point=eye)
            laws, switch = replace(laws, thresholds=(guard,)), (guard, at.highest)
        return WinchActor(
            _name(rope.name), rope.name, laws, start=at.start, lower=at.lower, upper=at.upper, switch=switch,
            emergency=at.emergency,
        )  # fmt: skip

    def _holds(self, rope: str) -> str:
        """The body whose actor the rope of this name is."""
        return next(_body(r) for r in self.system.all_ropes if r.name == rope)

    def _drive(self, name: str, element: str, laws: System) -> DriveActor:
        at = self._actuator(element)
        return DriveActor(name, element, laws, start=at.start, lower=at.lower, upper=at.upper, emergency=at.emergency)

    def _actuator(self, name: str) -> Actuator:
        """Where an actuator starts and what it can do; a rope starts at its length, the rest at 0."""
        if name in self.actuators:
            return self.actuators[name]
        lengths = {rope.name: rope.L0 for rope in self.system.all_ropes}
        return Actuator(name=name, start=lengths.get(name, 0.0), accel=0.0)


def _body(rope: Rope | RigidRope | Reeving) -> str:
    """The body whose actor a rope is."""
    for line in rope.lines:
        for point in (line.a, line.b):
            if point.body != WORLD:
                return point.body
    raise ModelError(f"rope {rope.name} hangs between two points of the ground, give it a body")


def _first(force: Force) -> str:
    """The body whose actor a force is: the first one at its ends that is not the ground."""
    return next((p.body for p in force.points if p.body != WORLD), "")


def _name(element: str) -> str:
    """A name for a model, from that of a mechanical element."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", element)


def turning(system: System) -> list[str]:
    """The drives and Masters of what a machine declares whose coordinate is an angle."""
    joints = {joint.name: JOINTS[joint.kind] for joint in system.joints}
    of = ((d.name, joints[d.joint], d.coordinate) for d in system.drives)
    found = [name for name, joint, at in of if joint.turns(joint.actable.index(at) if at else 0)]
    return found + [master.name for master in system.masters]
