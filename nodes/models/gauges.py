"""Actors that measure: load cells with their own rated value, and gauges that the commander sets.

Both arm thresholds of the kernel and hear when they are reached; they generate no force.
"""

from __future__ import annotations

from heavylift.kernel.describe import System, Threshold

from .messages import Order, Overload, Reached, StateEvent, Unwatch, UnwatchOrder, Watch, WatchOrder
from .parts import LiveActor

RELIEF = 0.97  # an overload is over below this part of the rated value


class LoadCell(LiveActor):
    """Reports when the summed tension of some ropes passes `rated` [N], and when it is back below."""

    def __init__(self, name: str, element: str, ropes: tuple[str, ...], rated: float) -> None:
        guard = Threshold(element, "tension", ropes=ropes)
        super().__init__(name, element, System(thresholds=(guard,)), hears=(element,))
        self.rated = rated

    def begin(self) -> None:
        """Arm the rated value."""
        self.over = False
        self.arm()

    def notice(self, event: StateEvent) -> None:
        """Overloaded, or no more."""
        self.over = not self.over
        self.say(Overload(self.element, event.value, self.rated, self.over))
        self.arm()

    def arm(self) -> None:
        """Wait for the other state."""
        self.say(Watch(self.element, self.rated * (RELIEF if self.over else 1.0), not self.over))


class Gauge(LiveActor):
    """Watches thresholds for the commander's conditions, each of them once per order."""

    def __init__(self, name: str, thresholds: tuple[Threshold, ...]) -> None:
        super().__init__(name, name, System(thresholds=thresholds), hears=tuple(t.name for t in thresholds))

    def answers(self, element: str) -> bool:
        """Orders name the threshold."""
        return element in self.hears

    def obey(self, order: Order) -> None:
        """Arm or disarm."""
        match order:
            case WatchOrder():
                self.say(Watch(order.actor, order.value, order.rising))
            case UnwatchOrder():
                self.say(Unwatch(order.actor))
            case _:
                super().obey(order)

    def notice(self, event: StateEvent) -> None:
        """Reached."""
        self.say(Reached(event.name, event.value))
