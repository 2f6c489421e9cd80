"""Errors of a candidate: the error of its steps by comparison with tighter steps, that of its level by comparison with
witnesses, which are levels that model what the candidate's level omits."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import inf

from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.models import system
from heavylift.nodes.plan.plan import Plan

from .measuring import WITNESSED, Errors, Measuring, added, largest, most, times
from .model_levels import Ladder, ModelLevel, undamped

ORDERS = (1.0, 0.75, 0.5)  # powers of the tolerance that errors of steps fall with
CLOSE = 1e-5  # tolerance of levels with waves in ropes where ropes go slack: two decades below the loosest

NO_FINER = "it is modelled as it is written, there is no finer level"


@dataclass(frozen=True)
class Look:
    """Measured errors of a run's figures at one model level: total, due to time steps, and due to the model level.

    `pairs`: the candidates that were compared; `why`: the reason if it could not run; `missing`: the reasons for errors
    that could not be measured.
    """

    candidate: ModelLevel
    error: Errors = field(default_factory=lambda: {"": inf})
    steps: Errors = field(default_factory=dict)
    model: Errors = field(default_factory=dict)
    pairs: tuple[tuple[ModelLevel, ModelLevel], ...] = ()
    why: str = ""
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def whole(self) -> bool:
        """Whether all errors were measured and are finite; the error of the finest level may be missing."""
        return max(self.error.values(), default=inf) < inf and {*self.missing.values()} <= {NO_FINER}


def looks(runs: Sequence[ModelLevel], measuring: Measuring) -> list[Look]:
    """Return the errors due to time steps and sampling at one model level, measured against the run with the tightest
    steps.

    `runs`: the candidates, loosest steps first.

    Errors of steps are assumed to fall as a power of the tolerance, whose exponent is observed on three candidates
    (Roache 1994; ASME V&V 20-2009, section 2) or, with only two, taken as 1/2. The error of the tightest candidate is
    extrapolated from its difference to the one before, or from the previous difference for a figure that hardly changed
    in the last.
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
        found.append(_look(candidate, steps, ((candidate, last),), measuring))
    if last in runs:
        found.append(_look(last, times(WITNESSED * left, now), ((others[-1], last),), measuring))
    return found


def _look(
    candidate: ModelLevel, steps: Errors, pairs: tuple[tuple[ModelLevel, ModelLevel], ...], measuring: Measuring
) -> Look:
    return Look(candidate, added(steps, measuring.misread(candidate)), steps, {}, pairs)


def with_level(look: Look, ladder: Ladder, measuring: Measuring) -> Look:
    """Return the errors of a run's figures after adding the measured error due to its model level."""
    if foresee(ladder, look.candidate, measuring, measuring.slack(look.candidate)):
        with suppress(HeavyliftError):  # computed meanwhile; errors are reported where they are used
            errors_of_limits(look, measuring)
    model = error_of_level(ladder, look.candidate, measuring)
    pairs = (*witnesses(ladder, look.candidate, measuring)[:1], *look.pairs)
    return replace(look, error=added(look.error, model), model=model, pairs=pairs)


def foresee(ladder: Ladder, candidate: ModelLevel, measuring: Measuring, slack: bool) -> bool:
    """Begin the run of the first witness of a candidate in a process beside; return whether it runs there."""
    levels, own = ladder.witnesses(candidate.plan.fidelity), ladder.in_own_steps(candidate)
    return bool(levels) and measuring.begin(_beside(own, slack).on(levels[0]))


def errors_of_limits(look: Look, measuring: Measuring) -> Errors:
    """Return the errors of the utilisations of all limits, estimated by comparing the runs made so far."""
    own = measuring.limits(look.candidate)
    known = [tuple(measuring.limits(x, values=True) for x in pair) for pair in look.pairs]
    apart = {name: [abs(a[name].value - b[name].value) for a, b in known if name in a and name in b] for name in own}
    # differences to what puts back one thing each add up
    return {
        name: (f.misread + WITNESSED * sum(apart[name])) / f.scale
        for name, f in own.items()
        if len(apart[name]) == len(known)
    }


def witnesses(ladder: Ladder, candidate: ModelLevel, measuring: Measuring) -> list[tuple[ModelLevel, ModelLevel]]:
    """Return pairs of model levels to run; the difference between the two runs of a pair shows the error due to a
    level.

    One is the candidate itself, the other its witness: the cheapest level that models every effect which the
    candidate's level omits. If hook ropes go slack or an element has no damping, all such levels are witnesses, since
    waves along ropes have any length. If any rope goes slack, witnesses run with a tolerance of at most `CLOSE`. The
    witness of the finest level is the next coarser one.
    """
    levels, own = ladder.witnesses(candidate.plan.fidelity), ladder.in_own_steps(candidate)
    beside = _beside(own, measuring.slack(own))
    # waves along ropes and undamped modes are seen by some levels only: compare with all that restore them
    if len(levels) > 1 and not undamped(system(candidate.plan)):
        levels = levels if any(measuring.slack(x, hooks=True) for x in (own, beside.on(levels[0]))) else levels[:1]
    return [(own, beside.on(level)) for level in levels or ([ladder.poorer] if ladder.poorer else [])]


def _beside(own: ModelLevel, slack: bool) -> ModelLevel:
    # what hangs on slack ropes swings as fast as their waves, which loose steps damp at both levels
    return own.within(CLOSE) if slack else own


def error_of_level(ladder: Ladder, candidate: ModelLevel, measuring: Measuring) -> Errors:
    """Return the error due to a model level, estimated by comparison with levels that include what it omits."""
    # the finest level has no better one: its error is smaller than the difference to the coarser one
    factor = WITNESSED if ladder.witnesses(candidate.plan.fidelity) else 1.0
    return times(factor, most(*(measuring.apart(*pair) for pair in witnesses(ladder, candidate, measuring))))


def tighter(candidate: ModelLevel) -> list[ModelLevel]:
    """Return the same model level with one set of tighter time steps, or with two if the scene has rigid ropes."""
    # impacts of rigid ropes can bifurcate: one tighter run may agree by chance
    once = candidate.tighter
    return [once, once.tighter] if system(candidate.plan).rigid_ropes else [once]


def as_it_is(plan: Plan, accuracy: float, measuring: Measuring) -> Look:
    """Measure the errors of a plan at its own model level and time steps; raises HeavyliftError if the plan cannot
    run."""
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
        missing["model"] = NO_FINER
    model = found("model", lambda: error_of_level(ladder, candidate, measuring))
    pairs += witnesses(ladder, candidate, measuring)[:1] if "model" not in missing else []
    look = _look(candidate, steps, tuple(pairs), measuring)
    return replace(look, error=added(look.error, model), model=model, missing=missing)
