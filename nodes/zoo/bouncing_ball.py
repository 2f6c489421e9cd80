"""A bouncing ball: each bounce reduces its speed, until it rests; a hybrid atomic model with one guard function.

Bounce n occurs at T (1 + 2 (e + e^2 + ... + e^(n-1))) with T = sqrt(2 height / g), where e is the fraction of the speed
that a bounce keeps; the bounces accumulate at T (1 + e) / (1 - e).
"""

from collections.abc import Mapping
from typing import ClassVar

from heavylift.nodes.devs import Coupled, Message, Out
from heavylift.nodes.devs.hybrid import Hybrid, State

G = 9.81  # [m/s2]


class Bounce(Message):
    """Message about a bounce: its number, and the speed after it [m/s]."""

    units: ClassVar[Mapping[str, str]] = {"speed": "m/s"}
    number: int
    speed: float


class FallingBall(Hybrid):
    """A ball that falls from a `height` [m]; a bounce keeps the fraction `e` [1] of its speed; below 1 mm/s it
    rests."""

    bounce = Out(Bounce)

    def __init__(self, name: str, height: float, e: float) -> None:
        super().__init__(name)
        self.height, self.e = height, e

    def start(self) -> None:
        """Start at rest at the initial height."""
        self.bounced, self.rests = 0, False
        self.go(self.height, 0.0)

    def flow(self, x: State) -> State:
        """Return the derivatives of height [m/s] and speed [m/s2]."""
        return (0.0, 0.0) if self.rests else (x[1], -G)

    def guards(self, x: State) -> State:
        """Return the height, whose fall through zero is a bounce."""
        return (x[0],)

    def tell(self, which: tuple[int, ...]) -> None:
        """Send a message about the bounce."""
        self.bounce.send(Bounce(self.bounced + 1, -self.e * self.ahead[1]))

    def fell(self, which: tuple[int, ...]) -> None:
        """Reverse and reduce the speed of the ball."""
        speed = -self.e * self.state[1]
        self.bounced, self.rests = self.bounced + 1, speed < 1e-3
        self.go(0.0, 0.0 if self.rests else speed)

    def result(self) -> Bounce:
        """Return the number of bounces and the present speed [m/s]."""
        return Bounce(self.bounced, self.present[1])


def bouncing(height: float = 10.0, e: float = 0.8) -> Coupled:
    """Return a model with one ball."""
    model = Coupled("room")
    model.add(FallingBall("ball", height, e))
    return model
