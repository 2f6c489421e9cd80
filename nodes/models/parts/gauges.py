"""Actors that measure: load cells with a rated value, an inclinometer, and gauges that the commander sets.

They arm thresholds of the kernel and hear when they are reached; they generate no force.
"""

from __future__ import annotations

from math import floor, radians

from heavylift.kernel.description.mechanics import System, Threshold
from heavylift.nodes.plan import actions as plan

from .messages import Attitude, Order, Overload, Reached, StateEvent, Unwatch, Watch
from .parts import LiveActor

MARK, FLUTTER = radians(30.0), radians(1.0)  # of the inclinometer
TOUCH = 1e-9  # a start this close to a mark is on it
RELIEF = 0.97  # an overload is over below this part of the rated value


class LoadCell(LiveActor):
    """Reports when the total tension of ropes exceeds `rated` [N], and when it is below again."""

    def __init__(self, name: str, element: str, ropes: tuple[str, ...], rated: float) -> None:
        guard = Threshold(element, "tension", ropes=ropes)
        super().__init__(name, element, System(thresholds=(guard,)), hears=(element,))
        self.rated = rated

    def begin(self) -> None:
        """Arm the rated value."""
        self.over = False
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Overload or its end."""
        self.over = not self.over
        self.say(Overload(self.element, event.value, self.rated, self.over))
        self.arm()

    def arm(self) -> None:
        """Wait for the other state."""
        self.say(Watch(self.element, self.rated * (RELIEF if self.over else 1.0), not self.over))


class Inclinometer(LiveActor):
    """Reports when the angle of the body `element` passes a multiple of 30 degrees.

    Armed are always the next mark above and, a degree lower so that it does not flutter, the last one below.
    """

    def __init__(self, name: str, element: str, start: float) -> None:
        self.up, self.down = f"{element}.attitude-up", f"{element}.attitude-down"
        guards = tuple(Threshold(guard, "angle", of=element) for guard in (self.up, self.down))
        super().__init__(name, element, System(thresholds=guards), hears=(self.up, self.down))
        self.first = floor(start / MARK + TOUCH)

    def begin(self) -> None:
        """Between two marks."""
        self.mark = self.first
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Move on by one mark."""
        rising = event.name == self.up
        angle = MARK * (self.mark + 1) if rising else MARK * self.mark - FLUTTER
        self.mark += 1 if rising else -1
        self.say(Attitude(self.element, angle, rising))
        self.arm()

    def arm(self) -> None:
        """Wait for the marks above and below."""
        self.say(Watch(self.up, MARK * (self.mark + 1), True), Watch(self.down, MARK * self.mark - FLUTTER, False))


class ThresholdWatcher(LiveActor):
    """Watches thresholds of the commander's conditions, each once per order."""

    def __init__(self, name: str, thresholds: tuple[Threshold, ...]) -> None:
        super().__init__(name, name, System(thresholds=thresholds), hears=tuple(t.name for t in thresholds))

    def answers(self, element: str) -> bool:
        """Orders name the threshold."""
        return element in self.hears

    def execute(self, order: Order) -> None:
        """Arm or disarm."""
        match order.what:
            case plan.WatchThreshold(value=value, rising=rising):
                self.say(Watch(order.actor, value, rising))
            case plan.EndOrder():
                self.say(Unwatch(order.actor))
            case _:
                super().execute(order)

    def notice(self, event: StateEvent) -> None:
        """Reached."""
        self.say(Reached(event.name, event.value))
