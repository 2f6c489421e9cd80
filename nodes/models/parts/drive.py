"""Actors that move along a trapezoidal speed profile: drives of joints, winches, masters.

A move is sent to the kernel once (SetProfile). Its end is an internal event, whose time this actor computes with the
same arithmetic as the kernel (`heavylift.kernel.description.profile`), exact to the nanosecond: t = d/v + v/a, or 2
sqrt(d/a). The actor knows its reference position at all times, so a move `to` a coordinate and end positions need no
measurement. A halted move ramps down and is done where it stops. Ramps in pulses, and moves from a log, consist of
speeds at given times, with one command for each. While an actuator follows a master it refuses moves; when it is
released, it holds its position.
"""

from math import copysign, inf, isclose

from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.profile import REST, Trapezoid, trapezoid
from heavylift.nodes.devs import Bag, InPort, seconds
from heavylift.nodes.plan import pulses
from heavylift.nodes.plan.actions import EndOrder, Follow, Motion, StopOrder
from heavylift.nodes.plan.interlock import BarredActuator
from heavylift.nodes.plan.plan import Driven

from . import messages as m
from .parts import LiveActor

SAME = 1e-12  # relative, of speeds that differ by rounding
TOUCH = 1e-9  # an end position closer than this is reached [m]


class DriveActor(LiveActor):
    """Actor of a drive or winch: moves the actuator `element` between its end positions (None: no end).

    `emergency`: deceleration of a stop at a limit switch or by an order that gives no deceleration; `stops`: how each
    interlock stops the actuator, by the name of the interlock."""

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
        emergency: float | None = None,
    ) -> None:
        super().__init__(name, element, laws, hears)
        self.emergency, self.stops = emergency, dict[str, BarredActuator]()
        self.initial, self.ends, self.limits = start, (lower, upper), limits
        self.log: Driven | None = None
        self.trip: InPort[m.Trip] | None = None  # from the interlocks of its machine

    def begin(self) -> None:
        """Reset the actuator to rest at its start position, or at the start of its log."""
        self.job: int | None = None
        self.halting = False
        self.limit = ""  # why the present move will not be done
        self.barred: dict[str, int] = {}  # ways along the coordinate (0: both) by what bars them
        self.heading = 0.0  # sign of the present move
        self.law: Follow | None = None
        self._rest(self.initial)
        self.pulsed: Motion | None = None  # the present move, if its ramps shall leave no swing
        log = self.log
        self.rows: pulses.Speeds = tuple(zip(log.times, log.speeds, strict=True)) if log else ()  # still to come
        self.wake = self.rows[0][0] if self.rows else None

    def external(self, e: int, x: Bag) -> None:
        """Process trips of interlocks first, then orders to the drive and state events."""
        for trip in x.get(self.trip, ()) if self.trip else ():
            self.heed(trip)
        super().external(e, x)

    def heed(self, trip: m.Trip) -> None:
        """React to an interlock: block a direction of the drive and stop motion in it, or free the direction again."""
        if (stopped := self.stops.get(trip.interlock)) is None:
            return
        why = f"interlock {trip.interlock}"
        if trip.bars:
            self.bar(why, stopped.way, stopped.emergency)
        else:
            self.barred.pop(why, None)

    def bar(self, why: str, way: int, emergency: float | None) -> None:
        """Block motion of the drive in the direction `way` (+1, -1, or 0 for both) for the reason `why`."""
        self.barred[why] = way
        if self.law is not None:
            self.say(m.Limit(self.element, why, self.reference()[0]))
        elif self.job is not None and not self.halting and way * self.heading >= 0.0:
            self.stop(why, emergency)

    def _barred(self, x: float, way: float) -> bool:
        """Return whether the direction `way` is blocked; if so, report the reason."""
        why = next((why for why, barred in self.barred.items() if way and way * barred >= 0.0), "")
        if why:
            self.say(m.Limit(self.element, why, x))
        return bool(why)

    def execute(self, order: m.Order) -> None:
        """Carry out an order to move, to follow a master, to stop, or to end such an order."""
        if self.log is not None:
            self.refuse(
                order,
                f"{self.element} follows the log column {self.log.source}; remove its orders from the action list",
            )
        match order.what:
            case Motion():
                self.run(order, order.what)
            case Follow():
                self.follow(order, order.what)
            case StopOrder(accel=accel):
                self.stand(order, accel)
            case EndOrder() if self.law is None:
                self.halt(order)
            case EndOrder(s=s):
                self.release(s)
            case _:
                super().execute(order)

    def run(self, order: m.Order, asked: Motion) -> None:
        """Begin a move of the actuator.

        An actuator that is ramping down or controlled by a user model starts with its present speed."""
        if self.law is not None:
            self.refuse(order, f"{self.element} follows {self.law.master}; wait until that is done")
        if self.job is not None and not self.halting and not order.led:
            self.refuse(order, f"{self.element} is already moving; wait for `moves done` or end that move first")
        x, v = self.reference()
        wish = asked.by if asked.by is not None else asked.speed if asked.to is None else asked.to - x
        if self._barred(x, wish):
            return
        if self.job is not None and not order.led:
            self.say(m.Done(self.element, self.job, x))
        self.job, self.halting, self.heading, self.rows = order.id, False, wish, ()
        distance, self.limit = self._distance(asked, x) if asked.speed else (None, "")
        self.pulsed = asked if asked.pulses and v == 0.0 and distance != 0.0 else None
        if self.pulsed is not None:
            self.goal = x + (distance or 0.0)
            self._begin_rows(
                pulses.profile(asked.pulses, distance, asked.speed, asked.accel, asked.periods, self.now.t)
            )
            return
        speed = asked.speed if distance is None else copysign(asked.speed, distance)
        self._profile(x, v, trapezoid(distance, speed, asked.accel, v), asked.accel)
        self.goal = x + (distance if distance is not None else self.profile.displacement(self.profile.d1))
        if self.profile is not REST:
            self.say(m.SetProfile(self.element, self.now.t, speed, asked.accel, distance))
        duration = self.profile.duration if asked.speed else self.profile.d1
        self.wake = self.now.t + seconds(duration) if duration < inf else None

    def halt(self, order: m.Order) -> None:
        """Ramp the actuator down if the move of this order is still in progress."""
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

    def stand(self, order: m.Order, accel: float | None) -> None:
        """Carry out an order to stop the actuator; the order is done when the actuator stands still."""
        if self.law is not None:
            self.refuse(order, f"{self.element} follows {self.law.master}; stop the block instead")
        x, v = self.reference()
        if self.job is not None:
            self.say(m.Done(self.element, self.job, x))
        if v == 0.0:
            self.expire()
            self.wake = None
            self.say(m.Done(self.element, order.id, x))
        else:
            self.job = order.id
            self.stop("", accel or self.emergency)

    def stop(self, limit: str, accel: float | None = None) -> None:
        """Ramp the actuator down to a stop with a deceleration, by default that of its move.

        `accel`: the deceleration [m/s2 or rad/s2]; None: that of the move."""
        x, v = self.reference()
        accel = accel or self.accel
        self.halting, self.limit, self.rows = True, limit, ()
        self._profile(x, v, trapezoid(None, 0.0, accel, v), accel)
        self.goal = x + self.profile.displacement(self.profile.d1)
        self.say(m.SetProfile(self.element, self.now.t, 0.0, accel))
        self.wake = self.now.t + seconds(self.profile.d1)

    def follow(self, order: m.Order, law: Follow) -> None:
        """Make the actuator follow a master coordinate by a reference law."""
        if self.job is not None or self.law is not None:
            self.refuse(order, f"{self.element} is already moving and cannot follow {law.master}")
        self.law = law
        self.say(m.SetFollow(self.element, law.master, law.law))

    def release(self, s: float) -> None:
        """Make the actuator stop following its master, whose present value is `s`."""
        assert self.law is not None
        self._rest(self.x0 + self.law.value(s) - self.law.value(self.law.s))
        self.law = None
        self.say(m.SetFollow(self.element))

    def due(self) -> list[m.KernelInput | m.Report]:
        """Return the report for the end of a move, if the move ends now."""
        if self.job is None or self._goes_on:
            return []
        if self.limit:
            return [m.Limit(self.element, self.limit, self.goal)]
        return [m.Done(self.element, self.job, self.goal)]

    def expire(self) -> None:
        """End the move of the actuator, or continue it with the next speed of its profile."""
        if self._goes_on:
            self._next_row()
            return
        self.job, self.halting, self.limit = None, False, ""
        self._rest(self.goal)

    def reference(self) -> tuple[float, float]:
        """Return the actuator's present reference position and speed, without the contribution of a followed master."""
        t = (self.now.t - self.since) / 1e9
        return self.x0 + self.profile.displacement(t), self.profile.speed(t)

    def _begin_rows(self, rows: pulses.Speeds) -> None:
        self.rows, self.top = rows, max(abs(v) for _, v in rows)
        self._next_row()

    @property
    def _goes_on(self) -> bool:
        """Whether the move continues after the scheduled time, with further speeds or at constant speed."""
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

    def _distance(self, order: Motion, x: float) -> tuple[float | None, str]:
        """Return the distance to go (None: unlimited), and the name of the limit that shortens it ("": none)."""
        wish = order.by if order.to is None else order.to - x
        up = (order.speed if wish is None else wish) > 0.0
        end = self.ends[up]
        if end is None or (wish is not None and (x + wish - end) * (1 if up else -1) <= TOUCH):
            return wish, ""
        left = end - x
        return (left if (left > 0.0) == up else 0.0), self.limits[up]


class HeldActor(LiveActor):
    """Replacement for the drive of a joint that is not modelled: refuses all orders with the reason `why`."""

    def __init__(self, name: str, element: str, why: str) -> None:
        super().__init__(name, element)
        self.why = why

    def execute(self, order: m.Order) -> None:
        """Refuse the order, because the joint of the drive is not modelled."""
        self.refuse(order, self.why)
