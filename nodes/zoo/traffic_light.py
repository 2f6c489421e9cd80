"""A traffic light with an operator: red, green, yellow in turn; "manual" blinks until "auto" starts it at red again.

One atomic whose phase determines how long it waits and what comes next; the elapsed time is not needed, since taking
over the light ends the phase.
"""

from enum import StrEnum

from heavylift.nodes.devs import Atomic, Bag, In, Message, Out, seconds


class Colour(StrEnum):
    """Colour of the light."""

    RED = "red"
    GREEN = "green"
    YELLOW = "yellow"
    DARK = "dark"


class LightMode(StrEnum):
    """How the light is run: automatically or by the operator."""

    AUTO = "auto"
    MANUAL = "manual"


class Take(Message):
    """A command of the operator."""

    mode: LightMode


class Show(Message):
    """The light has changed."""

    colour: Colour


TURN = {Colour.RED: Colour.GREEN, Colour.GREEN: Colour.YELLOW, Colour.YELLOW: Colour.RED}
BLINK = {Colour.YELLOW: Colour.DARK, Colour.DARK: Colour.YELLOW}
LASTS = {Colour.RED: seconds(60), Colour.GREEN: seconds(50), Colour.YELLOW: seconds(10)}
BLINKS = seconds(0.5)


class Light(Atomic):
    """Sends each colour when it begins."""

    take, show = In(Take), Out(Show)

    def start(self) -> None:
        """Start with red at time 0."""
        self.mode, self.coming = LightMode.AUTO, Colour.RED
        self.hold_in(0)

    def output(self) -> None:
        """Send the colour that begins."""
        self.show.send(Show(self.coming))

    def internal(self) -> None:
        """Wait for the duration of this colour."""
        shown = self.coming
        if self.mode == LightMode.AUTO:
            self.coming = TURN[shown]
            self.hold_in(LASTS[shown])
        else:
            self.coming = BLINK[shown]
            self.hold_in(BLINKS)

    def external(self, e: int, x: Bag) -> None:
        """Handle a command of the operator."""
        mode = x[self.take][-1].mode
        if mode != self.mode:
            self.mode, self.coming = mode, Colour.RED if mode == LightMode.AUTO else Colour.YELLOW
            self.hold_in(0)
