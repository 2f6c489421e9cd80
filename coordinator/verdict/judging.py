"""All checks of a run in one table, and the summary line of the verdict."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import msgspec
import numpy as np
from heavylift.kernel.description.findings import Check, finding, findings
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import UNREADABLE
from heavylift.nodes.limits.checks import Errors, checks_of, line_of, state_of, table_of, uncoloured
from heavylift.nodes.limits.geometry import geometry_findings
from heavylift.nodes.limits.judging import uses_of
from heavylift.nodes.limits.run_tables import HookReach, RunTables
from heavylift.nodes.limits.sharing import dynamics_required, hoisting_factors, shared
from heavylift.nodes.limits.signals import SignalColumns
from heavylift.nodes.plan.limit import Reach, Use
from heavylift.nodes.plan.plan import Plan, decode
from heavylift.nodes.plan.shapes import Shapes
from heavylift.nodes.scene.factor_sheet import charts_used, hooks, rigging
from heavylift.nodes.statics import Followed
from heavylift.nodes.statics.findings import missed_turns
from heavylift.recordings import Recording
from heavylift.recordings.format.viewer_messages import RopeLine
from heavylift.recordings.read.verdict import Clearance, RecordedVerdict, recorded_verdict
from heavylift.recordings.sheets.sheet import Table

from .clearances import SMALLEST, clearances, findings as too_near, lift_of, limit_between
from .conduct import Conduct, conduct_findings, conduct_of, landing, touching, turned, turning
from .history import History, RunHistory, blocks, history_of, rests
from .limits import dropped, impacts, rehits, signals_of_run, touches, unknown_forces
from .rigid_contacts import touches_of

NO_ERRORS: Errors = {}  # nobody has measured any
EVERY = "all"  # things of a scene
FURTHER = 8  # times as many clearances are looked at, where a limit has none among the smallest
RESOLVED = "resolved.json"  # the plan in a recording


@dataclass
class CheckContext:
    """Plan and results of a run for its checks, with the findings so far, including what could not be checked."""

    plan: Plan
    history: RunHistory
    conduct: Conduct
    findings: list[Check] = field(default_factory=list)
    clearances: list[Clearance] = field(default_factory=list)
    near: list[Clearance] = field(default_factory=list)  # those, and what was looked at besides
    smallest: int = SMALLEST
    mechanics: System | None = None
    uses: Sequence[Use] = ()
    reach: tuple[Reach, ...] = ()
    whole: bool = False  # with all tables of a report
    tables: Sequence[Table] = ()


def _geometry(context: CheckContext) -> None:
    """Check that the block's geometry is possible."""
    context.findings += geometry_findings(context.plan)


def _limits(context: CheckContext) -> None:
    """Check the table of limits, on tensions, poses and lengths."""
    plan, shown, text = context.plan, context.history, context.conduct
    if not len(shown.t):
        return
    stages = [(t, name) for t, _, name in text.stages if name]
    rigid = [*touches_of(plan, shown, text.touched)]
    hit = {x.block for x in rigid if x.speed is not None}
    context.findings += [
        *unknown_forces(plan, shown, rigid),
        *rehits(plan, shown, landing(plan, text)),
        *dropped(plan, shown, turning(plan, text)),
    ]
    peaks = text.peaks | impacts(plan, shown, rigid) | touches(plan, shown, rigid)
    reached, tables = HookReach(plan), RunTables(plan, stages, text.end)

    def columns(part: History) -> SignalColumns:
        return signals_of_run(
            plan, part.t, part.tensions, part.poses, part.rigs,
            stages=stages, peaks=peaks, crossings=text.overloads, lengths=part.lengths,
        )  # fmt: skip

    def at(t: float) -> tuple[SignalColumns, Sequence[RopeLine]]:
        k = min(int(np.searchsorted(times, t)), len(times) - 1)
        part = shown.part(k, k + 1)
        return columns(part), next((x.lines for x in reversed(part.rigs) if x.t_ns * 1e-9 <= t), ())

    times, signals = shown.t, map(reached.see, map(columns, blocks(shown)))
    uses = uses_of(plan, map(tables.see, signals) if context.whole else signals)
    context.uses = [
        x for x in uses if x.value is not None or x.limit.quantity != "impact" or x.limit.subject not in hit
    ]
    context.reach = reached.found
    for number, end in turned(plan, text):
        poses = {body: (p[0], R[0]) for body, (p, R) in at(end)[0].poses.items()}
        context.findings += missed_turns(plan, number, poses, end)
    context.tables = [*tables.tables(context.uses, text.peaks, at)] if context.whole else []


