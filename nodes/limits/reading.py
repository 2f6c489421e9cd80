"""Evaluation of the quantity of a limit over columns of samples.

A signal is one row of the kernel's table of quantities; its formula is also used for conditions and interlocks. A
reading holds the quantity at each instant and, if a run recorded the exact peak of a tension, the maximum with its
time. Unloaded ropes are not evaluated: an angle counts only while its rope carries a load.

The module also finds the hook radius and the utilisation of the radius chart in each stage: when the hook is first
loaded, at the highest utilisation, and at the end.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from heavylift.kernel.description import forces
from heavylift.kernel.description.mechanics import Point, System
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.model.quantities import LINED, lines, names, numbers, points, scalar
from heavylift.nodes.plan.limit import STANDING, TOUCHING, RatedLimit, Reach
from heavylift.nodes.plan.mechanism import lug_places
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import StaticState

from .factors import BASES, product
from .ground import drive_moment, stood, touch_speed
from .heave import relative_heave
from .named import KINDS, LOADS, OF_TENSIONS, hooks_of, origin, signal_of
from .signals import EMPTY, Column, SignalColumns, carries, place, signals_of, tie_of
from .splash import slack_sling, splash_load

RESTS = 1.05  # times the weight of a block: less on its supports is no impact
TIGHT = 0.02  # of its rated tension: with less a sling holds nothing


@dataclass(frozen=True)
class Reading:
    """Values (n,) of a limit's quantity in its unit, nan where it is undefined, and the exact maximum with its time [s]
    if it is known."""

    values: Column
    exact: tuple[float, float] | None = None


def read(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Evaluate the quantity of a limit; return None if the data are missing."""
    return READERS.get(limit.quantity, _named)(plan, limit, signals)


