"""A yard as Parallel DEVS: a dispatcher, the steps that it sends work to, and the resources that report their use.

A break interrupts work, which keeps its resources meanwhile.
"""

from collections.abc import Callable
from dataclasses import replace
from heapq import heapify, heappop, heappush
from math import inf

from heavylift.nodes.devs import NEVER, Atomic, Bag, Coupled, In, Message, Out, Simulator, TimeWeighted, seconds, stream
from heavylift.nodes.queueing.distributions import Fixed

from .dispatching import ActivityEnd, ActivityStart, Dispatcher, UnitsInUse, YardSchedule
from .lifts import Lift, LiftOrder
from .network import Activity, Yard, ranks, successors
from .waves import WaveLimit
from .weather import SeaWeather, Weather, WindChange

CarryOut = Callable[[LiftOrder, float], Lift]  # simulates a lift in a wind [m/s]


class ResourceUse(Message):
    """Use of a resource: mean and maximum number of units in use."""

    used: float
    most: int


class StepWork(Message):
    """Statistics of a step: time lost by wind [s], and numbers of stops, simulated lifts and lifts with red verdict."""

    stopped: float
    stops: int
    simulated: int
    red: int


class YardStep(Atomic):
    """Atomic model of one step for all blocks: rigging in the expected time, followed by the lift of the block.

    Wind delays, stops and resumes lifts; `carry_out` simulates a lift whose results depend on the wind when it
    begins."""

    work, wind, done = In(ActivityStart), In(WindChange), Out(ActivityEnd)

    def __init__(self, name: str, activities: dict[int, Activity], carry_out: CarryOut | None) -> None:
        super().__init__(name)
        self.activities, self.carry_out = activities, carry_out
        self.times = {n: seconds(one.takes.mean) for n, one in activities.items()}

    def start(self) -> None:
        """Start the yard's step with no activity under way."""
        self.due, self.rigging = list[tuple[int, int]](), dict[int, None]()  # ends of work; lifts that follow it
        self.held = dict[int, tuple[int, int, float]]()  # work left [ns], since when, wind that lets it go on [m/s]
        self.speed, self.stopped, self.stops, self.simulated, self.red = 0.0, 0, 0, 0, 0

    def external(self, e: int, x: Bag) -> None:
        """Begin the ordered activities; stop or resume lifts according to the wind."""
        now = self._present.now[0]
        for change in x[self.wind]:
            self.speed = change.speed
            self.stop(now)
        for message in x[self.work]:
            n = message.activity
            heappush(self.due, (self.activities[n].works.add(now, self.times[n]), n))
            if self.activities[n].lift:
                self.rigging[n] = None
        self.hold_in(self.due[0][0] - now if self.due else NEVER)

    def lift(self, n: int, now: int) -> None:
        """Begin the lift of a rigged block, or let the block wait for less wind."""
        one = self.activities[n]
        assert one.lift
        left = seconds(one.lift.seconds)
        if one.order and one.order.way == "run" and self.carry_out:
            found = self.carry_out(one.order, self.speed)
            self.simulated, self.red = self.simulated + 1, self.red + (found.state == "red")
            left = seconds(found.seconds)
        if self.speed > one.lift.wind:
            self.held[n] = left, now, one.lift.wind
        else:
            heappush(self.due, (one.works.add(now, left), n))

    def stop(self, now: int) -> None:
        """Stop lifts when the wind exceeds their limits, and resume them when it has dropped."""
        for end, n in [*self.due]:
            one = self.activities[n]
            if one.lift and n not in self.rigging and self.speed > one.lift.stop and end > now:
                self.due.remove((end, n))
                self.held[n], self.stops = (one.works.between(now, end), now, one.lift.resume), self.stops + 1
        for n, (left, since, limit) in [*self.held.items()]:
            if self.speed <= limit:
                del self.held[n]
                self.stopped += now - since
                self.due.append((self.activities[n].works.add(now, left), n))
        heapify(self.due)

    def output(self) -> None:
        """Report the activities that end now to the dispatcher."""
        for t, n in sorted(self.due):
            if t == self.due[0][0] and n not in self.rigging:
                self.done.send(ActivityEnd(n))

    def internal(self) -> None:
        """Remove the ended activities, begin the lifts of rigged blocks, and wait for the next end."""
        now, rigged = self.due[0][0], list[int]()
        while self.due and self.due[0][0] == now:
            n = heappop(self.due)[1]
            if n in self.rigging:
                del self.rigging[n]
                rigged.append(n)
        for n in rigged:
            self.lift(n, now)
        self.hold_in(self.due[0][0] - now if self.due else NEVER)

    def confluent(self, x: Bag) -> None:
        """Process the new wind before the step's own events, because the wind decides which lifts can begin now."""
        self.speed = x[self.wind][-1].speed if x[self.wind] else self.speed
        super().confluent(x)

    def result(self) -> StepWork:
        """Return how long and how often wind stopped the lifts of this step, and how many lifts were simulated."""
        return StepWork(self.stopped / 1e9, self.stops, self.simulated, self.red)


