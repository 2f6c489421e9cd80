"""The abstract simulator of Parallel DEVS, flat: one heap of distinct tags, direct routes.

One call of `advance(tag, bag)` does, for tag = next_time or an earlier tag at which something arrives:
  1. lambda of all imminent atomics (those with next == tag), in path order;
  2. route: each message lies in its receivers' bags at this same tag, ordered by source (see `flatten`);
  3. one transition per atomic: `internal` if imminent, `external` if it got something, `confluent` if both;
  4. next = after(tag, ta) for each; a wait of zero comes back at the next microstep.
Driving it from a larger simulation: while min(next_time, first input) < limit, read `outputs()` if that
tag is next_time, then `advance`. `outputs` may be called any number of times, or not at all. `run` does this alone,
half-open: events at t < until. After Chow and Zeigler (1994); two phases after adevs. Broken rules raise ModelError.
"""

from collections.abc import Callable, Sequence
from heapq import heappush
from typing import Any, NoReturn

from heavylift.kernel.errors import HeavyliftError, ModelError

from .bags import deliver, fitting, taken
from .events import Delivery, Event, Slack
from .flatten import flatten
from .lookahead import Observed, keep_promises, outs, promised, still_promised
from .messages import Message, decode, encode
from .models import Atomic, Clock, Model
from .ports import InPort, OutPort
from .schedule import Schedule
from .snapshot import frozen, thawed
from .tags import FOREVER, NEVER, Tag, after
from .transitions import Trace, Transition, logged

_TAIL = 32  # microsteps before the limit whose models are named as the loop


