"""Choose model level and steps of a scene: the cheapest candidate whose measured errors are within the accuracy.

Starts at the coarsest level with the loosest steps. The error of a level is its difference to a witness, a level that
puts back all that it leaves out; the error of the steps is the difference to steps with about a tenth of the tolerance.
Both differences are doubled and added, and the larger one decides which is refined. The finest level has no witness;
its error is the difference to the next coarser one. The choice depends on plan and question alone, never on clock or
machine; the cache only saves time.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import inf
from pathlib import Path

import msgspec
from heavylift.kernel.cache import contents, read_cached, remembered, sources
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.models import system
from heavylift.nodes.plan.fidelity import MEANT, Answer, Question, percent
from heavylift.nodes.plan.plan import Plan, encode, functions
from heavylift.nodes.scene import LoadedScene

from .in_memory import CUT, play
from .measuring import WITNESSED, Errors, Measuring, added, largest, most, times
from .model_levels import Ladder, ModelLevel, at_level, undamped

STUCK = 3  # decades of the tolerance that change nothing for the better, until it is given up: steps become four times
# as short, by which a method that has damped a swing away sees it
LOOSEST = 0.1  # tolerance of a step, as a part of the accuracy
HIDES = 0.25  # part of the errors of steps by which that of a level may be seen wrongly
ORDERS = (1.0, 0.75, 0.5)  # powers of the tolerance that errors of steps fall with
ACCURACIES = (0.01, 0.003, 0.001, 0.0003)  # by which checks are decided
ROOM = Path(__file__).parents[2]  # of the product
Report = Callable[[str], None]


def chosen(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Return the scene with the model level and steps that its accuracy requires; `say` reports the runs made to find
    them."""
    from heavylift.coordinator.verdict.worst_corners import with_worst_clearances

    scene = with_worst_clearances(scene)
    if (question := scene.question) is None:
        return scene
    # user models may depend on anything: they are not run again to measure
    if scene.plan.models:
        why = "a scene with models of its own is modelled as it is written, and nothing is measured for what it asks"
        return answered(scene, _unmeasured(scene.plan, why))

    def make() -> Answer:
        return choose(Ladder(scene.plan, scene.facts.named), question, Measuring(question.ask, say=say))

    # results of code outside the plan cannot be cached under the plan
    alone = scene.passing or bool(functions(scene.plan))  # whose code may change
    return answered(scene, make() if alone else remembered(_name(scene, question), Answer, make))


