"""Choose model level and steps of a scene: the cheapest candidate whose measured errors are within the accuracy.

Starts at the coarsest level with the loosest steps. The error of a level is its difference to a witness: a level that
models all effects which the first one omits; the error of the steps is the difference to steps with about a tenth of
the tolerance. Both differences are doubled and added, and the larger one decides which is refined. The finest level has
no witness; its error is the difference to the next coarser one. The choice depends on plan and question alone, never on
clock or machine; the cache only saves time.
"""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path

import msgspec
from heavylift.coordinator.record.in_memory import CUT, play
from heavylift.kernel.cache import contents, read_cached, remembered, sources
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import MEANT, Answer, Fidelity, Question, percent
from heavylift.nodes.plan.plan import Plan, encode, functions
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.loaded_scene import planned

from .beside import ALONE, Beside
from .looking import CLOSE, Look, as_it_is, errors_of_limits, foresee, looks, with_level
from .measuring import Measuring, largest
from .model_levels import DECADE, Ladder, ModelLevel, at_level

STUCK = 3  # decades of the tolerance that change nothing for the better, until it is given up: steps become four times
# as short, by which a method that has damped a swing away sees it
SEVERAL = 3  # tolerances, after which a level is compared although its steps are not fine enough
LOOSEST = 0.1  # tolerance of a step, as a part of the accuracy
HIDES = 0.25  # part of the errors of steps by which that of a level may be seen wrongly
ACCURACIES = (0.01, 0.003, 0.001, 0.0003)  # by which checks are decided
ROOM = Path(__file__).parents[2]  # of the product
Report = Callable[[str], None]


@contextmanager
def forestalled(beside: Beside) -> Iterator[None]:
    """While a scene is loaded, begin to compile for the model levels that its choice will begin with."""

    def begin(scene: LoadedScene) -> None:
        if scene.question and not scene.plan.models:
            with suppress(HeavyliftError):
                ladder = Ladder(scene.plan, scene.facts.named)
                first = ladder.candidates(ladder.plausible[0])[0]
                for level in (first.plan.fidelity, *ladder.witnesses(first.plan.fidelity)[:1]):
                    beside.compile(ladder.in_own_steps(first).on(level).plan)

    token = planned.set(begin)
    try:
        yield
    finally:
        planned.reset(token)


def chosen(
    scene: LoadedScene, say: Report = lambda message: None, beside: Beside = ALONE
) -> LoadedScene:  # fmt: skip
    """Return the scene with the model level and time steps that give its required accuracy; `say` reports the runs made
    to find them, some of them `beside`."""
    from heavylift.coordinator.verdict.worst_corners import with_worst_clearances

    scene = with_worst_clearances(scene)
    if (question := scene.question) is None:
        return scene
    # user models may depend on anything: they are not run again to measure
    if scene.plan.models:
        why = "a scene with models of its own is modelled as it is written, and nothing is measured for what it asks"
        return answered(scene, _unmeasured(scene.plan, why))

    def make() -> Answer:
        return choose(Ladder(scene.plan, scene.facts.named), question, Measuring(question.ask, say=say, beside=beside))

    # results of code outside the plan cannot be cached under the plan
    alone = scene.passing or bool(functions(scene.plan))  # whose code may change
    return answered(scene, make() if alone else remembered(_name(scene, question), Answer, make))


def decided(scene: LoadedScene, say: Report = lambda message: None, beside: Beside = ALONE) -> LoadedScene:
    """Return the scene at the loosest of the `ACCURACIES` that leaves no check undecided, or else at the tightest."""
    ask = scene.facts.ask or MEANT
    for accuracy in ACCURACIES:
        facts = msgspec.structs.replace(scene.facts, own=ask, written=accuracy, named=(*scene.facts.named, "ask"))
        found = chosen(replace(scene, facts=facts), say, beside)
        checks = play(found.plan, errors=found.errors).verdict.checks
        left = [check.sentence for check in checks if check.state == "undecided"]
        # each accuracy is tried in turn: most lifts are decided by the first
        say(f"to {percent(accuracy)}: {len(left)} checks undecided")
        if not left:
            break
    return found


def known(scene: LoadedScene) -> Answer | None:
    """Return the model level and time steps that were chosen for a scene earlier, from the cache; None if unknown."""
    if scene.question is None:
        return scene.answer
    try:
        return msgspec.msgpack.decode(read_cached(_name(scene, scene.question)), type=Answer)
    except msgspec.MsgspecError:
        return None


def answered(scene: LoadedScene, answer: Answer) -> LoadedScene:
    """Return a copy of the scene that uses the chosen model level, integration method, tolerance and sample rate."""
    plan = at_level(scene.plan, answer.fidelity)
    hz = plan.samples_hz if "samples" in scene.facts.named else answer.samples_hz or plan.samples_hz
    plan = msgspec.structs.replace(plan, method=answer.method, tolerance=answer.tolerance, samples_hz=hz)
    return replace(scene, plan=plan, chosen=True, answer=answer)


