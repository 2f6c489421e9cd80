"""Evaluation of the signals of a limit over columns of samples, and their reduction.

A signal is one row of the kernel's table of quantities; its formula is also used for conditions and interlocks. A
reading holds the reduced quantity at each instant and, where it is known, the exact maximum between samples with its
time: that of a tension that the run recorded, and that of a wind's history. Unloaded ropes are not evaluated: an angle
counts only while its rope carries a load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Point, System, merge
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.model.group_loads import ON_BASES, base_force, carried_group
from heavylift.kernel.model.quantities import LINED, FormulaContext, lines, names, numbers, points, scalar
from heavylift.nodes.plan.limit import ORDERED, ROUNDING, SIMULATED, STANDING, RatedLimit
from heavylift.nodes.plan.plan import Plan

from .factors import BASES, product
from .named import KINDS, LOADS, OF_TENSIONS, REDUCTIONS, MeasuredSignal, hooks_of, measured, origin, sling_signals
from .sharing import touching
from .signals import EMPTY, Column, SignalColumns, carries, place, tie_of, wind, wind_speed
from .splash import slack_sling, splash_load

RESTS = 1.05  # times the weight of a block: less on its supports is no impact
TIGHT = 0.02  # of its rated tension: with less a sling holds nothing
PARTS = 24  # of the way that a machine slews between two instants of a path at rest, which are looked at
STANDS = 1e-9  # [m] between two samples of a rope whose winch stands


@dataclass(frozen=True)
class Reading:
    """The sampled values (n,) of a limit's quantity and, if known, the exact maximum with its time [s]."""

    values: Column
    exact: tuple[float, float] | None = None
    source: str = ""  # where the values come from, if that differs


