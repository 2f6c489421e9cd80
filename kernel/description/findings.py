"""Findings and checks of a lift, before and after a run, and notes of one that goes on: every room tells them alike.

A note belongs to the instant that it tells of, as a sample does, and comes out the same however a run is cut up.
"""

from typing import Literal, NamedTuple, TypeAlias

import msgspec

Severity: TypeAlias = Literal["red", "warning", "note"]
State: TypeAlias = Literal["red", "undecided", "amber", "green", "none"]  # of a check, worst first


class Note(NamedTuple):
    """A sentence and the simulation time that it tells of [ns]."""

    t_ns: int
    sentence: str


UNITS = (1, 10, 100, 1000)  # in a second, by the digits behind it


class Finding(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What was found of a subject: a sentence for planners, and the numbers behind it."""

    severity: Severity
    kind: str  # "overload", "off-lead", "clearance", "two-blocked", "geometry", "stage", "cut", ...
    subject: str  # the element's name as the scene has it
    sentence: str
    where: str = ""  # file:line:column of what the planner would change
    stage: str = ""
    t: float | None = None  # [s] simulation time of the worst value
    value: float | None = None
    limit: float | None = None
    unit: str = ""

    @property
    def told(self) -> str:
        """The sentence, when, in which stage, and what a planner would change."""
        at = f", at {clock(self.t)}" if self.t is not None else ""
        stage = f" ({self.stage})" if self.stage else ""
        return f"{self.sentence}{at}{stage}" + (f" [{self.where}]" if self.where else "")


class Check(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One row of the list that a planner signs: a quantity of a subject, its worst value and limit [unit], the error of
    the value [unit] (None: unknown), and a state; which `amber` it is stands in `why`.

    `shown`, `allowed`: value and limit as people write them; `basis`: where the limit comes from; `sentence`: what was
    found, or what must be written or known for the row to turn green.
    """

    quantity: str
    subject: str
    state: State
    why: str = ""
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    use: float | None = None
    error: float | None = None
    t: float | None = None
    stage: str = ""
    basis: str = ""
    where: str = ""
    shown: str = ""
    allowed: str = ""
    sentence: str = ""

    @property
    def word(self) -> str:
        """Its state as it is told everywhere: of amber, which one it is."""
        return self.why or self.state


def clock(seconds: float, digits: int = 0) -> str:
    """A time of the run: 1:02, 1:06:04, with digits behind the second 1:02.5."""
    unit = UNITS[digits]
    minutes, rest = divmod(round(seconds * unit), 60 * unit)
    hours, minutes = divmod(minutes, 60)
    told = f"{rest / unit:0{3 + digits if digits else 2}.{digits}f}"
    return f"{hours}:{minutes:02}:{told}" if hours else f"{minutes}:{told}"