def _clearances(context: CheckContext) -> None:
    """Check clearances."""
    lands = landing(context.plan, context.conduct)
    meant = touching(context.plan, context.conduct)
    limits, n = [x for x in context.plan.limits if x.quantity == "clearance" and not x.inputs], context.smallest
    while True:  # until each limit has its smallest clearance, which may be larger than those of others
        context.near = clearances(context.plan, context.history, lands, n, context.mechanics, meant)
        if len(context.near) < n or len(_smallest(context)) == len({x.subject for x in limits}):
            break
        n *= FURTHER
    found = too_near(context.near, context.plan)
    red = {x.subject for x in found}
    context.clearances += [c for i, c in enumerate(context.near) if i < context.smallest or f"{c.a} and {c.b}" in red]
    context.findings += found


def near_at_rest(plan: Plan, statics: Followed) -> tuple[Check | Use, ...]:
    """Return findings for too small clearances on the equilibrium path; if there are none, the smallest clearance for
    each limit."""
    each = [*at_rest(plan, statics)]
    if found := findings(_placed(x, one.conduct) for one in each for x in one.findings):
        return found
    least: dict[str, Use] = {}
    for subject, use in (x for one in each for x in _smallest(one).items()):
        known = least.get(subject, use)
        least[subject] = min(known, use, key=lambda x: x.value or 0.0)
    return tuple({x.limit.subject: x for x in least.values()}.values())


def at_rest(plan: Plan, statics: Followed, smallest: int = SMALLEST) -> Iterator[CheckContext]:
    """Yield the smallest distances between parts in each action list, along its equilibrium path."""
    for past, points in rests(plan, statics.states) if statics.states else ():
        begun = {x.action: x.t for x in reversed(points) if x.action}
        stages = [(t, n - 1, plan.actions[n - 1].stage) for n, t in sorted(begun.items())]
        context = CheckContext(plan, past, Conduct(stages=stages, end=points[-1].t), smallest=smallest)
        _clearances(context)
        yield context


def _bending(context: CheckContext) -> None:
    """Check deflections of flexible blocks at their sampled places."""
    most: dict[str, tuple[float, str, float]] = {}
    for part in blocks(context.history):
        for along in (name for name in part.bent if name.endswith(".x") and len(part.t)):
            place = along.removesuffix(".x")
            size = np.sqrt(sum(part.bent[f"{place}.{axis}"] ** 2 for axis in "xyz"))
            (body, _, word), i = place.partition("."), int(np.argmax(size))
            most[body] = max(most.get(body, (-1.0, "", 0.0)), (float(size[i]), word, float(part.t[i])))
    for body, (largest, place, t) in most.items():
        message = f"{body} bends most at {place}, by {1e3 * largest:.3g} mm"
        context.findings.append(finding("none", "bending", body, message, t=t))


def _conduct(context: CheckContext) -> None:
    """Check the course of the run against the action list."""
    tripped = {name for _, name, _ in context.conduct.tripped}
    context.uses = [x for x in context.uses if x.limit.quantity != "interlock" or x.limit.subject not in tripped]
    context.findings += conduct_findings(context.plan, context.conduct)


def _edges(context: CheckContext) -> None:
    """Find the largest edge force of each rope, and where it occurs."""
    most: dict[str, tuple[float, float, float]] = {}
    for part in blocks(context.history):
        for name, force in part.borne.items():
            k = int(force.argmax()) if len(force) else 0
            if len(force) and force[k] > most.get(name, (0.0,))[0]:
                most[name] = float(force[k]), float(part.places[name][k]), float(part.t[k])
    for name, (force_N, place, t) in most.items():
        rope, _, edge = name.rpartition(".")
        message = f"the edge {edge} bears {force_N / 1e3:.1f} kN of {rope}, {place:.2f} m along it"
        context.findings.append(finding("none", "edge", name, message, t=t, value=force_N, unit="N"))


