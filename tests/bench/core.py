"""Time of one decision of the coordinator alone: DONE received, commits, floor, next GRANTs; no node, no transport.

    python tests/bench/core.py [--json] [--short]

CPU time of this thread, the best of several runs.  Nodes are played by the bench: in `silent` one node at a time has an
internal event, in `token` one token goes around (two GRANTs a hop), in `talk` each node speaks at times of its own.
Target: 15 us at 32 nodes with one imminent node.  `ports`: GRANTs that a ring of 8 needs when a quick port beside the
slow one of the ring reports to an observer, with a lookahead of its own for each port and with the least for all.
"""

import sys
import time
from pathlib import Path
from random import Random

from heavylift.coordinator.protocol import Coordinator, Grant, GrantDone, Hello, Node
from heavylift.nodes.devs import FOREVER, Atomic, Bag, Event, In, Message, Out, Simulator, Tag
from shared.rows import SHORT, options, row

sys.path.insert(0, str(Path(__file__).parents[1]))
from in_memory import run_in_memory

REPEATS, ROUNDS, NODES, SPAN = (1, 100, (8, 32), 2_000) if SHORT else (5, 1500, (8, 32, 128), 20_000)
TARGET_us = 15.0
SHAPES = (("ring", "silent"), ("ring", "token"), ("ring", "talk"), ("star", "silent"), ("star", "talk"))


def couplings(shape: str, names: list[str]) -> list[tuple[str, str, str, str]]:
    """Once around, or from the first to all others and back."""
    if shape == "ring":
        return [(a, "o", b, "i") for a, b in zip(names, [*names[1:], names[0]], strict=True)]
    hub, *leaves = names
    return [distance for leaf in leaves for distance in ((hub, "o", leaf, "i"), (leaf, "o", hub, "i"))]


def future(name: str, t: int, speaks: bool) -> tuple[Tag, list[Event], Tag]:
    """Next tag, offer, quiet of a node that is due at t [ns]."""
    if t == FOREVER.t:
        return FOREVER, [], FOREVER
    return Tag(t), [Event(t, 0, name, "o", 0, "X", b"")] if speaks else [], Tag(t, 0 if speaks else 1)


def decision(shape: str, kind: str, n: int) -> float:
    """Microseconds of one `done` and the `ready` after it."""
    random, names = Random(1), [f"n{i:03d}" for i in range(n)]
    core = Coordinator(names, couplings(shape, names))
    due = dict(zip(names, random.sample(range(1, 1000 * n), n), strict=True))
    if kind == "token":
        due = {name: 5 if name == names[0] else FOREVER.t for name in names}
    for name in names:
        core.hello(name, Hello(*future(name, due[name], kind != "silent")))
    grants, spent = core.ready(), 0
    for _ in range(ROUNDS):
        name, grant = grants.pop(0)
        if kind == "token":
            due[name] = FOREVER.t if grant.committed else grant.inputs[0].t + 7
        elif grant.committed or (kind == "silent" and Tag(due[name]) < grant.until):
            due[name] += random.randrange(500 * n, 1500 * n)
        done = answer(name, grant, due[name], kind != "silent")
        began = time.thread_time_ns()
        core.done(name, done)
        grants += core.ready()
        spent += time.thread_time_ns() - began
    return spent / ROUNDS / 1e3


def answer(name: str, grant: Grant, t: int, speaks: bool) -> GrantDone:
    next_, offer, quiet = future(name, t, speaks)
    return GrantDone(grant.gseq, min(grant.until, next_), [], next_, offer, quiet, b"")


class Number(Message):
    n: int


class Station(Atomic):
    """Passes numbers on after 50 ns by the slow port, and reports each of them at once by the quick one."""

    into, slow, quick = In(Number), Out(Number, lookahead=50), Out(Number)

    def __init__(self, name: str, seed: int, quick: bool) -> None:
        super().__init__(name)
        self.seed, self.slow.lookahead = seed, 50 if quick else 0

    def start(self) -> None:
        self.random, self.due, self.news = Random(self.seed), [self.seed], False
        self.hold_in(self.seed)

    def external(self, e: int, x: Bag) -> None:
        self.due = sorted([*self.due, *(self.now.t + 50 + self.random.randrange(50) for _ in x[self.into])])
        self.news = True
        self.hold_in(0)

    def output(self) -> None:
        (self.quick if self.news else self.slow).send(Number(1))

    def internal(self) -> None:
        self.due, self.news = self.due if self.news else self.due[1:], False
        if self.due:
            self.hold_in(max(self.due[0] - self.now.t, 50))
        else:
            self.passivate()


def grants_of(by_port: bool) -> int:
    """GRANTs of a ring of 8 with 8 numbers over SPAN [ns] of its time."""
    names = [f"s{i}" for i in range(8)]
    distances = [(a, "slow", b, "into") for a, b in zip(names, [*names[1:], names[0]], strict=True)]
    wires = [*distances, *((name, "quick", "z", "into") for name in names)]
    core = Coordinator([*names, "z"], wires, Tag(SPAN))
    nodes = [Node(name, Simulator(Station(name, i + 1, by_port), wires=wires)) for i, name in enumerate(names)]
    run_in_memory(core, [*nodes, Node("z", Simulator(Sink("z"), wires=wires))])
    return sum(node.gseq for node in core._by_rank)


class Sink(Atomic):
    into = In(Number)

    def external(self, e: int, x: Bag) -> None:
        self.passivate()


def main() -> None:
    options(__doc__ or "")
    for shape, kind in SHAPES:
        for n in NODES:
            value = min(decision(shape, kind, n) for _ in range(REPEATS))
            target = TARGET_us if n == 32 and kind == "silent" else None
            row(f"decision, {shape} of {n}, {kind}", value, "us", at_most=target)
    row("grants, lookahead of each port", grants_of(True), "", "least lookahead of all ports", grants_of(False))


if __name__ == "__main__":
    main()