def axis_of(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column | None:
    """Return the argument of a limit's chart at each sample: trolley position or radius [m], or sling angle [rad]. None
    if it is missing."""
    if limit.over == "angle":
        angles = [x.values for name in limit.elements if (x := _bridle(plan, limit, signals, name))]
        return np.fmax.reduce(angles) if angles else None
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
    """Return the values (n,) of a signal at the samples, in SI units; None if its data are not recorded. `given`:
    columns (n,) to use instead of the recorded ones."""
    if given is None:
        return signals.once(x, lambda: _evaluated(plan, x, signals, None))
    return _evaluated(plan, x, signals, given)


def _ropes(plan: Plan) -> System:
    systems = [machine.system for machine in plan.machines]
    rigid = tuple(rope for s in systems for rope in s.rigid_ropes)
    return System(ropes=tuple(rope for s in systems for rope in s.ropes), rigid_ropes=rigid)


def _evaluated(
    plan: Plan, x: ScalarSignal, signals: SignalColumns, given: Mapping[str, Column] | None
) -> Column | None:
    system = signals.once("ropes", lambda: _ropes(plan))
    if x.quantity in LINED and not {*x.ropes} <= {rope.name for rope in system.straight_ropes}:
        return None
    columns = given or (signals.lengths if x.quantity == "length" else signals.tensions)
    if x.quantity == "wind":
        columns = {x.of: _strongest(_winds(plan, x.of), signals.t)}
    places = [place(signals, point) for point in points(x, system)]
    values: list[Any] = [columns.get(name) for name in names(x)]
    if any(x is None for x in (*places, *values)):
        return None
    each: list[Any] = [p.T for p in places if p is not None]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(scalar(x, each, numbers(x, system), values, lines(x, system)))


def _named(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Evaluate the signal of a limit, with the exact peak of one rope or of the sum of several ropes."""
    kind, given = KINDS.get(limit.quantity), None
    if kind in OF_TENSIONS:
        on_record = tuple(name for name in limit.elements if name in signals.tensions)
        if limit.quantity == "lug load":
            on_record = tuple(x for x in on_record if _on_lug(plan, limit, signals, x))
        if not on_record:
            return Reading(np.zeros(len(signals.t))) if limit.quantity == "lug load" else None
        limit = msgspec.structs.replace(limit, elements=on_record)
        given = _hooked(plan, limit, signals) if limit.quantity == "lug load" else None
    x = signal_of(limit, plan.machines, plan.gravity)
    values = evaluated(plan, x, signals, given) if x else None
    if x is None or values is None:
        return None
    return _counted(plan, limit, signals, values, _exact(plan, limit, signals, x) if kind in OF_TENSIONS else None)


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
    block for charts by radius), off-lead angles only while the rope is loaded, regardless of their sign."""
    if limit.quantity in LOADS:
        if limit.over != "radius":
            return Reading(np.maximum(values, 0.0), exact)
        dead = sum(hook.block_mass for name, hook in hooks_of(plan.machines).items() if name in limit.elements)
        kept = (exact[0] + dead, exact[1]) if exact and exact[0] > EMPTY * dead else None
        return Reading(np.where(values > EMPTY * dead, values + dead, np.nan), kept)
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
    known = [lugs for start, lugs in signals.hooked if t is None or start <= t]
    return any(lugs.get(name) == limit.subject for lugs in (known if t is None else known[-1:]))


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


def _assembly(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the vertical load [kg] of all legs of a bridle together; its exact maximum is found at the peaks of the
    single legs, with the loads of the other legs at that time."""
    plumb = {}
    for name in limit.elements:
        if (angle := _bridle(plan, limit, signals, name)) is not None:
            plumb[name] = np.cos(np.nan_to_num(angle.values)) / plan.gravity
    loads = {name: x * signals.tensions[name] for name, x in plumb.items()}
    total, most = np.sum([np.zeros(len(signals.t)), *loads.values()], axis=0), list[tuple[float, float]]()
    for name, x in plumb.items():
        peak, when = signals.peaks.get(name, (0.0, -1.0))
        if signals.t[0] <= when <= signals.t[-1]:
            more = float(np.interp(when, signals.t, x * peak - loads[name]))
            most.append((float(np.interp(when, signals.t, total)) + more, when))
    return Reading(total, max(most, default=None))


def _bridle(plan: Plan, limit: RatedLimit, signals: SignalColumns, name: str = "") -> Reading | None:
    """Return the angle of a taut sling to the vertical [rad]."""
    tie = tie_of(plan, name or next(iter(limit.elements), ""))
    if tie is None or tie.rope not in signals.tensions:
        return None
    values = np.full(len(signals.t), np.nan)
    tight, lugs = signals.tensions[tie.rope] > TIGHT * tie.rated, lug_places(plan.machines)
    hung = [(lugs.get(lug), tight & inside) for lug, inside in signals.lugs(tie.rope)]
    for lower, inside in [(tie.lower, tight)] if tie.lower else hung:
        angle = evaluated(plan, ScalarSignal("off-lead", point=lower, origin=tie.upper), signals) if lower else None
        if angle is None:
            return None
        values = np.where(inside, np.minimum(angle, np.pi - angle), values)
    return Reading(values)


def _column(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return a quantity that another module computes: ground pressure, drive moment, or speed at lift-off and
    landing."""
    values = COLUMNS[limit.quantity](plan, limit, signals)
    return None if values is None else Reading(values)


def _wind(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the speed of the strongest wind of the scene [m/s], at each sample and at the breakpoints of its
    histories; on an equilibrium path up to the end of the scene."""
    winds = _winds(plan)
    if not winds:
        return None
    ran = signals.dynamic and len(signals.t) > 0
    end = float(signals.t[-1]) if ran else np.inf if plan.end is None else plan.end
    times = sorted({0.0, *(t for s in winds for t in s.times if t <= end)} | ({end} if np.isfinite(end) else set()))
    speeds = _strongest(winds, np.array(times))
    first = int(np.argmax(speeds))
    return Reading(_strongest(winds, signals.t), (speeds[first].item(), times[first]))


def _winds(plan: Plan, name: str = "") -> list[forces.InputSignal]:
    """Return the speed signals of all winds or, if `name` is given, of that wind."""
    each = (f for m in plan.machines for f in m.system.forces if isinstance(f, forces.Wind))
    return [f.signal for f in each if name in ("", f.name)]


def _strongest(winds: list[forces.InputSignal], t: Column) -> Column:
    """Return the highest speed (n,) [m/s] of any wind at the times t; at a jump the larger of both values."""
    speeds = [np.zeros(len(t))]
    for s in winds:
        if not s.times:
            speeds.append(np.full(len(t), abs(s.value)))
            continue
        values, last = np.abs(np.array(s.values)), len(s.times) - 1
        before, behind = (np.searchsorted(s.times, t, side) for side in ("left", "right"))
        jump = np.maximum(values[np.minimum(before, last)], values[behind - 1])
        speeds += [np.abs(np.interp(t, s.times, s.values)), np.where(behind > before, jump, 0.0)]
    return np.asarray(np.max(speeds, axis=0))


def _splash(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Reading | None:
    """Return the load of a hook in the splash zone, with the amplitude of the water's dynamic force."""
    rope, _ = limit.elements
    found = read(plan, msgspec.structs.replace(limit, quantity="hook load", elements=(rope,)), signals)
    return found and Reading(splash_load(plan, limit, signals, found.values))


COLUMNS: dict[str, Callable[[Plan, RatedLimit, SignalColumns], Column | None]] = {
    **dict.fromkeys(STANDING, stood),
    **dict.fromkeys(TOUCHING, touch_speed),
    "drive moment": drive_moment,
    "brake moment": drive_moment,
    "relative heave": relative_heave,
    "slack sling": slack_sling,
}

READERS: dict[str, Callable[[Plan, RatedLimit, SignalColumns], Reading | None]] = {
    "assembly load": _assembly,
    "bridle angle": _bridle,
    **dict.fromkeys(BASES, _design),
    "wind": _wind,
    "splash load": _splash,
    **dict.fromkeys(COLUMNS, _column),
}


WHEN = ("begins", "most", "ends")


class HookReach:
    """Radii of the hooks that have a radius chart, collected from successive parts of an equilibrium path or a run."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._limits = [x for x in plan.limits if x.quantity == "hook load" and x.over == "radius"]
        self._found: dict[tuple[str, str], list[Reach]] = {}

    def see(self, signals: SignalColumns) -> SignalColumns:
        """Add the samples of the next part, and return them."""
        for limit in self._limits:
            reading, radii = read(self._plan, limit, signals), axis_of(self._plan, limit, signals)
            if reading is None or radii is None:
                continue
            for k in np.flatnonzero(np.isfinite(reading.values + radii)).tolist():
                self._add(limit, signals, float(signals.t[k]), float(radii[k]), float(reading.values[k]), k)
            if reading.exact and signals.t[0] <= reading.exact[1] <= signals.t[-1]:
                load, t = reading.exact
                self._add(limit, signals, t, float(np.interp(t, signals.t, radii)), load, None)
        return signals

    def see_path(self, states: Sequence[StaticState]) -> tuple[Reach, ...]:
        """Return the radii found on an equilibrium path."""
        self.see(signals_of(states))
        return self.found

    def _add(
        self, limit: RatedLimit, signals: SignalColumns, t: float, radius: float, load: float, k: int | None
    ) -> None:
        stage = signals.stage_at(t, k)
        one = Reach(hook=limit.subject, stage=stage, t=t, radius=radius, load=load, capacity=limit.at(radius))
        first, most, last = self._found.setdefault((limit.subject, stage), [one] * 3)
        self._found[limit.subject, stage] = [
            one if t < first.t else first, one if one.use > most.use else most, one if t >= last.t else last
        ]  # fmt: skip

    @property
    def found(self) -> tuple[Reach, ...]:
        """Three radii for each hook and stage, in order of time: at the beginning, at the end, and at the highest
        utilisation."""
        each = sorted(self._found.values(), key=lambda three: three[0].t)
        return tuple(
            msgspec.structs.replace(x, when=when) for three in each for when, x in zip(WHEN, three, strict=True)
        )
