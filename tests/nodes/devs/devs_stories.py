"""Small models shared by DEVS tests: generator, relay, sink; and the log as plain tuples."""

from collections.abc import Sequence
from typing import Any

from heavylift.nodes.devs import (
    NEVER,
    Atomic,
    Bag,
    Coupled,
    In,
    Message,
    Model,
    Out,
    Port,
    Simulator,
    Tag,
    Transition,
    seconds,
)


class Item(Message):
    n: int


class Generator(Atomic):
    """Says 0, 1, 2, ... every `period` [ns], `count` times; an input ends it."""

    stop, out = In(Item), Out(Item)

    def __init__(self, name: str, period: int, first: int | None = None, count: int = 10**9) -> None:
        super().__init__(name)
        self.period, self.first, self.count = period, period if first is None else first, count

    def start(self) -> None:
        self.n = 0
        self.hold_in(self.first)

    def output(self) -> None:
        self.out.send(Item(self.n))

    def internal(self) -> None:
        self.n += 1
        self.hold_in(self.period if self.n < self.count else NEVER)

    def external(self, e: int, x: Bag) -> None:
        self.passivate()


class Relay(Atomic):
    """Says what it heard, `delay` [ns] later."""

    into, out = In(Item), Out(Item)

    def __init__(self, name: str, delay: int = 0, first: int | None = None) -> None:
        super().__init__(name)
        self.delay, self.first = delay, first

    def start(self) -> None:
        self.held: list[Item] = []
        self.elapsed: list[int] = []
        if self.first is not None:
            self.held = [Item(self.first)]
            self.hold_in(0)

    def external(self, e: int, x: Bag) -> None:
        self.elapsed.append(e)
        self.held = self.held + x[self.into]
        self.hold_in(self.delay)

    def output(self) -> None:
        for item in self.held:
            self.out.send(item)

    def internal(self) -> None:
        self.held = []
        self.passivate()


class Sink(Atomic):
    """Keeps what it hears: (tag, numbers of the bag)."""

    into = In(Item)

    def start(self) -> None:
        self.got: list[tuple[Tag, list[int]]] = []

    def external(self, e: int, x: Bag) -> None:
        self.got.append((self.now, [item.n for item in x[self.into]]))


def coupled(name: str, children: Sequence[Model], *couplings: tuple[Port[Any], Port[Any]]) -> Coupled:
    """A coupled model in one line."""
    model = Coupled(name)
    for child in children:
        model.add(child)
    for source, target in couplings:
        model.connect(source, target)
    return model


def run(model: Model, span: float) -> list[tuple[float, int, str, str]]:
    """Run over [0, seconds) and tell each transition as (t [s], microstep, path, kind)."""
    log: list[Transition] = []
    simulator = Simulator(model, log.append)
    simulator.start()
    simulator.run(seconds(span))
    return [(line.tag.t / 1e9, line.tag.k, line.path, line.kind) for line in log]


def kinds(model: Model, span: float) -> dict[str, str]:
    """For each path the first letters of its transitions, in order: {"r.a": "iec"}."""
    message: dict[str, str] = {}
    for _, _, path, kind in run(model, span):
        message[path] = message.get(path, "") + kind[0]
    return message