def decided(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Return the scene at the loosest accuracy of `ACCURACIES` that leaves no check undecided, otherwise at the finest
    one."""
    ask = scene.facts.ask or MEANT
    for accuracy in ACCURACIES:
        facts = msgspec.structs.replace(scene.facts, own=ask, written=accuracy, named=(*scene.facts.named, "ask"))
        found = chosen(replace(scene, facts=facts), say)
        checks = play(found.plan, errors=found.errors).verdict.checks
        left = [check.sentence for check in checks if check.state == "undecided"]
        # each accuracy is tried in turn: most lifts are decided by the first
        say(f"to {percent(accuracy)}: {len(left)} checks undecided")
        if not left:
            break
    return found


def known(scene: LoadedScene) -> Answer | None:
    """Return the cached choice of level and steps for a scene, or None."""
    if scene.question is None:
        return scene.answer
    try:
        return msgspec.msgpack.decode(read_cached(_name(scene, scene.question)), type=Answer)
    except msgspec.MsgspecError:
        return None


def answered(scene: LoadedScene, answer: Answer) -> LoadedScene:
    """Return the scene with the model level and steps that an `Answer` holds."""
    plan = at_level(scene.plan, answer.fidelity)
    hz = plan.samples_hz if "samples" in scene.facts.named else answer.samples_hz or plan.samples_hz
    plan = msgspec.structs.replace(plan, method=answer.method, tolerance=answer.tolerance, samples_hz=hz)
    return replace(scene, plan=plan, chosen=True, answer=answer)


def measured(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Measure the errors of the requested quantities at the scene's own level and steps; return the scene with these
    errors."""
    if not (ask := scene.facts.ask) or scene.plan.models:
        return scene
    measuring = Measuring(ask, say=say)
    try:
        look = as_it_is(scene.plan, scene.facts.accuracy, measuring)
    except HeavyliftError:  # with which its run will end, too
        return scene
    return replace(scene, answer=_answer(look, Question(ask, scene.facts.accuracy), measuring))


def level_of(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Return the scene with its chosen level and steps as explicit settings, which many variants can share."""
    if scene.question is None:
        return scene
    found = chosen(scene, say)
    return replace(found, settings=(*scene.settings, *ModelLevel(found.plan).settings))


@dataclass(frozen=True)
class Look:
    """Measured errors of one candidate: in total, due to its steps, and due to its level; the reason if it could not
    run; the errors that could not be measured, with the reasons."""

    candidate: ModelLevel
    error: Errors = field(default_factory=lambda: {"": inf})
    steps: Errors = field(default_factory=dict)
    model: Errors = field(default_factory=dict)
    pairs: tuple[tuple[ModelLevel, ModelLevel], ...] = ()
    why: str = ""
    missing: dict[str, str] = field(default_factory=dict)


def choose(ladder: Ladder, question: Question, measuring: Measuring) -> Answer:
    """Choose the model level and steps that answer a question; raises HeavyliftError only if a run exceeds its time
    limit."""
    last: Look | None = None
    for number, level in enumerate(ladder.levels):
        richer = number + 1 < len(ladder.levels)
        look = _climbed(ladder, ladder.candidates(level), question.accuracy, measuring, richer)
        last = look if last is None or not look.why or last.why else last
        if largest(look.error) <= question.accuracy:
            return _answer(look, question, measuring)
        # a finer level would inherit the error of the steps
        if not look.why and largest(look.model) <= largest(look.steps):
            break  # a finer level has the same trouble with its steps
    assert last is not None
    return _unconverged(last, question, measuring, ladder)


def _climbed(
    ladder: Ladder, candidates: Sequence[ModelLevel], accuracy: float, measuring: Measuring, richer: bool
) -> Look:
    """Return, for a level, the candidate with the loosest steps whose errors are within the accuracy. If there is none,
    return the one with the tightest steps that were run: then the error of the level is larger, or tighter steps give
    no improvement."""
    tolerances = [candidate.plan.tolerance for candidate in candidates]
    # looser steps than LOOSEST times the accuracy cannot be within it
    at = next((i for i, x in enumerate(tolerances) if x <= LOOSEST * accuracy * (1.0 + 1e-9)), len(candidates) - 1)
    run, checked, before, stuck = [at], at, inf, 0
    while True:
        try:
            if not all(measuring.read_well(candidates[i], accuracy) for i in run):
                continue  # with denser samples
            pair = tuple(witnesses(ladder, candidates[checked], measuring)[:1])
            model = error_of_level(ladder, candidates[checked], measuring)
            # the level alone is wrong by more than steps of this size can explain: go on to the next level
            if richer and largest(model) > accuracy / LOOSEST:  # by more than such steps can be
                return Look(candidates[at], model, {}, model, pair)
            if len(run) == 1 and run[0] + 1 < len(candidates):
                run.append(_next(tolerances, run[0], 0.1))
                continue
            results = _candidates([candidates[i] for i in run], model, pair, measuring)
        except HeavyliftError as error:
            if CUT in str(error):
                raise
            # a failed run may be one whose steps were too loose from the start
            if run == [at] and not measuring.spent and at + 2 < len(candidates):  # steps may be too loose to begin with
                run, checked = [at + 2], at + 2
                continue
            return Look(candidates[run[-1]], why=str(error).splitlines()[0])
        if kept := next((look for look in results if largest(look.error) <= accuracy), None):
            # errors of the level were measured at looser steps than those of the candidate: part of them may be hidden
            hidden = times(HIDES, results[run.index(checked)].steps)
            seen = candidates.index(kept.candidate) <= checked or largest(added(kept.error, hidden)) <= accuracy
            if seen and (checked == run[-1] or not measuring.slack(candidates[checked])):
                return kept
            checked = run[run.index(checked) + 1]  # looser steps may hide what its level is wrong by, above all where
            # ropes go slack and taut: what decides when is damped first
            continue
        best = results[-1]
        steps, wrong = largest(best.steps), largest(best.model)
        if wrong > steps:
            # the difference between levels may be an error of steps that differ between them
            if checked != run[-1] and largest(results[run.index(checked)].steps) > HIDES * wrong:
                checked = run[run.index(checked) + 1]  # its steps may be all that is seen of its level
                continue
            if richer or wrong > accuracy:
                return best
        # an improvement of less than half per decade counts as stuck
        before, stuck = steps, stuck + 1 if steps >= 0.5 * before else 0
        if run[-1] + 1 >= len(candidates) or stuck >= STUCK or steps == 0.0:
            return best
        # aim at half of what the level has left of the accuracy
        run.append(_next(tolerances, run[-1], 0.5 * max(accuracy - wrong, 0.1 * accuracy) / steps))


def _next(tolerances: Sequence[float], at: int, part: float) -> int:
    """Return the index of the loosest steps whose tolerance is smaller by the factor `part` (at least 0.1)."""
    wanted = max(part, 0.1) * tolerances[at] * (1.0 + 1e-9)
    return next((i for i, x in enumerate(tolerances) if i > at and x <= wanted), len(tolerances) - 1)


def _candidates(
    runs: Sequence[ModelLevel], model: Errors, pair: tuple[tuple[ModelLevel, ModelLevel], ...], measuring: Measuring
) -> list[Look]:
    """Return the candidates of one level, loosest steps first, with errors measured against the tightest of them.

    Errors of steps are assumed to fall as a power of the tolerance, observed on three candidates (Roache 1994, and ASME
    V&V 20-2009, section 2), or as its root if there are only two. The error of the tightest one is extrapolated from
    the last difference; for a figure that hardly changed in it, from the difference before.
    """
    found, (*others, last) = list[Look](), runs
    if not others:
        others, last = [last], last.tighter
    # two runs give one difference; a third one gives its rate of convergence
    now, ratio = measuring.apart(others[-1], last), others[-1].plan.tolerance / last.plan.tolerance
    order = ORDERS[-1]
    if len(others) > 1:
        before, wider = measuring.apart(*others[-2:]), others[-2].plan.tolerance / others[-1].plan.tolerance
        rate = largest(before) / largest(now) if 0.0 < largest(now) < inf else inf
        # the highest order that the observed rate supports (Roache's grid convergence)
        order = next((p for p in ORDERS if rate >= (wider**p - 1.0) / (1.0 - ratio**-p)), 0.0)
        now = {name: max(e, before.get(name, 0.0) / rate) for name, e in now.items()}
    # remaining error of the tightest run by Richardson extrapolation with that order
    left = 1.0 / (ratio**order - 1.0) if order and ratio > 1.0 else 1.0
    for candidate in others:
        # at least doubled: a difference between two runs is no bound by itself
        steps = times(max(WITNESSED, 1.0 + left), measuring.apart(candidate, last))
        found.append(_look(candidate, steps, model, (*pair, (candidate, last)), measuring))
    if last in runs:
        found.append(_look(last, times(WITNESSED * left, now), model, (*pair, (others[-1], last)), measuring))
    return found


def _look(
    candidate: ModelLevel,
    steps: Errors,
    model: Errors,
    pairs: tuple[tuple[ModelLevel, ModelLevel], ...],
    measuring: Measuring,
) -> Look:
    return Look(candidate, added(steps, measuring.misread(candidate), model), steps, model, pairs)


def _of_limits(look: Look, measuring: Measuring) -> Errors:
    """Return the errors of the utilisations of limits, from the runs made so far; they do not influence the choice of a
    candidate."""
    own = measuring.limits(look.candidate)
    known = [tuple(measuring.limits(x, values=True) for x in pair) for pair in look.pairs]
    return {
        name: (f.misread + WITNESSED * sum(abs(a[name].value - b[name].value) for a, b in known)) / f.scale
        for name, f in own.items()
        if all(name in a and name in b for a, b in known)
    }


def witnesses(ladder: Ladder, candidate: ModelLevel, measuring: Measuring) -> list[tuple[ModelLevel, ModelLevel]]:
    """Return the pairs of candidates whose difference shows the error of a candidate's level: the candidate itself and
    one at the cheapest level that models everything it leaves out. If hook ropes go slack or an element has no damping,
    all such levels are used, since waves along ropes have any length; for the finest level, the next coarser one."""
    levels, own = ladder.witnesses(candidate.plan.fidelity), ladder.in_own_steps(candidate)
    # waves along ropes and undamped modes are seen by some levels only: compare with all that restore them
    if len(levels) > 1 and not undamped(system(candidate.plan)):
        levels = levels if any(measuring.slack(x, hooks=True) for x in (own, own.on(levels[0]))) else levels[:1]
    return [(own, own.on(level)) for level in levels or ([ladder.poorer] if ladder.poorer else [])]


def error_of_level(ladder: Ladder, candidate: ModelLevel, measuring: Measuring) -> Errors:
    """Return twice the largest difference between a candidate and its witnesses, or for the finest level the simple
    difference, since that level is better than the coarser one with which it is compared."""
    # the finest level has no better one: its error is smaller than the difference to the coarser one
    factor = WITNESSED if ladder.witnesses(candidate.plan.fidelity) else 1.0
    return times(factor, most(*(measuring.apart(*pair) for pair in witnesses(ladder, candidate, measuring))))


def tighter(candidate: ModelLevel) -> list[ModelLevel]:
    """Return the candidate with tighter steps; with rigid ropes, whose impacts can bifurcate, two increasingly tight
    ones."""
    # impacts of rigid ropes can bifurcate: one tighter run may agree by chance
    once = candidate.tighter
    return [once, once.tighter] if system(candidate.plan).rigid_ropes else [once]


def as_it_is(plan: Plan, accuracy: float, measuring: Measuring) -> Look:
    """Measure the errors of a plan at its own level and steps: for the steps twice the difference to tighter ones, for
    the level the difference to its witnesses. Raises HeavyliftError if the plan cannot run."""
    ladder, candidate = Ladder(plan), ModelLevel(plan)
    while not measuring.read_well(candidate, accuracy):
        pass
    missing = dict[str, str]()

    def found(part: str, measure: Callable[[], Errors]) -> Errors:
        try:
            errors = measure()
        except HeavyliftError as error:
            missing[part] = f"a run beside it does not come to its end: {' '.join(str(error).split())}"
            return {}
        if lost := [name for name, e in errors.items() if e == inf]:
            missing[part] = f"the run beside it shows no {', '.join(lost[:3])}"
        return errors

    pairs = [(candidate, x) for x in tighter(candidate)]
    steps = found("numerical", lambda: times(WITNESSED, most(*(measuring.apart(*pair) for pair in pairs))))
    if ladder.poorer is None:
        missing["model"] = "it is modelled as it is written, there is no finer level"
    model = found("model", lambda: error_of_level(ladder, candidate, measuring))
    pairs += witnesses(ladder, candidate, measuring)[:1] if "model" not in missing else []
    return replace(_look(candidate, steps, model, tuple(pairs), measuring), missing=missing)


def _answer(look: Look, question: Question, measuring: Measuring, *notes: str) -> Answer:
    limits = _of_limits(look, measuring)
    plan, quantity = look.candidate.plan, {f.name: f.quantity for f in measuring.seen.values()}
    by = {q: {name: e for name, e in look.error.items() if quantity.get(name) == q} for q in question.ask}
    worst = {q: max(errors, key=lambda name: (errors[name], name)) for q, errors in by.items() if errors}
    if not worst and not notes:
        notes = (f"the run shows nothing of what is asked: {', '.join(question.ask)}",)
    return Answer(
        fidelity=plan.fidelity, method=plan.method, tolerance=plan.tolerance,
        samples_hz=measuring.factor * plan.samples_hz,
        figures={name: e for name, e in (look.error | limits).items() if e < inf},
        errors={q: by[q][name] for q, name in worst.items()}, worst={q: name for q, name in worst.items()},
        left_out=look.candidate.left_out, notes=notes,
    )  # fmt: skip


def _unconverged(look: Look, question: Question, measuring: Measuring, ladder: Ladder) -> Answer:
    if look.why:
        return _unmeasured(ladder.plan, f"nothing is measured for what it asks, since it makes no run: {look.why}")
    name = max(look.error, key=lambda x: (look.error[x], x))
    message = (
        f"not converged: asked to {percent(question.accuracy)}, what was run differs by {percent(look.error[name])}"
    )
    return _answer(look, question, measuring, f"{message} in {name}")


def _unmeasured(plan: Plan, why: str) -> Answer:
    candidate = ModelLevel(plan)
    return Answer(
        fidelity=plan.fidelity, method=plan.method, tolerance=plan.tolerance, left_out=candidate.left_out, notes=(why,)
    )


def _name(scene: LoadedScene, question: Question) -> str:
    """Return the file name under which an answer is cached: a hash of plan, question and code."""
    text = repr((question, scene.facts.named)).encode()
    return f"{hashlib.sha256(_code() + text + encode(scene.plan)).hexdigest()}.answer"


@cache
def _code() -> bytes:
    return sources() + contents(ROOM / "nodes", ".py") + contents(ROOM / "coordinator" / "ladder", ".py")
