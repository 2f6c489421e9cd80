"""Servers: equal units that serve entities from one queue, with priorities, pre-emption, balking and failures."""

from collections.abc import Mapping
from heapq import heapify, heappop, heappush
from typing import ClassVar, Literal

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import NEVER, Bag, In, Message, Out, Tally, TimeWeighted, seconds, stream
from heavylift.nodes.queueing.distributions import Distribution
from heavylift.nodes.queueing.entities import Demand, Entity, NetworkPart, Waiting, capacity_of, turn_of

What = Literal["served", "fails", "repaired", "lost", "asks"]  # in the end of a time that a server waits for


class Failures:
    """Failures of a server's units: distributions of the time to failure and of the repair time.

    Units fail both while busy and while idle; an interrupted job continues after the repair."""

    def __init__(self, up: Distribution, down: Distribution) -> None:
        self.up, self.down = up, down


class ServerStatistics(Message):
    """Statistics of a server: entities served, lost and interrupted, and their mean waiting time before service [s].

    Also the mean queue length, and the mean numbers of busy and of available units."""

    units: ClassVar[Mapping[str, str]] = {"wait": "s", "line": "1", "busy": "1", "available": "1"}
    served: int
    lost: int
    interrupted: int
    wait: float
    line: float
    busy: float
    available: float


