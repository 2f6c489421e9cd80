"""Which rules may be taken together: as long as their predicted errors stay within what the scene accepts.

Every set of rules is tried; of those whose errors, added up, stay below the accuracy for each quantity asked, the one
that leaves the cheapest rung is taken: so the predicted cost never rises with the accuracy that is given up.  What is
left of the accuracy is the steps', whose method and tolerance come last.  What the scene names itself is left as named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import reduce
from itertools import combinations
from typing import TYPE_CHECKING

import msgspec
from heavylift.nodes.models.assembly import system
from heavylift.nodes.scene.modelling import planar
from heavylift.nodes.scene.plan import Fidelity, Plan

from .always import ALWAYS
from .case import Case, case_of
from .cost import Cost, cost
from .method import METHODS, Stepped, stepped
from .question import Asked, Question
from .rules import RULES, Choice, Errors, chance

if TYPE_CHECKING:
    from heavylift.nodes.scene.follow import Following

__all__ = ["Verdict", "choose"]

RICHEST = Fidelity(ropes="massive", lumps=4, rope_mass="lumped", girder="elastic")
BEFORE_RIGID = ("lumped ropes", "rigid girder")
CERTAIN = 0.6  # part of the accuracy that rules may spend whatever chance adds
INTEGRATION = 0.1  # part of the accuracy that is left to the steps in time
EXPLICIT = ("dopri5", "dop853")  # that no stiff part of a mechanism takes by surprise


@dataclass(frozen=True)
class Decided:
    """A choice and what became of it: "left out", "kept", or "named" by the scene."""

    choice: Choice
    outcome: str


@dataclass(frozen=True)
class Verdict:
    """The fidelity for a question; `str` is the pruning report; no costs where nothing can be followed.

    `always`: what is left out of every lift.  `steps`: methods, the one to be used first; none where the scene names
    its steps.
    """

    question: Question
    fidelity: Fidelity
    decided: tuple[Decided, ...]
    errors: dict[Asked, float]
    cost: Cost | None = None
    richest: Cost | None = None
    always: tuple[Choice, ...] = ()
    steps: tuple[Stepped, ...] = ()
    chance: Errors = field(default_factory=dict)

    def __str__(self) -> str:
        asked = ", ".join(self.question.ask)
        lines = [f"asked: {asked}, to {self.question.accuracy:.3g} of each", ""]
        for d in self.decided:
            lines.append(
                f"  {d.choice.rule:<16} {d.outcome:<9} {d.choice.saved:>4} states   {self._told(d.choice.errors)}   "
                f"{d.choice.reason}"
            )
        for choice in self.always:
            outcome = "left out" if choice.allowed else "as it is"
            lines.append(f"  {choice.rule:<16} {outcome:<9} {choice.saved:>4} states   {choice.reason}")
        lines += [f"  predicted in all: {self._told(self.errors)}; the steps may add {self._told(self._left())}"]
        if self.chance:
            lines += [f"  by chance, whatever is modelled: {self._told(self.chance)}: which pad is the last to open"]
        if self.cost and self.richest:
            lines += [
                f"  {name:<16} {c.states:>4} states, bound by {c.omega:.0f} 1/s, about {c.evaluations:.2g} evaluations"
                for name, c in (("richest rung", self.richest), ("chosen rung", self.cost))
            ]
            lines += [f"  evaluations x states: 1/{self.richest.product / self.cost.product:.1f} of the richest rung's"]
        for i, s in enumerate(self.steps):
            fits = s.within(self._left())
            outcome = ("chosen" if fits else "at best") if i == 0 else "dearer" if fits else "unfit"
            at = f"{s.method} at {s.tolerance:.0e}" if s.allowed else s.method
            lines.append(f"  {at:<16} {outcome:<9} {self._words(s)}{s.reason}")
        return "\n".join(lines)

    def _told(self, errors: Errors) -> str:
        return ", ".join(f"{q} {errors.get(q, 0.0):.2%}" for q in self.question.ask)

    def _words(self, s: Stepped) -> str:
        """Predicted cost and errors of a method."""
        if not s.allowed:
            return ""
        spent = f"{s.cost.evaluations:.2g} evaluations"
        spent += f" and {s.cost.algebra:.2g} in matrices" if s.cost.algebra else ""
        return f"{spent}   {self._told(s.errors)}   "

    def _left(self) -> Errors:
        """Of the accuracy, for the steps."""
        return {q: self.question.accuracy - self.errors[q] for q in self.question.ask}

    def data(self) -> dict[str, object]:
        """The same as plain data."""
        return {
            "ask": list(self.question.ask),
            "accuracy": self.question.accuracy,
            "fidelity": msgspec.to_builtins(self.fidelity),
            "choices": [
                {"rule": d.choice.rule, "key": d.choice.key, "outcome": d.outcome, "states": d.choice.saved,
                 "errors": dict(d.choice.errors), "reason": d.choice.reason}
                for d in self.decided
            ],
            "always": [
                {"rule": c.rule, "left_out": c.allowed, "states": c.saved, "reason": c.reason} for c in self.always
            ],
            "steps": [
                {"method": s.method, "tolerance": s.tolerance, "sufficient": s.within(self._left()),
                 "errors": dict(s.errors), "cost": asdict(s.cost), "reason": s.reason}
                for s in self.steps
            ],
            "predicted": dict(self.errors),
            "chance": dict(self.chance),
            "cost": {name: asdict(c) for name, c in (("chosen", self.cost), ("richest", self.richest)) if c},
        }  # fmt: skip


def choose(
    plan: Plan, followed: Following, question: Question, named: frozenset[str], steps: frozenset[str] = frozenset()
) -> Verdict:
    """The fidelity that answers a question; `named`: the keys of the fidelity that the scene has written itself, and
    `steps`: those of method, tolerance and step."""
    case = case_of(plan, followed)
    spent: dict[Asked, float] = dict.fromkeys(question.ask, 0.0)
    if case is None:
        return Verdict(question, plan.fidelity, (), spent, always=_always(plan))
    fidelity = richest = _richest(plan.fidelity, named)
    left_out, decided = _cheapest(case, richest, question, named), list[Decided]()
    for rule in RULES:
        choice = rule(case, fidelity)
        if choice.rule in left_out:
            fidelity = _changed(fidelity, choice)
            spent = {q: e + choice.errors.get(q, 0.0) for q, e in spent.items()}
        decided.append(Decided(choice, _outcome(choice, left_out, named)))
    pruned, most = (
        msgspec.structs.replace(plan, fidelity=planar(f, plan.loaders, plan.cranes)) for f in (fidelity, richest)
    )
    ways = _steps(case, pruned, {q: question.accuracy - e for q, e in spent.items()}, steps)
    dearest = _steps(case, most, dict.fromkeys(question.ask, question.accuracy), steps)
    costs = (ways[0].cost, dearest[0].cost) if ways else (cost(case, fidelity), cost(case, richest))
    return Verdict(question, fidelity, tuple(decided), spent, *costs, _always(pruned), ways, chance(case))


def _always(plan: Plan) -> tuple[Choice, ...]:
    """What is left out of every lift."""
    return tuple(rule(plan, system(plan)) for rule in ALWAYS)


def _cheapest(case: Case, richest: Fidelity, question: Question, named: frozenset[str]) -> set[str]:
    """Of all sets of rules whose errors stay within the budget together, the one that leaves the cheapest rung."""
    choices = [rule(case, richest) for rule in RULES]
    open_ = [c for c in choices if c.allowed and c.key not in named]
    budget = {
        q: max((1.0 - INTEGRATION) * question.accuracy - chance(case).get(q, 0.0), CERTAIN * question.accuracy)
        for q in question.ask
    }
    found: tuple[float, int, set[str]] = (cost(case, richest).product, 0, set())
    for n in range(1, len(open_) + 1):
        for some in combinations(open_, n):
            if not _fit(some, choices, named):
                continue
            if any(sum(c.errors.get(q, 0.0) for c in some) > budget[q] for q in question.ask):
                continue
            product = cost(case, reduce(_changed, some, richest)).product
            if (product, -n) <= found[:2]:
                found = product, -n, {c.rule for c in some}
    return found[2]


def _fit(some: Sequence[Choice], choices: list[Choice], named: frozenset[str]) -> bool:
    """Ropes lose their elasticity only after their mass and the elasticity of what they hang from; without chains of
    lumps there is nothing to make coarser."""
    taken = {c.rule for c in some}
    if taken >= {"two lumps", "lumped ropes"}:
        return False
    before = {c.rule for c in choices if c.rule in BEFORE_RIGID and c.key not in named}
    return "rigid ropes" not in taken or before <= taken


def _outcome(choice: Choice, left_out: set[str], named: frozenset[str]) -> str:
    if choice.key in named:
        return "named"
    return "left out" if choice.rule in left_out else "kept"


def _steps(case: Case, plan: Plan, left: Errors, named: frozenset[str]) -> tuple[Stepped, ...]:
    """Methods with their tolerances, the one to be used first; none where the scene names its steps."""
    if "step" in named or ("method" in named and plan.method not in METHODS):
        return ()
    methods = (plan.method,) if "method" in named else EXPLICIT if plan.mechanisms else tuple(METHODS)
    return tuple(stepped(case, plan.fidelity, left, methods, plan.tolerance if "tolerance" in named else None))


def _richest(given: Fidelity, named: frozenset[str]) -> Fidelity:
    """The richest rung, but for what the scene names."""
    start = {k: getattr(RICHEST, k) for k in ("ropes", "lumps", "rope_mass", "girder") if k not in named}
    return msgspec.structs.replace(given, **start)


def _changed(fidelity: Fidelity, choice: Choice) -> Fidelity:
    locked = dict.fromkeys((*fidelity.locked, *choice.locked))
    return msgspec.structs.replace(fidelity, **{**choice.change, "locked": tuple(locked)})