class YardResource(Atomic):
    """Atomic model that measures the use of a resource over time."""

    level = In(UnitsInUse)

    def start(self) -> None:
        """Start with no units of the resource in use."""
        self.used = TimeWeighted()

    def external(self, e: int, x: Bag) -> None:
        """Record the number of units of the resource in use."""
        self.used.set(x[self.level][-1].used, self.now)

    def result(self) -> ResourceUse:
        """Return the statistics of the resource."""
        return ResourceUse(self.used.mean(self.now), int(self.used.most))


def coupled(yard: Yard, seed: int = 0, rule: str = "", carry_out: CarryOut | None = None) -> Coupled:
    """Return the DEVS model of a yard with a priority rule (default: the yard's); seed 0 means expected durations. The
    weather is random even with seed 0."""
    of = yard.weather
    root, limits, seas = Coupled("yard"), thresholds(yard) if of.wind else (), operational(yard) if of.sea else ()
    dispatcher = root.add(
        Dispatcher(
            "dispatcher", yard.activities, yard.capacities, ranks(yard, rule), successors(yard), limits, seas, of
        )
    )
    if of.sea and seas:
        sea = root.add(SeaWeather("sea", of.sea, seas, seed))
        root.connect(sea.wind, dispatcher.sea)
        root.connect(dispatcher.over, sea.over)
    weather = root.add(Weather("weather", of.wind, limits, seed)) if of.wind and limits else None
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
    """Return an activity with a fixed duration: drawn at random or, for seed 0, the expected one."""
    return replace(one, takes=Fixed(one.takes.draw(stream(seed, one.name)) if seed else one.takes.mean))


def expected(yard: Yard, rule: str = "") -> YardSchedule:
    """Return the schedule of a single run with expected durations."""
    model = coupled(yard, 0, rule)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    dispatcher = model.children["dispatcher"]
    assert isinstance(dispatcher, Dispatcher)
    return dispatcher.result()


def thresholds(yard: Yard) -> tuple[float, ...]:
    """Return the wind speeds [m/s] at which lifts may begin, stop or continue.

    If lifts are simulated with the wind of their time, all whole numbers up to 40 m/s are added."""
    lifts = [one.lift for one in yard.activities if one.lift]
    found = {limit for lift in lifts for limit in (lift.wind, lift.stop, lift.resume) if limit < inf}
    if any(one.order and one.order.way == "run" for one in yard.activities):
        found |= {float(n) for n in range(1, 41)}
    return tuple(sorted(found))


def operational(yard: Yard) -> tuple[WaveLimit, ...]:
    """Return the operational wave limits of all activities: each limit times each alpha factor."""
    factors = [x for _, x in yard.weather.alpha] or [1.0]
    return tuple(sorted({one.sea.times(x) for one in yard.activities if one.sea for x in factors}))
