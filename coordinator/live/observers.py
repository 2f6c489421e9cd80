"""What observers of a run are shown: every committed event, in total order.

An event is appended to a journal in the run's private directory, where its place is its number, then put on its key of
the bus, which drops it for a listener that is slow or frozen.  Observers read the journal, so one that comes late has
the past without gap or repetition, and the run never waits for anybody.  What one round has brought is written at once
by `shown`.  The last entry says how the run ended.

A run of node processes can be found and watched while in progress; a run in one process cannot.

The samples of a run on its bus, for programs that subscribe to them; who is slow misses some and holds nobody up.
"""

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import msgspec
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from heavylift.coordinator.supervision.journal import Journal
from heavylift.coordinator.transport.exchange import LocalHub
from heavylift.coordinator.transport.hub import Hub
from heavylift.nodes.devs import Event, Message

from .announce import Announcement

EVENTS = "events.journal"


class Ended(msgspec.Struct, frozen=True):
    """How a run ended: "finished", or "failed" with the reason; simulation time [s]."""

    status: str
    sim_s: float
    reason: str = ""


_ENCODER = msgspec.msgpack.Encoder()
_EVENT, _ENDED = msgspec.msgpack.Decoder(Event), msgspec.msgpack.Decoder(Ended)
ARRAY = 0x90  # the first half-byte of a short array in MessagePack


def entry(data: bytes) -> Event | Ended:
    """What an entry of the journal says; an event is an array, the end a map."""
    return _EVENT.decode(data) if data[0] & 0xF0 == ARRAY else _ENDED.decode(data)


class Audience(AbstractContextManager["Audience"]):
    """Shows the events of one run as long as it is open, as a context manager; `last_ns` is where the run has come."""

    def __init__(self, hub: Hub) -> None:
        self._hub, self.last_ns = hub, 0
        self._journal = Journal(hub.directory.path / EVENTS)
        self._events: list[Event] = []  # of this round

    def event(self, event: Event) -> None:
        """A committed event, to be shown."""
        self._events.append(event)

    def show(self) -> None:
        """Show the events that have been committed since the last time."""
        if self._events:
            self._journal.extend(map(_ENCODER.encode, self._events))
            for event in self._events:
                at = event.type, event.t, event.k, event.index
                self._hub.publish_event(event.source, event.port, event.payload, *at)
            self._events.clear()

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        status, reason = ("finished", "") if error is None else ("failed", str(error) or type(error).__name__)
        self.show()
        self._journal.append(_ENCODER.encode(Ended(status, self.last_ns * 1e-9, reason)))
        self._journal.close()


@contextmanager
def shown(
    hub: Hub | LocalHub,
    name: str,
    recording: Path | None,
    turning: Iterable[str] = (),
) -> Iterator[Audience | None]:
    """The audience of the run `name`; `turning`: the actuators whose coordinate is an angle."""
    if isinstance(hub, LocalHub):
        yield None
        return
    units = {kind.__name__: kind.units for kind in _kinds(Message) if kind.units}
    with (
        Audience(hub) as audience,
        Announcement(hub.directory.path, hub.run, name, recording, units, tuple(turning)),
    ):
        yield audience


def _kinds(type_: type[Message]) -> Iterator[type[Message]]:
    yield type_
    for kind in type_.__subclasses__():
        yield from _kinds(kind)


class OnTheBus:
    """Puts messages on the keys sample/<topic> of a run, once there is a hub."""

    def __init__(self) -> None:
        self._hub: Hub | None = None
        self._schemas: dict[str, str] = {}

    def open(self, hub: Hub) -> None:
        """Put on this run's keys from now on."""
        self._hub = hub
        for topic in self._schemas:
            hub.heard_data(topic[1:])

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """There will be messages of this kind on the topic."""
        self._schemas[topic] = descriptor.full_name
        if self._hub is not None:
            self._hub.heard_data(topic[1:])

    def listens(self) -> bool:
        """Whether anybody subscribes to one of them."""
        hub = self._hub
        return hub is not None and any([hub.heard_data(topic[1:]) for topic in self._schemas])

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """A message of this simulation time."""
        if self._hub is not None:
            self._hub.publish_data(topic[1:], data, self._schemas[topic], t_ns)
