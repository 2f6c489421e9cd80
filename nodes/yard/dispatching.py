"""The dispatcher of a yard, and the messages between it, the steps and the resources.

It is the parallel schedule generation scheme: whenever something ends, gets ready, or a shift begins, it starts all
activities that may start, in the order of the rule.
"""

from bisect import insort

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import NEVER, Atomic, Bag, In, Message, Out

from .network import Activity
from .waves import WaveLimit
from .weather import HOUR, NONE, WindChange, YardDone, YardWeather

PATIENCE = 3650 * 24 * HOUR
BAD = "in ten years of weather it is never good for long enough; raise the limit or shorten the step"
HELD = "blocks that hold it wait for others; release it at an earlier step, or add units"
NOT_READY, NO_SHIFT, WEATHER = "block not ready", "no shift", "weather"


class ActivityStart(Message):
    """Order to begin the activity with this number."""

    activity: int


class ActivityEnd(Message):
    """Report that the activity with this number has ended."""

    activity: int


class UnitsInUse(Message):
    """Message with the number of units of a resource that are in use."""

    used: int


class YardSchedule(Message):
    """Result of a yard's run: time of delivery [s], start and end [s] of each activity, and waiting times.

    Also whether each activity is on the critical sequence (0 or 1); total time [s] that activities waited for each
    cause: the block, the shift, then the resources."""

    delivery: float
    starts: tuple[float, ...]
    ends: tuple[float, ...]
    critical: tuple[int, ...]
    waits: tuple[float, ...]


class Dispatcher(Atomic):
    """Atomic model that starts activities by rank when predecessors, block, shift and resources allow it."""

    done, wind, sea, over = In(ActivityEnd), In(WindChange), In(WindChange), Out(YardDone)

    def __init__(self, name: str, activities: tuple[Activity, ...], capacities: dict[str, int], rank: list[int],
                 after: list[list[tuple[int, int]]], limits: tuple[float, ...] = (), seas: tuple[WaveLimit, ...] = (),
                 weather: YardWeather = NONE) -> None:  # fmt: skip
        super().__init__(name)
        self.weather, self.limits, self.seas = weather, limits, {limit: k for k, limit in enumerate(seas)}
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
        """Start the dispatcher with no activity begun."""
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
        self.calm, self.swell = list[int](), list[int]()  # until when wind and sea stay within each limit
        self.calms = [bool(self.limits), bool(self.seas)]  # will they change?
        self.waited = dict[int, int]()  # since when each waits for weather
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
        """Record the activities that have ended, then decide which activities begin."""
        unsent = self.begun, self.changed
        self.note(x)
        self.decide(*unsent)

    def internal(self) -> None:
        """Clear the orders that were sent, and decide again which activities begin."""
        self.telling = False
        self.decide()

    def confluent(self, x: Bag) -> None:
        """Process all inputs of this time first, then decide once which activities begin."""
        self.telling = False
        self.note(x)
        self.decide()

    def note(self, x: Bag) -> None:
        """Free the resources of activities that have ended, and queue the successors that have become ready."""
        now = self._present.now[0]
        for change in x[self.wind]:
            self.calm, self.calms[0] = list(change.calm), not change.last
        for change in x[self.sea]:
            self.swell, self.calms[1] = list(change.calm), not change.last
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
        """Begin all activities that can begin now, and schedule the next decision."""
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
                    if (self.limited[n] >= 0 and not self.calm_for(n, now)) or not self.window_for(n, now):
                        # a window that begins at the next opening may include fewer breaks, and so be shorter
                        cause, wake = WEATHER, min(wake, one.works.after(now))
            self.causes[n] = cause
            if cause == WEATHER and now - self.waited.setdefault(n, now) > PATIENCE:
                raise ModelError(f"{one.name} waits forever for weather: {BAD}")
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
        if kept and wake == NEVER and not self.running and not (any(self.calms) and WEATHER in self.causes):
            waits = self.activities[kept[0][1]]
            cause = self.causes[kept[0][1]]
            raise ModelError(f"{waits.name} waits forever for {cause}: {BAD if cause == WEATHER else HELD}")
        self.hold_in(0 if self.begun or self.changed or self.telling else wake if wake == NEVER else wake - now)

    def calm_for(self, n: int, now: int) -> bool:
        """Return whether the wind forecast allows a lift until its expected end, or as far as the forecast goes."""
        end = self.calm[self.limited[n]] if self.calm else -1
        one = self.activities[n]
        return end > now and end >= min(now + self.weather.forecast, one.works.add(now, one.expected))

    def window_for(self, n: int, now: int) -> bool:
        """Return whether the sea stays within the operational limit of an activity from now to its expected end.

        The operational limit is the activity's limit times the alpha factor for a window of this length."""
        one = self.activities[n]
        if not self.seas or not one.sea:
            return True
        end = one.works.add(now, one.expected)
        factor = self.weather.factor(end - now)
        if not factor:
            shortest = one.works.shortest(one.expected)
            if self.weather.factor(shortest):
                return False
            message = f"{one.name} needs a window of {shortest / HOUR:.3g} h, longer than all with an alpha factor"
            raise ModelError(f"{message} in the yard")
        return bool(self.swell) and self.swell[self.seas[one.sea.times(factor)]] >= max(end, now + 1)

    def result(self) -> YardSchedule:
        """Return the schedule, and the waiting times by cause."""
        critical = set(self.critical())
        return YardSchedule(
            max(self.end) / 1e9, tuple(t / 1e9 for t in self.begin), tuple(t / 1e9 for t in self.end),
            tuple(int(n in critical) for n in range(len(self.end))), tuple(t / 1e9 for t in self.waits.values()),
        )  # fmt: skip

    def critical(self) -> list[int]:
        """Return the critical sequence of activities, which ends with the activity that ends last.

        It is traced backwards, each time to the activity whose end allowed the later one to begin."""
        last = max(range(len(self.end)), key=lambda n: (self.end[n], -n))
        found = [last]
        while (n := self.releaser(found[-1])) >= 0:
            found.append(n)
        return found[::-1]

    def releaser(self, n: int) -> int:
        """Return the number of the activity whose end allowed activity n to begin; -1 if none did."""
        one, lacked = self.activities[n], self.lacked[n]
        before = [(self.end[m] + lag, True, -m) for m, lag in one.after]
        if lacked:
            for m, freed in enumerate(self.ending):
                if m != n and 0 <= self.end[m] <= self.begin[n] and any(name == lacked for name, _ in freed):
                    before.append((self.end[m], False, -m))
        time, _, number = max(before, default=(-1, False, 1))
        return -number if time >= one.ready and number <= 0 else -1
