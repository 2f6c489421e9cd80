"""The answer to a question: every choice with its errors and its reason, the steps, and what cannot be guaranteed.

`str` is the report that `heavylift check` prints, `data` the same as plain data, `notes` the warnings before a run: an
accuracy that is not guaranteed must not look as if it were.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field

import msgspec
from heavylift.nodes.plan.actions import parts
from heavylift.nodes.plan.fidelity import Asked, Question
from heavylift.nodes.plan.plan import Fidelity, Plan

from .chance import Errors
from .cost import Cost
from .lifts import lift_of
from .method import Stepped
from .rules import Choice

EXACT = 2e-4  # to which the richest rung itself is right: what two lumps and four differ by in peaks
INTEGRATION = 0.1  # part of the accuracy that is left to the steps in time


@dataclass(frozen=True)
class Decided:
    """A choice and what became of it: "left out", "kept", or "named" by the scene; `poor`: without what the rule looks
    at, by name."""

    choice: Choice
    outcome: str
    poor: bool = False


@dataclass(frozen=True)
class Verdict:
    """The fidelity for a question; no errors and no costs where nothing is predicted, for the reason `unknown`.

    `errors`: of all that is left out, by rule or by name.  `always`: what is left out of every lift.  `chance`: what
    the richest rung may be wrong by.  `steps`: methods, the one to be used first; none where the scene names its steps.
    `unpredicted`: what is named and no rule speaks of.
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
    unknown: str = ""
    unpredicted: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Why what is asked is not promised; empty if it is."""
        if self.unknown:
            return (f"nothing is chosen or promised for what the scene asks: {self.unknown}",)
        accuracy, notes = self.question.accuracy, []
        if dear := [f"{q} {percent(e)}" for q, e in self.errors.items() if e > accuracy]:
            notes.append(
                f"what the scene names costs more than the accuracy asked, {percent(accuracy)}: {', '.join(dear)}"
            )
        notes += [
            f"the scene names '{key}', whose error no rule predicts here: not promised" for key in self.unpredicted
        ]
        exact = max([EXACT, *(self.chance.get(q, 0.0) for q in self.question.ask)])
        if accuracy < exact / (1.0 - INTEGRATION):
            finest = f"the richest rung itself is right to {percent(exact)}"
            notes.append(
                f"no rung keeps an accuracy of {percent(accuracy)} for certain: {finest}, nothing finer is promised"
            )
        if self.steps and not self.steps[0].within(self._left()):
            unfit = "is kept although unfit: no method promises what is left for the steps"
            notes.append(f"{self.steps[0].method} {unfit}")
        return tuple(notes)

    def __str__(self) -> str:
        asked = ", ".join(self.question.ask)
        lines = [f"asked: {asked}, to {percent(self.question.accuracy)} of each", ""]
        if self.unknown:
            return "\n".join([*lines, *(f"  {note}" for note in self.notes)])
        for d in self.decided:
            lines.append(
                f"  {d.choice.rule:<16} {d.outcome:<9} {d.choice.saved:>4} states   {self._errors(d.choice.errors)}   "
                f"{d.choice.reason}"
            )
        for choice in self.always:
            outcome = "left out" if choice.allowed else "as it is"
            lines.append(f"  {choice.rule:<16} {outcome:<9} {choice.saved:>4} states   {choice.reason}")
        rest = f"; the steps may add {self._errors(self._left())}" if self.steps else ""
        lines += [f"  predicted in all: {self._errors(self.errors)}{rest}"]
        if self.chance:
            lines += [
                f"  whatever is modelled: {self._errors(self.chance)}: bends of ropes, which pad is the last to open"
            ]
        if self.cost and self.richest:
            lines += [
                f"  {name:<16} {c.states:>4} states, bound by {c.omega:.0f} 1/s, about {c.evaluations:.2g} evaluations"
                for name, c in (("richest rung", self.richest), ("chosen rung", self.cost))
            ]
            lines += [f"  evaluations x states: 1/{self.richest.product / self.cost.product:.1f} of the richest rung's"]
        for i, s in enumerate(self.steps):
            fits = s.within(self._left())
            first = "chosen" if fits and not self.notes else "not promised" if fits else "kept although unfit"
            outcome = first if i == 0 else "dearer" if fits else "unfit"
            at = f"{s.method} at {s.tolerance:.0e}" if s.allowed else s.method
            lines.append(f"  {at:<17} {outcome:<18} {self._words(s)}{s.reason}")
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def _errors(self, errors: Errors) -> str:
        return ", ".join(f"{q} {percent(errors.get(q, 0.0))}" for q in self.question.ask)

    def _words(self, s: Stepped) -> str:
        """Predicted cost and errors of a method."""
        if not s.allowed:
            return ""
        spent = f"{s.cost.evaluations:.2g} evaluations"
        spent += f" and {s.cost.algebra:.2g} in matrices" if s.cost.algebra else ""
        return f"{spent}   {self._errors(s.errors)}   "

    def _left(self) -> Errors:
        """Of the accuracy, for the steps."""
        return left(self.question, self.errors, self.chance)

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
            "notes": list(self.notes),
            "cost": {name: asdict(c) for name, c in (("chosen", self.cost), ("richest", self.richest)) if c},
        }  # fmt: skip


def unruled(plan: Plan) -> str:
    """What of a lift no rule looks at, as a sentence; "" if there is nothing."""
    if lift_of(plan).tied:
        only = {m.name for m in plan.mechanisms} == {"wind"}
        return f"{'the wind' if only else 'its mechanism'} acts on the lift, which no rule looks at"
    if lift_of(plan).block and lift_of(plan).block.flexible:
        return "its block is flexible, which no rule looks at"
    if any(sling.over for sling in lift_of(plan).rig.slings):
        return "its slings bend over edges, which no rule looks at"
    if any(parts(action) for action in plan.actions):
        return "a sling parts, which no rule looks at"
    return ""


def left(question: Question, spent: Errors, reserved: Errors) -> Errors:
    """Of the accuracy, for the steps; their usual part where what is named has spent more."""
    spare = {q: question.accuracy - spent[q] - reserved.get(q, 0.0) for q in question.ask}
    return {q: e if e > 0.0 else INTEGRATION * question.accuracy for q, e in spare.items()}


def percent(error: float) -> str:
    """A relative error in percent, to three digits."""
    return f"{100.0 * error:.3g} %"
