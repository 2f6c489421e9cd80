"""The verbs of the action list: one row each, which grammar, targets, checks and the kernel of the commander read.

A verb that moves a drive or a winch is a row and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "gantry", "trolley", "hook", "block", "load", "drive", "winch", "sling", "rope", "brake", "lock", "interlock",
    "lift", "none",
]  # fmt: skip
Becomes = Literal["move", "turn", "hook", "unhook", "release", "brake", "stop", "level", "wait", "begin"]


@dataclass(frozen=True)
class Verb:
    """`kinds` of actors can be given it, and it `becomes` such an order of the plan."""

    name: str
    kinds: tuple[Kind, ...]
    becomes: Becomes
    sign: int = 0
    """Of the coordinate that it moves, as hoisting shortens a rope; 0: the number says it."""
    units: Literal["sliding", "turning", "either"] = "sliding"
    """Of way, speed and ramp."""
    speeds: tuple[str, str] | None = None
    """Keys of a crane with the highest speed, with a load and without."""
    along: Literal["", "x", "y"] = ""
    """Axis of the crane along which it carries what hangs there."""
    engages: bool = False
    ways: tuple[str, str] = ("", "")
    """Words for its ways along the coordinate, upwards and downwards."""

    def limit(self, crane: object, *, loaded: bool) -> float | None:
        """The highest speed of a scene's crane [m/s], if it has one."""
        return float(getattr(crane, self.speeds[0 if loaded else 1])) if self.speeds else None


FORWARD = ("forward", "back")
HOISTING = ("hoist_speed", "empty_hoist_speed")

VERBS: dict[str, Verb] = {
    verb.name: verb
    for verb in (
        Verb("travel", ("gantry", "drive"), "move", speeds=("gantry_speed", "gantry_speed"), along="x", ways=FORWARD),
        Verb(
            "traverse", ("trolley", "drive"), "move", speeds=("trolley_speed", "trolley_speed"), along="y", ways=FORWARD
        ),
        Verb("slew", ("drive",), "move", units="turning", ways=("left", "right")),
        Verb("luff", ("drive",), "move", units="turning", ways=("in", "out")),
        Verb("hoist", ("hook", "winch"), "move", sign=-1, speeds=HOISTING),
        Verb("lower", ("hook", "winch"), "move", sign=1, speeds=HOISTING),
        Verb("drive", ("drive",), "move", units="either"),
        Verb("turn", ("block",), "turn", units="turning"),
        Verb("level", ("block", "load"), "level"),
        Verb("hook", ("hook", "sling", "rope"), "hook"),
        Verb("unhook", ("hook", "sling", "rope"), "unhook"),
        Verb("lock", ("hook", "lock"), "brake", engages=True),
        Verb("unlock", ("hook", "lock"), "brake"),
        Verb("engage", ("brake",), "brake", engages=True),
        Verb("release", ("brake", "sling", "rope"), "release"),
        Verb("bypass", ("interlock",), "brake"),
        Verb("restore", ("interlock",), "brake", engages=True),
        Verb("stop", ("gantry", "trolley", "hook", "drive", "winch"), "stop", units="either"),
        Verb("hold", ("gantry", "trolley", "hook", "drive", "winch"), "stop", units="either", engages=True),
        Verb("wait", ("none",), "wait"),
        Verb("begin", ("lift",), "begin"),
    )
}
MOTIONS = tuple(verb.name for verb in VERBS.values() if verb.becomes == "move")