def measured(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Return the scene with the measured errors of the requested quantities at its own model level and time steps."""
    if not (ask := scene.facts.ask) or scene.plan.models:
        return scene
    measuring = Measuring(ask, say=say)
    try:
        look = as_it_is(scene.plan, scene.facts.accuracy, measuring)
    except HeavyliftError:  # with which its run will end, too
        return scene
    return replace(scene, answer=_answer(look, Question(ask, scene.facts.accuracy), measuring))


def level_of(scene: LoadedScene, say: Report = lambda message: None) -> LoadedScene:
    """Return the scene with its chosen model level and time steps written as explicit settings."""
    if scene.question is None:
        return scene
    found = chosen(scene, say)
    return replace(found, settings=(*scene.settings, *ModelLevel(found.plan).settings))


def choose(ladder: Ladder, question: Question, measuring: Measuring) -> Answer:
    """Choose the cheapest model level and time steps that compute the requested quantities to the requested accuracy.

    Raises HeavyliftError only if a run exceeds its time limit.
    """
    last: Look | None = None
    tolerance = LOOSEST * question.accuracy  # looser steps cannot be within the accuracy
    for number, level in enumerate(levels := ladder.plausible):
        for other in ladder.witnesses(level)[:1]:
            measuring.prepare(ladder.in_own_steps(ladder.candidates(level)[0]).on(other))
        look = _climbed(ladder, level, tolerance, question.accuracy, measuring, number + 1 < len(levels))
        last = look if last is None or not look.why or last.why else last
        if largest(look.error) <= question.accuracy:
            return _answer(look, question, measuring)
        if not look.why:
            if largest(look.model) <= largest(look.steps):  # a finer level would inherit the error of the steps
                break
            tolerance = look.candidate.plan.tolerance  # at which the next level was run as witness
    assert last is not None
    return _unconverged(last, question, measuring, ladder)


def _climbed(
    ladder: Ladder, level: Fidelity, tolerance: float, accuracy: float, measuring: Measuring, richer: bool
) -> Look:
    """Return the candidate of a level with the loosest steps whose total error is within the accuracy. First the steps
    are refined until their own error is small enough; then the level is compared once with its witnesses at these
    steps. If no candidate suffices, return one whose level error exceeds what its steps explain, or the one with the
    tightest steps that was run."""
    candidates = ladder.candidates(level)
    tolerances = [candidate.plan.tolerance for candidate in candidates]
    at = next((i for i, x in enumerate(tolerances) if x <= tolerance * (1.0 + 1e-9)), len(candidates) - 1)
    # a looser run shows the errors of steps at less cost than a tighter one
    run = [at - DECADE, at] if at >= DECADE and tolerance < LOOSEST * accuracy else [at]
    before, stuck, patience, most = inf, 0, STUCK, accuracy
    close = max(CLOSE * (1.0 + 1e-9), tolerances[-1])
    while True:
        try:
            if tolerances[run[0]] > close and ladder.waves(level) and measuring.slack(candidates[run[-1]]):
                run, patience = [max(run[-1], next(i for i, x in enumerate(tolerances) if x <= close))], 1
            if not all(measuring.read_well(candidates[i], accuracy) for i in run):
                continue  # with denser samples
            if len(run) == 1 and run[0] + 1 < len(candidates):
                run.append(_next(tolerances, run[0], 0.1))
                if slack := measuring.slack(candidates[run[0]]):  # at a tolerance that is known
                    foresee(ladder, candidates[run[-1]], measuring, slack)
                continue
            results = looks([candidates[i] for i in run], measuring)
            best = results[-1]
            # an improvement of less than half per decade counts as stuck
            steps = largest(best.steps)
            enough = (x for x in results if largest(x.error) <= accuracy and largest(x.steps) <= most)
            kept = next(enough, None)
            misread = largest(measuring.misread(best.candidate))  # which other steps do not change
            if last := run[-1] + 1 >= len(candidates) or stuck >= patience or steps == 0.0 or misread > accuracy:
                kept = kept or best
            if kept:
                kept = with_level(kept, ladder, measuring)
                if largest(kept.error) <= accuracy or last:
                    return kept
                # the difference between levels may be an error of steps that differ between them
                own, wrong = largest(kept.steps), largest(kept.model)
                if own <= HIDES * max(wrong, accuracy) and (richer or largest(kept.error) - own > accuracy):
                    return kept
                most = min(0.5 * most, max(0.5 * (accuracy - wrong), (HIDES if richer else 0.1) * accuracy))
                continue
            # before more runs are spent on their steps: levels may be further apart than any steps explain
            if len(run) == SEVERAL and richer:
                whole = with_level(results[0], ladder, measuring)
                where = max(whole.model, key=lambda x: (whole.model[x], x), default="")
                wrong = whole.model.get(where, 0.0)
                if wrong > accuracy and whole.steps[where] <= wrong:
                    return replace(whole, steps={})
        except HeavyliftError as error:
            if CUT in str(error):
                raise
            # a failed run may be one whose steps were too loose from the start
            if run == [at] and not measuring.spent and at + 2 < len(candidates):
                run = [at + 2]
                continue
            return Look(candidates[run[-1]], why=str(error).splitlines()[0])
        before, stuck = steps, stuck + 1 if steps >= 0.5 * before else 0
        # two runs assume the lowest order: a third one mostly shows that the errors are smaller
        run.append(_next(tolerances, run[-1], (2.0 if len(run) == 2 else 0.5) * most / steps))
        foresee(ladder, candidates[run[-1]], measuring, measuring.slack(candidates[run[0]]))  # mostly the last


def _next(tolerances: Sequence[float], at: int, part: float) -> int:
    """Return the index of the loosest steps whose tolerance is at most `part` (no less than 0.1) of the tolerance
    `at`."""
    wanted = max(part, 0.1) * tolerances[at] * (1.0 + 1e-9)
    return next((i for i, x in enumerate(tolerances) if i > at and x <= wanted), len(tolerances) - 1)


def _answer(look: Look, question: Question, measuring: Measuring, *notes: str) -> Answer:
    limits = errors_of_limits(look, measuring)
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
