"""Models of a user's own, as they lie beside a scene: one listens, others go wrong."""

from __future__ import annotations

from math import nan

from heavylift.nodes.devs import Atomic, Bag, In, Message, Out, ms, seconds
from heavylift.nodes.models import Sample, SetPoint


class Heard(Message):
    values: tuple[tuple[int, float], ...]


class Ear(Atomic):
    """Keeps all that it hears."""

    heard = In(Sample)

    def start(self) -> None:
        self.known: tuple[tuple[int, float], ...] = ()

    def external(self, e: int, x: Bag) -> None:
        self.known += tuple((self.now.t, sample.value) for sample in x[self.heard])

    def result(self) -> Heard:
        return Heard(self.known)


class Hand(Atomic):
    """Says these speeds [m/s], one after each `wait` [s]; hears something, too."""

    heard, speed = In(Sample), Out(SetPoint)

    def __init__(
        self, name: str, one: float = 0.0, two: float = 0.0, three: float = 0.0, wait: float = 1.0, wild: bool = False
    ) -> None:
        super().__init__(name)
        self.speeds, self.wait = (nan if wild else one, two, three), seconds(wait)

    def start(self) -> None:
        self.said = 0
        self.hold_in(self.wait)

    def external(self, e: int, x: Bag) -> None:
        pass

    def output(self) -> None:
        self.speed.send(SetPoint(self.speeds[self.said]))

    def internal(self) -> None:
        self.said += 1
        if self.said < len(self.speeds):
            self.hold_in(self.wait)
        else:
            self.passivate()


class Chatterbox(Hand):
    """Says more than one thing in a period."""

    def internal(self) -> None:
        self.said = 1 - self.said
        self.hold_in(ms(10))


HEARD: list[float] = []


class Gossip(Ear):
    """Tells all of its kind in a process what it hears."""

    def external(self, e: int, x: Bag) -> None:
        HEARD.append(x[self.heard][0].value)


class Clumsy(Ear):
    """Fails at what it hears at one second."""

    speed = Out(SetPoint)

    def external(self, e: int, x: Bag) -> None:
        if self.now.t >= ms(1000):
            raise ZeroDivisionError("there is no way")


def number(name: str, **parameters: float) -> int:
    return len(name)


def broken(name: str) -> Ear:
    raise KeyError("gain")
