"""Models distributed by tests/bench/sync.py: clocks in turn, a full round, the ring workload, a queue."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b
from math import log
from random import Random

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, OutPort, seconds

GAP = 1_000_000  # [ns] mean time between the ticks of a station of the ring workload
SPREAD = 3  # every third event of a station is passed on


class Text(Message):
    text: str


class Job(Message):
    n: int


class Clock(Atomic):
    """Ticks every `period` [ns], first after `phase`; says `text` at each tick unless it is empty."""

    into, out = In(Text), Out(Text)

    def __init__(self, name: str, phase: int, period: int, text: str) -> None:
        super().__init__(name)
        self.phase, self.period, self.text = phase, period, text

    def start(self) -> None:
        self.heard = 0
        self.hold_in(self.phase)

    def output(self) -> None:
        if self.text:
            self.out.send(Text(self.text))

    def internal(self) -> None:
        self.hold_in(self.period)

    def external(self, e: int, x: Bag) -> None:
        self.heard += len(x[self.into])


def ring(name: str, clocks: list[Clock]) -> Coupled:
    model = Coupled(name)
    for clock in clocks:
        model.add(clock)
    for i, clock in enumerate(clocks):
        model.connect(clock.out, clocks[(i + 1) % len(clocks)].into)
    return model


def turns(n: int) -> Coupled:
    """Clocks that tick in turn and might speak: at each decision exactly one of n nodes is imminent."""
    return ring("turns", [Clock(f"n{i}", 1000 * (i + 1), 1000 * n, "") for i in range(n)])


def rounds(n: int, size: int) -> Coupled:
    """Clocks that tick together and say `size` characters to their neighbour: each grant is confluent."""
    return ring("rounds", [Clock(f"n{i}", 1000, 1000, "x" * size) for i in range(n)])


class Station(Atomic):
    """Ticks at random gaps of mean GAP; a tick or an arrival is an event, every third one goes into a free slot."""

    into = In(Job)

    def __init__(self, name: str, slots: int) -> None:
        super().__init__(name)
        self.slots: list[OutPort[Job]] = [self.add_out(f"slot{i}", Job) for i in range(slots)]

    def start(self) -> None:
        self.events, self.sent, self.due = 0, 0, 0
        self.passing = False
        self.hold_in(self.gap())

    def gap(self) -> int:
        """Exponential, from the station's name and its number of events."""
        seed = int.from_bytes(blake2b(f"{self.path} {self.events}".encode(), digest_size=6).digest(), "little")
        wait = 1 + int(-GAP * log((seed + 1) / 2**48))
        self.due = self.now.t + wait
        return wait

    def output(self) -> None:
        if self.passing:
            self.slots[self.sent % len(self.slots)].send(Job(self.events))

    def internal(self) -> None:
        if self.passing:
            self.passing, self.sent = False, self.sent + 1
            self.hold_in(self.due - self.now.t)
        else:
            self.events += 1
            gap = self.gap()
            self.passing = self.events % SPREAD == 0
            self.hold_in(0 if self.passing else gap)

    def external(self, e: int, x: Bag) -> None:
        for _ in x[self.into]:
            self.events += 1
            self.passing |= self.events % SPREAD == 0
        self.hold_in(0 if self.passing else self.due - self.now.t)


class Slot(Atomic):
    """Holds one job for the lookahead, then passes it on."""

    into = In(Job)

    def __init__(self, name: str, lookahead: int) -> None:
        super().__init__(name)
        self.hold = lookahead
        self.out = self.add_out("done", Job, lookahead)

    def start(self) -> None:
        self.job: Job | None = None

    def external(self, e: int, x: Bag) -> None:
        if self.job is not None:
            raise RuntimeError("a job came into a slot that is not free: give the station more slots")
        (self.job,) = x[self.into]
        self.hold_in(self.hold)

    def output(self) -> None:
        assert self.job is not None
        self.out.send(self.job)

    def internal(self) -> None:
        self.job = None
        self.passivate()


def workload(n: int, gaps: int) -> Coupled:
    """Stations in a ring, each a node of a station and its slots; the lookahead is so many mean gaps."""
    model = Coupled("workload")
    members = []
    for i in range(n):
        member = model.add(Coupled(f"n{i}"))
        station = member.add(Station("station", 16 + 2 * gaps))
        into, out = member.add_in("into", Job), member.add_out("out", Job)
        member.connect(into, station.into)
        for k, slot in enumerate(_slots(member, station, gaps * GAP)):
            member.connect(station.slots[k], slot.into)
            member.connect(slot.out, out)
        members.append((into, out))
    for i, (_, out) in enumerate(members):
        model.connect(out, members[(i + 1) % n][0])
    return model


def _slots(member: Coupled, station: Station, lookahead: int) -> Iterator[Slot]:
    for k in range(len(station.slots)):
        yield member.add(Slot(f"slot{k}", lookahead))


class Source(Atomic):
    """Customers at exponential gaps."""

    out = Out(Job)

    def start(self) -> None:
        self.random, self.n = Random(1), 0
        self.wait()

    def wait(self) -> None:
        self.hold_in(1 + seconds(self.random.expovariate(2.0)))

    def output(self) -> None:
        self.out.send(Job(self.n))

    def internal(self) -> None:
        self.n += 1
        self.wait()


class Counter(Atomic):
    """Three servers and their queue."""

    into, out = In(Job), Out(Job)

    def start(self) -> None:
        self.random, self.queue, self.busy = Random(2), list[Job](), list[tuple[int, Job]]()

    def serve(self) -> None:
        while self.queue and len(self.busy) < 3:
            self.busy.append((self.now.t + 1 + seconds(self.random.expovariate(1.2)), self.queue.pop(0)))
        self.busy.sort(key=lambda job: job[0])
        if self.busy:
            self.hold_in(self.busy[0][0] - self.now.t)
        else:
            self.passivate()

    def external(self, e: int, x: Bag) -> None:
        self.queue += x[self.into]
        self.serve()

    def output(self) -> None:
        for due, job in self.busy:
            if due == self.busy[0][0]:
                self.out.send(job)

    def internal(self) -> None:
        self.busy = [served for served in self.busy if served[0] > self.now.t]
        self.serve()


class Router(Atomic):
    """Sends a quarter of the customers back."""

    into, again, leave = In(Job), Out(Job), Out(Job)

    def start(self) -> None:
        self.random, self.jobs = Random(3), list[tuple[bool, Job]]()

    def external(self, e: int, x: Bag) -> None:
        self.jobs += [(self.random.random() < 0.25, job) for job in x[self.into]]
        self.hold_in(0)

    def output(self) -> None:
        for back, job in self.jobs:
            (self.again if back else self.leave).send(job)

    def internal(self) -> None:
        self.jobs = []
        self.passivate()


class Door(Atomic):
    """Counts who leaves."""

    into = In(Job)

    def start(self) -> None:
        self.left = 0

    def external(self, e: int, x: Bag) -> None:
        self.left += len(x[self.into])


def queue() -> Coupled:
    """M/M/3 with feedback."""
    root = Coupled("queue")
    source, counter = root.add(Source("source")), root.add(Counter("counter"))
    router, listener = root.add(Router("router")), root.add(Door("door"))
    root.connect(source.out, counter.into)
    root.connect(counter.out, router.into)
    root.connect(router.again, counter.into)
    root.connect(router.leave, listener.into)
    return root
