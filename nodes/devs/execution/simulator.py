"""The abstract simulator of Parallel DEVS, flat: one heap of distinct tags, direct routes.

One call of `advance(tag, bag)` does, for tag = next_time or an earlier tag at which something arrives:
  1. lambda of all imminent atomics (those with next == tag), in path order;
  2. route: each message lies in its receivers' bags at this same tag, ordered by source (see `flatten`);
  3. one transition per atomic: `internal` if imminent, `external` if it got something, `confluent` if both;
  4. next = after(tag, ta) for each; a wait of zero comes back at the next microstep.
Driving it from a larger simulation: while min(next_time, first input) < limit, read `outputs()` if that
tag is next_time, then `advance`. `outputs` may be called any number of times, or not at all. `run` does this alone,
half-open: events at t < until. A node may let it work ahead of an `advance`, by a bounded number of tags at which
nothing leaves the root. After Chow and Zeigler (1994); two phases after adevs. Broken rules raise ModelError.
"""

from collections.abc import Callable, Sequence
from typing import Any

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import Delivery, Event, Slack
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Model, Present
from heavylift.nodes.devs.ports import InPort, Port
from heavylift.nodes.devs.tags import BEGIN, FOREVER, NEVER, Instant, Tag, after, tag_of
from heavylift.nodes.devs.travelling import travelling

from .bags import deliver, entry, fitting, offered, received, sorted_bag
from .flatten import flatten
from .lookahead import Observed, keep_promises, leaving, outs, promised, speakers, still_promised
from .purity import Witness
from .rules import LIMIT, Patience, fail
from .schedule import Schedule
from .snapshot import frozen, thawed
from .transitions import Log, Trace, Transition

SILENT = 256  # tags that a node works ahead of an `advance`