CheckFunction = Callable[[CheckContext], None]
JUDGES: tuple[CheckFunction, ...] = (_geometry, _limits, _clearances, _bending, _conduct, _edges)


def verdict_of_run(plan: Plan, history: RunHistory, conduct: Conduct, errors: Errors = NO_ERRORS) -> RecordedVerdict:
    """Return the verdict of a run; `errors`: relative errors of its figures, if known."""
    return verdict_with_uses(plan, history, conduct, errors, whole=True)[0]


def verdict_with_uses(
    plan: Plan,
    history: RunHistory,
    conduct: Conduct,
    errors: Errors = NO_ERRORS,
    smallest: int = SMALLEST,
    mechanics: System | None = None,
    whole: bool = False,
) -> tuple[RecordedVerdict, Sequence[Use]]:
    """Return the verdict of a run, and the highest utilisation of each limit during the run.

    `smallest`: number of clearances to report even if none is below its limit; `mechanics`: those of the plan, if
    known; `whole`: include all tables of a report.
    """
    context = CheckContext(plan, history, conduct, smallest=smallest, mechanics=mechanics, whole=whole)
    for one in JUDGES:
        one(context)
    shapes = Shapes(plan)
    others = [*(_placed(x, conduct) for x in context.findings), *uncoloured(plan, shapes)]
    tables = hooks(plan), charts_used(context.reach), *rigging(plan, context.uses), *context.tables
    checks = checks_of(plan, [*context.uses, *_apart(context)], others, errors, shapes.shapeless)
    verdict = RecordedVerdict(
        red=state_of(checks) == "red",
        state=state_of(checks),
        line=line_of(checks),
        dynamic=dynamics_required(plan),
        tables=(table_of(checks, *hoisting_factors(plan), *shared(plan)), *(x for x in tables if x.rows)),
        clearances=tuple(context.clearances),
        checks=tuple(checks),
    )
    return verdict, context.uses


def _apart(context: CheckContext) -> list[Use]:
    """Return the clearances at the worst corner of uncertain inputs and, if no clearance is below its limit, the
    smallest clearance of each limit."""
    known = {f"{c.a} and {c.b}": c for c in reversed(context.near)}
    worst = [x for x in context.plan.limits if x.quantity == "clearance" and x.inputs]
    found = [x.met(c.distance, c.t) if (c := known.get(x.subject)) else x.met() for x in worst]
    if any(x.quantity == "clearance" for x in context.findings):
        return found
    return [*{x.limit.subject: x for x in (*_smallest(context).values(), *found)}.values()]


def _smallest(context: CheckContext) -> dict[str, Use]:
    """Return, for each clearance limit by its subject, the smallest clearance to which the limit applies."""
    plan, keep, found = context.plan, limit_between(context.plan), dict[str, Use]()
    for limit in (x for x in plan.limits if x.quantity == "clearance" and not x.inputs):
        lifts = {c: (EVERY, lift_of(plan, c.a), lift_of(plan, c.b)) for c in context.near}
        apart = [c for c, of in lifts.items() if limit.subject in of and c.limit == keep(c.a, c.b)]
        if apart:
            c = min(apart, key=lambda c: c.distance)
            pair = msgspec.structs.replace(limit, subject=f"{c.a} and {c.b}", value=c.limit)
            found[limit.subject] = replace(pair.met(c.distance, c.t), stage=context.conduct.stage_at(c.t))
    return found


def verdict_of(rec: Recording) -> RecordedVerdict | None:
    """Return the recorded verdict, or one computed from the recording if it has none; None if the plan is of another
    version."""
    found = recorded_verdict(rec)
    if found is not None or RESOLVED not in rec.attachments:
        return found
    try:
        plan = decode(rec.attachments[RESOLVED])
    except UNREADABLE:
        return None
    with rec.reading():
        errors = msgspec.convert(rec.fact("errors", {}), dict[str, float])
        return verdict_of_run(plan, history_of(rec), conduct_of(rec), errors)


def _placed(f: Check, conduct: Conduct) -> Check:
    """Return the finding with the stage in which its time lies, unless it names a stage."""
    if f.stage or f.t is None:
        return f
    return msgspec.structs.replace(f, stage=conduct.stage_at(f.t))
