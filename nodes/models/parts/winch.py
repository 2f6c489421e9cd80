"""Winches: drives that wind ropes, with their upper limit switches, and those that keep a tugger line at a tension."""

from collections.abc import Mapping

from heavylift.kernel.description.mechanics import System, Threshold
from heavylift.nodes.plan.actions import UnhookSling

from . import messages as m
from .drive import DriveActor

SWITCH_BACK = 0.1  # an upper limit switch closes again this far below [m]
UPPER, HOISTING = "upper limit", -1
SLACK = "no tension", "no tension"


class TuggerActor(DriveActor):
    """Actor of a tugger line with a winch that takes orders: its coordinate is the tension [N]."""

    def execute(self, order: m.Order) -> None:
        """Change the tension of the line, or release the line."""
        if isinstance(order.what, UnhookSling):
            self.say(m.Unhook(self.element), m.Unhooked(self.element), m.Done(self.element, order.id))
        else:
            super().execute(order)


class WinchActor(DriveActor):
    """Actor of a winch: moves its rope, reports when the rope is taut or slack, and stops at an upper limit switch.

    `switch`: threshold on the height of the hook eye and the value at which it trips; hoisting then stops, with the
    deceleration `emergency` if given. A rope in several `pieces` (names with their shares of its length) is wound as
    one rope.
    """

    def __init__(
        self,
        name: str,
        rope: str,
        laws: System | None = None,
        *,
        start: float,
        lower: float | None = None,
        upper: float | None = None,
        switch: tuple[Threshold, float] | None = None,
        pieces: Mapping[str, float] | None = None,
        emergency: float | None = None,
    ) -> None:
        guards = (switch[0],) if switch else ()
        laws = laws or System(thresholds=guards)
        hears = (rope, *(guard.name for guard in guards))
        limits = ("shortest rope", "drum empty")
        super().__init__(
            name, rope, laws, start=start, lower=lower, upper=upper, limits=limits, hears=hears, emergency=emergency
        )
        self.switch, self.pieces = switch, pieces or {rope: 1.0}

    def begin(self) -> None:
        """Reset the winch to rest, and arm its upper limit switch."""
        super().begin()
        self.tripped = False
        self._arm()

    def say(self, *messages: m.KernelInput | m.Report) -> None:
        """Put messages into the winch's outbox; a speed profile becomes one message for each piece of the rope."""
        for message in messages:
            if isinstance(message, m.SetProfile | m.SetFollow):
                super().say(*(message.part(*piece) for piece in self.pieces.items()))
            else:
                super().say(message)

    def notice(self, event: m.StateEvent) -> None:
        """Process a state event of the winch's rope or upper limit switch."""
        if event.name == self.element:
            if event.what in ("taut", "slack"):
                self.say(m.RopeState(self.element, event.what, event.value))
            return
        self.tripped = not self.tripped
        self._arm()
        if not self.tripped:
            self.barred.pop(UPPER)
        elif self.job is not None and not self.halting:
            self.barred[UPPER] = HOISTING
            self.stop(UPPER, self.emergency)
        else:
            self.barred[UPPER] = HOISTING
            self.say(m.Limit(self.element, UPPER, self.reference()[0]))

    def _arm(self) -> None:
        if self.switch is not None:
            guard, height = self.switch
            self.say(m.Watch(guard.name, height - SWITCH_BACK * self.tripped, not self.tripped))
