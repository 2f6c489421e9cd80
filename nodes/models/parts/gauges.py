"""Actors that measure: load cells with a rated value, an inclinometer, and gauges that the commander sets.

They arm thresholds of the kernel and receive its events; they exert no force.
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
    """Reports when the total tension of ropes exceeds `rated` [N], and when it has fallen below it again."""

    def __init__(self, name: str, element: str, ropes: tuple[str, ...], rated: float) -> None:
        guard = Threshold(element, "tension", ropes=ropes)
        super().__init__(name, element, System(thresholds=(guard,)), hears=(element,))
        self.rated = rated

    def begin(self) -> None:
        """Arm the rated value."""
        self.over = False
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Report an overload or its end."""
        self.over = not self.over
        self.say(Overload(self.element, event.value, self.rated, self.over))
        self.arm()

    def arm(self) -> None:
        """Arm the threshold of the opposite state."""
        self.say(Watch(self.element, self.rated * (RELIEF if self.over else 1.0), not self.over))


class Inclinometer(LiveActor):
    """Reports when the angle of the body `element` passes a multiple of 30 degrees. The next mark above is armed, and
    the last one below, lowered by a degree so that it does not chatter."""

    def __init__(self, name: str, element: str, start: float) -> None:
        self.up, self.down = f"{element}.attitude-up", f"{element}.attitude-down"
        guards = tuple(Threshold(guard, "angle", of=element) for guard in (self.up, self.down))
        super().__init__(name, element, System(thresholds=guards), hears=(self.up, self.down))
        self.first = floor(start / MARK + TOUCH)

    def begin(self) -> None:
        """Reset to the marks around the start angle."""
        self.mark = self.first
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Report the mark, and move on to the next one."""
        rising = event.name == self.up
        angle = MARK * (self.mark + 1) if rising else MARK * self.mark - FLUTTER
        self.mark += 1 if rising else -1
        self.say(Attitude(self.element, angle, rising))
        self.arm()

    def arm(self) -> None:
        """Arm the marks above and below."""
        self.say(Watch(self.up, MARK * (self.mark + 1), True), Watch(self.down, MARK * self.mark - FLUTTER, False))


class ThresholdWatcher(LiveActor):
    """Watches the thresholds of the commander's conditions, each once per order."""

    def __init__(self, name: str, thresholds: tuple[Threshold, ...]) -> None:
        super().__init__(name, name, System(thresholds=thresholds), hears=tuple(t.name for t in thresholds))

    def answers(self, element: str) -> bool:
        """Return whether the order is for one of its thresholds."""
        return element in self.hears

    def execute(self, order: Order) -> None:
        """Arm or disarm a threshold."""
        match order.what:
            case plan.WatchThreshold(value=value, rising=rising):
                self.say(Watch(order.actor, value, rising))
            case plan.EndOrder():
                self.say(Unwatch(order.actor))
            case _:
                super().execute(order)

    def notice(self, event: StateEvent) -> None:
        """Report that a threshold was reached."""
        self.say(Reached(event.name, event.value))
