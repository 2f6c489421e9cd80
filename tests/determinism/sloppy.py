"""Models that depend on an execution condition, one for each condition."""

from __future__ import annotations

from itertools import count

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out

NUMBERS = (n for n in count())  # shared by all models of a process; no check looks into a generator


class Word(Message):
    text: str


class Careful(Atomic):
    """Says its next number at each tick, and says again what it hears."""

    into, out = In(Word), Out(Word)

    def start(self) -> None:
        self.word = Word("")
        self.n = 0
        self.hold_in(5)

    def next(self, heard: list[str]) -> str:
        self.n += 1
        return f"{self.n} {sorted(heard)}"[:60]

    def output(self) -> None:
        self.out.send(self.word)

    def internal(self) -> None:
        self.word = Word(self.next([]))
        self.hold_in(10)

    def external(self, e: int, x: Bag) -> None:
        self.word = Word(self.next([word.text for word in x[self.into]]))
        self.hold_in(10)


class Hashing(Careful):
    """Takes what it hears in the order of a set of strings."""

    def next(self, heard: list[str]) -> str:
        return " ".join({f"{self.name}{i}" for i in range(8)})[:60]


class Sharing(Careful):
    """Counts with a number that it shares with whoever lives in its process."""

    def next(self, heard: list[str]) -> str:
        return str(next(NUMBERS))


def group(kind: str) -> Coupled:
    """Five of a kind in a ring, all of which speak and hear at the same tags."""
    model = Coupled("group")
    kinds = {"careful": Careful, "hashing": Hashing, "sharing": Sharing}
    members = [model.add(kinds[kind](f"m{i}")) for i in range(5)]
    for i, member in enumerate(members):
        model.connect(member.out, members[(i + 1) % 5].into)
    return model
