"""Interlocks in the plan: the thresholds at which they trip, and the actuators that they stop."""

import msgspec
from heavylift.kernel.description.findings import State
from heavylift.kernel.description.mechanics import Threshold
from heavylift.recordings.format.spellings import driven

from .actions import Item


class BarredActuator(Item, frozen=True, kw_only=True):
    """An actuator that an interlock stops, and the direction that is blocked: 1, -1, or 0 for both.

    `emergency`: deceleration of the stop [m/s2 or rad/s2] (None: that of the move)."""

    actuator: str
    way: int = 0
    emergency: float | None = None


class Interlock(Item, frozen=True, kw_only=True):
    """An interlock: trips when a measured quantity reaches a value, resets when all quantities are back in range.

    If `rising`, it trips when any of the guards reaches `value` from below, and resets when all guards are below
    `resets`; if not `rising`, above and below are exchanged.

    `machine`: the model that has it; `text`: its condition in words; `tells`: text put before its message.
    """

    name: str
    machine: str
    guards: tuple[Threshold, ...]
    value: float
    resets: float
    rising: bool
    stops: tuple[BarredActuator, ...] = ()
    unit: str | None = None  # of the value; None: it is on no record
    text: str = ""
    tells: str = ""
    hooks: tuple[str, ...] = msgspec.field(default_factory=tuple)
    """Hook ropes whose load or chart this interlock watches: overloads of these hooks do not make a scene invalid."""

    def message(self, bypassed: bool = False) -> tuple[State, str]:
        """Return the state of the check of an interlock, and the sentence about its trip."""
        did = "would have stopped, had it not been bypassed," if bypassed else "stopped"
        names = ", ".join(dict.fromkeys(driven(stopped.actuator) for stopped in self.stops))
        sentence = f"the interlock {self.name} {did} {names}: {self.text}" if self.stops else self.text
        return ("red" if self.stops else "none"), f"{self.tells}: {sentence}" if self.tells else sentence
