"""Pace of a run: as fast as possible, or by the wall clock; pauses and steps of an operator.

A pace sets the horizon of the coordinator's decisions and so delays grants; the digest of a run is the same at any
rate. In a run by the wall clock, a logical time is granted when the clock has reached it and never before; on a machine
that is too slow it is granted late, in order, and the lateness is reported. While a run is paused, nothing at or after
`limit` is decided, and everything before it is done.
"""

import math
import time
from collections.abc import Callable
from threading import Event as Alarm
from typing import NamedTuple

from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Tag, after

LATE_s = 0.01  # more than a wake-up from sleep
REST_s = 1e-6  # shortest rest: less may be lost in rounding the clock


class Lateness(NamedTuple):
    """Lateness of grants in a real-time run: number of late grants, largest and mean lateness [s], share of grants more
    than 10 ms late."""

    rounds: int
    max: float
    mean: float
    share: float

    def __str__(self) -> str:
        """Return the lateness as text for the summary of a run."""
        times = f"latest {self.max * 1e3:.3g} ms late, {self.mean * 1e3:.3g} ms in the mean"
        return f"{times}, {self.share:.1%} of {self.rounds} rounds more than {LATE_s * 1e3:g} ms"


class Pace:
    """Pace of a run without a clock, which runs as fast as possible.

    Decisions reach at most `ahead` [ns] beyond the next event, which bounds how long a command waits.
    """

    def __init__(self, ahead: int = NEVER) -> None:
        self.ahead = ahead

    def horizon(self, first: Tag) -> Tag:
        """Return the logical time up to which grants may be sent; `first`: the earliest pending logical time."""
        return after(first, self.ahead) if first < FOREVER else FOREVER

    def wait(self, first: Tag) -> float:
        """Return the wall time [s] to wait until `first` may be granted, always 0 without a clock."""
        return 0.0

    def rest(self, alarm: Alarm, seconds: float) -> None:
        """Wait for a wall time [s], or until another thread calls for attention through `alarm`."""
        alarm.wait(seconds)

    def granted(self, first: Tag) -> None:
        """Record that the grant for logical time `first` was sent."""

    def hold(self) -> None:
        """Do nothing when the run is paused, since there is no clock to stop."""

    def go_on(self, at: Tag) -> None:
        """Continue at logical time `at` after a pause."""

    def change(self, factor: float) -> float:
        """Refuse to change the rate of a run without a clock; raises ProtocolError."""
        raise ProtocolError("the run goes as fast as it can; start it with --rate to change its rate")

    @property
    def lateness(self) -> Lateness | None:
        """Lateness of grants; None for a run without a clock."""
        return None


