"""Models that reach beyond their nodes, or are not the same twice; each is a legal flat model."""

import random
import time
from dataclasses import dataclass

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out

WORDS = {"hook", "sling", "block", "crane", "lug", "pad", "rope"}
LOG: list[str] = []
TABLE = {"a": [1, 2, 3]}  # which nobody changes
FRIENDS: dict[str, Atomic] = {}
count = 0


class Note(Message):
    text: str = ""


class Ticker(Atomic):
    """Says `text` every 10 ns; `act`, by its name, is what it does before at the third."""

    out = Out(Note)
    total = 0

    def __init__(self, name: str, act: str = "rest", friend: Atomic | None = None) -> None:
        super().__init__(name)
        self.act, self.friend = act, friend

    def start(self) -> None:
        self.n, self.text = 0, "tick"
        self.hold_in(10)

    def output(self) -> None:
        self.out.send(Note(self.text))

    def internal(self) -> None:
        self.n += 1
        if self.n == 3:
            getattr(self, self.act)()
        self.hold_in(10)

    def rest(self) -> None: ...

    def look(self) -> None:
        """What may be known of others: names, paths, what is fixed of the parent."""
        self.text = f"{self.name} of {self.parent.name} {self.parent.path} {self.parent.crew} {TABLE['a']}"

    def add(self) -> None:
        self.parent.add(Ear("late"))

    def remove(self) -> None:
        self.parent.remove("ear")

    def connect(self) -> None:
        self.parent.connect(self.out, self.parent.children["spare"].ports["into"])

    def disconnect(self) -> None:
        self.parent.disconnect(*self.parent.couplings[0])

    def more_in(self) -> None:
        self.parent.add_in("job", Note)

    def more_out(self) -> None:
        self.parent.add_out("done", Note)

    def children(self) -> None:
        self.text = str(len(self.parent.children))

    def sibling(self) -> None:
        self.text = self.friend.act

    def tell_sibling(self) -> None:
        self.friend.text = "told"

    def blackboard(self) -> None:
        self.parent.crew = 4

    def board(self) -> None:
        self.parent.board.append("told")

    def registered(self) -> None:
        self.text = FRIENDS["other"].act

    def log(self) -> None:
        note(self.name)

    def tally(self) -> None:
        global count
        count += 1

    def classwide(self) -> None:
        Ticker.total += 1


def note(name: str) -> None:
    LOG.append(name)


class Ear(Atomic):
    into = In(Note)

    def external(self, e: int, x: Bag) -> None:
        self.heard = [*getattr(self, "heard", []), *(note.text for note in x[self.into])]


def yard(act: str) -> Coupled:
    root = Coupled("yard")
    root.crew, root.board = 3, []
    ear, other, _ = root.add(Ear("ear")), root.add(Ticker("other")), root.add(Ear("spare"))
    FRIENDS.clear()
    if act == "registered":
        FRIENDS["other"] = other
    for ticker in (other, root.add(Ticker("ticker", act, other))):
        root.connect(ticker.out, ear.into)
    return root


def words() -> Coupled:
    """Says first what comes first in a set."""
    root = yard("rest")
    root.remove("other")
    root.add(Teller("other"))
    root.connect(root.children["other"].out, root.children["ear"].into)
    return root


class Teller(Ticker):
    def internal(self) -> None:
        self.text = next(iter({"hook", "sling", "block", "crane", "lug", "pad", "rope"}))
        self.hold_in(10)


def random_build(what: str) -> Coupled:
    """A model that no other process builds again."""
    root = yard("rest")
    other = root.children["other"]
    if what == "attribute":
        other.weight = random.random()
    elif what == "deep":
        other.plan = {"a": [1, {"b": (random.random(),)}]}
    elif what == "generator":
        other.random = random.Random()
    elif what == "clock":
        other.born = time.time_ns()
    elif what == "numpy":
        import numpy as np

        other.random = np.random.default_rng()
    elif what == "port":
        other.add_out("more", Note, random.getrandbits(60))
    elif what == "couplings":
        root.add(Ear(f"ear{random.getrandbits(60)}"))
    elif what == "inner":
        inner = root.add(Coupled("inner"))
        inner.add(Ticker(f"t{random.getrandbits(60)}"))
    return root


ONCE = yard("rest")


def same() -> Coupled:
    return ONCE


class Relay(Atomic):
    into, out = In(Note), Out(Note)

    def __init__(self, name: str, left: int) -> None:
        super().__init__(name)
        self.left = left

    def start(self) -> None:
        if self.left:
            self.hold_in(5)

    def external(self, e: int, x: Bag) -> None:
        self.left = int(x[self.into][0].text)
        if self.left:
            self.hold_in(0)

    def output(self) -> None:
        self.out.send(Note(str(self.left - 1)))

    def internal(self) -> None:
        self.passivate()


def chain(length: int) -> Coupled:
    """A word goes to and fro so many times without a delay, and is at rest then."""
    root = Coupled("chain")
    a, b = root.add(Relay("a", length)), root.add(Relay("b", 0))
    root.connect(a.out, b.into)
    root.connect(b.out, a.into)
    return root


class Settings:
    """What is no plain data, and holds some."""

    def __init__(self, values: list[int]) -> None:
        self.values = values


@dataclass(frozen=True)
class Frozen:
    """What is fixed itself, and may refer to what is not."""

    values: object


class Counting(Ticker):
    """Writes into what it shares with others, and says what stands there."""

    def __init__(self, name: str, **shared: object) -> None:
        super().__init__(name)
        self.__dict__ |= shared

    def internal(self) -> None:
        self.values.append(len(self.values))
        seen = [self.table["values"], getattr(self, "settings", self).values, sorted(getattr(self, "words", []))]
        self.text = f"{self.values} {seen[0] is self.values} {seen[1] is self.values} {seen[2]}"
        self.hold_in(10)


def crowd(what: str, size: int = 3) -> Coupled:
    """All hold one list, by two ways; `what` else of it."""
    root, values = Coupled("yard"), [1]
    shared: dict[str, object] = {"values": values, "table": {"values": values, "a": (1, [2])}}
    more: dict[str, dict[str, object]] = {
        "settings": {"settings": Settings(values)},
        "words": {"words": {"hook", "sling"}},
        "frozen": {"settings": Frozen(values)},
        "fixed": {"fixed": Frozen((1, Frozen("hook")))},
    }
    ear = root.add(Ear("ear"))
    for i in range(size):
        root.connect(root.add(Counting(f"c{i}", **shared, **more.get(what, {}))).out, ear.into)
    return root
