"""A yard as a Parallel DEVS model: a dispatcher, the steps to which it sends work, and the resources, which report
their use.

The dispatcher is the parallel schedule generation scheme: whenever an activity ends or becomes ready, or a shift
begins, it starts all activities that may start, in the order of the priority rule. A break interrupts work, and the
interrupted work keeps its resources.
"""

from bisect import insort
from collections.abc import Callable
from dataclasses import replace
from heapq import heapify, heappop, heappush
from math import inf

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import NEVER, Atomic, Bag, Coupled, In, Message, Out, Simulator, TimeWeighted, seconds, stream
from heavylift.nodes.queueing.distributions import Fixed

from .lifts import Lift, LiftOrder
from .network import Activity, Yard, ranks, successors
from .weather import Weather, WindChange, YardDone

NOT_READY, NO_SHIFT, WEATHER = "block not ready", "no shift", "weather"
CarryOut = Callable[[LiftOrder, float], Lift]  # simulates a lift in a wind [m/s]


class ActivityStart(Message):
    """Order to begin the activity with this number."""

    activity: int


class ActivityEnd(Message):
    """Report that the activity with this number has ended."""

    activity: int


class UnitsInUse(Message):
    """Number of units of a resource in use."""

    used: int


class YardSchedule(Message):
    """Result of a yard's run: time of delivery [s], start and end of each activity [s], whether it is on the critical
    sequence (0 or 1), and the total time [s] that activities waited for each cause: the block, the shift, then the
    resources."""

    delivery: float
    starts: tuple[float, ...]
    ends: tuple[float, ...]
    critical: tuple[int, ...]
    waits: tuple[float, ...]


class ResourceUse(Message):
    """Use of a resource: mean and maximum number of units in use."""

    used: float
    most: int


class StepWork(Message):
    """Statistics of a step: time for which wind stopped its lifts [s], number of stops, number of simulated lifts and
    of those with a red verdict."""

    stopped: float
    stops: int
    simulated: int
    red: int


