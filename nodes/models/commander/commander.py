"""The commander: an atomic model that carries out the action list and is connected to every actor (section 4.1 of the
paper).

It begins an action when the action's condition holds, sends each order to its actor exactly once, processes the
reports, halts moves whose `until` holds, and sends `stage` when a stage begins and `finished` at the end. A Done report
ends a move. An action that contradicts the state ends the run with an error; `waiting_for` describes what a stalled run
waits for. Messages between models refer to actions and orders by number; error messages name the lines in the scene.
"""

import msgspec
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Bag, seconds
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan import actions as scene
from heavylift.nodes.plan.places import ASIDE, WHEN, located, place
from heavylift.nodes.plan.plan import driven

from .conditions import OFF, EvaluationContext, OrderRejected, next_time, words
from .jobs import addressed, clock, still_open
from .orders import Orders


class Commander(Orders):
    """Atomic model that executes the action list of a plan."""

    def start(self) -> None:
        """Begin the first action of the list if its condition holds."""
        self._clear()
        self.index, self.since, self.over, self.ended = self.plan.first, 0, False, False
        self._expect()
        self._settle()

    def external(self, e: int, x: Bag) -> None:
        """Process reports and commands, then begin the actions and orders that have become possible."""
        for report in x.get(self.report, ()):
            self._hear(report)
        for command in x.get(self.command, ()):
            self._execute(command)
        for port, led in self.aims.items():
            for point in x.get(port, ()):
                self._aim(led, point.value)
        self._settle()

    def output(self) -> None:
        """Send the commander's orders to the machines."""
        for port, message in self.outbox:
            port.send(message)

    def internal(self) -> None:
        """Remove the orders that were sent, and give the orders that are possible now."""
        self.outbox = []
        self._settle()

    def waiting_for(self) -> str:
        """Return a sentence about the conditions that the action list is waiting for; "" if the list is done."""
        moment = EvaluationContext(self.now.t, self.since, still_open(self.jobs, self.index - 1))
        if self.index == self.end:
            if all(job.ends_ns is not None for job in self.jobs):
                return ""  # a last `wait` that the end of the scene cuts short
            lacks, where = words(scene.MovesDone(), self.picture, moment), ""
        else:
            action = self.plan.action(self.index)
            condition = action.when or scene.MovesDone()
            where = condition.where or action.where
            lacks = words(condition, self.picture, moment)
        stuck = "".join(f"; {driven(job.actor)} stopped ({job.limit})" for job in self.jobs if job.limit)
        since = clock(self.since)
        return f"still waiting for {lacks} since {since}{stuck}, {where or 'end'}" if lacks else ""

    def _settle(self) -> None:
        """Begin and end all that is possible now, then wait for the next report or time."""
        while not self.over and (self._end_moves() or self._next_action()):
            pass
        times = [job.ends_ns for job in self.jobs if job.ends_ns is not None]
        for job in self.jobs:
            times += next_time(job.until, EvaluationContext(self.now.t, job.since_ns))
        if self.index < self.end and not self.outbox:
            action = self.plan.action(self.index)
            times += next_time(action.when, EvaluationContext(self.now.t, self.since))
            if action.timeout is not None:
                times.append(self.since + seconds(action.timeout))
        if self.outbox:
            self.hold_in(0)
        elif times and not self.over:
            self.hold_in(min(times) - self.now.t)
        else:
            self.passivate()

    def _end_moves(self) -> bool:
        """Close waits that are over and halt moves whose `until` holds; return whether anything was closed."""
        closed = False
        for job in list(self.jobs):
            if job.ends_ns is not None and job.ends_ns <= self.now.t:
                self.jobs.remove(job)
                closed = True
            elif job.until is not None and not job.halting and self._holds(job.until, job.action, job.since_ns):
                job.halting = True
                if job.limit:
                    self.jobs.remove(job)
                    closed = True
                else:
                    self._tell(job.actor, job.id, job.at, scene.EndOrder())
        return closed

    def _next_action(self) -> bool:
        """Begin the next action if its condition holds, or report the end of the list; return whether an action
        began."""
        plan = self.plan
        if self.index == self.end:
            if not still_open(self.jobs, self.index - 1) and not still_open(self.jobs, ASIDE):
                if self.lists is not None and not self.ended:
                    self.outbox.append((self.lists, m.Ended(self.name)))
                if plan.end is None:
                    self.over = True
                    self.outbox.append((self.finished, m.Finished()))
                self.ended = True
            return False
        action = plan.action(self.index)
        condition = action.when or scene.MovesDone()
        if not self._holds(condition, self.index, self.since):
            if action.timeout is not None and self.now.t >= self.since + seconds(action.timeout):
                raise ModelError(f"{self.waiting_for()}: the timeout of {action.timeout:g} s has passed")
            return False
        lateral = {job.actor for job in self.jobs if job.action == ASIDE and not job.halting and not job.limit}
        if any(lateral if actor is None else actor in lateral for actor in map(addressed, action.orders)):
            return False  # an operator's order comes first
        self._forget(condition, (self.index, WHEN))
        self.index, self.since = self.index + 1, self.now.t
        if action.stage:
            self.outbox.append((self.stage, m.Stage(action.stage, self.index - 1)))
        if fall := self.known.lets_fall(action.orders, self.picture, self.lugs):
            raise ModelError(f"{action.where or place(plan, (self.index - 1, 0))}: {fall}")
        for i, order in enumerate(action.orders):
            at = self.index - 1, i
            try:
                self._give(order, at)
            except OrderRejected as error:
                raise ModelError(f"{place(plan, at)}: {located(plan, str(error), error.by)}") from None
        self._expect()
        return True

    def _execute(self, command: m.OperatorCommand) -> None:
        """Carry out an operator's command: all of its orders or, if one of them is refused, none. A command without
        orders ends the run."""
        if not command.action:
            self.outbox += [] if self.over else [(self.finished, m.Finished())]
            self.over = True
            return
        orders = msgspec.msgpack.decode(command.action, type=scene.Action).orders
        # of all places where slings can hang, those are meant where they do
        hung = [
            x for x in orders if not isinstance(x, scene.UnhookSling) or self.picture.ropes.get(x.sling, OFF) != OFF
        ]
        orders = tuple(hung) or orders
        asked = [self.owners.get(addressed(order) or "", "") for order in orders]
        if self.plan.lists and asked[0] not in self.own:
            return  # another list answers
        before = list(self.jobs), list(self.outbox), self.ids
        answer = m.OperatorAnswer(command.text, self.now.t)
        try:
            if self.plan.lists and (self.over or not {*asked} <= {*self.own}):
                many = "it addresses machines of several lifts; give one command for each lift"
                raise OrderRejected("the action list of this lift is over" if self.over else many)
            if fall := self.known.lets_fall(orders, self.picture, self.lugs):
                raise OrderRejected(fall)
            for i, order in enumerate(orders):
                self._give(order, (ASIDE, i))
        except OrderRejected as error:
            self.jobs, self.outbox, self.ids = before
            answer = m.OperatorAnswer(command.text, self.now.t, str(error), error.by)
        self.outbox.append((self.answer, answer))

    def _expect(self) -> None:
        """Order the actors to watch the thresholds on which the condition of the next action depends."""
        if self.index < self.end:
            self._watch(self.plan.action(self.index).when, (self.index, WHEN))
