"""A traffic light with an operator: it shows red, green and yellow in turn; after "manual" it blinks, until "auto"
starts it again at red.

It is a single atomic model whose phase determines how long it waits and what comes next. The elapsed time is not
needed, since an operator's command ends the phase.
"""

from enum import StrEnum

from heavylift.nodes.devs import Atomic, Bag, In, Message, Out, seconds


class Colour(StrEnum):
    """Colour of the traffic light."""

    RED = "red"
    GREEN = "green"
    YELLOW = "yellow"
    DARK = "dark"


class LightMode(StrEnum):
    """Mode of the traffic light: automatic, or operated manually."""

    AUTO = "auto"
    MANUAL = "manual"


class Take(Message):
    """Command of the operator to switch the traffic light to a mode."""

    mode: LightMode


class Show(Message):
    """Message that the light has changed to this colour."""

    colour: Colour


TURN = {Colour.RED: Colour.GREEN, Colour.GREEN: Colour.YELLOW, Colour.YELLOW: Colour.RED}
BLINK = {Colour.YELLOW: Colour.DARK, Colour.DARK: Colour.YELLOW}
LASTS = {Colour.RED: seconds(60), Colour.GREEN: seconds(50), Colour.YELLOW: seconds(10)}
BLINKS = seconds(0.5)


class Light(Atomic):
    """Atomic model of a traffic light; it sends a message with each colour when this colour begins."""

    take, show = In(Take), Out(Show)

    def start(self) -> None:
        """Start with red at time 0."""
        self.mode, self.coming = LightMode.AUTO, Colour.RED
        self.hold_in(0)

    def output(self) -> None:
        """Send the colour of the traffic light that begins now."""
        self.show.send(Show(self.coming))

    def internal(self) -> None:
        """Keep the new colour of the traffic light for its duration."""
        shown = self.coming
        if self.mode == LightMode.AUTO:
            self.coming = TURN[shown]
            self.hold_in(LASTS[shown])
        else:
            self.coming = BLINK[shown]
            self.hold_in(BLINKS)

    def external(self, e: int, x: Bag) -> None:
        """Handle a command of the operator to the traffic light."""
        mode = x[self.take][-1].mode
        if mode != self.mode:
            self.mode, self.coming = mode, Colour.RED if mode == LightMode.AUTO else Colour.YELLOW
            self.hold_in(0)
