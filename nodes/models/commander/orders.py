"""Translation of the scene's orders into orders to actors, with their reports and the orders in progress.

An order of the scene becomes one order to each actor that it concerns; a job represents it until its Done report.
"""

from math import isfinite
from typing import Any

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, In, Message, Out, OutPort, seconds
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.models.user_models import aim_port
from heavylift.nodes.plan import actions as scene
from heavylift.nodes.plan.places import ASIDE, LED, numbered
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.user_models import Led

from .actuator_registry import first_lugs, first_state, machines, turn_of, turns
from .conditions import EvaluationContext, OrderRejected, crossings, holds, watched
from .jobs import CommanderJob, barred, make_way, partners, still_open
from .order_checks import Machines

ROUNDING = 1e-9  # of a speed


class Orders(Atomic):
    """Sends the orders of a plan to their actors and tracks their execution."""

    report, command = In(m.Report), In(m.OperatorCommand)
    stage = Out(m.Stage)
    skipped = Out(m.Skipped)
    finished = Out(m.Finished)
    answer = Out(m.OperatorAnswer)

    def __init__(self, name: str, plan: Plan) -> None:
        """Create the model for the orders of a plan: the plan of the whole scene, or the part with one action list."""
        super().__init__(name)
        self.take(plan)
        self.own = plan.lists[0].machines if plan.lists else ()
        self.lists = self.add_out("lists", m.Report) if plan.lists else None  # to other lists
        targets = dict.fromkeys([*(self.own if plan.lists else machines(plan)), *watched(plan)])
        self.turn = turn_of(plan)
        targets |= {self.turn: None} if turns(plan) else {}
        self.aims = {
            self.add_in(aim_port(own.name, led.port), m.SetPoint): led
            for own in plan.models
            for led in own.leads
            if not plan.lists or led.move.model in self.own
        }
        self.to: dict[str, OutPort[m.Order]] = {name: self.add_out(f"order_{name}", m.Order) for name in targets}

    def take(self, plan: Plan) -> None:
        """Carry out the orders of a plan, which needs the ports that there are."""
        self.plan, self.known, self.end = plan, Machines(plan), plan.first + len(plan.actions)
        self.owners, self.index, self.lugs = self.known.owners, plan.first, first_lugs(plan.machines)

    def _clear(self) -> None:
        """Set the initial state, without open orders."""
        machines = self.known.parts
        self.picture, self.lugs, self.theta = first_state(machines), first_lugs(machines), self.plan.start
        self.jobs: list[CommanderJob] = []
        self.places = {each.name: each.start for machine in self.plan.machines for each in machine.actuators}
        self.led: dict[str, float] = {}  # speed that models ask of actuators
        self.ids = 0
        self.outbox: list[tuple[OutPort[Any], Message]] = []

    def _aim(self, led: Led, speed: float) -> None:
        """Order an actuator to take the speed that a user model demands, unless it has this speed already."""
        move, who = led.move, self.plan.leader(led.move.actuator)
        if not isfinite(speed):
            raise ModelError(f"{who}: {led.port} sends {speed}, which is not a speed; send a finite number")
        if move.speed and abs(speed) > move.speed * (1.0 + ROUNDING):
            most = f"{move.speed:g} m/s or rad/s"
            raise ModelError(
                f"{who}: {led.port} requests a speed of {abs(speed):g} from {move.actuator}, whose limit is {most}; "
                "limit the set-points"
            )
        try:
            self.known.check(move, self.picture, self.lugs)
        except OrderRejected as error:
            raise ModelError(f"{who}: {error}") from None
        if speed != self.led.get(move.actuator, 0.0):
            self.led[move.actuator] = speed
            self.ids += 1
            self._tell(move.actuator, self.ids, (LED,), scene.for_actor(move, speed=speed))

    def _give(self, order: scene.Order, at: tuple[int, int]) -> None:
        """Translate an order of the scene into orders to actors; `at`: numbers of the action and of the order in it."""
        self.known.check(order, self.picture, self.lugs)
        self.known.check_led(order, self.lugs)
        match order:
            case scene.Wait():
                self._job(at, "wait", "", ends_ns=self.now.t + seconds(order.seconds))
            case scene.Move():
                if order.until is None or not self._holds(order.until, at[0], self.now.t):
                    for kept in order.keeps:
                        make_way(self.jobs, kept.actuator)
                    job = self._job(at, order.verb, order.actuator, order.until, followers=order.keeps)
                    job.move = order
                    for kept in order.keeps:
                        self._tell(kept.actuator, job.id, at, scene.for_actor(kept, s=self.places[order.actuator]))
                    self._tell(job.actor, job.id, at, scene.for_actor(order))
                elif at[0] != ASIDE:
                    self.outbox.append((self.skipped, m.Skipped(at[0], order.actuator)))
            case scene.Turn():
                found = self.known.followers(order, self.lugs, self.turn)
                for f in found:
                    make_way(self.jobs, f.actuator)
                job = self._job(at, "turn", self.turn, order.until, followers=tuple(found))
                for f in found:
                    self._tell(f.actuator, job.id, at, scene.for_actor(f, s=self.theta))
                turn = scene.Motion(speed=order.rate, accel=order.accel, to=order.to)
                self._tell(self.turn, job.id, at, turn)
            case scene.Hookup():
                job = self._job(at, "hook", order.sling)
                lug = self.known.lugs.get(order.lug)
                self._tell(order.sling, job.id, at, scene.for_actor(order, p=lug.p if lug else None))
            case scene.UnhookSling():
                job = self._job(at, "release" if order.parted else "unhook", order.sling)
                self.picture.parted |= {order.sling} if order.parted else set()
                self._tell(order.sling, job.id, at, scene.for_actor(order))
            case scene.Begin():
                assert self.lists is not None
                self.outbox.append((self.lists, m.Begun(order.lift)))
            case scene.StopOrder():
                self._stop(order, at)
            case scene.BrakeOrder():
                job = self._job(at, "brake", order.brake)
                self._tell(order.brake, job.id, at, scene.for_actor(order))

    def _stop(self, order: scene.StopOrder, at: tuple[int, int]) -> None:
        """Stop an actuator, the actuators that move together with it, and a turn that it follows; their orders end."""
        actor = order.actuator
        for job in (job for job in self.jobs if actor in (f.actuator for f in job.followers)):
            if not job.halting:
                job.halting, job.at = True, at
                self._tell(job.actor, job.id, at, scene.EndOrder())
            return
        if not any(job.verb == "stop" and job.actor == actor for job in self.jobs):
            others = partners(self.jobs, actor)
            self.jobs = [job for job in self.jobs if job.actor != actor or not job.limit]
            self.ids += 1
            led = tuple(f for job in self.jobs if job.actor == actor for f in job.followers)
            for job in (job for job in self.jobs if job.actor == actor):
                job.followers = ()  # they follow until it stands
            self.jobs.append(CommanderJob(self.ids, at, "stop", actor, self.now.t, followers=led, halting=True))
            self._tell(actor, self.ids, at, scene.for_actor(order))
            for job in others:
                self._stop(self._stopping(job.actor, order.accel), at)

    def _stopping(self, actor: str, accel: float | None = None) -> scene.StopOrder:
        return scene.StopOrder(model=self.owners[actor], actuator=actor, accel=accel)

    def _job(
        self,
        at: tuple[int, int],
        verb: str,
        actor: str,
        until: scene.Condition | None = None,
        *,
        ends_ns: int | None = None,
        followers: tuple[scene.Follow, ...] = (),
    ) -> CommanderJob:
        """Open a job for an order, and order that the thresholds of its `until` are watched."""
        if actor:
            make_way(self.jobs, actor)
        self.ids += 1
        job = CommanderJob(self.ids, at, verb, actor, self.now.t, until, ends_ns, followers)
        self.jobs.append(job)
        self._watch(until, at)
        return job

    def _hear(self, report: m.Report) -> None:
        """Update the observed state and the open jobs with a report."""
        if isinstance(report, m.Done | m.Limit) and report.actor in self.places:
            self.places[report.actor] = report.position
        match report:
            case m.Done():
                for job in [job for job in self.jobs if job.id == report.id and job.actor]:  # waits end by themselves
                    self._close(job, report.position)
            case m.Limit():
                self._part(report.actor, None)
                for job in self.jobs:
                    if job.actor == report.actor:
                        job.limit = report.limit
                        self._release(job, report.position)
                    if any(f.actuator == report.actor for f in job.followers):
                        self._stop(self._stopping(report.actor), job.at)  # what one cannot follow is over for all
            case m.Tripped() if report.over and not report.bypassed:
                stops = next(x.stops for x in self.plan.interlocks if x.name == report.actor)
                for actor, accel in barred(self.jobs, stops):
                    self._part(actor, accel)
            case m.Hooked() if report.lug:
                self.lugs[report.actor] = report.lug
            case m.Unhooked():
                self.lugs.pop(report.actor, None)
        self.picture.note(report)

    def _part(self, actor: str, accel: float | None) -> None:
        """Stop the actuators that move together with `actor`, which was stopped with the deceleration `accel` (None:
        that of each move)."""
        others = partners(self.jobs, actor)
        for job in (job for job in self.jobs if job.actor == actor and others):
            job.halting = True
        for job in others:
            assert job.move is not None
            self._stop(self._stopping(job.actor, accel or job.move.accel), job.at)

    def _close(self, job: CommanderJob, position: float) -> None:
        """Close a finished order; if it was a turn, order its followers to hold their positions."""
        self.jobs.remove(job)
        if job.until is not None:
            self._forget(job.until, job.at)
        if job.actor == self.turn:
            self.theta = position
        self._release(job, position)

    def _release(self, job: CommanderJob, position: float) -> None:
        """Order the actuators that follow the motion of this order to hold their positions."""
        for f in job.followers:
            self._tell(f.actuator, job.id, job.at, scene.EndOrder(s=position))
        job.followers = ()

    def _watch(self, condition: scene.Condition | None, at: tuple[int, int]) -> None:
        for i, c in crossings(condition):
            watch = scene.WatchThreshold(value=c.value, rising=c.rising)
            self._tell(c.threshold.name, 0, (*at, i), watch, self.to[c.model])

    def _forget(self, condition: scene.Condition, at: tuple[int, int]) -> None:
        for i, c in crossings(condition):
            if c.threshold.name not in self.picture.reached:
                self._tell(c.threshold.name, 0, (*at, i), scene.EndOrder(), self.to[c.model])

    def _tell(
        self,
        actor: str,
        number: int,
        at: tuple[int, ...],
        what: scene.ActorCommand,
        port: OutPort[m.Order] | None = None,
    ) -> None:
        """Send an order to an actor through the port of its machine, or through `port` if given."""
        to = port or self.to[self.turn if actor == self.turn else self.owners[actor]]
        self.outbox.append((to, m.Order(actor, number, at, what)))

    def _holds(self, condition: scene.Condition, action: int, since_ns: int) -> bool:
        try:
            return holds(
                condition, self.picture, EvaluationContext(self.now.t, since_ns, still_open(self.jobs, action - 1))
            )
        except OrderRejected as error:
            if action == ASIDE:
                raise
            raise ModelError(f"{condition.where or numbered((action,))}: {error}") from None