def read(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the values of the quantity that a limit checks; None if the data are missing."""
    if limit.quantity in BASES:
        return _design(plan, limit, signals)
    reduction, kind = REDUCTIONS.get(limit.quantity, "largest"), KINDS.get(limit.quantity)
    if reduction == "ordered speed":
        exact = signals.peaks.get(f"{limit.subject} {limit.quantity}")
        if exact or (signals.dynamic and {*limit.elements} & {*signals.tensions}):
            none = np.full(len(signals.t), np.nan)
            ordered = max((speed for _, speed in touching(plan, limit.quantity, limit.subject)), default=0.0)
            if exact and limit.known and limit.use(ordered) > 1.0 + ROUNDING:  # whatever the errors of the run
                return Reading(none, (ordered, exact[1]), f"{ORDERED}; {60.0 * exact[0]:.3g} m/min {SIMULATED}")
            return Reading(none, exact, SIMULATED)
        return _ordered_speed(plan, limit, signals)
    if reduction == "splash zone":
        return _splash(plan, limit, signals)
    given = None
    if kind in OF_TENSIONS:
        on_record = tuple(name for name in limit.elements if name in signals.tensions)
        if limit.quantity == "lug load":
            on_record = tuple(x for x in on_record if _on_lug(plan, limit, signals, x))
        if not on_record:
            return Reading(np.zeros(len(signals.t))) if limit.quantity == "lug load" else None
        limit = msgspec.structs.replace(limit, elements=on_record)
        given = _hooked(plan, limit, signals) if limit.quantity == "lug load" else None
    each = measured(limit, plan.machines, plan.gravity, plan.actions)
    if reduction == "sum":
        return _sum(plan, each, signals)
    values = _largest(plan, each, signals, given)
    if values is None:
        return None
    if reduction == "range at rest":
        over = range_at_rest(values, signals, limit.elements)
        return None if over is None else Reading(over)
    if limit.quantity in STANDING:
        return Reading(_while_slewing(plan, limit, each[0].signal, signals, values))
    exact = _exact(plan, limit, signals, each[0].signal) if kind in OF_TENSIONS else None
    return _counted(plan, limit, signals, values, _strongest(plan, each, signals) if kind == "wind" else exact)


def axis_of(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column | None:
    """Return the argument of a limit's chart at each sample: trolley position, radius [m] or sling angle [rad].

    None if the argument was not recorded."""
    if limit.over == "angle":
        slings = (x for name in limit.elements for x in sling_signals(name, "slope", plan.machines, plan.gravity))
        return _largest(plan, list(slings), signals)
    hook = hooks_of(plan.machines).get(limit.elements[0])
    if limit.over == "radius" and hook and hook.axis:
        return evaluated(plan, ScalarSignal("radius", point=hook.eye, origin=hook.axis), signals)
    if hook is None:
        return None
    numbers = (origin(plan.machines, hook.on, 1),)
    return evaluated(plan, ScalarSignal("place across", point=Point(hook.on), numbers=numbers), signals)


def evaluated(
    plan: Plan, x: ScalarSignal, signals: SignalColumns, given: Mapping[str, Column] | None = None
) -> Column | None:
    """Return the values (n,) of a signal at the samples, in SI units; None if its data are not recorded.

    `given`: columns (n,) to use instead of the recorded ones."""
    if given is None:
        return signals.once(x, lambda: _evaluated(plan, x, signals, None))
    return _evaluated(plan, x, signals, given)


def _evaluated(
    plan: Plan, x: ScalarSignal, signals: SignalColumns, given: Mapping[str, Column] | None, turned: Sequence[Any] = ()
) -> Column | None:
    system: System = signals.once("system", lambda: merge((m.system for m in plan.machines), plan.gravity))
    if x.quantity in LINED and not {*x.ropes} <= {rope.name for rope in system.straight_ropes}:
        return None
    columns = given or (signals.lengths if x.quantity == "length" else signals.tensions)
    if x.quantity == "wind":
        columns = {x.of: wind_speed(wind(plan, x.of), signals.t)}
    if x.quantity in ON_BASES:  # of one resultant force, which is the same for all corners of a base
        force = signals.once(("force", x.point), lambda: force_on_base(x, system, signals))
        if force is None:
            return None
        V, along, across = force
        each: list[Any] = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (along, across, 0.0)]
        values, own, counts = list[Any](), list[Any]((*x.numbers, V)), tuple[int, ...]()
    else:
        places = [place(signals, point) for point in points(x, system)]
        values = [columns.get(name) for name in names(x, system)]
        if any(x is None for x in (*places, *values)):
            return None
        each, own, counts = [p.T for p in places if p is not None], list(numbers(x, system)), lines(x, system)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(scalar(x, each, [*turned, *own[len(turned) :]], values, counts))


def force_on_base(x: ScalarSignal, system: System, signals: SignalColumns) -> tuple[Column, Column, Column] | None:
    """Return the resultant force (n,) [N] on a base and where it acts (n,) [m] along and across; None without data."""
    group = carried_group(x, system)
    places = [place(signals, point) for point in group.points]
    tensions = [signals.tensions.get(name) for name in group.ropes]
    if any(x is None for x in (*places, *tensions)):
        return None
    each: list[Any] = [p.T for p in places if p is not None]
    context = FormulaContext(each, (1.0, 0.0, *group.numbers), tensions, [*map(len, group.ropes.values())])  # type: ignore[arg-type]
    return base_force(context, 2)


def _largest(
    plan: Plan, each: Sequence[MeasuredSignal], signals: SignalColumns, given: Mapping[str, Column] | None = None
) -> Column | None:
    """Return the largest of several signals (n,), nan where none counts; None if there are none or data are missing."""
    live = [x for x in each if x.sling is None or not x.lug or x.lug in dict(signals.lugs(x.sling.rope))] or each[:1]
    values = [_measured(plan, x, signals, given) for x in live]
    known = [x for x in values if x is not None]
    return np.asarray(np.fmax.reduce(known)) if known and len(known) == len(values) else None


def _measured(
    plan: Plan, x: MeasuredSignal, signals: SignalColumns, given: Mapping[str, Column] | None = None
) -> Column | None:
    """Return a signal (n,) that a limit checks, nan where its sling is slack or hooked elsewhere."""
    if x.sling is None:
        return evaluated(plan, x.signal, signals, given)
    if x.sling.rope not in signals.tensions:
        return None
    held = signals.tensions[x.sling.rope] > TIGHT * x.sling.rated
    held &= dict(signals.lugs(x.sling.rope)).get(x.lug, np.False_) if x.lug else np.True_
    values = evaluated(plan, x.signal, signals, given) if held.any() else np.full(len(signals.t), np.nan)
    return None if values is None else np.where(held, values, np.nan)


def _sum(plan: Plan, each: Sequence[MeasuredSignal], signals: SignalColumns) -> Reading | None:
    """Return the sum of the signals of several ropes, or None if none is recorded; its exact maximum is found at the
    peaks of the single ropes, with the values of the others at that time."""
    known = {x: y for x in each if (y := _measured(plan, x, signals)) is not None}
    if not known:
        return None
    total, most = np.zeros(len(signals.t)), list[tuple[float, float]]()
    for values in known.values():
        total = total + np.nan_to_num(values)
    for x, values in known.items():
        (rope,) = x.signal.ropes
        peak, when = signals.peaks.get(rope, (0.0, -1.0))
        if signals.t[0] <= when <= signals.t[-1]:
            there = _measured(plan, x, signals, {rope: np.full(len(signals.t), peak)})
            assert there is not None  # as before
            more = np.nan_to_num(there) - np.nan_to_num(values)
            most.append((float(np.interp(when, signals.t, total) + np.interp(when, signals.t, more)), when))
    return Reading(total, max(most, default=None))


def _while_slewing(plan: Plan, limit: RatedLimit, x: ScalarSignal, signals: SignalColumns, values: Column) -> Column:
    """Return the largest value of a base's signal up to each instant of an equilibrium path, also at angles between two
    instants while the machine slews."""
    actuators = () if signals.dynamic else next(m.actuators for m in plan.machines if m.name == limit.elements[0])
    for slewer in (a.name for a in actuators if a.verb == "slew" and a.name in signals.lengths):
        angles = np.append(0.0, np.diff(signals.lengths[slewer])) * np.arange(1, PARTS)[:, None] / PARTS
        if (angles != 0.0).any():
            turned = [np.array([[float(f(a)) for a in row] for row in angles]) for f in (cos, sin)]
            between = _evaluated(plan, x, signals, None, turned)
            assert between is not None  # as the values themselves
            values = np.maximum(values, between.max(axis=0))
    return values


def range_at_rest(values: Column, signals: SignalColumns, elements: tuple[str, ...]) -> Column | None:
    """Return the peak-to-peak range of a signal since the rope's winch stopped, for each sample (n,); None if data are
    missing.

    The range is the highest minus the lowest value. The winch may have stopped in an earlier part of the run."""
    length = signals.lengths.get(elements[0])
    if length is None or not signals.dynamic:
        return None
    found = np.zeros(len(values))
    low, high = signals.carried.get(elements, (np.inf, -np.inf))
    ends = [0, *(np.flatnonzero(np.abs(np.diff(length)) > STANDS) + 1).tolist(), len(values)]
    for a, b in pairwise(ends):
        lowest = np.minimum(np.minimum.accumulate(values[a:b]), low)
        highest = np.maximum(np.maximum.accumulate(values[a:b]), high)
        found[a:b] = highest - lowest
        low, high = np.inf, -np.inf
        if b == len(values) > a:
            signals.carried[elements] = float(lowest[-1]), float(highest[-1])
    return found


def _ordered_speed(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the highest ordered hook speed (n,) [m/s] in the actions, or in a run the stages, with lift-off or landing
    of a block; None of a run that orders none."""
    values, own = np.full(len(signals.t), np.nan), [x.first for x in plan.lists]
    each = touching(plan, limit.quantity, limit.subject)
    for number, speed in each:
        first = max((x for x in own if x < number), default=0)
        stage = next((x.stage for x in reversed(plan.actions[first:number]) if x.stage), "")
        here = np.array(signals.actions) == number if signals.named else signals.within(stage)
        values[here] = np.fmax(values[here], speed)
    return Reading(values, source=ORDERED) if each or not signals.dynamic else None


def _exact(plan: Plan, limit: RatedLimit, signals: SignalColumns, x: ScalarSignal) -> tuple[float, float] | None:
    """Return the value of the signal when the tension of the limit's rope, or the sum of several tensions, is at its
    exact peak, and the time [s] of this peak."""
    alone = signals.peaks.get(limit.elements[0]) if len(limit.elements) == 1 else None
    if alone and limit.quantity == "lug load" and not _on_lug(plan, limit, signals, limit.elements[0], alone[1]):
        alone = None
    cell = f"{limit.subject}.main" if limit.quantity in ("crane load", "tandem load") else limit.subject
    message = signals.crossings.get(f"{cell.replace(' ', '.')}.load") if limit.quantity != "lug load" else None
    peak = signals.peaks.get(f"{limit.subject} {limit.quantity}") or alone or message
    if peak is None:
        return None
    if x.quantity not in LINED:
        return float(scalar(x, (), x.numbers[:1] if x.quantity == "use" else x.numbers, peak[:1])), peak[1]
    column = evaluated(plan, x, signals, {x.ropes[0]: np.full(len(signals.t), peak[0])})
    return None if column is None else (float(np.interp(peak[1], signals.t, column)), peak[1])


def _counted(
    plan: Plan, limit: RatedLimit, signals: SignalColumns, values: Column, exact: tuple[float, float] | None
) -> Reading | None:
    """Return the values that a limit counts: charts apply only while the hook is loaded (with the mass of the hook
    block for charts by radius, and of slings and shackles that the model leaves out), off-lead angles only while the
    rope is loaded, regardless of their sign."""
    if limit.quantity in LOADS:
        hung = limit.rigging
        if limit.over != "radius":
            return Reading(np.maximum(values, 0.0) + hung, (exact[0] + hung, exact[1]) if exact else None)
        dead = sum(hook.block_mass for name, hook in hooks_of(plan.machines).items() if name in limit.elements)
        kept = (exact[0] + dead + hung, exact[1]) if exact and exact[0] > EMPTY * dead else None
        return Reading(np.where(values > EMPTY * dead, values + dead + hung, np.nan), kept)
    if limit.quantity == "impact":  # a block that stands has landed long ago, and softly if it only weighs on its pads
        weighs = values <= min(RESTS / limit.factor, 1.0) * (limit.value or 0.0)
        return Reading(np.where(weighs, np.nan, values), exact) if signals.dynamic else None
    if limit.quantity.startswith("off-lead"):
        hook = hooks_of(plan.machines)[limit.elements[0]]
        return Reading(np.where(carries(plan, hook, signals), np.abs(values), np.nan))
    return Reading(np.abs(values) if limit.quantity == "side force" else values, exact)


def _on_lug(plan: Plan, limit: RatedLimit, signals: SignalColumns, name: str, t: float | None = None) -> bool:
    """Return whether a sling is hooked to the lug of a limit at a time t [s], or at any time if t is None."""
    tie = tie_of(plan, name)
    if tie is None or tie.lower is not None:
        return True
    if t is None:
        return any(lug == limit.subject for lug, _ in signals.lugs(name))
    known = [lugs for start, lugs in signals.hooked if start <= t]
    return any(lugs.get(name) == limit.subject for lugs in known[-1:])


def _hooked(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> dict[str, Column]:
    """Return the tensions [N] of the slings, counted only while they are hooked to the lug of a limit."""
    found = {}
    for name in limit.elements:
        on = next((x for lug, x in signals.lugs(name) if lug == limit.subject), False)
        tie = tie_of(plan, name)
        free = tie is None or tie.lower is not None
        found[name] = signals.tensions[name] if free else np.where(on, signals.tensions[name], 0.0)
    return found


def _design(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the static load times its factors; in a run, the simulated load times all but the dynamic one."""
    if limit.rest is None or (signals.dynamic and limit.rest.alone):
        return None
    found = read(plan, msgspec.structs.replace(limit, quantity=BASES[limit.quantity]), signals)
    times = product(limit, dynamic=signals.dynamic)
    return found and Reading(found.values * times, (found.exact[0] * times, found.exact[1]) if found.exact else None)


def _splash(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the share of slack, or the load of a hook, in the splash zone, with the amplitude of the water's dynamic
    force."""
    if limit.quantity == "slack sling":
        return Reading(slack_sling(plan, limit, signals))
    found = read(plan, msgspec.structs.replace(limit, quantity="hook load", elements=limit.elements[:1]), signals)
    return found and Reading(splash_load(plan, limit, signals, found.values))


def _strongest(plan: Plan, each: Sequence[MeasuredSignal], signals: SignalColumns) -> tuple[float, float] | None:
    """Return the highest speed [m/s] of the winds at the breakpoints of their histories, with its time [s]; on an
    equilibrium path up to the end of the scene."""
    ran = signals.dynamic and len(signals.t) > 0
    end = float(signals.t[-1]) if ran else np.inf if plan.end is None else plan.end
    breaks = (t for x in each for t in wind(plan, x.signal.of).times if t <= end)
    times = np.array(sorted({0.0, *breaks} | ({end} if np.isfinite(end) else set())))
    speeds = _largest(plan, each, replace(signals, t=times, known={}))
    assert speeds is not None  # which need no data
    first = int(np.argmax(speeds))
    return speeds[first].item(), times[first].item()
