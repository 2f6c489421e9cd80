"""A committed event as a line for people: time, stage, who says it on which port, and the message with its units.

9.032650 s  take up slack  west.report  RopeState west.H1: state taut, tension 1234.5 N
"""

from __future__ import annotations

from typing import Any

import msgspec
from heavylift.kernel.errors import SPACES, printable
from heavylift.nodes.devs import Event

from .announce import Notice


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
