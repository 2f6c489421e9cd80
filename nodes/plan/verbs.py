"""The verbs (action words) of orders in the action list, one row each; the grammar, the resolver, the checks and the
commander use them.

A verb that only moves a drive or a winch needs nothing but its row.
"""

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "hook", "block", "load", "drive", "winch", "tugger", "sling", "rope", "brake", "lock", "interlock", "lift", "none",
]  # fmt: skip
Becomes = Literal["move", "turn", "hook", "unhook", "release", "brake", "stop", "level", "wait", "begin", "own"]


@dataclass(frozen=True)
class Verb:
    """A verb in orders, such as `hoist`: the `kinds` of actors that accept it, and the class of its orders."""

    name: str
    kinds: tuple[Kind, ...]
    becomes: Becomes
    sign: int = 0
    """Sign of the coordinate's change by this verb, as hoisting shortens a rope; 0: the sign is in the order."""
    units: Literal["sliding", "turning", "either", "pulling"] = "sliding"
    """Whether distance, speed and ramp have units of length, of angle, of either, or of force."""
    along: Literal["", "x", "y"] = ""
    """Axis of the crane along which this verb carries the hanging load."""
    engages: bool = False
    ways: tuple[str, str] = ("", "")
    """Words for the directions of motion along the coordinate, upwards and downwards."""
    module: str = ""
    """Module of a verb whose meaning is its `own`: `phrase(reader)` reads the words after the verb, and `orders(actors,
    phrase, where)` returns the orders of the plan."""


FORWARD = ("forward", "back")

VERBS: dict[str, Verb] = {
    verb.name: verb
    for verb in (
        Verb("travel", ("drive",), "move", along="x", ways=FORWARD),
        Verb("traverse", ("drive",), "move", along="y", ways=FORWARD),
        Verb("slew", ("drive",), "move", units="turning", ways=("left", "right")),
        Verb("luff", ("drive",), "move", units="turning", ways=("in", "out")),
        Verb("hoist", ("hook", "winch"), "move", sign=-1),
        Verb("lower", ("hook", "winch"), "move", sign=1),
        Verb("drive", ("drive",), "move", units="either"),
        Verb("pull", ("tugger",), "move", units="pulling"),
        Verb("turn", ("block",), "turn", units="turning"),
        Verb("level", ("block", "load"), "level"),
        Verb("hook", ("hook", "sling", "rope"), "hook"),
        Verb("unhook", ("hook", "winch", "sling", "rope", "tugger"), "unhook"),
        Verb("lock", ("hook", "lock"), "brake", engages=True),
        Verb("unlock", ("hook", "lock"), "brake"),
        Verb("engage", ("brake",), "brake", engages=True),
        Verb("release", ("brake", "sling", "rope", "tugger"), "release"),
        Verb("bypass", ("interlock",), "brake"),
        Verb("restore", ("interlock",), "brake", engages=True),
        Verb("stop", ("hook", "drive", "winch", "tugger"), "stop", units="either"),
        Verb("hold", ("hook", "drive", "winch", "tugger"), "stop", units="either", engages=True),
        Verb("wait", ("none",), "wait"),
        Verb("begin", ("lift",), "begin"),
    )
}
MOTIONS = tuple(verb.name for verb in VERBS.values() if verb.becomes == "move")
