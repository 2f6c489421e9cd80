"""Delivery of messages to the input bags of their receivers, in the order that `flatten` determines, and the schedule
of transitions.

The first message for an atomic model is held in the model itself, since most bags contain a single message, and
containers that live for a whole instant would keep the garbage collector busy.

The schedule has a heap of distinct times, a list (slot) of atomic models for each time, and the list of models due at
the next microstep. Only waits of zero lead to a microstep above 0, and always to the next one, so they need no heap. A
rescheduled model stays in its old slot, where its stored time shows that the entry is stale; when most entries are
stale, all slots are rebuilt.
"""

from collections.abc import Collection, Sequence
from heapq import heappop, heappush, heapreplace
from operator import itemgetter

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import FOREVER, NEVER, Event, Instant, Tag, after, beyond
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model, Present
from heavylift.nodes.devs.ports import Arrived, InPort, OutPort, Port

from .flatten import Entries
from .rules import fail

place = itemgetter(0)
model_port_and_place = itemgetter(0, 1, 2)


def deliver(sources: Sequence[Port[Message]], values: Sequence[Message], t: int) -> list[int]:
    """Put messages into the bags of their receivers; return the indices of receivers with no event due at t."""
    reached = []
    n = 0
    for source in sources:
        for m, port, place in source.routes:
            value = values[n]
            if m._port is None:
                m._port, m._place, m._value = port, place, value
                if m._t != t:
                    # imminent atomics are movers already
                    reached.append(m._index)
            elif m._more is None:
                m._more = [(place, port, value)]
            else:
                m._more.append((place, port, value))
        n += 1  # noqa: SIM113 (an enumerate costs as much as a transition where few speak at a time)
    return reached


def sorted_bag(m: Atomic) -> dict[InPort[Message], list[Message]]:
    """Empty an atomic model's bag and return its messages by input port, in the order of port names and sources."""
    assert m._port is not None
    assert m._more is not None
    bag = Arrived()
    for _, port, value in sorted([(m._place, m._port, m._value), *m._more], key=place):
        bag.setdefault(port, []).append(value)
    m._more = None
    return bag


def spoken(
    tag: Instant, sources: Sequence[Port[Message]], values: Sequence[Message], inner: bool = False
) -> list[Event]:
    """Return the events sent at a logical time to other nodes or, if `inner`, within this node, in total order."""
    left = [
        # the total order of events: source, port, then place in the port's bag
        (target.owner.name, target.name, number, value)
        for port, value in zip(sources, values, strict=True)
        if isinstance(port, OutPort)
        for target, number in (port.inner if inner else port.exits)
    ]
    if len(left) > 1:
        left.sort(key=model_port_and_place)
    (t, k), found, last, i = tag, [], ("", ""), 0
    for name, out, _, value in left:
        i = i + 1 if (name, out) == last else 0
        found.append(Event.of(t, k, name, out, i, value))
        last = name, out
    return found


def fitting(port: Port[Message], value: Message) -> Message:
    """Return the message; raises ModelError if its type is not the message type of the port."""
    if not isinstance(value, port.type):
        raise ModelError(f"{port!r} carries {port.type.__name__}, not {type(value).__name__}")
    return value


def entry(model: Model, name: str) -> InPort[Message]:
    """Return the input port of a model with the given name; raises ModelError if the model has no such port."""
    port = model.ports.get(name)
    if not isinstance(port, InPort):
        ins = ", ".join(key for key, port in model.ports.items() if isinstance(port, InPort)) or "none"
        raise ModelError(f"{model.path}: there is no input port {name}; its input ports: {ins}")
    return port


def received(entries: Entries, event: Event) -> tuple[Port[Message], Message]:
    """Return the input port at which an event from another node enters, and its message, shared by all receivers.

    Raises ModelError if no port here is coupled to the event's source."""
    if (event.source, event.port) not in entries:
        raise ModelError(f"{event.source}.{event.port} at {event.tag}: no port of this node is coupled to this output")
    start, targets = entries[event.source, event.port]
    target = targets[0]
    try:
        # taken once: messages are immutable, so that receivers may share one
        value = event.value
        for target in targets:
            fitting(target, value)
    except ModelError as error:
        raise ModelError(f"{target!r} at {event.tag}: {error} (from {event.source}.{event.port})") from None
    return start, value