class RealTime(Pace):
    """Pace of a run that follows the wall clock: `rate` simulated seconds per second, counted from the first call of
    `horizon`."""

    def __init__(self, rate: float, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(0)
        if not (0.0 < rate < math.inf):
            raise ProtocolError(f"--rate {rate:g}: a rate must be positive and finite; 1 is real time")
        self.rate, self._clock = rate, clock
        self._since: tuple[float, int] | None = None  # time of the clock [s], of the simulation [ns]
        self._rounds, self._late, self._sum, self._max = 0, 0, 0.0, 0.0

    def horizon(self, first: Tag) -> Tag:
        """Return the simulation time that the clock has reached; everything earlier is due."""
        if self._since is None:
            self.go_on(Tag(0))
        return Tag(self._now())

    def wait(self, first: Tag) -> float:
        """Return the wall time [s] until the clock of the run reaches the logical time `first`."""
        if first == FOREVER:
            return math.inf
        return max(REST_s, -self._lateness(first)) if self._since is None or first.t >= self._now() else 0.0

    def granted(self, first: Tag) -> None:
        """Record how late the grant for logical time `first` was sent."""
        late = max(0.0, self._lateness(first))
        self._rounds, self._sum, self._max = self._rounds + 1, self._sum + late, max(self._max, late)
        self._late += late > LATE_s

    def hold(self) -> None:
        """Stop the clock for a pause."""
        self._since = None

    def go_on(self, at: Tag) -> None:
        """Restart the clock at logical time `at` after a pause."""
        self._since = self._since or (self._clock(), at.t)

    def change(self, factor: float) -> float:
        """Change the rate from the present time on, and return the new rate."""
        rate = self.rate * factor
        if not (0.0 < rate < math.inf):
            raise ProtocolError(f"a rate must be positive and finite, not {rate:g}")
        if self._since is not None:
            self._since = self._clock(), self._now()
        self.rate = rate
        return rate

    @property
    def lateness(self) -> Lateness | None:
        """Lateness of all grants so far."""
        n = max(1, self._rounds)
        return Lateness(self._rounds, self._max, self._sum / n, self._late / n)

    def _now(self) -> int:
        assert self._since is not None
        began, t = self._since
        return t + math.floor((self._clock() - began) * self.rate * 1e9)

    def _lateness(self, tag: Tag) -> float:
        """Return the wall time [s] since a logical time was due, counted from the end of its nanosecond."""
        if self._since is None:
            return -math.inf
        began, t = self._since
        return self._clock() - began - (tag.t + 1 - t) * 1e-9 / self.rate


TICK_s = 0.05  # longest rest, so that lost nodes are noticed
GRAIN_ns = 2  # of steps to the next event: a step of the mechanics is announced one nanosecond before its end


class Tempo:
    """Decides up to which logical time the coordinator may grant; also pauses and steps the run."""

    def __init__(self, pace: Pace | None = None) -> None:
        self.pace = pace or Pace()
        self.alarm = Alarm()
        """Event that ends `rest`; other threads set it when they have queued an order or a message."""
        self.limit: Tag | None = None
        self.held = False
        """Whether a pause has been reached: everything before `limit` has been done."""
        self._to_event = False
        self._horizon = self._first = Tag(0)

    def horizon(self, core: OpenCoordinator) -> Tag:
        """Return the logical time up to which grants may be sent now; also record whether a pause holds grants back."""
        self.held = False
        if self._free:
            return FOREVER
        self.alarm.clear()
        self._first = first = core.first
        if self.limit is not None and self.limit <= first and not core.running:
            if not self._to_event or first == FOREVER:
                self.pace.hold()
                self.held = True
                return self.limit
            self.limit = Tag(first.t + GRAIN_ns)  # one instant more
        self._horizon = max(self._horizon, self.pace.horizon(first))
        return self._horizon if self.limit is None else min(self.limit, self._horizon)

    def granted(self) -> None:
        """Record that a grant was sent for the earliest pending logical time."""
        self.pace.granted(self._first)

    def rest(self, core: OpenCoordinator) -> float:
        """Wait until a grant is due, if no node is working; return how long to wait for the next message of a node
        [s]."""
        if self._free:
            return math.inf
        first = core.first
        held = self.limit is not None and self.limit <= first and not self._to_event
        wait = math.inf if held else self.pace.wait(first)
        if core.running:
            return wait or math.inf  # what is due now waits for a node that works
        if wait > 0.0:
            self.pace.rest(self.alarm, min(wait, TICK_s))
        return 0.0

    @property
    def _free(self) -> bool:
        return self.limit is None and self.pace.ahead == NEVER

    def event(self) -> None:
        """Record that a committed event was released; a pending step to the next event is then complete."""
        self._to_event = False

    def pause(self, core: OpenCoordinator) -> Tag:
        """Pause the run at the earliest logical time still possible; return that time."""
        self.limit, self._to_event = Tag(core.safe_ns), False
        return self.limit

    def step(self, core: OpenCoordinator, by_ns: int | None) -> None:
        """Run for `by_ns` [ns], or until the next event is released (None), and pause again."""
        here = self.limit if self.limit is not None else Tag(core.safe_ns)
        self._to_event = by_ns is None
        self.limit = here if by_ns is None else after(here, by_ns)
        self.held = False
        self.pace.go_on(here)

    def go_on(self) -> None:
        """Continue after a pause, and cancel any later pause."""
        if self.limit is not None:
            self.pace.go_on(self.limit)
        self.limit, self._to_event = None, False
