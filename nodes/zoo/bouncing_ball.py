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
    """Message about a bounce of the ball: its number, and the speed after it [m/s]."""

    units: ClassVar[Mapping[str, str]] = {"speed": "m/s"}
    number: int
    speed: float


class FallingBall(Hybrid):
    """Hybrid model of a ball that falls from a `height` [m] and bounces with the fraction `e` [1] of its speed.

    Below 1 mm/s it rests."""

    bounce = Out(Bounce)

    def __init__(self, name: str, height: float, e: float) -> None:
        super().__init__(name)
        self.height, self.e = height, e

    def start(self) -> None:
        """Start with the ball at rest at its initial height."""
        self.bounced, self.rests = 0, False
        self.go(self.height, 0.0)

    def flow(self, x: State) -> State:
        """Return the derivatives of the ball's height [m/s] and speed [m/s2]."""
        return (0.0, 0.0) if self.rests else (x[1], -G)

    def guards(self, x: State) -> State:
        """Return the height of the ball as guard: when it falls through zero, the ball bounces."""
        return (x[0],)

    def tell(self, which: tuple[int, ...]) -> None:
        """Send a message about the bounce of the ball."""
        self.bounce.send(Bounce(self.bounced + 1, -self.e * self.ahead[1]))

    def fell(self, which: tuple[int, ...]) -> None:
        """Reverse and reduce the speed of the ball, which bounces."""
        speed = -self.e * self.state[1]
        self.bounced, self.rests = self.bounced + 1, speed < 1e-3
        self.go(0.0, 0.0 if self.rests else speed)

    def result(self) -> Bounce:
        """Return the number of bounces of the ball and its present speed [m/s]."""
        return Bounce(self.bounced, self.present[1])


def bouncing(height: float = 10.0, e: float = 0.8) -> Coupled:
    """Return a coupled model with one bouncing ball."""
    model = Coupled("room")
    model.add(FallingBall("ball", height, e))
    return model
