"""A scene that can be run, and what follows from its plan at rest: loads, use of limits, findings, what is modelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.description.findings import Check, Finding
from heavylift.nodes.limits.checks import Errors, checks_of
from heavylift.nodes.limits.geometry import geometry_findings
from heavylift.nodes.limits.judging import judge, uses_on_path
from heavylift.nodes.limits.table_rows import sorted_findings
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.fidelity import MEANT, OF_TENSIONS, USUAL, Answer, Asked, Question
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.shapes import Shapes
from heavylift.nodes.statics import Followed, StaticState, follow, goal_states
from heavylift.nodes.statics.findings import path_findings

if TYPE_CHECKING:
    from .keys import schema


class SceneFacts(msgspec.Struct, frozen=True):
    """What a run asks of the keys of a scene besides its plan: what it asks itself, and its accuracy if that is
    `written`; `named`: keys that say how it is to be run, those of its fidelity too, and that are never chosen
    otherwise; `placement`: node -> process, for the nodes that the scene places; `remote`: processes that it places on
    other hosts; `tandem`: what each crane may carry beside another; `project`: what the
    document says of itself.
    """

    own: tuple[Asked, ...]
    written: float | None
    named: tuple[str, ...]
    placement: dict[str, str]
    remote: list[str]
    tandem: dict[str, float]
    project: dict[str, str] = {}

    @property
    def ask(self) -> tuple[Asked, ...]:
        """What is asked of it: what is usually meant, if it names nothing of how it is to be run."""
        return self.own if {*self.named} - {"samples"} else MEANT

    @property
    def accuracy(self) -> float:
        """Of each quantity that is asked, or of the rope tensions (0.01: 1 %)."""
        return self.written or (USUAL if self.ask else OF_TENSIONS)


@dataclass(frozen=True)
class LoadedScene:
    """A scene that can be run: its plan, its text as it stands in the file, its path, what a run asks of its keys."""

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
        """The action list followed at rest, as far as that goes."""
        if self.plan.lists:
            return self.apart or Followed((), (), (), "", None, "")  # of a recording, which has no scenes of each
        return follow(self.plan, keep=not self.passing)

    @property
    def states(self) -> Sequence[StaticState]:
        """The points of the path at rest along the action list; none where nothing is lifted."""
        return self.statics.states if self.lifts else ()

    @property
    def lifts(self) -> bool:
        """Whether hooks lift something."""
        machines = self.plan.machines
        return any(machine.hooks for machine in machines) and any(machine.cargo for machine in machines)

    @property
    def question(self) -> Question | None:
        """What it asks and how accurately, while nothing is chosen for it."""
        return Question(self.facts.ask, self.facts.accuracy) if self.facts.ask and not self.chosen else None

    @cached_property
    def uses(self) -> list[Use]:
        """The worst of each limit on that path, of a lift also where its moves are to lead."""
        if not self.plan.limits or (self.lifts and not self.states):
            return []
        found = uses_on_path(self.plan, [*self.statics.states, *goal_states(self.plan, self.statics)])
        tripped = {name for _, name in self.statics.tripped}
        return [use for use in found if use.limit.quantity != "interlock" or use.limit.subject not in tripped]

    @cached_property
    def findings(self) -> list[Finding]:
        """What is beyond a limit on that path, or should be reported."""
        return sorted_findings([*self._others, *judge(self.plan, self.uses, dynamic=False)])

    @property
    def errors(self) -> Errors:
        """By how much the figures of a run may be wrong, as far as that was measured."""
        return self.answer.figures if self.answer else {}

    @cached_property
    def _others(self) -> list[Finding]:
        return [*geometry_findings(self.plan), *path_findings(self.plan, self.statics)]

    @property
    def checks(self) -> list[Check]:
        """All checks of that path, and what nobody checks there."""
        return self.checked()

    def checked(self, near: Sequence[Finding] = ()) -> list[Check]:
        """The same with what comes too `near` to what."""
        unread = {id(use.limit) for use in self.uses}
        uses = [
            *self.uses,
            *(
                Use(limit, None)
                for limit in self.plan.limits
                if id(limit) not in unread and limit.quantity != "interlock"
            ),
        ]
        return checks_of(self.plan, uses, [*self._others, *near], None, Shapes(self.plan).shapeless)
