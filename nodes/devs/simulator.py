"""The abstract simulator of Parallel DEVS, flat: one heap of distinct tags, direct routes.

One call of `advance(tag, bag)` does, for tag = next_time or an earlier tag at which something arrives:
  1. lambda of all imminent atomics (those with next == tag), in path order;
  2. route: each message lies in its receivers' bags at this same tag, ordered by source (see `flatten`);
  3. one transition per atomic: `internal` if imminent, `external` if it got something, `confluent` if both;
  4. next = after(tag, ta) for each; a wait of zero comes back at the next microstep.
Driving it from a larger simulation: while min(next_time, first input) < limit, read `outputs()` if that
tag is next_time, then `advance`. `outputs` may be called any number of times, or not at all. `run` does
this alone, half-open: events at t < until. After Chow and Zeigler (1994); the two-phase face after adevs.
Broken rules raise ModelError.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from heapq import heappop, heappush
from typing import Any, NamedTuple, NoReturn

from heavylift.kernel.errors import HeavyliftError, ModelError

from .events import Delivery, Event
from .flatten import Route, flatten
from .messages import Message, decode, encode
from .models import Atomic, Clock, Model
from .ports import InPort, OutPort
from .tags import FOREVER, NEVER, Tag, after, succ

_TAIL = 32  # microsteps before the limit whose models are named as the loop


class Transition(NamedTuple):
    """One line of the log: what an atomic did at a tag, received and said, as (port, message)."""

    tag: Tag
    path: str
    kind: str  # "internal", "external" or "confluent"
    bag: tuple[tuple[str, Message], ...]
    sent: tuple[tuple[str, Message], ...]


class Simulator:
    """Runs one model, alone or as the `Steppable` of a node."""

    def __init__(self, model: Model, log: Callable[[Transition], None] | None = None, microsteps: int = 10_000) -> None:
        """`log` hears every transition; `microsteps` is the length at which a zero-time loop is an error."""
        self.model, self.log, self.microsteps = model, log, microsteps
        self.atomics, self._entries = flatten(model)
        self._speakers = [
            (m, min(port.lookahead for port in _outs(m) if port.exits))
            for m in self.atomics
            if any(port.exits for port in _outs(m))
        ]
        self.lookahead = min((ahead for _, ahead in self._speakers), default=NEVER)
        self._clock = Clock()
        for m in self.atomics:
            m._clock = self._clock
            m._promises = any(port.lookahead for port in _outs(m))

    def start(self) -> None:
        """Set every atomic to its initial state at (0, 0); starting again is a fresh run."""
        self._last, self._clock.now = Tag(-1, 0), Tag(0, 0)
        self._times: list[Tag] = []
        self._slots: dict[Tag, set[int]] = {}
        self._said: list[tuple[OutPort[Any], Any]] | None = None
        self._staged: list[tuple[str, Message]] = []
        self._loop: set[str] = set()
        for m in self.atomics:
            m._bag, m._next, m._last, m._set, m._ta, m._sent = {}, FOREVER, 0, -NEVER, NEVER, None
            try:
                m.start()
            except Exception as error:
                _fail(m, Tag(0, 0), "start", error)
            if m._ta < NEVER:
                self._schedule(m, Tag(m._ta, 0), imminent=True)

    @property
    def next_time(self) -> Tag:
        """Tag of the next internal transition; FOREVER when all are passive."""
        times, slots = self._times, self._slots
        while times:
            if times[0] in slots:
                return times[0]
            heappop(times)
        return FOREVER

    @property
    def quiet(self) -> Tag:
        """Earliest tag at which something can leave the root if nothing reaches it."""
        tag = self.next_time
        if tag is FOREVER or any(port.exits for port, _ in self._lambda(tag)):
            return tag
        reached = [after(tag, ahead) for _, ahead in self._speakers]
        return min([*reached, *(m._next for m, _ in self._speakers if m._next > tag)], default=FOREVER)

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
        self._entry(port, value)
        self._staged.append((port, value))

    def advance(self, tag: Tag, bag: Sequence[Delivery] = (), until: Tag = FOREVER) -> None:
        """Transit at `tag`: deliver `bag` (sorted) and what was injected, move the imminent atomics on."""
        due = self.next_time
        if tag <= self._last:
            raise ModelError(f"{self.model.path} at {self._last}: late message, {tag} is past already")
        if tag > due:
            raise ModelError(f"{self.model.path}: cannot advance to {tag}, the next transition is at {due}")
        if tag.k >= self.microsteps - _TAIL:
            self._watch(tag)
        said = self._lambda(tag) if tag == due else []
        self._said, self._last, self._clock.now = None, tag, tag

        movers = self._slots.pop(tag) if tag == due else set[int]()
        for delivery in bag:
            value = self._receive(delivery)
            _deliver(self._entry(delivery.port, value), value, movers)
        for name, value in self._staged:
            _deliver(self._entry(name, value), value, movers)
        self._staged.clear()
        for port, value in said:
            _deliver(port.routes, value, movers)

        atomics, t, log = self.atomics, tag.t, self.log
        soon: Tag | None = None
        for i in sorted(movers):
            m = atomics[i]
            x: Any = m._bag
            m._ta, imminent, kind = None, m._next == tag, "internal"
            try:
                if not x:
                    m.internal()
                else:
                    m._bag, kind = {}, "confluent" if imminent else "external"
                    x = x if len(x) == 1 else dict(sorted(x.items(), key=_port_name))
                    if imminent:
                        m.confluent(x)
                    else:
                        m.external(t - m._last, x)
            except Exception as error:
                _fail(m, tag, kind, error)
            m._last, wait = t, m._ta
            if wait is None:
                if imminent:
                    _fail(m, tag, kind, ModelError(f"{kind}() scheduled nothing: call hold_in or passivate"))
            else:
                if wait == 0:
                    later = soon = soon or succ(tag)
                else:
                    later = Tag(t + wait) if wait < NEVER - t else FOREVER
                if imminent or later != m._next:
                    self._schedule(m, later, imminent)
                    m._set = t
            if log is not None:
                sent = tuple((p.name, v) for p, v in said if p.owner is m)
                log(Transition(tag, m.path, kind, tuple((p.name, v) for p in x for v in x[p]), sent))

    def run(self, until: int = NEVER) -> None:
        """Advance alone through all tags at t < `until` [ns]; calling it again continues."""
        while (tag := self.next_time).t < until:
            self.advance(tag)

    def _lambda(self, tag: Tag) -> list[tuple[OutPort[Any], Any]]:
        """What the imminent atomics say at `tag` = next_time, in path order."""
        if self._said is None:
            said: list[tuple[OutPort[Any], Any]] = []
            self._clock.now = tag
            for i in sorted(self._slots.get(tag, ())):
                m = self.atomics[i]
                sent = m._sent = []
                try:
                    m.output()
                    if m._promises:
                        _keep_promises(m, tag, sent)
                except Exception as error:
                    _fail(m, tag, "output", error)
                m._sent = None
                said += sent
            self._said = said
        return self._said

    def _schedule(self, m: Atomic, later: Tag, imminent: bool) -> None:
        """Move an atomic to another slot of the heap; an empty slot leaves its tag behind in the heap."""
        slots = self._slots
        if not imminent and m._next is not FOREVER:
            slot = slots[m._next]
            slot.discard(m._index)
            if not slot:
                del slots[m._next]
        m._next = later
        if later is not FOREVER:
            found = slots.get(later)
            if found is None:
                slots[later] = {m._index}
                heappush(self._times, later)
            else:
                found.add(m._index)

    def _receive(self, delivery: Delivery) -> Message:
        """The receiver's own copy of a message from another node."""
        event = delivery.event
        try:
            return decode(event.type, event.payload)
        except ModelError as error:
            here = f"{self.model.path}.{delivery.port} at {event.tag}"
            raise ModelError(f"{here}: {error} (from {event.source}.{event.port})") from None

    def _entry(self, name: str, value: Message) -> tuple[Route, ...]:
        port = self.model.ports.get(name)
        if not isinstance(port, InPort):
            raise ModelError(f"{self.model.path}: there is no in port {name}")
        if not isinstance(value, port.type):
            raise ModelError(f"{port!r} carries {port.type.__name__}, not {type(value).__name__}")
        return self._entries[name]

    def _watch(self, tag: Tag) -> None:
        """Collect who keeps time from advancing, and name them at the limit."""
        self._loop.update(self.atomics[i].path for i in self._slots.get(tag, ()))
        if tag.k >= self.microsteps:
            raise ModelError(
                f"{', '.join(sorted(self._loop))} at {tag}: zero-time loop, {self.microsteps} microsteps in "
                f"which no time passes; let one of them hold for more than 0 ns"
            )


