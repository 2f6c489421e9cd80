"""Parts that route entities: branches, joins, resources that entities seize and release, and monitors between two
points."""

from bisect import bisect
from collections.abc import Mapping
from typing import ClassVar

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Bag, In, Message, Out, Tally, TimeWeighted, stream
from heavylift.nodes.queueing.entities import Entity, NetworkPart, Waiting, shares_of, turn_of


class MonitorStatistics(Message):
    """Statistics of a monitored section: number of entities that left it, and mean time of an entity in it [s]."""

    units: ClassVar[Mapping[str, str]] = {"number": "1", "time": "s"}
    left: int
    number: float
    most: int
    time: float


class ResourceStatistics(Message):
    """Statistics of a resource: seizures, mean waiting time [s], mean numbers of seized units and waiting entities."""

    units: ClassVar[Mapping[str, str]] = {"wait": "s", "used": "1", "waiting": "1"}
    seized: int
    wait: float
    used: float
    waiting: float


class _Forwarding(NetworkPart):
    """Base class of parts that send the entities in `leaving` at the next microstep."""

    def start(self) -> None:
        """Start the model without entities to forward."""
        self.leaving = list[tuple[str, Entity]]()

    def output(self) -> None:
        """Send the entities that this part of the network forwards now."""
        for port, entity in self.leaving:
            self.ports[port].send(entity)  # type: ignore[attr-defined]

    def internal(self) -> None:
        """Clear the list of forwarded entities, and wait for input."""
        self.leaving = []
        self.passivate()

    def forward(self) -> None:
        """Schedule an output at the next microstep if there are entities to forward."""
        self.hold_in(0) if self.leaving else self.passivate()


class Branch(_Forwarding):
    """Routes each entity to one of the output ports out0, out1, ..., chosen at random by `weights` [1]."""

    into = In(Entity)

    def __init__(self, name: str, weights: tuple[float, ...], seed: int = 1) -> None:
        super().__init__(name)
        self.sums, self.seed = shares_of(name, weights), seed
        for n in range(len(weights)):
            self.add_out(f"out{n}", Entity)

    def start(self) -> None:
        """Create the branch's stream of random numbers."""
        super().start()
        self.random = stream(self.seed, self.path)

    def external(self, e: int, x: Bag) -> None:
        """Choose an output port at random for each arriving entity."""
        for entity in x[self.into]:
            self.leaving.append((f"out{bisect(self.sums, self.random.random())}", entity))
        self.forward()


class Join(_Forwarding):
    """Joins the parts of an entity: sends the last part when all `parts` with the same number have arrived."""

    into, out = In(Entity), Out(Entity)

    def __init__(self, name: str, parts: int) -> None:
        super().__init__(name)
        self.parts = parts

    def start(self) -> None:
        """Start with no part of any entity received."""
        super().start()
        self.arrived = dict[int, int]()

    def external(self, e: int, x: Bag) -> None:
        """Count the parts that arrive at the join, separately for each entity number."""
        for entity in x[self.into]:
            count = self.arrived.pop(entity.number, 0) + 1
            if count == self.parts:
                self.leaving.append(("out", entity))
            else:
                self.arrived[entity.number] = count
        self.forward()


class Resource(_Forwarding):
    """A resource of equal units, such as cranes or workers, which entities seize and release.

    An entity that arrives seizes one unit and leaves through the port `seized`; when the entity arrives at the port
    `release`, the unit is free again."""

    request, release, seized = In(Entity), In(Entity), Out(Entity)

    def __init__(self, name: str, units: int, discipline: str = "first in, first out") -> None:
        super().__init__(name)
        self.units, self.discipline = units, discipline

    def start(self) -> None:
        """Start with all units of the resource free."""
        super().start()
        self.waiting, self.count, self.holders = Waiting(self.discipline), 0, dict[int, None]()
        self.waits, self.used, self.length = Tally(), TimeWeighted(), TimeWeighted()

    def external(self, e: int, x: Bag) -> None:
        """Free the released units, then assign free units to waiting entities."""
        now = self.now
        for entity in x[self.release]:
            if self.holders.pop(entity.number, self) is not None:
                raise ModelError(f"entity {entity.number} releases a unit of {self.name} that it has not seized")
        for entity in x[self.request]:
            self.count += 1
            self.waiting.put(turn_of(self.discipline, self.count), now.t, -1, entity)
        while self.waiting and len(self.holders) < self.units:
            _, since, _, entity = self.waiting.take()
            if entity.number in self.holders:
                raise ModelError(
                    f"entity {entity.number} seizes a second unit of {self.name}; an entity can hold only one"
                )
            self.holders[entity.number] = None
            self.waits.add((now.t - since) / 1e9)
            self.leaving.append(("seized", entity))
        self.used.set(len(self.holders), now)
        self.length.set(len(self.waiting), now)
        self.forward()

    def result(self) -> ResourceStatistics:
        """Return the statistics of the resource."""
        return ResourceStatistics(
            self.waits.count, self.waits.mean, self.used.mean(self.now), self.length.mean(self.now)
        )


class Monitor(NetworkPart):
    """Measures the number of entities between two points of a network, and their time from the first to the second."""

    enter, leave = In(Entity), In(Entity)

    def start(self) -> None:
        """Start with no entity in the monitored section."""
        self.inside, self.number, self.times = dict[int, int](), TimeWeighted(), Tally()

    def external(self, e: int, x: Bag) -> None:
        """Record the entities that enter or leave the monitored section."""
        now = self.now
        for entity in x[self.enter]:
            self.inside[entity.number] = now.t
        for entity in x[self.leave]:
            if (since := self.inside.pop(entity.number, None)) is not None:
                self.times.add((now.t - since) / 1e9)
        self.number.set(len(self.inside), now)

    def result(self) -> MonitorStatistics:
        """Return the statistics of the monitored section."""
        n = self.number
        return MonitorStatistics(self.times.count, n.mean(self.now), int(n.most), self.times.mean)
