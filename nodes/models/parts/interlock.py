"""An interlock: stops drives and winches of its machine by itself, without the commander.

It trips when a guard of the kernel is reached, blocks the directions that lead further, and frees them when all guards
are back. Bypassed, it reports but blocks nothing.
"""

from __future__ import annotations

from typing import cast

from heavylift.kernel.description.mechanics import System
from heavylift.nodes.devs import Coupled, InPort, Message, Model, Out, Port
from heavylift.nodes.plan.actions import BrakeOrder
from heavylift.nodes.plan.interlock import Interlock

from . import messages as m
from .drive import DriveActor
from .parts import LiveActor, RealObject


class InterlockActor(LiveActor):
    """An interlock of the plan."""

    trip = Out(m.Trip)

    def __init__(self, name: str, plan: Interlock) -> None:
        laws = System(thresholds=plan.guards)
        super().__init__(name, plan.name, laws, hears=tuple(guard.name for guard in plan.guards))
        self.plan = plan

    def begin(self) -> None:
        """Watch all guards."""
        self.beyond: frozenset[str] = frozenset()
        self.bypassed = False
        for guard in self.plan.guards:
            self._watch(guard.name)

    def execute(self, order: m.Order) -> None:
        """Bypass the interlock or make it active."""
        if not isinstance(order.what, BrakeOrder):
            super().execute(order)
        else:
            self.bypassed = not order.what.engaged
            self.say(m.BrakeState(self.element, order.what.engaged), m.Done(self.element, order.id))
            if self.beyond:
                self.say(m.Tripped(self.element, True, self.bypassed))

    def notice(self, event: m.StateEvent) -> None:
        """Register that a guard was reached or is back, and report a trip or reset."""
        before = bool(self.beyond)
        self.beyond = self.beyond ^ {event.name}
        self._watch(event.name)
        if before != bool(self.beyond):
            self.say(m.Tripped(self.element, bool(self.beyond), self.bypassed))

    def output(self) -> None:
        """Send reports and kernel inputs, and a trip to the drives."""
        super().output()
        if any(isinstance(message, m.Tripped) for message in self.outbox):
            self.trip.send(m.Trip(self.element, bool(self.beyond) and not self.bypassed))

    def _watch(self, guard: str) -> None:
        back = guard in self.beyond
        value = self.plan.resets if back else self.plan.value
        self.say(m.Watch(guard, value, self.plan.rising != back))


def fit(machine: RealObject, plan: Interlock) -> None:
    """Build an interlock into a machine, connected to the drives that it stops."""
    actor = machine.take(InterlockActor(f"interlock-{plan.name.rpartition('.')[2]}", plan))
    for stopped in plan.stops:
        outer: Coupled = machine
        source: Port[Message] = actor.trip
        for child in _path(machine, stopped.actuator):
            port = child.ports.get("trip") or child.add_in("trip", m.Trip)
            if (source, port) not in outer.couplings:
                outer.connect(source, port)
            if isinstance(child, DriveActor):
                child.stops[plan.name], child.trip = stopped, cast(InPort[m.Trip], port)
            elif isinstance(child, Coupled):
                outer, source = child, port


def _path(model: Coupled, element: str) -> list[Model]:
    """Return the path from a coupled model to the drive of an element; empty if there is none."""
    for child in model.children.values():
        if isinstance(child, DriveActor) and child.element == element:
            return [child]
        if isinstance(child, Coupled) and (below := _path(child, element)):
            return [child, *below]
    return []