STALE = 4  # stale entries for each atomic at which the slots are made anew


class Schedule:
    """The times at which the atomic models are due.

    `imminent`: indices of the models due at the logical time that `next` returned, in the order of their paths."""

    def __init__(
        self, atomics: list[Atomic], last: Instant, present: Present, known: Collection[Atomic] = frozenset()
    ) -> None:
        """Schedule the atomic models after the logical time `last`; models not in `known` are started first."""
        self.atomics = atomics
        self.times: list[int] = []  # heap of the times [ns] with a slot
        self.slots: dict[int, list[int]] = {}
        self.soon: list[int] = []
        self.imminent: list[int] = []
        self._stale = 0
        for m in atomics:
            if m in known:
                self._enter(m, last[0])
            else:
                self._begin(m, last, present)

    def next(self, last: Instant) -> Instant:
        """Return the earliest logical time after `last` at which a model is due; `imminent` then lists these models."""
        if self.soon:
            self.imminent, self.soon = self.soon, []
            self.imminent.sort()
            return last[0], last[1] + 1
        atomics, times, slots, now = self.atomics, self.times, self.slots, last[0]
        while times:
            t = times[0]
            if t > now:
                slot = slots.pop(t)
                if len(slot) > 1:
                    # a slot may hold atomics twice, or such that have been rescheduled since
                    slot = [i for i in sorted({*slot}) if atomics[i]._t == t]
                elif atomics[slot[0]]._t != t:
                    slot = []
                if slot:
                    self.imminent = slot
                    return t, 0
            heappop(times)
        self.imminent = []
        return FOREVER

    def wait(self) -> None:
        """Put the imminent models back into the schedule, because an input arrives before they are due."""
        if self.imminent:
            self.slots[self.times[0]] = self.imminent

    def move(self, m: Atomic, t: int, now: int) -> None:
        """Reschedule an atomic model to the time t [ns].

        If t is `now`, the caller must append the index of the model to `soon` for the next microstep."""
        before, slots, times = m._t, self.slots, self.times
        if t == before:
            return
        m._t = t
        if t in slots:
            slots[t].append(m._index)
        elif t >= NEVER:
            if t - now < NEVER:  # not for ever, only too long
                raise ModelError(f"{m.path} at {m.now}: {beyond(t - now)}")
            m._t = NEVER
        elif t > now:
            slots[t] = [m._index]
            if times and times[0] <= now:  # a time that has passed stands in the heap until a new one replaces it
                heapreplace(times, t)
            else:
                heappush(times, t)
        # the entry in the old slot stays: removing it would cost a search
        if before != now and before != NEVER:
            self._stale += 1
            # rebuilt when most entries are stale, so that memory and search stay proportional to the atomics
            if self._stale > STALE * len(self.atomics):
                self._renew(now)

    def _enter(self, m: Atomic, now: int) -> None:
        """Add an atomic model to the schedule at its own time; if that is `now` [ns], at the next microstep."""
        if m._t <= now:
            self.soon.append(m._index)
        else:
            t, m._t = m._t, NEVER
            self.move(m, t, now)

    def _begin(self, m: Atomic, last: Instant, present: Present) -> None:
        """Start an atomic model that was added after the logical time `last`, and schedule it."""
        m._t, m._last, m._wait, m._port, m._more = NEVER, max(last[0], 0), None, None, None
        m._set = last[0] if last[0] >= 0 else -NEVER
        present.busy = True
        try:
            m.start()
        except BaseException as error:
            fail(m, present.now, "start", error)
        present.busy = False
        if m._wait is not None:
            if NEVER - m._last <= m._wait < NEVER:
                fail(m, present.now, "start", ModelError(beyond(m._wait)))
            m._t, m._wait = after(Tag(m._last), m._wait).t, None
        self._enter(m, last[0])

    def _renew(self, now: int) -> None:
        """Rebuild all slots without stale entries."""
        self._stale = 0
        self.slots.clear()
        self.times.clear()
        for m in self.atomics:
            if m._t > now:
                self._enter(m, now)