class Dispatcher(Atomic):
    """Starts activities in the order of their ranks as soon as predecessors, block, shift and resources allow it
    (parallel schedule generation)."""

    done, wind, over = In(ActivityEnd), In(WindChange), Out(YardDone)

    def __init__(self, name: str, activities: tuple[Activity, ...], capacities: dict[str, int], rank: list[int],
                 after: list[list[tuple[int, int]]], limits: tuple[float, ...] = (),
                 forecast: int = 0) -> None:  # fmt: skip
        super().__init__(name)
        self.forecast = forecast
        place = {limit: k for k, limit in enumerate(limits)}
        self.limited = [place.get(one.lift.wind, -1) if one.lift else -1 for one in activities]
        self.activities, self.capacities, self.rank, self.successors = activities, capacities, rank, after
        self.ending: list[list[tuple[str, int]]] = [[] for _ in activities]  # what is free after each
        for one in activities:
            for need in one.needs:
                self.ending[need.until].append((need.resource, need.units))
        for step in dict.fromkeys(one.step for one in activities):
            self.add_out(f"to-{step}", ActivityStart)
        for resource in capacities:
            self.add_out(f"use-{resource}", UnitsInUse)

    def start(self) -> None:
        """Start without any activity begun."""
        count = len(self.activities)
        self.begin, self.end = [-1] * count, [-1] * count
        self.ready = [one.ready for one in self.activities]
        self.opening = [one.works.open(one.ready) for one in self.activities]  # of the first shift when it is ready
        self.open = [len(one.after) for one in self.activities]  # predecessors that are not done
        self.used, self.running, self.decided = dict.fromkeys(self.capacities, 0), 0, 0
        self.freed = dict[str, None]()
        self.pending = sorted((self.rank[n], n) for n in range(count) if not self.open[n])
        self.causes = [""] * count  # why each waits
        self.lacked = [""] * count  # the resource that each lacked last
        self.waits = dict.fromkeys((NOT_READY, NO_SHIFT, WEATHER, *self.capacities), 0)
        self.calm, self.calms = list[int](), True  # until when the wind stays within each limit; will it change?
        self.left, self.telling = count, False
        self.decide()

    def output(self) -> None:
        """Send orders to begin activities, and the changed numbers of units in use."""
        for n in self.begun:
            self.ports[f"to-{self.activities[n].step}"].send(ActivityStart(n))  # type: ignore[attr-defined]
        for resource in self.changed:
            self.ports[f"use-{resource}"].send(UnitsInUse(self.used[resource]))  # type: ignore[attr-defined]
        if self.telling:
            self.over.send(YardDone())

    def external(self, e: int, x: Bag) -> None:
        """Record the activities that ended, then decide which ones begin."""
        unsent = self.begun, self.changed
        self.note(x)
        self.decide(*unsent)

    def internal(self) -> None:
        """Forget the orders that were sent, and decide again which activities begin."""
        self.telling = False
        self.decide()

    def confluent(self, x: Bag) -> None:
        """Handle everything that happens now, then decide once."""
        self.telling = False
        self.note(x)
        self.decide()

    def note(self, x: Bag) -> None:
        """Free the resources of the activities that ended, and queue successors that have become ready."""
        now = self._present.now[0]
        for change in x[self.wind]:
            self.calm, self.calms = list(change.calm), not change.last
        for message in x[self.done]:
            n = message.activity
            self.end[n], self.running, self.left = now, self.running - 1, self.left - 1
            self.telling = not self.left
            for resource, units in self.ending[n]:
                self.used[resource] -= units
                self.freed[resource] = None
            for m, lag in self.successors[n]:
                self.open[m] -= 1
                if now + lag > self.ready[m]:
                    self.ready[m], self.opening[m] = now + lag, self.activities[m].works.open(now + lag)
                if not self.open[m]:
                    insort(self.pending, (self.rank[m], m))

    def decide(self, begun: tuple[int, ...] = (), changed: tuple[str, ...] = ()) -> None:
        """Start all activities that may start now, and schedule the next decision for when a block is ready or a shift
        begins."""
        now, wake, kept = self._present.now[0], NEVER, list[tuple[int, int]]()
        freed, self.freed = self.freed, {}
        started, opens = list(begun), dict[str, int]()  # when the next shift begins, by calendar
        for rank, n in self.pending:
            one = self.activities[n]
            if cause := self.causes[n]:
                self.waits[cause] += now - self.decided
            cause, at = "", self.opening[n]
            if at <= now and (at := opens.get(one.works.key, -1)) < 0:
                at = opens[one.works.key] = one.works.open(now)
            if at > now:
                cause, wake = NOT_READY if self.ready[n] > now else NO_SHIFT, min(wake, at)
            else:
                for need in one.needs:
                    if self.used[need.resource] + need.units > self.capacities[need.resource]:
                        cause = self.lacked[n] = need.resource
                        break
                else:
                    if self.limited[n] >= 0 and not self.calm_for(n, now):
                        cause = WEATHER
            self.causes[n] = cause
            if cause:
                kept.append((rank, n))
                continue
            self.begin[n], self.running = now, self.running + 1
            started.append(n)
            for need in one.needs:
                self.used[need.resource] += need.units
                freed[need.resource] = None
        self.pending, self.decided = kept, now
        self.begun, self.changed = tuple(started), tuple(sorted({**freed, **dict.fromkeys(changed)}))
        if kept and wake == NEVER and not self.running and not (self.calms and WEATHER in self.causes):
            waits = self.activities[kept[0][1]]
            raise ModelError(
                f"{waits.name} waits for ever for {self.causes[kept[0][1]]}, as blocks that keep it wait for others; "
                "let an earlier step give it back, or have more of it"
            )
        self.hold_in(0 if self.begun or self.changed or self.telling else wake if wake == NEVER else wake - now)

    def calm_for(self, n: int, now: int) -> bool:
        """Return whether the wind allows a lift to begin now, and does so until its expected end or the end of the
        forecast."""
        end = self.calm[self.limited[n]] if self.calm else -1
        one = self.activities[n]
        return end > now and end >= min(now + self.forecast, one.works.add(now, one.expected))

    def result(self) -> YardSchedule:
        """Return the schedule, and the waiting times by cause."""
        critical = set(self.critical())
        return YardSchedule(
            max(self.end) / 1e9, tuple(t / 1e9 for t in self.begin), tuple(t / 1e9 for t in self.end),
            tuple(int(n in critical) for n in range(len(self.end))), tuple(t / 1e9 for t in self.waits.values()),
        )  # fmt: skip

    def critical(self) -> list[int]:
        """Return the critical sequence: from the activity that ends last, backwards through the activities whose ends
        allowed the starts."""
        last = max(range(len(self.end)), key=lambda n: (self.end[n], -n))
        found = [last]
        while (n := self.releaser(found[-1])) >= 0:
            found.append(n)
        return found[::-1]

    def releaser(self, n: int) -> int:
        """Return the number of the activity whose end allowed activity n to start; -1 if there is none or if n waited
        for its block to be ready."""
        one, lacked = self.activities[n], self.lacked[n]
        before = [(self.end[m] + lag, True, -m) for m, lag in one.after]
        if lacked:
            for m, freed in enumerate(self.ending):
                if m != n and 0 <= self.end[m] <= self.begin[n] and any(name == lacked for name, _ in freed):
                    before.append((self.end[m], False, -m))
        time, _, number = max(before, default=(-1, False, 1))
        return -number if time >= one.ready and number <= 0 else -1


