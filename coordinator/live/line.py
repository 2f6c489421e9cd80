"""A committed event as a line of text: what planners follow, or the message itself with its port and units.

  0:09.0  take up slack           west.H1 taut
9.032650 s  take up slack  west.report  RopeState west.H1: state taut, tension 1234.5 N
"""

from __future__ import annotations

from collections.abc import Callable
from math import degrees
from typing import Any

import msgspec
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import SPACES, printable
from heavylift.nodes.devs import Event
from heavylift.nodes.models.parts import messages

from .announce import Notice

LISTED: dict[str, Callable[[dict[str, Any]], str]] = {  # events that planners follow, in their words
    "Stage": lambda x: f"stage {x['name']} begins" if x["name"] else "",
    "RopeState": lambda x: f"{x['actor']} {x['state']}",
    "Hooked": lambda x: f"{x['actor']} hooked to {x['lug']}",
    "Unhooked": lambda x: f"{x['actor']} unhooked",
    "Overload": lambda x: (
        f"load of {x['actor']} {'above' if x['over'] else 'back below'} its rated "
        f"{x['rated'] / 1e3:.1f} kN: {x['tension'] / 1e3:.1f} kN"
    ),
    "Tripped": lambda x: f"interlock {x['actor']} {'tripped' if x['over'] else 'reset'}{', bypassed' * x['bypassed']}",
    "Limit": lambda x: f"{x['actor']} stopped: {x['limit']}",
    "Lifted": lambda x: f"{x['actor']} lifted off",
    "Touched": lambda x: f"{x['actor']} touches {x['support']}",
    "Landed": lambda x: f"{x['actor']} landed on its {x['face']} face",
    "Attitude": lambda x: (
        f"{x['actor']} turned to {turn} deg" if (turn := round(degrees(x["angle"]))) % 30 == 0 else ""
    ),
    "BrakeState": lambda x: f"{x['actor']} {'engaged' if x['engaged'] else 'released'}",
    "Begun": lambda x: f"lift {x['actor']} begins",
    "Ended": lambda x: f"lift {x['actor']} done",
    "OperatorCommand": lambda x: f"operator: {x['text']}",
    "OperatorAnswer": lambda x: x["refused"] or x["text"],
    "Skipped": lambda x: f"{x['actor']}: its condition held already, not moved",
    "Finished": lambda _: "action list done",
}


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

    def report(self, event: Event) -> str:
        """The line of an event for planners; "" for orders, thresholds and the like.  Messages of a user's models are
        shown as they are."""
        stage, value = self.of(event)
        if event.type not in LISTED:
            return "" if hasattr(messages, event.type) or event.source == "kernel" else self.text(event)
        told = LISTED[event.type](value)
        return printable(f"{clock(event.t * 1e-9, 1):>12}  {stage:<24}  {told}", keep=SPACES) if told else ""

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
