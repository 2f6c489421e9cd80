"""Data for observers of a run, every committed event in total order and samples; and the observers that read them.

An event is appended to a journal in the run's private directory, where its position is its number, then published on
the bus, which drops it for a slow or frozen subscriber. An `Observer` only reads the journal, at its own speed: a late
one gets the past without gap or repetition, and the run never waits for it. Events of one round are written at once by
`shown`; the last entry says how the run ended. A run in one process cannot be watched.

As a line for people: 9.032650 s  take up slack  west.report  RopeState west.H1: state taut, tension 1234.5 N
"""

import time
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import Any

import msgspec
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from heavylift.coordinator.supervision.journal import Journal, JournalReader
from heavylift.coordinator.transport.exchange import LocalHub
from heavylift.coordinator.transport.hub import Hub
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import SPACES, printable
from heavylift.nodes.devs import Event, Message
from heavylift.nodes.devs.events import in_bytes
from heavylift.nodes.models.parts import messages
from heavylift.recordings.format.text import LISTED

from .announce import AnnouncedRun, Notice, announced, find

EVENTS = "events.journal"


class RunEnded(msgspec.Struct, frozen=True):
    """End of a run: "finished", or "failed" with the reason, and the simulation time [s] of the end."""

    status: str
    sim_s: float
    reason: str = ""


_ENCODER = msgspec.msgpack.Encoder(enc_hook=in_bytes)
_EVENT, _ENDED = msgspec.msgpack.Decoder(Event), msgspec.msgpack.Decoder(RunEnded)
ARRAY = 0x90  # the first half-byte of a short array in MessagePack


def entry(data: bytes) -> Event | RunEnded:
    """Decode an entry of the journal: an event, or the end of the run."""
    return _EVENT.decode(data) if data[0] & 0xF0 == ARRAY else _ENDED.decode(data)


class EventPublisher(AbstractContextManager["EventPublisher"]):
    """Publishes the events of one run while this context is open; `last_ns`: simulation time reached [ns]."""

    def __init__(self, hub: Hub) -> None:
        self._hub, self.last_ns = hub, 0
        self._journal = Journal(hub.directory.path / EVENTS)
        self._events: list[Event] = []  # of this round

    def event(self, event: Event) -> None:
        """Queue a committed event; `show` publishes it."""
        self._events.append(event)

    def show(self) -> None:
        """Publish the queued events."""
        if self._events:
            self._journal.extend(map(_ENCODER.encode, self._events))
            for event in self._events:
                at = event.type, event.t, event.k, event.index
                self._hub.publish_event(event.source, event.port, event.payload, *at)
            self._events.clear()

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        status, reason = ("finished", "") if error is None else ("failed", str(error) or type(error).__name__)
        self.show()
        self._journal.append(_ENCODER.encode(RunEnded(status, self.last_ns * 1e-9, reason)))
        self._journal.close()


@contextmanager
def shown(
    hub: Hub | LocalHub, name: str, recording: Path | None, turning: Iterable[str] = ()
) -> Iterator[EventPublisher | None]:
    """Publish the events of run `name` while this context is open; a run in one process is not published (yields None).

    `turning`: actuators whose coordinate is an angle.
    """
    if isinstance(hub, LocalHub):
        yield None
        return
    units = {kind.__name__: kind.units for kind in _kinds(Message) if kind.units}
    with (
        EventPublisher(hub) as publisher,
        announced(hub.directory.path, hub.run, name, recording, units, tuple(turning)),
    ):
        yield publisher


def _kinds(type_: type[Message]) -> Iterator[type[Message]]:
    yield type_
    for kind in type_.__subclasses__():
        yield from _kinds(kind)


