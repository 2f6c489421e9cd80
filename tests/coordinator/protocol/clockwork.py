"""A model that speaks at given times, and messages of its own making, for tests of the protocol message by message."""

from collections.abc import Sequence

from heavylift.coordinator.protocol import Coupling, Hello, Node
from heavylift.nodes.devs import FOREVER, Atomic, Bag, Event, In, Message, Out, Simulator, Tag, encode as encode_value


class Word(Message):
    n: int


class Clockwork(Atomic):
    """Says n at the n-th of its times [ns], and what it hears again `delay` [ns] later."""

    into, out, last = In(Word), Out(Word), Out(Word)

    def __init__(self, name: str, times: Sequence[int] = (), delay: int | None = None) -> None:
        super().__init__(name)
        self.times, self.delay = times, delay

    def start(self) -> None:
        self.n, self.heard = 0, list[tuple[Tag, int]]()
        self.again = 0
        self.plan(-1)

    def plan(self, t: int) -> None:
        if self.n < len(self.times):
            self.hold_in(self.times[self.n] - max(t, 0))
        else:
            self.passivate()

    def output(self) -> None:
        if self.again:
            self.out.send(Word(self.again))
        else:
            self.out.send(Word(self.n))
            if self.n == len(self.times) - 1:
                self.last.send(Word(self.n))

    def internal(self) -> None:
        if not self.again:
            self.n += 1
        self.again = 0
        self.plan(self.now.t)

    def external(self, e: int, x: Bag) -> None:
        self.heard += [(self.now, word.n) for word in x[self.into]]
        if self.delay is not None:
            self.again = 100
            self.hold_in(self.delay)


def event(t: int, source: str = "a", n: int = 0, k: int = 0, port: str = "out") -> Event:
    return Event(t, k, source, port, 0, "Word", encode_value(Word(n)))


def hello(t: int, offer: Sequence[Event] = (), **lookahead: int) -> Hello:
    """With the lookaheads of models on their port `out`."""
    quiet = Tag(t) if offer or t == FOREVER.t else Tag(t, 1)
    return Hello(Tag(t), list(offer), quiet, {f"{model}.out": ahead for model, ahead in lookahead.items()})


PAIR = [Coupling("a", "out", "b", "into"), Coupling("b", "out", "a", "into")]


def started(*models: Clockwork) -> list[Node]:
    """Each hears of `b`, and others of all that it says."""
    text = [("a", port, "b", "into") for port in ("out", "last")]
    return [Node(m.name, Simulator(m, wires=[("b", "out", "a", "into"), *text])) for m in models]