class Simulator:
    """Runs one model, alone or as the `Steppable` of a node."""

    def __init__(
        self,
        model: Model,
        log: Callable[[Transition], None] | None = None,
        microsteps: int = LIMIT,
        trace: Trace | None = None,
        watched: bool = True,
    ) -> None:
        """`log` hears of every transition, `trace` keeps them; a zero-time loop of `microsteps` tags is an error, and
        so is an output that changes the state, where that is `watched`."""
        self.model, self._patience, self._watched = model, Patience(microsteps), watched
        self.trace = Log(log) if log is not None else trace
        self._present, self._observed = Present(live=True), Observed()
        self._due: Tag | None = None  # the next tag, once it is looked for
        self._adopt()

    def _adopt(self) -> None:
        """Take the model tree as it is now."""
        if self.trace is not None:
            self.trace.settle()
        self.atomics = flatten(self.model)
        self._promises = any(port.lookahead for m in self.atomics for port in outs(m))
        self._speakers = speakers(self.atomics)
        self._ahead = min((ahead for _, ahead in self._speakers), default=NEVER)
        self.lookahead = promised(self.model, self.atomics)
        for m in (*self.atomics, self.model):
            m._present = self._present

    def start(self) -> None:
        """Set every atomic to its initial state at (0, 0); starting again is a fresh run."""
        self._last: Instant = (-1, 0)
        self._due, self._spoken = None, False  # whether lambda has run for it
        self._staged: list[tuple[InPort[Message], Message]] = []
        self._observed = Observed()
        self._schedule, self._witness = Schedule(self.atomics), Witness(self._watched)
        self._witness.meet(self.atomics)
        self._present.now, self._present.speaker, self._present.busy = (0, 0), None, False
        for m in self.atomics:
            self._schedule.begin(m, self._last, self._present)

    @property
    def next_time(self) -> Tag:
        """Tag of the next internal transition; FOREVER when all are passive."""
        if self._present.busy:
            at = f"{self.model.path} at {Tag(*self._present.now)}"
            raise ModelError(f"{at}: a transition of this tag failed, or runs the simulator itself; start again")
        if self._present.changes:
            self._restructure()
        if self._due is None:
            if not hasattr(self, "_schedule"):
                raise ModelError(f"{self.model.path}: nothing has begun, call start() first")
            self._due = tag_of(self._schedule.next(self._last))
        return self._due

    @property
    def passed(self) -> int:
        """A number that grows with progress; any thread may read it."""
        return sum(self._present.now)

    @property
    def quiet(self) -> Tag:
        """Earliest tag at which something can leave the root if nothing reaches it."""
        tag = self.next_time
        if tag == FOREVER or leaving(self._lambda(tag).sources):
            return tag
        soonest, t = after(tag, self._ahead), tag.t
        if soonest.t == t:
            return soonest
        return min(soonest, Tag(min((m._t for m, _ in self._speakers if m._t > t), default=NEVER)))

    def outputs(self) -> list[Event]:
        """What leaves the root at next_time, in total order; changes nothing."""
        tag = self.next_time
        said = self._lambda(tag)
        return offered(self.model.name, tag, said.sources, said.values) if leaving(said.sources) else []

    def inject(self, port: str, value: Message) -> None:
        """Put a message into an in port of the root; it arrives with the next `advance`."""
        into = entry(self.model, port)
        self._staged.append((into, travelling(fitting(into, value), repr(into))))

    def advance(self, tag: Tag, bag: Sequence[Delivery] = (), until: Tag = BEGIN) -> None:
        """Transit at `tag`: deliver `bag` (sorted) and what was injected, move the imminent atomics on.

        Then, while nothing leaves the root, at the next tags below `until` as well.
        """
        due = self.next_time
        if tag == due:
            said = self._lambda(due)
            imminent, sources, values = self._schedule.imminent, said.sources, said.values
        elif tag <= self._last:
            raise ModelError(f"{self.model.path} at {Tag(*self._last)}: late message, {tag} is past already")
        elif tag > due:
            raise ModelError(f"{self.model.path}: cannot advance to {tag}, the next transition is at {due}")
        else:
            self._schedule.wait()
            imminent, sources, values = [], [], []
        if bag or self._staged:
            heard = [received(self.model, d) for d in bag] + self._staged
            sources = [*(port for port, _ in heard), *sources]
            values = [*(value for _, value in heard), *values]
            self._staged = []
        self._work(tag, imminent, sources, values, until, SILENT)

    def run(self, until: int = NEVER, stop: Callable[[], bool] | None = None) -> None:
        """Advance alone through all tags at t < `until` [ns], or until `stop()` after one; call it again to go on."""
        due, until = self.next_time, min(until, NEVER)
        while due.t < until:
            if self._staged:
                self.advance(due)
            else:
                said = self._lambda(due)
                end = (until, 0) if stop is None else BEGIN
                self._work(due, self._schedule.imminent, said.sources, said.values, end)
            if stop is not None and stop():
                return
            due = self.next_time

    def _work(
        self,
        tag: Instant,
        imminent: list[int],
        sources: list[Port[Message]],
        values: list[Message],
        until: Instant,
        silent: int = 0,
    ) -> None:
        """Steps 2 to 4 at a tag; all steps at those that follow below `until` while the structure stays.

        If it shall be `silent`, so many at most, while nothing leaves the root and time does not stand still for long.
        """
        present, schedule, atomics, trace = self._present, self._schedule, self.atomics, self.trace
        move, patience, speakers = schedule.move, self._patience.start, self._speakers
        self._spoken, present.busy = False, True
        while True:
            (t, k), soon = tag, schedule.soon
            present.now = tag
            reached = deliver(sources, values, t) if sources else ()
            if speakers and sources:
                self._observed.note(t, sources)
            movers = [*imminent, *reached] if reached else imminent
            if k >= patience:
                self._patience.watch(tag, [atomics[i].path for i in movers])
            for i in movers:
                m = atomics[i]
                what = "internal"
                try:
                    if m._port is None:
                        m.internal()
                    else:
                        x: Any = {m._port: [m._value]} if m._more is None else sorted_bag(m)
                        m._port = m._value = None
                        if m._t != t:
                            what = "external"
                            m.external(t - m._last, x)
                        elif m._plain:
                            m.internal()
                            what = "external"
                            m.external(0, x)
                        else:
                            what = "confluent"
                            m.confluent(x)
                except (Exception, SystemExit) as error:
                    fail(m, tag, what, error)
                m._last, wait = t, m._wait
                if wait is None:
                    if m._t == t:
                        fail(m, tag, what, ModelError(f"{what}() scheduled nothing: call hold_in or passivate"))
                else:
                    m._wait, m._set = None, t
                    if wait:
                        move(m, t + wait, t)
                    else:
                        if m._t != t:
                            move(m, t, t)
                        soon.append(i)
            if trace is not None:
                trace.note(tag, atomics, imminent, sources, values)
            due = None if present.changes else schedule.next(tag)
            if due is None or due >= until or (silent and (silent == 1 or due[1] >= patience)):
                self._last, self._due, present.busy = tag, None if due is None else tag_of(due), False
                return
            self._speak(due)
            if silent:
                silent -= 1
                if present.sources and leaving(present.sources):
                    self._last, self._due, present.busy, self._spoken = tag, tag_of(due), False, True
                    return
            tag, imminent, sources, values = due, schedule.imminent, present.sources, present.values

    def _restructure(self) -> None:
        """What was asked of the structure since the last tag happens now, after all transitions of that tag."""
        changes, before, promises = self._present.changes, set(self.atomics), self.lookahead
        self._present.changes, self._present.live = [], False
        for where, change in changes:
            try:
                change()
            except ModelError as error:
                raise ModelError(f"{error} (a change of {where.path} at {Tag(*self._last)})") from None
        self._present.live = True
        self._adopt()
        still_promised(self.model.path, Tag(*self._last), promises, self.lookahead)
        self._schedule = Schedule(self.atomics)
        self._witness.meet(self.atomics)
        for m in self.atomics:
            if m in before:
                self._schedule.enter(m, self._last[0])
            else:
                self._schedule.begin(m, self._last, self._present)
        self._due, self._spoken = None, False

    def snapshot(self) -> bytes:
        """All that the future depends on, between two tags; ModelError if a state cannot be kept."""
        _ = self.next_time  # what was asked of the structure has happened then
        return frozen(self.model, (self._last, self._staged))

    def restore(self, snapshot: bytes) -> None:
        """Go on from a snapshot; `model` and `atomics` are new ones then."""
        self.model, (self._last, self._staged) = thawed(snapshot, self.model)
        self._due, self._spoken, self._observed = None, False, Observed()
        self._present.now, self._present.busy = self._last, False
        self._adopt()
        self._schedule, self._witness = Schedule(self.atomics), Witness(self._watched)
        self._witness.meet(self.atomics)
        for m in self.atomics:
            self._schedule.enter(m, self._last[0])

    def _lambda(self, tag: Instant) -> Present:
        """What the imminent atomics say at `tag` = next_time, in path order; later calls find it said."""
        if not self._spoken:
            self._speak(tag)
            self._spoken = True
        return self._present

    def _speak(self, tag: Instant) -> None:
        present, atomics, witness, imminent = self._present, self.atomics, self._witness, self._schedule.imminent
        present.now, present.sources, present.values = tag, [], []
        witness.left -= 1
        looked_at = witness.left < 0 or (witness.new and not witness.new.isdisjoint(imminent))
        seen = witness.before(imminent) if looked_at else None
        try:
            for i in imminent:
                present.speaker = m = atomics[i]
                try:
                    m.output()
                except (Exception, SystemExit) as error:
                    fail(m, tag, "output", error)
                if m._wait is not None:
                    told = "output() must not change the state: call hold_in in a transition"
                    fail(m, tag, "output", ModelError(told))
        finally:
            present.speaker = None
        if seen:
            witness.after(tag, seen)
        if self._promises:
            keep_promises(tag, present.sources)

    @property
    def slack(self) -> list[Slack]:
        """Observed lookaheads of the ports that send to the outside, since start or restore."""
        return self._observed.table()
