"""Actors that measure: load cells with a rated value, an inclinometer, and gauges that the commander sets.

They arm thresholds of the kernel and receive its events; they exert no force.

An interlock stops drives and winches of its machine without the commander. It trips when a threshold of the kernel is
reached, blocks the directions that lead further, and frees them when all its thresholds are reset. A bypassed interlock
reports but blocks nothing.
"""

from math import floor, radians
from typing import cast

from heavylift.kernel.description.mechanics import System, Threshold
from heavylift.nodes.devs import Coupled, InPort, Message, Model, Out, Port
from heavylift.nodes.plan import actions as plan
from heavylift.nodes.plan.actions import BrakeOrder
from heavylift.nodes.plan.interlock import Interlock

from . import messages as m
from .drive import DriveActor
from .messages import Attitude, Order, Overload, Reached, StateEvent, Unwatch, Watch
from .parts import LiveActor, RealObject

MARK, FLUTTER = radians(30.0), radians(1.0)  # of the inclinometer
TOUCH = 1e-9  # a start this close to a mark is on it
RELIEF = 0.97  # an overload is over below this part of the rated value


class LoadCell(LiveActor):
    """Reports when the total tension of its ropes rises above `rated` [N], and when it falls below `rated` again."""

    def __init__(self, name: str, element: str, ropes: tuple[str, ...], rated: float) -> None:
        guard = Threshold(element, "tension", ropes=ropes)
        super().__init__(name, element, System(thresholds=(guard,)), hears=(element,))
        self.rated = rated

    def begin(self) -> None:
        """Start watching whether the total tension reaches the rated value."""
        self.over = False
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Report that the load cell is overloaded, or that the overload has ended."""
        self.over = not self.over
        self.say(Overload(self.element, event.value, self.rated, self.over))
        self.arm()

    def arm(self) -> None:
        """Watch the rated value of the load cell or, in an overload, the value at which the overload ends."""
        self.say(Watch(self.element, self.rated * (RELIEF if self.over else 1.0), not self.over))


class Inclinometer(LiveActor):
    """Reports when the angle of the body `element` passes a multiple of 30 degrees.

    Its lower threshold is 1 degree below a multiple, so that it does not report repeatedly at one angle."""

    def __init__(self, name: str, element: str, start: float) -> None:
        self.up, self.down = f"{element}.attitude-up", f"{element}.attitude-down"
        guards = tuple(Threshold(guard, "angle", of=element) for guard in (self.up, self.down))
        super().__init__(name, element, System(thresholds=guards), hears=(self.up, self.down))
        self.first = floor(start / MARK + TOUCH)

    def begin(self) -> None:
        """Reset the thresholds to the multiples of 30 degrees next to the start angle."""
        self.mark = self.first
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Report that the angle has passed a multiple of 30 degrees, and watch the next thresholds."""
        rising = event.name == self.up
        angle = MARK * (self.mark + 1) if rising else MARK * self.mark - FLUTTER
        self.mark += 1 if rising else -1
        self.say(Attitude(self.element, angle, rising))
        self.arm()

    def arm(self) -> None:
        """Watch the multiples of 30 degrees directly above and below the present angle."""
        self.say(Watch(self.up, MARK * (self.mark + 1), True), Watch(self.down, MARK * self.mark - FLUTTER, False))


class ThresholdWatcher(LiveActor):
    """Watches thresholds for the commander's conditions, and reports once when a watched threshold is reached."""

    def __init__(self, name: str, thresholds: tuple[Threshold, ...]) -> None:
        super().__init__(name, name, System(thresholds=thresholds), hears=tuple(t.name for t in thresholds))

    def answers(self, element: str) -> bool:
        """Return whether an order starts or ends the watch of one of this watcher's thresholds."""
        return element in self.hears

    def execute(self, order: Order) -> None:
        """Start or stop watching a threshold, as ordered."""
        match order.what:
            case plan.WatchThreshold(value=value, rising=rising):
                self.say(Watch(order.actor, value, rising))
            case plan.EndOrder():
                self.say(Unwatch(order.actor))
            case _:
                super().execute(order)

    def notice(self, event: StateEvent) -> None:
        """Report that a watched threshold was reached."""
        self.say(Reached(event.name, event.value))


class InterlockActor(LiveActor):
    """Stops the drives of its machine while a threshold of the interlock is exceeded."""

    trip = Out(m.Trip)

    def __init__(self, name: str, plan: Interlock) -> None:
        laws = System(thresholds=plan.guards)
        super().__init__(name, plan.name, laws, hears=tuple(guard.name for guard in plan.guards))
        self.plan = plan

    def begin(self) -> None:
        """Start watching all thresholds of the interlock."""
        self.beyond: frozenset[str] = frozenset()
        self.bypassed = False
        for guard in self.plan.guards:
            self._watch(guard.name)

    def execute(self, order: m.Order) -> None:
        """Bypass the interlock or activate it again."""
        if not isinstance(order.what, BrakeOrder):
            super().execute(order)
        else:
            self.bypassed = not order.what.engaged
            self.say(m.BrakeState(self.element, order.what.engaged), m.Done(self.element, order.id))
            if self.beyond:
                self.say(m.Tripped(self.element, True, self.bypassed))

    def notice(self, event: m.StateEvent) -> None:
        """Process a state event of a threshold of the interlock; report if the interlock thereby trips or resets."""
        before = bool(self.beyond)
        self.beyond = self.beyond ^ {event.name}
        self._watch(event.name)
        if before != bool(self.beyond):
            self.say(m.Tripped(self.element, bool(self.beyond), self.bypassed))

    def output(self) -> None:
        """Send the interlock's reports and kernel inputs, and inform the drives of a trip or reset."""
        super().output()
        if any(isinstance(message, m.Tripped) for message in self.outbox):
            self.trip.send(m.Trip(self.element, bool(self.beyond) and not self.bypassed))

    def _watch(self, guard: str) -> None:
        back = guard in self.beyond
        value = self.plan.resets if back else self.plan.value
        self.say(m.Watch(guard, value, self.plan.rising != back))


def fit(machine: RealObject, plan: Interlock) -> None:
    """Add an interlock to a machine, and connect the interlock to the drives that it stops."""
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
    """Return the models from below a coupled model down to the drive `element`; empty if there is none."""
    for child in model.children.values():
        if isinstance(child, DriveActor) and child.element == element:
            return [child]
        if isinstance(child, Coupled) and (below := _path(child, element)):
            return [child, *below]
    return []
