"""A scene that can be run, and what follows from its plan at rest: loads, use of limits, findings, what is modelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.description.findings import Check, findings
from heavylift.nodes.limits.checks import Errors, checks_of
from heavylift.nodes.limits.geometry import geometry_findings
from heavylift.nodes.limits.judging import uses_on_path
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.fidelity import MEANT, OF_TENSIONS, USUAL, Answer, Asked, Question
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.shapes import Shapes
from heavylift.nodes.statics import Followed, StaticState, follow, goal_states
from heavylift.nodes.statics.findings import path_findings

if TYPE_CHECKING:
    from .keys import schema


class SceneFacts(msgspec.Struct, frozen=True):
    """Settings of a scene outside its plan: requested quantities and accuracy, if `written`; `named`: keys that fix how
    it is run; `placement`: node -> process; `remote`: processes on other hosts; `tandem`: capacity of each crane beside
    another; `project`: data for documents."""

    own: tuple[Asked, ...]
    written: float | None
    named: tuple[str, ...]
    placement: dict[str, str]
    remote: list[str]
    tandem: dict[str, float]
    project: dict[str, str] = {}
    uncertain: bool = False  # inputs state an uncertainty

    @property
    def ask(self) -> tuple[Asked, ...]:
        """Requested quantities: the usual ones if it fixes nothing of how it is run."""
        return self.own if {*self.named} - {"samples"} else MEANT

    @property
    def accuracy(self) -> float:
        """Accuracy of each requested quantity, or of rope tensions (0.01: 1 %)."""
        return self.written or (USUAL if self.ask else OF_TENSIONS)


@dataclass(frozen=True)
class LoadedScene:
    """A scene that can be run: plan, text, path and settings."""

    plan: plan.Plan
    text: str
    path: Path
    facts: SceneFacts
    merged: str = ""  # text of the whole scene as JSON where it extends another one or has settings laid over it
    typed: str = ""  # its path or the name of a bundled scene, as it was given
    settings: tuple[str, ...] = ()  # laid over it
    passing: bool = False  # one of many that nobody loads again
    chosen: bool = False  # its plan is that of a run: nothing is to be chosen for what it asks
    answer: Answer | None = None  # how its plan was chosen
    apart: Followed | None = None  # the paths at rest of several lifts, each followed as if it were alone
    keys: schema.Scene | None = field(default=None, compare=False, repr=False)  # where they have been read already

    @cached_property
    def scene(self) -> schema.Scene:
        """Its keys."""
        from .keys.validate import validated  # with what reads scenes

        return self.keys or validated(self.merged or self.text, str(self.path))

    @cached_property
    def statics(self) -> Followed:
        """The action list followed at rest, as far as possible."""
        if self.plan.lists:
            return self.apart or Followed((), (), (), "", None, "")  # of a recording, which has no scenes of each
        return follow(self.plan, keep=not self.passing)

    @property
    def states(self) -> Sequence[StaticState]:
        """States of the path at rest; none where nothing is lifted."""
        return self.statics.states if self.lifts else ()

    @property
    def lifts(self) -> bool:
        """Whether hooks lift something."""
        machines = self.plan.machines
        return any(machine.hooks for machine in machines) and any(machine.cargo for machine in machines)

    @property
    def question(self) -> Question | None:
        """Requested quantities and accuracy, unless level and steps are chosen already."""
        return Question(self.facts.ask, self.facts.accuracy) if self.facts.ask and not self.chosen else None

    @cached_property
    def uses(self) -> list[Use]:
        """The highest utilisation of each limit on that path; for a lift also at the goals of moves."""
        if not self.plan.limits or (self.lifts and not self.states):
            return []
        found = uses_on_path(self.plan, [*self.statics.states, *goal_states(self.plan, self.statics)])
        tripped = {name for _, name in self.statics.tripped}
        return [use for use in found if use.limit.quantity != "interlock" or use.limit.subject not in tripped]

    @property
    def findings(self) -> tuple[Check, ...]:
        """What is beyond a limit on that path, or should be reported."""
        return findings(self.checks)

    @property
    def errors(self) -> Errors:
        """Measured errors of the figures of a run."""
        return self.answer.figures if self.answer else {}

    @property
    def checks(self) -> list[Check]:
        """All checks of that path, including those not possible there."""
        return self.checked()

    def checked(self, near: Sequence[Check] = ()) -> list[Check]:
        """The same with clearances too `near`."""
        unread = {id(use.limit) for use in self.uses}
        uses = [
            *self.uses,
            *(limit.met() for limit in self.plan.limits if id(limit) not in unread and limit.quantity != "interlock"),
        ]
        others = [*geometry_findings(self.plan), *path_findings(self.plan, self.statics), *near]
        return checks_of(self.plan, uses, others, None, Shapes(self.plan).shapeless)
