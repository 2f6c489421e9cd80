"""Actors that move something along a trapezoid: drives of joints, winches, Masters.

A move is sent to the kernel once (SetProfile); its end is an internal event that this actor computes with
the same arithmetic (`heavylift.kernel.description.profile`), exact to the nanosecond: t = d/v + v/a, or 2 sqrt(d/a).
The actor knows its reference at all times, so `to` a coordinate and end positions need no measurement.  A
halted move ramps down and is done where it stands.  Ramps in pulses, and a log, are speeds at times, with a
command for each.  While it follows a Master it takes no moves; released, it holds its place.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import copysign, inf, isclose

from heavylift.kernel.description.mechanics import System, Threshold
from heavylift.kernel.description.profile import REST, Trapezoid, trapezoid
from heavylift.nodes.devs import ns
from heavylift.nodes.plan import pulses
from heavylift.nodes.plan.plan import Driven

from . import messages as m
from .inputs import part, value
from .parts import LiveActor

SAME = 1e-12  # relative, of speeds that differ by rounding
TOUCH = 1e-9  # an end position closer than this is reached [m]
SWITCH_BACK = 0.1  # an upper limit switch closes again this far below [m]


class DriveActor(LiveActor):
    """Moves the actuator `element` between its end positions (None: none)."""

    def __init__(
        self,
        name: str,
        element: str,
        laws: System | None = None,
        *,
        start: float,
        lower: float | None = None,
        upper: float | None = None,
        limits: tuple[str, str] = ("travel limit", "travel limit"),
        hears: tuple[str, ...] = (),
    ) -> None:
        super().__init__(name, element, laws, hears)
        self.initial, self.ends, self.limits = start, (lower, upper), limits
        self.log: Driven | None = None

    def begin(self) -> None:
        """Stand at the start."""
        self.job: int | None = None
        self.halting = False
        self.limit = ""  # why the present move will not be done
        self.law: m.Follow | None = None
        self._rest(self.initial)
        self.pulsed: m.RunInPulses | None = None  # the present move, if its ramps shall leave no swing
        log = self.log
        self.rows: pulses.Speeds = tuple(zip(log.times, log.speeds, strict=True)) if log else ()  # still to come
        self.wake = self.rows[0][0] if self.rows else None

    def obey(self, order: m.Order) -> None:
        """Run, aim, halt, follow, release."""
        if self.log is not None:
            self.refuse(order, f"{self.element} follows {self.log.source}; take its orders out of the action list")
        match order:
            case m.Run():
                self.run(order)
            case m.Halt():
                self.halt(order)
            case m.Aim():
                self.aim(order)
            case m.Follow():
                self.follow(order)
            case _:
                super().obey(order)

    def run(self, order: m.Run) -> None:
        """Begin a move; one that is still ramping down passes its speed on."""
        if self.law is not None:
            self.refuse(order, f"{self.element} follows {self.law.master}, wait until that is done")
        if self.job is not None and not self.halting:
            self.refuse(order, f"{self.element} is moving already, wait for `moves done` or end that first")
        x, v = self.reference()
        if self.job is not None:
            self.say(m.Done(self.element, self.job, x))
        self.job, self.halting = order.id, False
        distance, self.limit = self._distance(order, x)
        self.goal = x + (distance or 0.0)
        self.pulsed = order if isinstance(order, m.RunInPulses) and v == 0.0 and distance != 0.0 else None
        self.rows = ()
        if self.pulsed is not None:
            p = self.pulsed
            self._begin_rows(pulses.profile(p.pulses, distance, p.speed, p.accel, p.periods, self.now.t))
            return
        speed = order.speed if distance is None else copysign(order.speed, distance)
        self._profile(x, v, trapezoid(distance, speed, order.accel, v), order.accel)
        if self.profile is not REST:
            self.say(m.SetProfile(self.element, self.now.t, speed, order.accel, distance))
        self.wake = self.now.t + ns(self.profile.duration) if self.profile.duration < inf else None

    def aim(self, order: m.Aim) -> None:
        """Lead the present speed to another one, as far as the end position on that side."""
        if self.law is not None:
            self.refuse(order, f"{self.element} follows {self.law.master}, wait until that is done")
        self.job, self.halting, self.limit, self.pulsed, self.rows = order.id, False, "", None, ()
        x, v = self.reference()
        distance = None
        if order.speed:
            run = m.Run(order.actor, order.id, order.at, order.speed, order.accel)
            distance, self.limit = self._distance(run, x)
        speed = order.speed if distance is None else copysign(order.speed, distance)
        self._profile(x, v, trapezoid(distance, speed, order.accel, v), order.accel)
        duration = self.profile.duration if order.speed else self.profile.d1
        self.goal = x + (distance if distance is not None else self.profile.displacement(self.profile.d1))
        if self.profile is not REST:
            self.say(m.SetProfile(self.element, self.now.t, speed, order.accel, distance))
        self.wake = self.now.t + ns(duration) if duration < inf else None

    def halt(self, order: m.Halt) -> None:
        """Ramp down the move of that id, unless it stands already."""
        if self.job != order.id or self.halting:
            return
        x, v = self.reference()
        if self.pulsed is None or not isclose(abs(v), self.top, rel_tol=SAME):  # in a ramp it swings already
            self.stop("")
            return
        p, self.halting = self.pulsed, True
        rows = pulses.stop(p.pulses, v, p.accel, p.periods[1], self.now.t)
        self.goal = x + pulses.way(rows)
        self._begin_rows(rows)

    def stop(self, limit: str, accel: float | None = None) -> None:
        """Ramp down now, with the ramp of the move or another one."""
        x, v = self.reference()
        accel = accel or self.accel
        self.halting, self.limit, self.rows = True, limit, ()
        self._profile(x, v, trapezoid(None, 0.0, accel, v), accel)
        self.goal = x + self.profile.displacement(self.profile.d1)
        self.say(m.SetProfile(self.element, self.now.t, 0.0, accel))
        self.wake = self.now.t + ns(self.profile.d1)

    def follow(self, order: m.Follow) -> None:
        """Follow a Master from here, or let it go and stand still."""
        if order.master and (self.job is not None or self.law is not None):
            self.refuse(order, f"{self.element} is moving already and cannot follow {order.master}")
        if order.master:
            self.law = order
            self.say(m.SetFollow(self.element, order.master, 0.0, order.kc, order.ks))
        elif self.law is not None:
            self._rest(self.x0 + value(self.law, order.s) - value(self.law, self.law.s))
            self.law = None
            self.say(m.SetFollow(self.element))

    def due(self) -> list[m.KernelInput | m.Report]:
        """The end of a move."""
        if self.job is None or self._goes_on:
            return []
        if self.limit:
            return [m.Limit(self.element, self.limit, self.goal)]
        return [m.Done(self.element, self.job, self.goal)]

    def expire(self) -> None:
        """Stand where the move ended, or go on to the next speed."""
        if self._goes_on:
            self._next_row()
            return
        self.job, self.halting, self.limit = None, False, ""
        self._rest(self.goal)

    def reference(self) -> tuple[float, float]:
        """Coordinate and speed that are asked for now (of its own moves)."""
        t = (self.now.t - self.since) / 1e9
        return self.x0 + self.profile.displacement(t), self.profile.speed(t)

    def _begin_rows(self, rows: pulses.Speeds) -> None:
        self.rows, self.top = rows, max(abs(v) for _, v in rows)
        self._next_row()

    @property
    def _goes_on(self) -> bool:
        """Whether what it wakes for is no end: there are further speeds, or the one that is reached is kept."""
        return self.log is not None or len(self.rows) > 1 or bool(self.rows and self.rows[0][1])

    def _next_row(self) -> None:
        x, v = self.reference()
        self.rows = self.rows[1:]
        if not self.rows and self.log is None:
            return
        self.wake, speed = self.rows[0] if self.rows else (None, 0.0)
        if not isclose(speed, v, rel_tol=SAME):
            last = self.log.accel if self.log else 0.0
            accel = abs(speed - v) * 1e9 / (self.wake - self.now.t) if self.wake is not None else last
            self._profile(x, v, trapezoid(None, speed, accel, v), accel)
            self.say(m.SetProfile(self.element, self.now.t, speed, accel))

    def _rest(self, x: float) -> None:
        self._profile(x, 0.0, REST, 0.0)
        self.goal = x

    def _profile(self, x: float, v: float, profile: Trapezoid, accel: float) -> None:
        self.x0, self.since, self.profile, self.accel = x, self.now.t, profile, accel

    def _distance(self, order: m.Run, x: float) -> tuple[float | None, str]:
        """How far to go (None: endlessly), and the limit that cuts the way short."""
        wish = order.by if order.to is None else order.to - x
        up = (order.speed if wish is None else wish) > 0.0
        end = self.ends[up]
        if end is None or (wish is not None and (x + wish - end) * (1 if up else -1) <= TOUCH):
            return wish, ""
        left = end - x
        return (left if (left > 0.0) == up else 0.0), self.limits[up]


class HeldActor(LiveActor):
    """In place of the drive `element` of a joint that is not modelled: refuses all orders; `why`: its answer."""

    def __init__(self, name: str, element: str, why: str) -> None:
        super().__init__(name, element)
        self.why = why

    def obey(self, order: m.Order) -> None:
        """Refuse."""
        self.refuse(order, self.why)


class WinchActor(DriveActor):
    """A drive that winds a rope: reports when the rope is taut or slack; has an upper limit switch at the hook.

    `switch` is the height of the hook eye with the value at which it trips; hoisting stops then, with the deceleration
    `emergency` where it has one.  A rope of several
    `pieces` (with their parts of its length) is wound as if all of them were.
    """

    def __init__(
        self,
        name: str,
        rope: str,
        laws: System | None = None,
        *,
        start: float,
        lower: float | None = None,
        upper: float | None = None,
        switch: tuple[Threshold, float] | None = None,
        pieces: Mapping[str, float] | None = None,
        emergency: float | None = None,
    ) -> None:
        guards = (switch[0],) if switch else ()
        laws = laws or System(thresholds=guards)
        hears = (rope, *(guard.name for guard in guards))
        limits = ("shortest rope", "drum empty")
        super().__init__(name, rope, laws, start=start, lower=lower, upper=upper, limits=limits, hears=hears)
        self.switch, self.pieces, self.emergency = switch, pieces or {rope: 1.0}, emergency

    def begin(self) -> None:
        """Arm the limit switch."""
        super().begin()
        self.tripped = False
        self._arm()

    def run(self, order: m.Run) -> None:
        """Refuse to hoist any higher while the limit switch is open."""
        way = order.by if order.by is not None else order.speed if order.to is None else order.to - self.reference()[0]
        if self.tripped and way < 0.0:
            self.say(m.Limit(self.element, "upper limit", self.reference()[0]))
        else:
            super().run(order)

    def say(self, *messages: m.KernelInput | m.Report) -> None:
        """Give every piece of the rope its part."""
        for message in messages:
            if isinstance(message, m.SetProfile | m.SetFollow):
                super().say(*(part(message, *piece) for piece in self.pieces.items()))
            else:
                super().say(message)

    def aim(self, order: m.Aim) -> None:
        """Do not hoist any higher while the limit switch is open."""
        if self.tripped and order.speed < 0.0:
            self.say(m.Limit(self.element, "upper limit", self.reference()[0]))
        else:
            super().aim(order)

    def notice(self, event: m.StateEvent) -> None:
        """The rope changed its state, or the limit switch did."""
        if event.name == self.element:
            if event.what in ("taut", "slack"):
                self.say(m.RopeState(self.element, event.what, event.value))
            return
        self.tripped = not self.tripped
        self._arm()
        if self.tripped and self.job is not None and not self.halting:
            self.stop("upper limit", self.emergency)
        elif self.tripped:
            self.say(m.Limit(self.element, "upper limit", self.reference()[0]))

    def _arm(self) -> None:
        if self.switch is not None:
            guard, height = self.switch
            self.say(m.Watch(guard.name, height - SWITCH_BACK * self.tripped, not self.tripped))
