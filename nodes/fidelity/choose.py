"""Which rules may be taken together: as long as their predicted errors stay within what the scene accepts.

Every set of rules is tried; of those whose errors, added up, stay below the accuracy for each quantity asked, the one
that leaves the cheapest rung is taken: so the predicted cost never rises with the accuracy that is given up.  What is
left of the accuracy is the steps', whose method and tolerance come last.  What the scene names itself is left as named,
and what it costs is counted first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from itertools import combinations

import msgspec
from heavylift.nodes.models.assembly import system
from heavylift.nodes.plan.fidelity import ALONG, Asked, Question
from heavylift.nodes.plan.plan import Fidelity, Plan
from heavylift.nodes.plan.planar import planar

from .always import ALWAYS
from .case import Case, case_of
from .chance import FARTHEST, Errors, chance
from .cost import cost
from .following import Following
from .method import METHODS, Stepped, stepped
from .rules import RULES, Choice
from .verdict import INTEGRATION, Decided, Verdict, left, percent, unruled

RICHEST = Fidelity(ropes="massive", lumps=4, rope_mass="lumped", girder="elastic")
PLAIN = 1e-6  # tolerance of a run without a question
STARTING = 6e7  # evaluations times states in the time that a process takes to start, about
# over the run without a question, of accuracies down to this; where that is predicted, 1.5 is measured
DEAREST, PRICED = 1.6, 3e-3
EXPLICIT = ("dopri5", "dop853")  # that no stiff part of a mechanism takes by surprise


def choose(
    plan: Plan, followed: Following, question: Question, named: frozenset[str], steps: frozenset[str] = frozenset()
) -> Verdict:
    """The fidelity that answers a question; `named`: the keys of the fidelity that the scene has written itself, and
    `steps`: those of method, tolerance and step."""
    if why := unruled(plan):
        return unpromised(question, plan.fidelity, why, _always(plan))
    case = case_of(plan, followed)
    if case is None:
        why = "no block is lifted as far as the action list can be followed before the run"
        return unpromised(question, plan.fidelity, why, _always(plan))
    if not followed.known:
        why = f"its action list cannot be followed at rest to its end: {followed.path.why}"
        return unpromised(question, plan.fidelity, why, _always(plan))
    if case.awaits > FARTHEST:
        why = f"it awaits an event while the load swings by up to {1e3 * case.awaits:.0f} mm"
        return unpromised(question, plan.fidelity, why, _always(plan))
    if case.changes and not case.damped:
        why = "a hook is taken from the load, and its ropes damp nothing of what that sets ringing"
        return unpromised(question, plan.fidelity, why, _always(plan))
    if case.flies_up and "rope tension" in question.ask:  # no number of lumps is sure how hard it falls back
        why = "a hook is let go with more on it than it weighs itself, so its rope slackens and snaps taut"
        return unpromised(question, plan.fidelity, why, _always(plan))
    fidelity = richest = _richest(plan.fidelity, named)
    left_out, decided = _cheapest(case, richest, question, named), list[Decided]()
    spent: dict[Asked, float] = dict.fromkeys(question.ask, 0.0)
    for rule in RULES:
        choice = rule(case, fidelity)
        poor = _poor(choice, richest, named)
        if choice.rule in left_out:
            fidelity = _changed(fidelity, choice)
        elif choice.key in named and not poor:
            choice = replace(choice, errors={}, saved=0)
        if choice.rule in left_out or poor:
            spent = {q: e + choice.errors.get(q, 0.0) for q, e in spent.items()}
        decided.append(Decided(choice, _outcome(choice, left_out, named), poor))
    pruned, most = (msgspec.structs.replace(plan, fidelity=planar(f, plan.machines)) for f in (fidelity, richest))
    unsure = chance(case)
    ways = _steps(case, pruned, left(question, spent, unsure), steps)
    dearer = (STARTING + ways[0].cost.product) / (STARTING + _plain(case, plan, steps)) if ways else 1.0
    if dearer > DEAREST and question.accuracy >= PRICED:
        why = f"to {percent(question.accuracy)} it would take {dearer:.1f} times as long as without a question"
        why += f", which is modelled instead; an accuracy finer than {percent(PRICED)} is kept at any price"
        return replace(unpromised(question, plan.fidelity, why, _always(plan)), cost=ways[0].cost)
    dearest = _steps(case, most, dict.fromkeys(question.ask, question.accuracy), steps)
    costs = (ways[0].cost, dearest[0].cost) if ways else (cost(case, fidelity), cost(case, richest))
    return Verdict(
        question, fidelity, tuple(decided), spent, *costs, _always(pruned), ways, unsure,
        unpredicted=(*_unpredicted(decided, richest, named), *_own_steps(plan, steps)),
    )  # fmt: skip


def unpromised(question: Question, fidelity: Fidelity, why: str, always: tuple[Choice, ...] = ()) -> Verdict:
    """Of a scene that is modelled as it is written, since nothing of it can be predicted."""
    return Verdict(question, fidelity, (), {}, always=always, unknown=why)


def _always(plan: Plan) -> tuple[Choice, ...]:
    """What is left out of every lift."""
    mechanics = system(plan)
    return tuple(rule(plan, mechanics) for rule in ALWAYS)


def _cheapest(case: Case, richest: Fidelity, question: Question, named: frozenset[str]) -> set[str]:
    """Of all sets of rules whose errors stay within the budget together, the one that leaves the cheapest rung."""
    choices = [rule(case, richest) for rule in RULES]
    open_ = [c for c in choices if c.allowed and c.key not in named]
    budget = {q: (1.0 - INTEGRATION) * question.accuracy - e for q, e in chance(case).items()}
    poor = [c.errors for c in choices if _poor(c, richest, named)]
    for q in question.ask:
        by_name = sum(errors.get(q, 0.0) for errors in poor)
        lost = by_name > question.accuracy  # no rule makes that better, nor should one make it much worse
        budget[q] = INTEGRATION * question.accuracy if lost else max(0.0, budget[q] - by_name)
    found: tuple[float, int, set[str]] = (cost(case, richest).product, 0, set())
    for n in range(1, len(open_) + 1):
        for some in combinations(open_, n):
            if {"two lumps", "lumped ropes"} <= {c.rule for c in some}:  # without chains nothing is made coarser
                continue
            if any(sum(c.errors.get(q, 0.0) for c in some) > budget[q] for q in question.ask):
                continue
            product = cost(case, reduce(_changed, some, richest)).product
            if (product, -n) <= found[:2]:
                found = product, -n, {c.rule for c in some}
    return found[2]


def _poor(choice: Choice, given: Fidelity, named: frozenset[str]) -> bool:
    """Whether the scene has left out by name what a rule looks at, or some of it."""
    if choice.key not in named:
        return False
    if choice.key == "ropes":
        return given.ropes == "rigid" or (given.ropes == "elastic" and choice.change["ropes"] == "elastic")
    if choice.key == "lumps":
        return given.ropes == "massive" and given.lumps < RICHEST.lumps
    if choice.key == "locked":
        return any(joint in given.locked for joint in choice.locked)
    return bool(getattr(given, choice.key) != getattr(RICHEST, choice.key))


def _unpredicted(decided: Sequence[Decided], given: Fidelity, named: frozenset[str]) -> tuple[str, ...]:
    """What the scene names that no rule allows, or looks at."""
    wrong = [d.choice.key for d in decided if d.poor and not d.choice.allowed and d.choice.key != "lumps"]
    wrong += ["motion"] if "motion" in named and given.motion == ALONG else []
    wrong += ["slings"] if given.slings == "rigid" and given.ropes != "rigid" else []
    massless = given.ropes != "massive" and "rope_mass" in named and given.rope_mass == "none"
    wrong += ["rope mass"] if massless else []
    return tuple(dict.fromkeys(wrong))


def _outcome(choice: Choice, left_out: set[str], named: frozenset[str]) -> str:
    if choice.key in named:
        return "named"
    return "left out" if choice.rule in left_out else "kept"


def _steps(case: Case, plan: Plan, left: Errors, named: frozenset[str]) -> tuple[Stepped, ...]:
    """Methods with their tolerances, the one to be used first; none where the scene names its steps."""
    if _own_steps(plan, named):
        return ()
    methods = (plan.method,) if "method" in named else EXPLICIT if plan.mechanisms else tuple(METHODS)
    return tuple(stepped(case, plan.fidelity, left, methods, plan.tolerance if "tolerance" in named else None))


def _plain(case: Case, plan: Plan, named: frozenset[str]) -> float:
    """Evaluations times states of the run without a question."""
    method = METHODS.get(plan.method, METHODS["dopri5"])
    return method(case, plan.fidelity, plan.tolerance if "tolerance" in named else PLAIN).cost.product


def _own_steps(plan: Plan, named: frozenset[str]) -> tuple[str, ...]:
    """What the scene names of its steps so that nothing is predicted of them."""
    return ("step",) if "step" in named else ("method",) if "method" in named and plan.method not in METHODS else ()


def _richest(given: Fidelity, named: frozenset[str]) -> Fidelity:
    """The richest rung, but for what the scene names."""
    start = {k: getattr(RICHEST, k) for k in ("ropes", "lumps", "rope_mass", "girder") if k not in named}
    return msgspec.structs.replace(given, **start)


def _changed(fidelity: Fidelity, choice: Choice) -> Fidelity:
    locked = dict.fromkeys((*fidelity.locked, *choice.locked))
    return msgspec.structs.replace(fidelity, **{**choice.change, "locked": tuple(locked)})