class Simulator:
    """Runs one model, alone or as the `Steppable` of a node."""

    def __init__(
        self,
        model: Model,
        log: Callable[[Transition], None] | None = None,
        microsteps: int = 10_000,
        trace: Trace | None = None,
    ) -> None:
        """`log` hears of every transition, `trace` the same, raw; a zero-time loop of `microsteps` is an error."""
        self.model, self.microsteps = model, microsteps
        self.trace = logged(log) if log is not None else trace
        self._clock, self._observed = Clock(), Observed()
        self.atomics: list[Atomic] = []
        self._adopt()
        self.model._changes = []

    def _adopt(self) -> None:
        """Take the model tree as it is now."""
        self.atomics = flatten(self.model)
        self._speakers = [
            (m, min(port.lookahead for port in outs(m) if port.exits))
            for m in self.atomics
            if any(port.exits for port in outs(m))
        ]
        self.lookahead = promised(self.model, self.atomics)
        for m in self.atomics:
            m._clock = self._clock
            m._promises = any(port.lookahead for port in outs(m))
            m._plain = type(m).confluent is Atomic.confluent

    def start(self) -> None:
        """Set every atomic to its initial state at (0, 0); starting again is a fresh run."""
        self._last, self._clock.now = Tag(-1, 0), Tag(0, 0)
        self._schedule = Schedule(self.atomics)
        self._due: Tag | None = None
        self._said: list[tuple[OutPort[Any], Any]] | None = None
        self._staged: list[tuple[InPort[Any], Message]] = []
        self._loop: set[str] = set()
        self._observed = Observed()
        for m in self.atomics:
            self._begin(m, Tag(-1, 0))

    def _begin(self, m: Atomic, last: Tag) -> None:
        """Initial state of an atomic that comes in after the tag `last`."""
        m._t, m._k, m._last, m._ta, m._sent = NEVER, 0, max(last.t, 0), NEVER, None
        m._set = last.t if last.t >= 0 else -NEVER
        try:
            m.start()
        except Exception as error:
            _fail(m, self._clock.now, "start", error)
        if m._ta < NEVER - last.t:
            m._t, m._k = after(last, m._ta) if last.t >= 0 else Tag(m._ta)
        self._schedule.enter(m)

    @property
    def next_time(self) -> Tag:
        """Tag of the next internal transition; FOREVER when all are passive."""
        if self.model._changes:
            self._restructure()
        if self._due is None:
            self._due = self._schedule.find(self._last)
        return self._due

    @property
    def quiet(self) -> Tag:
        """Earliest tag at which something can leave the root if nothing reaches it."""
        tag = self.next_time
        if tag is FOREVER or any(port.exits for port, _ in self._lambda(tag)):
            return tag
        reached = [after(tag, ahead) for _, ahead in self._speakers]
        others = (Tag(m._t, m._k) for m, _ in self._speakers)
        return min([*reached, *(due for due in others if due > tag)], default=FOREVER)

    def outputs(self) -> list[Event]:
        """What leaves the root at next_time, in total order; changes nothing."""
        tag, bags = self.next_time, dict[str, list[tuple[int, Any]]]()
        for port, value in self._lambda(tag):
            for target, rank in port.exits:
                bags.setdefault(target.name, []).append((rank, value))
        name, found = self.model.name, []
        for out in sorted(bags):
            bag = sorted(bags[out], key=lambda said: said[0])
            for i, (_, value) in enumerate(bag):
                found.append(Event(tag.t, tag.k, name, out, i, type(value).__name__, encode(value)))
        return found

    def inject(self, port: str, value: Message) -> None:
        """Put a message into an in port of the root; it arrives with the next `advance`."""
        into = self._entry(port)
        self._staged.append((into, fitting(into, value)))

    def advance(self, tag: Tag, bag: Sequence[Delivery] = (), until: Tag = FOREVER) -> None:
        """Transit at `tag`: deliver `bag` (sorted) and what was injected, move the imminent atomics on."""
        due = self._due or self.next_time
        if tag is not due:
            if tag <= self._last:
                raise ModelError(f"{self.model.path} at {self._last}: late message, {tag} is past already")
            if tag > due:
                raise ModelError(f"{self.model.path}: cannot advance to {tag}, the next transition is at {due}")
        t, k = tag
        if k >= self.microsteps - _TAIL:
            self._watch(tag)
        movers: list[int] = []
        said: list[tuple[OutPort[Any], Any]] = []
        if tag is due or tag == due:
            said = self._lambda(tag)
            movers = self._schedule.take(k)
        self._due, self._said, self._last, self._clock.now = None, None, tag, tag
        received: list[int] = []
        if bag or self._staged:
            deliver([*((self._entry(d.port), self._receive(d)) for d in bag), *self._staged], received)
            self._staged = []
        if said:
            deliver(said, received)
            if self._speakers:
                self._observed.note(t, said)
        if received:
            movers = sorted({*movers, *received})

        atomics, schedule, trace = self.atomics, self._schedule, self.trace
        slots, soon = schedule.slots, schedule.soon
        for i in movers:
            m = atomics[i]
            m._ta, imminent, kind = None, m._t == t and m._k == k, "internal"
            x: Any = None
            try:
                if m._into is None:
                    m.internal()
                else:
                    x = taken(m)
                    if imminent:
                        kind = "confluent"
                        if m._plain:
                            m.internal()
                            m.external(0, x)
                        else:
                            m.confluent(x)
                    else:
                        kind = "external"
                        m.external(t - m._last, x)
            except Exception as error:
                _fail(m, tag, kind, error)
            m._last, wait = t, m._ta
            if wait == 0:
                m._t, m._k, m._set = t, k + 1, t
                soon.append(i)
            elif wait is not None:
                later = t + wait if wait < NEVER - t else NEVER
                if imminent or later != m._t:
                    if not imminent and m._t != NEVER:
                        schedule.leave(t)
                    m._t, m._k, m._set = later, 0, t
                    if later != NEVER:
                        slot = slots.get(later)
                        if slot is None:
                            slots[later] = [i]
                            heappush(schedule.times, later)
                        else:
                            slot.append(i)
            elif imminent:
                _fail(m, tag, kind, ModelError(f"{kind}() scheduled nothing: call hold_in or passivate"))
            if trace is not None:
                trace(tag, m._path, kind, x, said)

    def run(self, until: int = NEVER, stop: Callable[[], bool] | None = None) -> None:
        """Advance alone through all tags at t < `until` [ns], or until `stop()` after one; call it again to go on."""
        tag = self.next_time
        while tag[0] < until:
            self.advance(tag)
            tag = FOREVER if stop is not None and stop() else self.next_time

    def _restructure(self) -> None:
        """What was asked of the structure since the last tag happens now, after all transitions of that tag."""
        changes, self.model._changes = self.model._changes or [], None
        before, promises = set(self.atomics), self.lookahead
        for where, change in changes:
            try:
                change()
            except ModelError as error:
                raise ModelError(f"{error} (a change of {where.path} at {self._last})") from None
        self._adopt()
        still_promised(self.model.path, self._last, promises, self.lookahead)
        self._schedule = Schedule(self.atomics)
        for m in self.atomics:
            if m in before:
                self._schedule.enter(m)
            else:
                self._begin(m, self._last)
        self.model._changes, self._due, self._said = [], None, None

    def snapshot(self) -> bytes:
        """All that the future depends on, between two tags; ModelError if a state cannot be kept."""
        return frozen(self.model, (self._last, self._staged))

    def restore(self, snapshot: bytes) -> None:
        """Go on from a snapshot; `model` and `atomics` are new ones then."""
        self.model, (self._last, self._staged) = thawed(snapshot, self.model)
        self._due, self._said, self._loop, self._clock.now = None, None, set(), self._last
        self._observed = Observed()
        self._adopt()
        self.model._changes = []
        self._schedule = Schedule(self.atomics)
        for m in self.atomics:
            self._schedule.enter(m)

    def _lambda(self, tag: Tag) -> list[tuple[OutPort[Any], Any]]:
        """What the imminent atomics say at `tag` = next_time, in path order."""
        if self._said is not None:
            return self._said
        said: list[tuple[OutPort[Any], Any]] = []
        atomics, self._clock.now = self.atomics, tag
        for i in self._schedule.imminent:
            m = atomics[i]
            m._sent = said
            try:
                m.output()
                if m._promises:
                    keep_promises(m, tag, said)
            except Exception as error:
                _fail(m, tag, "output", error)
            m._sent = None
        self._said = said
        return said

    @property
    def slack(self) -> list[Slack]:
        """What was observed of the lookaheads of those who speak to the outside, since start or restore."""
        return self._observed.table()

    def _receive(self, delivery: Delivery) -> Message:
        """The receiver's own copy of a message from another node."""
        event = delivery.event
        try:
            value: Message = fitting(self._entry(delivery.port), decode(event.type, event.payload))
            return value
        except ModelError as error:
            here = f"{self.model.path}.{delivery.port} at {event.tag}"
            raise ModelError(f"{here}: {error} (from {event.source}.{event.port})") from None

    def _entry(self, name: str) -> InPort[Any]:
        port = self.model.ports.get(name)
        if not isinstance(port, InPort):
            raise ModelError(f"{self.model.path}: there is no in port {name}")
        return port

    def _watch(self, tag: Tag) -> None:
        """Collect who keeps time from advancing, and name them at the limit."""
        self._loop.update(self.atomics[i].path for i in self._schedule.imminent)
        if tag.k >= self.microsteps:
            raise ModelError(
                f"{', '.join(sorted(self._loop))} at {tag}: zero-time loop, {self.microsteps} microsteps in which no "
                "time passes; let one of them hold for more than 0 ns"
            )


def _fail(m: Atomic, tag: Tag, what: str, error: Exception) -> NoReturn:
    sentence = str(error) if isinstance(error, HeavyliftError) else f"{what}() raised {type(error).__name__}: {error}"
    raise ModelError(f"{m.path} at {tag}: {sentence}") from error
