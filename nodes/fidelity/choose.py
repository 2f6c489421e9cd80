"""Which rules may be taken together: as long as their predicted errors stay within what the scene accepts.

Rules are tried in their order, from the richest rung downwards; each is taken if the sum of all errors predicted so far
and its own stays below the accuracy for every quantity asked.  A part that the scene names itself is left as named.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import msgspec
from heavylift.nodes.scene.plan import Fidelity, Plan

from .case import case_of
from .cost import Cost, cost
from .question import Asked, Question
from .rules import RULES, Choice

if TYPE_CHECKING:
    from heavylift.nodes.scene.follow import Following

__all__ = ["Verdict", "choose"]

RICHEST = Fidelity(ropes="massive", lumps=2, girder="elastic")
INTEGRATION = 0.1  # part of the accuracy that is left to the steps in time
ALWAYS = (  # what needs no decision
    "bodies that locked joints join are one body; reevings are lumped to one spring; no wind: none is named",
    "all machines are solved together, tied by ropes or not",
)


@dataclass(frozen=True)
class Decided:
    """A choice and what became of it: "left out", "kept", or "named" by the scene."""

    choice: Choice
    outcome: str


@dataclass(frozen=True)
class Verdict:
    """The fidelity for a question; `str` is the pruning report; no costs where nothing can be followed."""

    question: Question
    fidelity: Fidelity
    decided: tuple[Decided, ...]
    errors: dict[Asked, float]
    cost: Cost | None = None
    richest: Cost | None = None

    def __str__(self) -> str:
        asked = ", ".join(self.question.ask)
        lines = [f"asked: {asked}, to {self.question.accuracy:.3g} of each", ""]
        for d in self.decided:
            told = ", ".join(f"{q} {d.choice.errors.get(q, 0.0):.2%}" for q in self.question.ask)
            lines.append(
                f"  {d.choice.rule:<16} {d.outcome:<9} {d.choice.saved:>4} states   {told}   {d.choice.reason}"
            )
        total = ", ".join(f"{q} {e:.2%}" for q, e in self.errors.items())
        lines += [f"  predicted in all: {total}; the steps in time may add {INTEGRATION * self.question.accuracy:.2%}"]
        if self.cost and self.richest:
            lines += [
                f"  {name:<16} {c.states:>4} states, bound by {c.omega:.0f} 1/s, about {c.evaluations:.2g} evaluations"
                for name, c in (("richest rung", self.richest), ("chosen rung", self.cost))
            ]
            lines += [f"  evaluations x states: 1/{self.richest.product / self.cost.product:.1f} of the richest rung's"]
        return "\n".join([*lines, *(f"  {line}" for line in ALWAYS)])

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
            "predicted": dict(self.errors),
            "cost": {name: asdict(c) for name, c in (("chosen", self.cost), ("richest", self.richest)) if c},
        }  # fmt: skip


def choose(plan: Plan, followed: Following, question: Question, named: frozenset[str]) -> Verdict:
    """The fidelity that answers a question; `named`: the keys of the fidelity that the scene has written itself."""
    case = case_of(plan, followed)
    given = plan.fidelity
    fidelity = _richest(given, named) if case else given
    budget = question.accuracy * (1.0 - INTEGRATION)
    spent: dict[Asked, float] = dict.fromkeys(question.ask, 0.0)
    decided: list[Decided] = []
    for rule in RULES if case else ():
        assert case is not None
        choice = rule(case, fidelity)
        if choice.key in named:
            decided.append(Decided(choice, "named"))
            continue
        after = {q: spent[q] + choice.errors.get(q, 0.0) for q in question.ask}
        if choice.allowed and _before(choice, decided) and all(e <= budget for e in after.values()):
            fidelity, spent = _changed(fidelity, choice), after
            decided.append(Decided(choice, "left out"))
        else:
            decided.append(Decided(choice, "kept"))
    costs = (cost(case, fidelity), cost(case, _richest(given, named))) if case else (None, None)
    return Verdict(question, fidelity, tuple(decided), spent, *costs)


def _richest(given: Fidelity, named: frozenset[str]) -> Fidelity:
    """The richest rung, but for what the scene names."""
    start = {k: getattr(RICHEST, k) for k in ("ropes", "lumps", "girder") if k not in named}
    return msgspec.structs.replace(given, **start)


def _before(choice: Choice, decided: list[Decided]) -> bool:
    """Ropes lose their elasticity after their mass and the elasticity of what they hang from."""
    if choice.rule != "rigid ropes":
        return True
    return all(d.outcome != "kept" for d in decided if d.choice.rule in ("massless ropes", "rigid girder"))


def _changed(fidelity: Fidelity, choice: Choice) -> Fidelity:
    locked = dict.fromkeys((*fidelity.locked, *choice.locked))
    return msgspec.structs.replace(fidelity, **{**choice.change, "locked": tuple(locked)})
