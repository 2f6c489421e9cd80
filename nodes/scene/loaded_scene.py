"""A scene that is ready to run, and the static results of its plan: loads, utilisations, findings, model level."""

from collections.abc import Callable, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.description.findings import Check, findings
from heavylift.nodes.limits.checks import Errors, checks_of, uncoloured
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
    """Settings for the run of a scene that are not part of its plan, such as method and accuracy.

    `own`: quantities that the scene asks for; `written`: accuracy, if given; `named`: keys that fix how the scene is
    run; `placement`: process of each node; `remote`: processes on other hosts; `tandem`: share of its capacity that
    each crane may use together with others; `project`: data for documents.
    """

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
        """The quantities that the scene lists under `ask`; a model level is chosen for their accuracy.

        They are the default quantities if the scene leaves the choice of the model and the method open."""
        return self.own if {*self.named} - {"samples"} else MEANT

    @property
    def accuracy(self) -> float:
        """Largest accepted relative error (0.01 is 1 %) of the requested quantities, or of rope tensions by default."""
        return self.written or (USUAL if self.ask else OF_TENSIONS)


planned: ContextVar[Callable[["LoadedScene"], None]] = ContextVar("planned", default=lambda scene: None)
"""Called with a new scene as soon as it has a plan; steps that need the equilibrium path may still change it."""


@dataclass(frozen=True)
class LoadedScene:
    """A scene that is ready to run: plan, text, path and settings."""

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
    keys: "schema.Scene | None" = field(default=None, compare=False, repr=False)  # where they have been read already

    @cached_property
    def scene(self) -> "schema.Scene":
        """The validated keys of the scene file."""
        from .keys.validate import validated  # with what reads scenes

        return self.keys or validated(self.merged or self.text, str(self.path))

    @cached_property
    def statics(self) -> Followed:
        """The equilibrium path along the action list, up to the point where an equilibrium can no longer be found."""
        if self.plan.lists:
            return self.apart or Followed((), (), (), "", None, "")  # of a recording, which has no scenes of each
        return follow(self.plan, keep=not self.passing)

    @property
    def states(self) -> Sequence[StaticState]:
        """The states of the equilibrium path; empty if the scene lifts nothing."""
        return self.statics.states if self.lifts else ()

    @property
    def lifts(self) -> bool:
        """Whether the scene has hooks and something to lift."""
        machines = self.plan.machines
        return any(machine.hooks for machine in machines) and any(machine.cargo for machine in machines)

    @property
    def question(self) -> Question | None:
        """The quantities under `ask` in the scene and their accuracy; None if the model level is already chosen."""
        return Question(self.facts.ask, self.facts.accuracy) if self.facts.ask and not self.chosen else None

    @cached_property
    def uses(self) -> list[Use]:
        """The highest static utilisation of each limit on the equilibrium path and at the end positions of moves."""
        if not self.plan.limits or (self.lifts and not self.states):
            return []
        path, starts = self.plan, [x.start or 0.0 for x in self.scene.lifts.values()] if self.apart else [0.0]
        begun = [x for x in starts if isinstance(x, float)]
        if path.end is None and self.states and self.statics.known and len(begun) == len(starts):
            path = msgspec.structs.replace(path, end=max(x.t for x in self.states) + max(begun))  # of its wind
        found = uses_on_path(path, [*self.statics.states, *goal_states(self.plan, self.statics)])
        tripped = {name for _, name in self.statics.tripped}
        return [use for use in found if use.limit.quantity != "interlock" or use.limit.subject not in tripped]

    @property
    def findings(self) -> tuple[Check, ...]:
        """Findings on the equilibrium path: exceeded limits, and remarks."""
        return findings(self.checks)

    @property
    def errors(self) -> Errors:
        """The measured error of each result of a run."""
        return self.answer.figures if self.answer else {}

    @property
    def checks(self) -> list[Check]:
        """All checks on the equilibrium path, including checks that only a run can decide."""
        return self.checked()

    def checked(self, near: Sequence[Check | Use] = ()) -> list[Check]:
        """Return all checks on the equilibrium path.

        `near`: findings about clearances on the path, or utilisations of clearances."""
        apart = [x for x in near if isinstance(x, Use)]
        seen = {id(use.limit) for use in self.uses}
        rest = [x for x in self.plan.limits if id(x) not in seen and x.quantity != "interlock"]
        uses = [*self.uses, *(x.met() for x in rest if x.inputs or x.quantity != "clearance" or not apart), *apart]
        found = [x for x in near if isinstance(x, Check)]
        others = [*geometry_findings(self.plan), *path_findings(self.plan, self.statics), *found]
        shapes = Shapes(self.plan)
        return checks_of(self.plan, uses, [*others, *uncoloured(self.plan, shapes)], None, shapes.shapeless)


def on_same_path(loaded: LoadedScene, built: plan.Plan) -> LoadedScene:
    """Return the scene with another plan that has the same equilibrium path, so that the path is not computed again."""
    other = replace(loaded, plan=built)
    if "statics" in vars(loaded):
        vars(other).update(statics=loaded.statics)
    return other
