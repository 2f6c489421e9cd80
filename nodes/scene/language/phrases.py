"""The phrase language of the action list: phrases to the right of `target:`, `when:` and `until`.

    order      = motion | pull | turn | level | "hook" ["[" lug {"," lug} "]"] | "unhook" | "lock" | "unlock"
               | "engage" | "release" | "stop" ["ramp" acceleration] | "hold" ["height"]
               | "bypass" | "restore" | "wait" time | "begin"
    motion     = ("travel" | "traverse" | "slew" | "luff" | "hoist" | "lower" | "drive") speed ["ramp" ramp]
                 ( "by" distance ["or" "until" condition]
                 | "to" (position ["of rope"] | "above" "[" lug {"," lug} "]") ["or" "until" condition]
                 | "until" condition ) ["together"]
    pull       = "pull" rate of tension ("by" force | "to" force | "until" condition) ["or" "until" condition]
    ramp       = acceleration ["in two pulses"] | "one swing"
    turn       = "turn" rate ["ramp" acceleration] "to" angle ["or" "until" condition]
    level      = "level" speed "within" angle ["at" angle] "with" hook {"," hook}
    condition  = test {"and" test}
    test       = ["all" | "any"] [set] ("slings" | "ropes") state | rope-or-sling state
               | ("moves" | verb) ("done" | "stopped") | [block] "lifted" | [block] "landed" ["on" name]
               | lift "done"
               | "after" time
               | quantity (">=" | "<=") value      ("load of" and "tension of" also in % of the rated value)
    state      = "taut" | "slack"
    quantity   = "angle" ["of" name] | "height" ["of" name] | "position of" name | "speed of" name
               | "length of" name | "tension of" (name | set "slings" | set "ropes") | "load of" hook
               | "moment of" hook | "radius of" hook | "off-lead of" rope | "swing along of" rope
               | "swing across of" rope | "gap" name name | "height difference" name name | "wind"

A ramp without swing is computed for the pendulum that the move excites, with the positions of ropes, hook and load when
it begins to speed up and to slow down; `check` prints the accelerations. A ramp in two pulses is faster; where the
pulses would overlap, each has half of the acceleration.

Moves `together` all stop when one of them is stopped. `to above [A, B]` ends with the ropes above the middle of these
lugs, at the position of the block when the move begins. `level` hoists, then lowers these hooks until a block is level,
or at the given turn angle (by default that of the last turn), along the line from these hooks to the others; spreaders
and beams in between are taken into account. `hold` stops a drive; then the brakes of its joint engage,
if there are any. A winch with `hold height` hoists and lowers while its boom luffs by an order of the same action, so
that its hook keeps its height.

A block is `landed` on its supports, and `landed on` something (floor, obstacle, other block, a body with a contact)
when it is within a millimetre of it.

A move stopped by an interlock or a limit switch is `stopped`, not done. With `any hook` or `any sling` an interlock
watches each of them.

`grammar` parses phrases. Names are resolved later, when the machines of the scene are known.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from heavylift.nodes.plan.actions import AfterCondition, MovesDone, Term
from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.units import Dimension

State = Literal["taut", "slack"]


class PhraseError(ValueError):
    """Raised for a phrase that cannot be parsed, with a hint and the column in the phrase, counted from 0."""

    def __init__(self, sentence: str, hint: str, column: int) -> None:
        super().__init__(sentence)
        self.hint, self.column = hint, column


class SlingTest(Term, frozen=True):
    """Condition: all or any slings or ropes of a set are taut or slack.

    `of`: name of the set, "" for all slings of the scene, or the name of a single sling."""

    each: Literal["all", "any"]
    of: str
    noun: Literal["slings", "ropes", "one"]
    state: State
    column: int


class GroundTest(Term, frozen=True):
    """Condition on a block: it has left all its supports, or has landed on all supports of one face.

    Or the action list of a lift is done. `of`: the block or lift; `on`: another object on which the block landed."""

    state: Literal["lifted", "landed", "done"]
    column: int
    of: str = ""
    on: str = ""


class CrossTest(Term, frozen=True):
    """Condition: a measured quantity reaches a value [SI units].

    `turning`: the value was written as an angle; `share`: the value was written in % of the rated value."""

    quantity: str
    of: str
    rising: bool
    value: float
    turning: bool
    column: int
    share: bool = False


Test: TypeAlias = SlingTest | GroundTest | CrossTest | MovesDone | AfterCondition
ConditionPhrase: TypeAlias = tuple[Test, ...]  # all of these at once


@dataclass(frozen=True)
class SwingRamp:
    """A ramp without swing: one acceleration pulse that lasts a swing period, or two pulses half a period apart."""

    pulses: Literal[1, 2] = 1
    accel: float | None = None


@dataclass(frozen=True)
class OrderPhrase:
    """An order as written; the verb determines which of the values are used [SI units].

    `turning`: whether the speed was written as an angular speed. `lugs`: in the order of the target's slings.
    """

    verb: str
    speed: float = 0.0
    turning: bool = False
    ramp: float | SwingRamp | None = None
    by: float | None = None
    to: float | None = None
    of_rope: bool = False
    above: tuple[str, ...] = ()
    within: float = 0.0
    hooks: tuple[str, ...] = ()
    together: bool = False
    until: ConditionPhrase | None = None
    lugs: tuple[str, ...] = ()
    seconds: float = 0.0
    height: bool = False


@dataclass(frozen=True)
class NamedQuantity:
    """A quantity that conditions can name: its dimension, and the number of names of objects that it needs."""

    dimension: Dimension
    of: Literal["none", "some", "one", "two"] = "one"
    rated: bool = False


QUANTITIES = {
    "angle": NamedQuantity(units.ANGLE, "some"),
    "height difference": NamedQuantity(units.LENGTH, "two"),
    "height": NamedQuantity(units.LENGTH, "some"),
    "position": NamedQuantity(units.STROKE),
    "speed": NamedQuantity(units.STROKE_SPEED),
    "length": NamedQuantity(units.LENGTH),
    "tension": NamedQuantity(units.FORCE, rated=True),
    "load": NamedQuantity(units.MASS, rated=True),
    "moment": NamedQuantity(units.RATIO),
    "radius": NamedQuantity(units.LENGTH),
    "off-lead": NamedQuantity(units.ANGLE),
    "swing along": NamedQuantity(units.ANGLE),
    "swing across": NamedQuantity(units.ANGLE),
    "gap": NamedQuantity(units.LENGTH, "two"),
    "wind": NamedQuantity(units.SPEED, "none"),
}