def _deliver(routes: tuple[Route, ...], value: Message, movers: set[int]) -> None:
    """Put one message into its receivers' bags, in order of rank."""
    for port, m, rank in routes:
        bag = m._bag
        if port not in bag:
            movers.add(m._index)
            bag[port] = [value]
            port.ranks = [rank]
        else:
            at = bisect_right(port.ranks, rank)
            port.ranks.insert(at, rank)
            bag[port].insert(at, value)


def _keep_promises(m: Atomic, tag: Tag, sent: list[tuple[OutPort[Any], Any]]) -> None:
    for port, _ in sent:
        if tag.t - m._set < port.lookahead:
            raise ModelError(
                f"port {port.name} promises a lookahead of {port.lookahead} ns and speaks "
                f"{tag.t - m._set} ns after the transition that scheduled it; hold for longer or declare less"
            )


def _fail(m: Atomic, tag: Tag, what: str, error: Exception) -> NoReturn:
    sentence = str(error) if isinstance(error, HeavyliftError) else f"{what}() raised {type(error).__name__}: {error}"
    raise ModelError(f"{m.path} at {tag}: {sentence}") from error


def _outs(m: Atomic) -> list[OutPort[Any]]:
    return [port for port in m.ports.values() if isinstance(port, OutPort)]


def _port_name(item: tuple[InPort[Any], list[Any]]) -> str:
    return item[0].name
