"""One who looks at a run from another process: all events so far, then each as it happens, until the run ends.

An observer only reads the run's journal of events, in its own time: the coordinator does not know of it, so none can
slow a run, however many there are and however slow or frozen they are, and none misses or repeats anything.  (Programs
that want to be called hear the same events on the bus, where a slow one misses some.)

A committed event as a line for people: time, stage, who says it on which port, and the message with its units.

9.032650 s  take up slack  west.report  RopeState west.H1: state taut, tension 1234.5 N
"""

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
from heavylift.coordinator.supervision.journal import JournalReader
from heavylift.kernel.errors import SPACES, printable
from heavylift.nodes.devs import Event

from .announce import AnnouncedRun, Notice, find
from .observers import EVENTS, Ended, entry

LOOK_s = 0.02  # how often an observer looks for more


class Observer(Iterator[tuple[int, Event]]):
    """Iterates over (number, event); afterwards `ended` says how the run ended."""

    def __init__(self, found: AnnouncedRun) -> None:
        self.found = found
        self.ended = Ended("failed", 0.0, "its coordinator was killed")
        self._journal = JournalReader(found.directory / EVENTS)
        self._events = self._follow()

    def __next__(self) -> tuple[int, Event]:
        return next(self._events)

    def _follow(self) -> Iterator[tuple[int, Event]]:
        number, alive = 0, True
        with closing(self._journal) as journal:
            while alive:
                alive = self.found.lives
                for said in map(entry, journal):
                    if isinstance(said, Ended):
                        self.ended = said
                        return
                    self.ended = Ended("failed", said.t * 1e-9, self.ended.reason)
                    yield number, said
                    number += 1
                time.sleep(LOOK_s)


def observe(run: str | Path | AnnouncedRun = "") -> Observer:
    """All events of a run in progress, as (number, event) from 0 upwards; `run` as for `find`."""
    return Observer(run if isinstance(run, AnnouncedRun) else find(str(run)))


class Lines:
    """Writes the events of one run; it must see all of them to know the stage."""

    def __init__(self, notice: Notice) -> None:
        self._units, self._angles = notice.units, notice.angles
        self._stage = ""

    def of(self, event: Event) -> tuple[str, Any]:
        """The stage in which an event falls, and its message as plain data."""
        value = msgspec.msgpack.decode(event.payload)
        if event.type == "Stage":
            self._stage = value["name"] or self._stage
        return self._stage, value

    def text(self, event: Event) -> str:
        """The line of an event."""
        stage, value = self.of(event)
        micro = f"+{event.k}" if event.k else ""
        at, who = f"{event.t * 1e-9:.6f}{micro} s", f"{event.source}.{event.port}"
        line = f"{at:>18}  {stage:<24}  {who:<24}  {event.type}{self._words(event.type, value)}"
        return printable(line, keep=SPACES)

    def _words(self, type_: str, value: dict[str, Any]) -> str:
        actor = value.get("actor", value.get("actuator"))
        units = self._units.get(type_, {})
        told = {name: x for name, x in value.items() if x is not actor and x is not None}
        if isinstance(what := told.pop("what", None), dict):  # an order: its kind and what it says
            told = {"to": what["type"]} | told | {name: x for name, x in what.items() if name != "type" and x != actor}
        said = ", ".join(f"{name} {_number(x)}{self._unit(units.get(name, ''), actor)}" for name, x in told.items())
        return "".join([f" {actor}" if actor else "", f": {said}" if said else ""])

    def _unit(self, unit: str, actor: str | None) -> str:
        """Of a coordinate that may be a length or an angle the one that its actuator has."""
        told = unit.split(" or ")[-1 if actor in self._angles else 0]
        return f" {told}" if told else ""


def _number(x: object) -> str:
    return f"{x:g}" if isinstance(x, float) else str(x)