class YardStep(Atomic):
    """Carries out one step for all blocks, each in its own expected time. Wind stops lifts and lets them continue;
    `carry_out` simulates lifts whose properties depend on the wind at their begin."""

    work, wind, done = In(ActivityStart), In(WindChange), Out(ActivityEnd)

    def __init__(self, name: str, activities: dict[int, Activity], carry_out: CarryOut | None) -> None:
        super().__init__(name)
        self.activities, self.carry_out = activities, carry_out
        self.times = {n: seconds(one.takes.mean) for n, one in activities.items()}

    def start(self) -> None:
        """Start with no activity under way."""
        self.due = list[tuple[int, int]]()
        self.speed, self.held = 0.0, dict[int, tuple[int, int]]()  # [m/s]; work left and since when of what stands
        self.stopped, self.stops, self.simulated, self.red = 0, 0, 0, 0

    def external(self, e: int, x: Bag) -> None:
        """Begin the ordered activities; stop or continue lifts according to the wind."""
        now = self._present.now[0]
        for change in x[self.wind]:
            self.speed = change.speed
            self.stop(now)
        for message in x[self.work]:
            n = message.activity
            heappush(self.due, (self.activities[n].works.add(now, self.times[n] + self.lifting(n)), n))
        self.hold_in(self.due[0][0] - now if self.due else NEVER)

    def lifting(self, n: int) -> int:
        """Return the duration of the lift of a block [ns]."""
        one = self.activities[n]
        if one.order and one.order.way == "run" and self.carry_out:
            found = self.carry_out(one.order, self.speed)
            self.simulated, self.red = self.simulated + 1, self.red + (found.state == "red")
            return seconds(found.seconds)
        return seconds(one.lift.seconds) if one.lift else 0

    def stop(self, now: int) -> None:
        """Stop lifts for which the wind is too strong, and continue those that are allowed again."""
        for end, n in [*self.due]:
            one = self.activities[n]
            if one.lift and self.speed > one.lift.stop and end > now:
                self.due.remove((end, n))
                self.held[n], self.stops = (one.works.between(now, end), now), self.stops + 1
        for n, (left, since) in [*self.held.items()]:
            one = self.activities[n]
            if one.lift and self.speed <= one.lift.resume:
                del self.held[n]
                self.stopped += now - since
                self.due.append((one.works.add(now, left), n))
        heapify(self.due)

    def output(self) -> None:
        """Report the activities that end now."""
        for t, n in sorted(self.due):
            if t == self.due[0][0]:
                self.done.send(ActivityEnd(n))

    def internal(self) -> None:
        """Remove the activities that ended, and wait for the next end."""
        now = self.due[0][0]
        while self.due and self.due[0][0] == now:
            heappop(self.due)
        self.hold_in(self.due[0][0] - now if self.due else NEVER)

    def result(self) -> StepWork:
        """Return how often and how long wind stopped the lifts of this step."""
        return StepWork(self.stopped / 1e9, self.stops, self.simulated, self.red)


class YardResource(Atomic):
    """Measures the use of a resource over time."""

    level = In(UnitsInUse)

    def start(self) -> None:
        """Start with no units in use."""
        self.used = TimeWeighted()

    def external(self, e: int, x: Bag) -> None:
        """Record the number of units in use."""
        self.used.set(x[self.level][-1].used, self.now)

    def result(self) -> ResourceUse:
        """Return the measured statistics."""
        return ResourceUse(self.used.mean(self.now), int(self.used.most))


def coupled(yard: Yard, seed: int = 0, rule: str = "", carry_out: CarryOut | None = None) -> Coupled:
    """Return the DEVS model of a yard with its own priority rule or another one; seed 0 means expected durations, in
    random weather."""
    root, limits = Coupled("yard"), thresholds(yard) if yard.wind else ()
    dispatcher = root.add(
        Dispatcher(
            "dispatcher", yard.activities, yard.capacities, ranks(yard, rule), successors(yard), limits, yard.forecast
        )
    )
    weather = root.add(Weather("weather", yard.wind, limits, seed)) if yard.wind and limits else None
    if weather:
        root.connect(weather.wind, dispatcher.wind)
        root.connect(dispatcher.over, weather.over)
    for name in dict.fromkeys(one.step for one in yard.activities):
        own = {n: settled(one, seed) for n, one in enumerate(yard.activities) if one.step == name}
        step = root.add(YardStep(f"step-{name}", own, carry_out))
        root.connect(dispatcher.ports[f"to-{name}"], step.work)
        root.connect(step.done, dispatcher.done)
        if weather and any(one.lift for one in own.values()):
            root.connect(weather.wind, step.wind)
    for name in yard.capacities:
        root.connect(dispatcher.ports[f"use-{name}"], root.add(YardResource(f"resource-{name}")).level)
    return root


def settled(one: Activity, seed: int) -> Activity:
    """Return an activity with the working time that is drawn for it, for seed 0 with the expected one."""
    return replace(one, takes=Fixed(one.takes.draw(stream(seed, one.name)) if seed else one.takes.mean))


def expected(yard: Yard, rule: str = "") -> YardSchedule:
    """Return the schedule of one run with expected durations."""
    model = coupled(yard, 0, rule)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    dispatcher = model.children["dispatcher"]
    assert isinstance(dispatcher, Dispatcher)
    return dispatcher.result()


def thresholds(yard: Yard) -> tuple[float, ...]:
    """Return the wind speeds [m/s] at which a lift may begin or must stop; every whole number up to 40 m/s if lifts are
    simulated in their wind."""
    lifts = [one.lift for one in yard.activities if one.lift]
    found = {limit for lift in lifts for limit in (lift.wind, lift.stop, lift.resume) if limit < inf}
    if any(one.order and one.order.way == "run" for one in yard.activities):
        found |= {float(n) for n in range(1, 41)}
    return tuple(sorted(found))
