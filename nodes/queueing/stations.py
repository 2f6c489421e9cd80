"""Stations of a queueing network: sources, queues, delays and sinks, each with its statistics as its result.

Random times of different stations are independent: each station draws from the random stream of its seed and path.
"""

from bisect import bisect
from collections.abc import Mapping
from heapq import heappop, heappush
from typing import ClassVar

from heavylift.nodes.devs import NEVER, Bag, In, Message, Out, Tally, TimeWeighted, seconds, stream
from heavylift.nodes.queueing.distributions import Distribution
from heavylift.nodes.queueing.entities import Demand, Entity, NetworkPart, Waiting, capacity_of, shares_of, turn_of


class SourceStatistics(Message):
    """Statistics of a source: number of entities sent."""

    sent: int


class WaitingStatistics(Message):
    """Statistics of a queue: entities passed and lost, mean time in the queue [s], mean and largest queue length."""

    units: ClassVar[Mapping[str, str]] = {"wait": "s", "length": "1"}
    passed: int
    lost: int
    wait: float
    length: float
    longest: int


class SinkStatistics(Message):
    """Statistics of a sink: number of entities that arrived, and statistics of their time in the network [s]."""

    units: ClassVar[Mapping[str, str]] = {"mean": "s", "deviation": "s", "least": "s", "most": "s"}
    count: int
    mean: float
    deviation: float
    least: float
    most: float


class Source(NetworkPart):
    """Sends at most `most` entities (0: no limit) at random intervals, with random priorities by `weights` [1]."""

    out = Out(Entity)

    def __init__(
        self,
        name: str,
        every: Distribution,
        kind: str = "",
        weights: tuple[float, ...] = (1.0,),
        most: int = 0,
        seed: int = 1,
    ) -> None:
        super().__init__(name)
        self.every, self.kind, self.most, self.seed = every, kind, most, seed
        self.sums = shares_of(name, weights)

    def start(self) -> None:
        """Draw the interval until the first entity."""
        self.random, self.number = stream(self.seed, self.path), 0
        self.next()

    def output(self) -> None:
        """Send the next entity of the source."""
        self.out.send(Entity(self.number, self.kind, self.priority, self.ns))

    def internal(self) -> None:
        """Count the entity that the source has sent, and draw the interval until the next one."""
        self.number += 1
        if self.number == self.most:
            self.passivate()
        else:
            self.next()

    def next(self) -> None:
        """Draw the interval until the next entity, and its priority."""
        draw = self.random.random() if self.sums else 0.0
        self.priority = bisect(self.sums, draw)
        self.hold_in(seconds(self.every.draw(self.random)))

    def result(self) -> SourceStatistics:
        """Return the number of entities that the source has sent."""
        return SourceStatistics(self.number)


class Queue(NetworkPart):
    """Holds entities until servers demand them; an entity that arrives at a full queue is lost."""

    into, demand, out, lost = In(Entity), In(Demand), Out(Entity), Out(Entity)

    def __init__(self, name: str, discipline: str = "first in, first out", capacity: int | None = None) -> None:
        super().__init__(name)
        self.discipline, self.capacity = discipline, capacity_of(name, capacity)

    def start(self) -> None:
        """Start with an empty queue."""
        self.waiting, self.demanded, self.count = Waiting(self.discipline), 0, 0
        self.leaving, self.balked = list[Entity](), list[Entity]()
        self.waits, self.length, self.losses = Tally(), TimeWeighted(), 0

    def external(self, e: int, x: Bag) -> None:
        """Add arriving entities and demands to the queue, and match them."""
        now = self.now
        self.demanded += sum(demand.count for demand in x[self.demand])
        for entity in x[self.into]:
            if self.demanded or self.capacity is None or len(self.waiting) < self.capacity:
                self.count += 1
                self.waiting.put(turn_of(self.discipline, self.count), now.t, -1, entity)
                self.match()
            else:
                self.losses += 1
                self.balked.append(entity)
        self.match()
        self.length.set(len(self.waiting), now)
        self.hold_in(0) if self.leaving or self.balked else self.passivate()

    def match(self) -> None:
        """Take one entity out of the queue for each open demand."""
        while self.demanded and self.waiting:
            _, since, _, entity = self.waiting.take()
            self.demanded -= 1
            self.waits.add((self.ns - since) / 1e9)
            self.leaving.append(entity)

    def output(self) -> None:
        """Send the entities that leave the queue for servers, and those lost at a full queue."""
        for entity in self.leaving:
            self.out.send(entity)
        for entity in self.balked:
            self.lost.send(entity)

    def internal(self) -> None:
        """Clear the list of entities that the queue has just sent."""
        self.leaving, self.balked = [], []
        self.passivate()

    def result(self) -> WaitingStatistics:
        """Return the statistics of the queue."""
        return WaitingStatistics(
            self.waits.count, self.losses, self.waits.mean, self.length.mean(self.now), int(self.length.most)
        )


class Delay(NetworkPart):
    """Delays each entity by a random time of its own, like a server with an unlimited number of units."""

    into, out = In(Entity), Out(Entity)

    def __init__(self, name: str, time: Distribution, seed: int = 1) -> None:
        super().__init__(name)
        self.time, self.seed = time, seed

    def start(self) -> None:
        """Start with no entity in the delay."""
        self.random, self.count = stream(self.seed, self.path), 0
        self.held = list[tuple[int, int, Entity]]()

    def external(self, e: int, x: Bag) -> None:
        """Draw a delay for each entity that arrives."""
        for entity in x[self.into]:
            self.count += 1
            heappush(self.held, (self.ns + seconds(self.time.draw(self.random)), self.count, entity))
        self.hold_in(self.held[0][0] - self.ns)

    def output(self) -> None:
        """Send all entities whose delay has passed."""
        for at, _, entity in sorted(self.held):
            if at == self.held[0][0]:
                self.out.send(entity)

    def internal(self) -> None:
        """Remove the entities that the delay has just sent."""
        at = self.held[0][0]
        while self.held and self.held[0][0] == at:
            heappop(self.held)
        self.hold_in(self.held[0][0] - at if self.held else NEVER)


class Sink(NetworkPart):
    """Removes entities from the network and measures how long they were in it."""

    into = In(Entity)

    def start(self) -> None:
        """Start the sink with no entity counted."""
        self.times = Tally()

    def external(self, e: int, x: Bag) -> None:
        """Record the time that each arriving entity has spent in the network."""
        for entity in x[self.into]:
            self.times.add((self.ns - entity.born) / 1e9)

    def result(self) -> SinkStatistics:
        """Return the statistics of the sink."""
        t = self.times
        return SinkStatistics(t.count, t.mean, t.deviation, t.least, t.most)