class OnTheBus:
    """Publishes samples of a run to observers, on the keys sample/<topic>."""

    def __init__(self) -> None:
        self._hub: Hub | None = None
        self._schemas: dict[str, str] = {}

    def open(self, hub: Hub) -> None:
        """Publish samples on the keys of this run from now on."""
        self._hub = hub
        for topic in self._schemas:
            hub.heard_data(topic[1:])

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """Announce a topic and the type of its messages."""
        self._schemas[topic] = descriptor.full_name
        if self._hub is not None:
            self._hub.heard_data(topic[1:])

    def listens(self) -> bool:
        """Return whether a client has subscribed to one of the announced topics."""
        hub = self._hub
        return hub is not None and any([hub.heard_data(topic[1:]) for topic in self._schemas])

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """Publish a message on one of the announced topics with this simulation time [ns]."""
        if self._hub is not None:
            self._hub.publish_data(topic[1:], data, self._schemas[topic], t_ns)


LOOK_s = 0.02  # how often an observer looks for more


class Observer(Iterator[tuple[int, Event]]):
    """Iterator over the numbered events of a run in progress; after the last one, `ended` states how the run ended."""

    def __init__(self, found: AnnouncedRun) -> None:
        self.found = found
        self.ended = RunEnded("failed", 0.0, "its coordinator was killed")
        self._journal = JournalReader(found.directory / EVENTS)
        self._events = self._follow()

    def __next__(self) -> tuple[int, Event]:
        return next(self._events)

    def _follow(self) -> Iterator[tuple[int, Event]]:
        number, alive = 0, True
        with closing(self._journal) as journal:
            while alive:
                alive = self.found.lives
                for text in map(entry, journal):
                    if isinstance(text, RunEnded):
                        self.ended = text
                        return
                    self.ended = RunEnded("failed", text.t * 1e-9, self.ended.reason)
                    yield number, text
                    number += 1
                time.sleep(LOOK_s)


def observe(run: str | Path | AnnouncedRun = "") -> Observer:
    """Return an iterator over the numbered events of a run in progress; `run`: a text as for `find`, or the run
    itself."""
    return Observer(run if isinstance(run, AnnouncedRun) else find(str(run)))


class Lines:
    """Formatter of events as lines of text with their stages; it must receive all events of a run in order."""

    def __init__(self, notice: Notice) -> None:
        self._units, self._angles = notice.units, notice.angles
        self._stage = ""

    def of(self, event: Event) -> tuple[str, Any]:
        """Return the name of the stage in which an event occurs, and the event's message as plain data."""
        value = msgspec.msgpack.decode(event.payload)
        if event.type == "Stage":
            self._stage = value["name"] or self._stage
        return self._stage, value

    def text(self, event: Event) -> str:
        """Return an event as a line of text with its complete message."""
        stage, value = self.of(event)
        micro = f"+{event.k}" if event.k else ""
        at, who = f"{event.t * 1e-9:.6f}{micro} s", f"{event.source}.{event.port}"
        line = f"{at:>18}  {stage:<24}  {who:<24}  {event.type}{self._words(event.type, value)}"
        return printable(line, keep=SPACES)

    def report(self, event: Event) -> str:
        """Return an event as a line of text for planners, or "" for an event that planners need not see, such as an
        order."""
        stage, value = self.of(event)
        if event.type not in LISTED:
            return "" if hasattr(messages, event.type) or event.source == "kernel" else self.text(event)
        message = LISTED[event.type](value)
        return printable(f"{clock(event.t * 1e-9, 1):>12}  {stage:<24}  {message}", keep=SPACES) if message else ""

    def _words(self, type_: str, value: dict[str, Any]) -> str:
        actor = value.get("actor", value.get("actuator"))
        units = self._units.get(type_, {})
        fields = {name: x for name, x in value.items() if x is not actor and x is not None}
        if isinstance(what := fields.pop("what", None), dict):  # an order: its kind and what it says
            fields = (
                {"to": what["type"]} | fields | {name: x for name, x in what.items() if name != "type" and x != actor}
            )
        text = ", ".join(f"{name} {_number(x)}{self._unit(units.get(name, ''), actor)}" for name, x in fields.items())
        return "".join([f" {actor}" if actor else "", f": {text}" if text else ""])

    def _unit(self, unit: str, actor: str | None) -> str:
        """Return the unit of a coordinate; `actor` decides between length and angle."""
        message = unit.split(" or ")[-1 if actor in self._angles else 0]
        return f" {message}" if message else ""


def _number(x: object) -> str:
    return f"{x:g}" if isinstance(x, float) else str(x)
