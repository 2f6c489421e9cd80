"""A node that takes its time, and one that could go on but for it."""

import time

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, ms

TICKS, PAUSE_s = 20, 0.005


class Beat(Message):
    """One beat."""


class Slow(Atomic):
    out = Out(Beat)

    def start(self) -> None:
        self.hold_in(ms(10))

    def output(self) -> None:
        self.out.send(Beat())

    def internal(self) -> None:
        time.sleep(PAUSE_s)
        self.hold_in(ms(10))


class Quick(Atomic):
    into = In(Beat)

    def start(self) -> None:
        self.hold_in(ms(3))

    def external(self, e: int, x: Bag) -> None:
        pass

    def internal(self) -> None:
        self.hold_in(ms(3))


def pair() -> Coupled:
    model = Coupled("pair")
    slow, quick = model.add(Slow("slow")), model.add(Quick("quick"))
    model.connect(slow.out, quick.into)
    return model