class Server(NetworkPart):
    """Equal units that serve entities from one queue.

    `capacity` limits the length of the queue: an entity that finds it full is lost (balks). If `preemptive`, an entity
    of higher priority interrupts the service of the entity with the lowest priority, whose service continues later from
    where it was. If `pulls`, the server demands entities from separate queues, one for each unit that becomes free.
    """

    into, done, lost, ready = In(Entity), Out(Entity), Out(Entity), Out(Demand)

    def __init__(
        self,
        name: str,
        service: Distribution,
        units: int = 1,
        discipline: str = "first in, first out",
        *,
        preemptive: bool = False,
        capacity: int | None = None,
        failures: Failures | None = None,
        pulls: bool = False,
        seed: int = 1,
    ) -> None:
        super().__init__(name)
        if not isinstance(units, int) or units < 1:
            raise ModelError(f"{name}: {units!r} units; give a whole number of at least 1")
        if preemptive and discipline != "priority":
            raise ModelError(f"{name}: only the discipline 'priority' can be preemptive, not '{discipline}'")
        self.service, self.units, self.discipline, self.preemptive = service, units, discipline, preemptive
        self.capacity, self.failures, self.pulls, self.seed = capacity_of(name, capacity), failures, pulls, seed

    def start(self) -> None:
        """Start the server with all units idle and available."""
        self.random, self.marks = stream(self.seed, self.path), 0
        self.waiting, self.idle = Waiting(self.discipline), list(range(self.units))
        self.serving = list[tuple[int, int, int, int, Entity] | None]([None] * self.units)  # mark, end, turn, since
        self.broken, self.losing = dict[int, int](), dict[int, Entity]()  # what is left of the job of a unit [ns]
        self.due = list[tuple[int, int, int, What]]()  # time [ns], mark, unit, what
        self.served, self.losses, self.interrupted = 0, 0, 0
        self.waits, self.line, self.busy = Tally(), TimeWeighted(), TimeWeighted()
        self.available = TimeWeighted(self.units)
        if self.failures:
            for unit in range(self.units):
                self.later(seconds(self.failures.up.draw(self.random)), unit, "fails")
        if self.pulls:
            self.later(0, self.units, "asks")
        self.schedule()

    def external(self, e: int, x: Bag) -> None:
        """Serve, queue or lose the entities that arrive at the server."""
        now, more = self.ns, x[self.into]
        for entity in more:
            if self.idle:
                self.begin(now, self.turn(), now, -1, entity)
            elif (unit := self.lowest(entity)) >= 0:
                self.interrupt(unit, now)
                self.begin(now, self.turn(), now, -1, entity)
            elif self.capacity is None or len(self.waiting.heap) < self.capacity:
                self.waiting.put(self.turn(), now, -1, entity)
            else:
                self.losses += 1
                self.losing[self.later(now, -1, "lost")] = entity
        self.schedule()

    def output(self) -> None:
        """Send an entity that the server has served or lost, or the server's demand for the next entities."""
        _, mark, unit, what = self.due[0]
        if what == "served":
            self.done.send(self.serving[unit][4])  # type: ignore[index]
        elif what == "lost":
            self.lost.send(self.losing[mark])
        elif what == "asks":
            self.ready.send(Demand(unit))

    def internal(self) -> None:
        """Handle the end of a service, a failure or a repair at the server."""
        now, mark, unit, what = heappop(self.due)
        if what == "served":
            self.served += 1
            self.release(unit)
            if self.pulls:
                self.later(now, 1, "asks")
        elif what == "lost":
            del self.losing[mark]
        elif what in ("fails", "repaired"):
            self.fail(unit, now) if what == "fails" else self.repair(unit, now)
        while self.waiting.heap and (self.idle or self.preempts(now)):
            self.begin(now, *self.waiting.take())
        self.schedule()

    def fail(self, unit: int, now: int) -> None:
        """Stop a unit of the server that fails; the entity in service stays on the unit."""
        assert self.failures
        if (job := self.serving[unit]) is None:
            self.idle.remove(unit)
            heapify(self.idle)
        self.broken[unit] = job[1] - now if job else -1
        self.serving[unit] = job and (0, *job[1:])  # its end is void
        self.later(now + seconds(self.failures.down.draw(self.random)), unit, "repaired")

    def repair(self, unit: int, now: int) -> None:
        """Return a repaired unit to service; it continues its interrupted job."""
        assert self.failures
        left, job = self.broken.pop(unit), self.serving[unit]
        if job is None:
            heappush(self.idle, unit)
        else:
            self.serving[unit] = (self.later(now + left, unit, "served"), now + left, *job[2:])
        self.later(now + seconds(self.failures.up.draw(self.random)), unit, "fails")

    def begin(self, now: int, turn: int, since: int, left: int, entity: Entity) -> None:
        """Start serving an entity on the first idle unit; the service takes `left` [ns] (-1: a random time)."""
        unit = heappop(self.idle)
        if left < 0:
            self.waits.add((now - since) / 1e9)
            left = seconds(self.service.draw(self.random))
        end = now + left
        self.serving[unit] = (self.later(end, unit, "served"), end, turn, since, entity)

    def interrupt(self, unit: int, now: int) -> None:
        """Interrupt the service by a unit, and put the entity back to its former place in the order of service."""
        _, end, turn, since, entity = self.serving[unit]  # type: ignore[misc]
        self.interrupted += 1
        self.release(unit)
        self.waiting.put(turn, since, end - now, entity)

    def preempts(self, now: int) -> bool:
        """Interrupt a service if the first waiting entity has a higher priority; return whether this happened."""
        unit = self.lowest(self.waiting.heap[0][4]) if self.preemptive else -1
        if unit >= 0:
            self.interrupt(unit, now)
        return unit >= 0

    def lowest(self, entity: Entity) -> int:
        """Return the unit that serves the entity of the lowest priority, if `entity` has a higher priority; else -1."""
        if not self.preemptive:
            return -1
        jobs = [(job[4].priority, job[2], unit) for unit, job in enumerate(self.serving) if job and job[0]]
        priority, _, unit = max(jobs, default=(entity.priority, 0, -1))
        return unit if priority > entity.priority else -1

    def release(self, unit: int) -> None:
        """Make a unit of the server idle at the end of a service."""
        self.serving[unit] = None
        heappush(self.idle, unit)

    def turn(self) -> int:
        """Return the sort key of the next arriving entity in the order of service."""
        self.marks += 1
        return turn_of(self.discipline, self.marks)

    def later(self, at: int, unit: int, what: What) -> int:
        """Schedule an event of a unit at the time `at` [ns], and return the number of the event."""
        self.marks += 1
        heappush(self.due, (at, self.marks, unit, what))
        return self.marks

    def schedule(self) -> None:
        """Schedule the server's next internal transition at the earliest event of all units."""
        due, serving, waiting, down = self.due, self.serving, len(self.waiting.heap), len(self.broken)
        while due and due[0][3] == "served" and ((job := serving[due[0][2]]) is None or job[0] != due[0][1]):
            heappop(due)
        if self.line.value != waiting:
            self.line.set(waiting, self.now)
        if self.busy.value != (busy := self.units - down - len(self.idle)):
            self.busy.set(busy, self.now)
        if self.available.value != self.units - down:
            self.available.set(self.units - down, self.now)
        self.hold_in(due[0][0] - self.ns if due else NEVER)

    def result(self) -> ServerStatistics:
        """Return the statistics of the server."""
        now = self.now
        return ServerStatistics(
            self.served, self.losses, self.interrupted, self.waits.mean, self.line.mean(now), self.busy.mean(now),
            self.available.mean(now),
        )  # fmt: skip
