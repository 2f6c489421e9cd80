"""Models that run for a while, and some that do what no model should do, at a tag that is theirs."""

from __future__ import annotations

import os
import random
import signal
import time
from pathlib import Path

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, ms

NODES = ("north", "east", "south")
ROUNDS = 60


class Baton(Message):
    n: int
    mark: int


class Runner(Atomic):
    """Passes a token on after a random while, and changes it."""

    into, out = In(Baton), Out(Baton)

    def __init__(self, name: str, first: bool) -> None:
        super().__init__(name)
        self.first = first

    def start(self) -> None:
        self.random = random.Random(self.name)
        self.seen: list[int] = []
        self.token = Baton(0, 0)
        if self.first:
            self.hold_in(ms(1))

    def output(self) -> None:
        self.out.send(Baton(self.token.n + 1, self.token.mark))

    def internal(self) -> None:
        self.passivate()

    def external(self, e: int, x: Bag) -> None:
        (self.token,) = x[self.into]
        self.seen.append(self.token.mark)
        self.token = Baton(self.token.n, hash((self.token.mark, self.random.randrange(1000), len(self.seen))) % 10007)
        if self.token.n < ROUNDS:
            self.happen()
            self.hold_in(ms(self.random.randint(1, 9)))
        else:
            self.passivate()

    def result(self) -> Baton:
        return Baton(self.now.t + len(self.seen), sum(self.seen))

    def happen(self) -> None:
        """What a doomed one does."""


class Doomed(Runner):
    def happen(self) -> None:
        if self.token.n == 32:
            getattr(self, os.environ["DOOM"])()

    def crash(self) -> None:
        os.kill(os.getpid(), signal.SIGSEGV)

    def leave(self) -> None:
        os._exit(7)

    def raises(self) -> None:
        raise ValueError("the hook is not there")

    def hang(self) -> None:
        while True:
            pass

    def hang_once(self) -> None:
        flag = Path(os.environ["DOOM_FLAG"])
        if not flag.exists():
            flag.touch()
            self.hang()

    def dawdle(self) -> None:
        time.sleep(0.9)

    def look_at_the_clock(self) -> None:
        self.token = Baton(self.token.n, os.getpid() % 9973)


def ring(cls: type[Runner]) -> Coupled:
    root = Coupled("ring")
    runners = []
    for name in NODES:
        node = root.add(Coupled(name))
        runner = node.add((cls if name == "south" else Runner)("runner", name == "north"))
        into, out = node.add_in("into", Baton), node.add_out("out", Baton)
        node.connect(into, runner.into)
        node.connect(runner.out, out)
        runners.append(node)
    for a, b in zip(runners, [*runners[1:], runners[0]], strict=True):
        root.connect(a.ports["out"], b.ports["into"])
    return root


def build() -> Coupled:
    return ring(Runner)


def doomed() -> Coupled:
    return ring(Doomed)
