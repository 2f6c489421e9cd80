"""What of a scene is modelled, by which steps: the cheapest rung whose measured errors are below what is asked.

From the poorest level and the loosest steps upwards: the steps are judged by steps a tenth as tolerant, the level by
one that puts back all that it leaves out, both differences are added and doubled, and the larger one says which is
refined.  On the finest level there is no witness; its error is its difference to the next poorer one.  What comes of it
depends on plan and question alone, never on the clock or the machine; what is remembered only saves time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path

import msgspec
from heavylift.kernel.cache import contents, read_cached, remembered, sources
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Answer, Asked, Question, percent
from heavylift.nodes.plan.plan import Plan, encode, functions
from heavylift.nodes.scene import LoadedScene

from .in_memory import CUT
from .measuring import WITNESSED, Errors, Measuring, added, largest, times
from .rungs import Ladder, Rung, at_level

STUCK = 2  # times that steps a tenth as tolerant change nothing for the better, until it is given up
LOOSEST = 0.1  # tolerance of a step, as a part of the accuracy
ROOM = Path(__file__).parents[2]  # of the product
Say = Callable[[str], None]


def chosen(scene: LoadedScene, say: Say = lambda told: None) -> LoadedScene:
    """The scene with what it asks answered, ready to be run; `say` hears of the runs that were needed."""
    if (question := scene.question) is None:
        return scene
    if scene.plan.models:
        why = "a scene with models of its own is modelled as it is written, and nothing is measured for what it asks"
        return answered(scene, _unmeasured(scene.plan, why))

    def make() -> Answer:
        return choose(Ladder(scene.plan, scene.facts.named), question, Measuring(question.ask, say=say))

    alone = scene.passing or bool(functions(scene.plan))  # whose code may change
    return answered(scene, make() if alone else remembered(_name(scene, question), Answer, make))


def known(scene: LoadedScene) -> Answer | None:
    """The answer that is remembered of a scene that asks something, if one is."""
    if scene.question is None:
        return scene.answer
    try:
        return msgspec.msgpack.decode(read_cached(_name(scene, scene.question)), type=Answer)
    except msgspec.MsgspecError:
        return None


def answered(scene: LoadedScene, answer: Answer) -> LoadedScene:
    """The scene as an answer has it modelled."""
    plan = at_level(scene.plan, answer.fidelity)
    plan = msgspec.structs.replace(plan, method=answer.method, tolerance=answer.tolerance)
    return replace(scene, plan=plan, chosen=True, answer=answer)


def level_of(scene: LoadedScene, say: Say = lambda told: None) -> LoadedScene:
    """The scene with the level and the steps of its answer among its settings, for many variants of it."""
    if scene.question is None:
        return scene
    found = chosen(scene, say)
    return replace(found, settings=(*scene.settings, *Rung(found.plan).settings))


def error_of(plan: Plan, ask: Sequence[Asked]) -> tuple[float, str]:
    """The largest relative error of what is asked of a plan as it is, measured, and in which figure."""
    measuring, rung, ladder = Measuring(ask), Rung(plan), Ladder(plan)
    errors = added(times(WITNESSED, measuring.apart(rung, rung.tighter)), error_of_level(ladder, rung, measuring))
    name = max(errors, key=lambda x: (errors[x], x), default="")
    return errors.get(name, 0.0), name


@dataclass(frozen=True)
class _Look:
    """A rung and by what it differs from tighter steps and from its witness; why it made no run."""

    rung: Rung
    steps: Errors = field(default_factory=lambda: {"": inf})
    model: Errors = field(default_factory=dict)
    error: Errors = field(default_factory=lambda: {"": inf})
    why: str = ""


def choose(ladder: Ladder, question: Question, measuring: Measuring) -> Answer:
    """The answer to a question; raises HeavyliftError only where the clock cuts a run."""
    level = stuck = at = 0
    first = ladder.rungs(ladder.levels[0])
    while at + 1 < len(first) and first[at].plan.tolerance > LOOSEST * question.accuracy * (1.0 + 1e-9):
        at += 1
    before, last = inf, _Look(first[at])
    while True:
        rungs = ladder.rungs(ladder.levels[level])
        look = _look(ladder, rungs[at], question.accuracy, measuring, first=before == inf)
        if look is None:  # with denser samples
            continue
        if largest(look.error) <= question.accuracy:
            return _answer(look, question, measuring, ladder)
        last = look if not look.why or last.why else last
        steps, model = WITNESSED * largest(look.steps), largest(look.model)
        stuck = stuck + 1 if steps > 0.5 * before else 0
        before = steps
        finer, richer = at + 1 < len(rungs) and stuck < STUCK, level + 1 < len(ladder.levels)
        if richer and (model > steps or (look.why and not finer)):
            level, before, stuck = level + 1, inf, 0
        elif finer and steps > 0.0 and not (model > question.accuracy and not richer and model > steps):
            at += 1
        else:
            return _unconverged(last, question, measuring, ladder)


def _look(ladder: Ladder, rung: Rung, accuracy: float, measuring: Measuring, first: bool) -> _Look | None:
    """A rung beside its tighter steps and, where these are good enough or it is the first of its level, beside its
    witness; None if samples must be denser."""
    try:
        if not measuring.read_well(rung, accuracy):
            return None
        steps = measuring.apart(rung, rung.tighter)
        error = added(times(WITNESSED, steps), measuring.misread(rung))
        well = first or WITNESSED * largest(steps) <= accuracy
        model = error_of_level(ladder, rung, measuring) if well else {}
        return _Look(rung, steps, model, added(error, model))
    except HeavyliftError as error:
        if CUT in str(error):
            raise
        return _Look(rung, why=str(error).splitlines()[0])


def _of_limits(ladder: Ladder, rung: Rung, measuring: Measuring) -> Errors:
    """The same of the uses of limits, as far as the runs that were needed tell; nothing decides on them."""
    level = ladder.witness(rung.plan.fidelity) or ladder.poorer
    others = [rung.tighter, *([rung.on(level)] if level else [])]
    own, *known = (measuring.limits.get(each.key, {}) for each in (rung, *others))
    return {
        name: WITNESSED * sum(abs(f.value - other[name].value) for other in known) / f.scale
        for name, f in own.items()
        if all(name in other for other in known)
    }


def error_of_level(ladder: Ladder, rung: Rung, measuring: Measuring) -> Errors:
    """What the level of a rung leaves out, by its witness; of the finest level by the one before it."""
    if witness := ladder.witness(rung.plan.fidelity):
        return times(WITNESSED, measuring.apart(rung, rung.on(witness)))
    return measuring.apart(rung, rung.on(ladder.poorer)) if ladder.poorer else {}


def _answer(look: _Look, question: Question, measuring: Measuring, ladder: Ladder, *notes: str) -> Answer:
    limits = _of_limits(ladder, look.rung, measuring)
    plan, quantity = look.rung.plan, {f.name: f.quantity for f in measuring.seen.values()}
    by = {q: {name: e for name, e in look.error.items() if quantity.get(name) == q} for q in question.ask}
    worst = {q: max(errors, key=lambda name: (errors[name], name)) for q, errors in by.items() if errors}
    if not worst and not notes:
        notes = (f"the run shows nothing of what is asked: {', '.join(question.ask)}",)
    return Answer(
        fidelity=plan.fidelity, method=plan.method, tolerance=plan.tolerance,
        figures={name: e for name, e in (look.error | limits).items() if e < inf},
        errors={q: by[q][name] for q, name in worst.items()}, worst={q: name for q, name in worst.items()},
        left_out=look.rung.left_out, rungs=tuple(measuring.names), notes=notes,
    )  # fmt: skip


def _unconverged(look: _Look, question: Question, measuring: Measuring, ladder: Ladder) -> Answer:
    if look.why:
        return _unmeasured(ladder.plan, f"nothing is measured for what it asks, since it makes no run: {look.why}")
    name = max(look.error, key=lambda x: (look.error[x], x))
    told = f"not converged: asked to {percent(question.accuracy)}, what was run differs by {percent(look.error[name])}"
    return _answer(look, question, measuring, ladder, f"{told} in {name}")


def _unmeasured(plan: Plan, why: str) -> Answer:
    rung = Rung(plan)
    return Answer(
        fidelity=plan.fidelity, method=plan.method, tolerance=plan.tolerance, left_out=rung.left_out, notes=(why,)
    )


def _name(scene: LoadedScene, question: Question) -> str:
    """Of the file that remembers an answer: by the whole plan, what is asked and named, and the code."""
    said = repr((question, scene.facts.named)).encode()
    code = sources() + contents(ROOM / "nodes", ".py") + contents(ROOM / "coordinator" / "ladder", ".py")
    return f"{hashlib.sha256(code + said + encode(scene.plan)).hexdigest()}.answer"
