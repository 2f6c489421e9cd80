"""The phrase language of the action list: what is written to the right of `target:`, `when:` and `until`.

    order      = motion | turn | "hook" "[" lug {"," lug} "]" | "unhook" | "lock" | "unlock"
               | "engage" | "release" | "wait" time
    motion     = ("travel" | "traverse" | "hoist" | "lower" | "drive") speed ["ramp" acceleration]
                 ( "by" distance ["or" "until" condition]
                 | "to" position ["of rope"] ["or" "until" condition]
                 | "until" condition )
    turn       = "turn" rate ["ramp" acceleration] "to" angle ["or" "until" condition]
    condition  = test {"and" test}
    test       = ["all" | "any"] [set] ("slings" | "ropes") state | rope-or-sling state
               | "moves done" | verb "done" | "lifted" | "landed" | "after" time
               | quantity (">=" | "<=") value
    state      = "taut" | "slack"
    quantity   = "angle" ["of" name] | "height" ["of" name] | "position of" name | "speed of" name
               | "length of" name | "tension of" (name | set "slings" | set "ropes")

These are the meanings of phrases; `grammar` reads them.  Names are resolved later, against the machines of the
scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

State = Literal["taut", "slack"]


class PhraseError(ValueError):
    """A phrase that cannot be read: the sentence, a hint, and the column in the phrase (from 0)."""

    def __init__(self, sentence: str, hint: str, column: int) -> None:
        super().__init__(sentence)
        self.hint, self.column = hint, column


@dataclass(frozen=True, kw_only=True)
class Worded:
    """A test, or a part of one, with the words it was written in."""

    text: str = ""


@dataclass(frozen=True)
class SlingTest(Worded):
    """Slings or ropes of a set ("" = all there are; or the name of one) are taut or slack."""

    each: Literal["all", "any"]
    of: str
    noun: Literal["slings", "ropes", "one"]
    state: State
    column: int


@dataclass(frozen=True)
class DoneTest(Worded):
    """The moves of the previous action are done; with a verb, only those."""

    verbs: tuple[str, ...]


@dataclass(frozen=True)
class GroundTest(Worded):
    """The block stands on no support any more, or on all of one face."""

    state: Literal["lifted", "landed"]
    column: int


@dataclass(frozen=True)
class CrossTest(Worded):
    """A measured quantity reaches a value [SI]."""

    quantity: str
    of: str
    rising: bool
    value: float
    column: int


@dataclass(frozen=True)
class AfterTest(Worded):
    """Time since the previous action began [s]."""

    seconds: float


@dataclass(frozen=True)
class AllTests(Worded):
    """All of these at once."""

    tests: tuple[Test, ...]


Test: TypeAlias = SlingTest | DoneTest | GroundTest | CrossTest | AfterTest | AllTests


@dataclass(frozen=True)
class Motion:
    """A drive, trolley, crane or winch moves; `angular` tells what kind of speed was written."""

    verb: str
    speed: float
    angular: bool
    ramp: float | None = None
    by: float | None = None
    to: float | None = None
    of_rope: bool = False
    until: Test | None = None


@dataclass(frozen=True)
class Turning:
    """The block turns to an angle [rad]."""

    rate: float
    to: float
    ramp: float | None = None
    until: Test | None = None


@dataclass(frozen=True)
class Hooking:
    """Slings are hooked to these lugs, in the order of the target's slings."""

    lugs: tuple[str, ...]


@dataclass(frozen=True)
class Simple:
    """An order of one word."""

    verb: str


@dataclass(frozen=True)
class Waiting:
    """Nothing happens for a while [s]."""

    seconds: float


OrderPhrase: TypeAlias = Motion | Turning | Hooking | Simple | Waiting
