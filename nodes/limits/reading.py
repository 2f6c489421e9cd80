"""How each quantity of the table of limits is read: by the signal that the limit names, or by one function of its own.

A signal is one row of the kernel's table of quantities, whose formula conditions and interlocks trace; here it is
evaluated on columns.  A reading is the quantity at each instant and, where a run kept the exact peak of a tension, the
largest with its time.  An angle of a rope counts only while the rope holds a load: what hangs empty may swing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from heavylift.kernel.description import forces
from heavylift.kernel.description.mechanics import Line, System
from heavylift.kernel.description.signals import Signal
from heavylift.kernel.model.quantities import names, numbers, points, scalar
from heavylift.nodes.plan.limit import Limit
from heavylift.nodes.plan.mechanism import lug_places
from heavylift.nodes.plan.plan import Plan

from .factors import BASES, product
from .named import KINDS, LOADS, signal_of
from .reeving import drum_end_factor, lead_factor
from .rope_signals import EMPTY, carries, hooks_of, place, rope_direction, rope_length, rope_of, tie_of
from .signals import Column, Signals

TIGHT = 0.02  # of its rated tension: with less a sling holds nothing
ALONG, ACROSS, UP = 0, 1, 2  # world axes: rails, girders, height


@dataclass(frozen=True)
class Reading:
    """Values (n,) in the unit of the limit, nan where there is none; the exact largest and when [s], where known."""

    values: Column
    exact: tuple[float, float] | None = None


def read(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """The quantity of a limit; None if nothing of it can be read."""
    reader = READERS.get(limit.quantity)
    return reader(plan, limit, signals) if reader else None


def axis_of(plan: Plan, limit: Limit, signals: Signals) -> Column | None:
    """What the chart of a limit is over, at each instant: a trolley's place on its girder, or a hook's radius [m]."""
    if limit.over == "angle":
        angles = [x.values for name in limit.elements if (x := _bridle(plan, limit, signals, name))]
        return np.fmax.reduce(angles) if angles else None
    hook = hooks_of(plan).get(limit.elements[0])
    if limit.over == "radius" and hook and hook.axis:
        return evaluated(plan, Signal("radius", point=hook.eye, origin=hook.axis), signals)
    rope = rope_of(plan, limit.elements[0])
    return _along(plan, signals, rope.lines[0].a.body, ACROSS) if rope else None


def evaluated(
    plan: Plan, x: Signal, signals: Signals, lines: tuple[Line, ...] = (), given: Mapping[str, Column] | None = None
) -> Column | None:
    """A signal at each instant (n,), in its unit of SI; None if something that it is of is on no record.  `lines`: of
    its rope, else all of them; `given`: values (n,), else those of the record."""
    systems = [machine.system for machine in plan.machines]
    rigid = tuple(rope for s in systems for rope in s.rigid_ropes)
    system = System(ropes=tuple(rope for s in systems for rope in s.ropes), rigid_ropes=rigid)
    own = [end for line in lines for end in (line.a, line.b)]
    columns = given or (signals.lengths if x.quantity == "length" else signals.tensions)
    if x.quantity == "wind":
        columns = {x.of: _strongest(_winds(plan, x.of), signals.t)}
    places = [place(signals, point) for point in own or points(x, system)]
    values: list[Any] = [columns.get(name) for name in names(x)]
    if any(x is None for x in (*places, *values)):
        return None
    each: list[Any] = [p.T for p in places if p is not None]
    shares = tuple(line.share for line in lines) or numbers(x, system)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(scalar(x, each, shares, values))


# by the signals that limits name


def _named(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """The signal of a limit; of its ropes those that are on record, with the exact peak of one, or of all together.

    Of a signal that the scene itself limits all must be on record.
    """
    watched = KINDS.get(limit.quantity) in ("load", "tension")
    if watched:
        on_record = tuple(name for name in limit.elements if name in signals.tensions)
        if not on_record:
            return None
        limit = msgspec.structs.replace(limit, elements=on_record)
    x = signal_of(limit, hooks_of(plan), plan.gravity)
    values = evaluated(plan, x, signals) if x else None
    if x is None or values is None:
        return None
    peak = _peak(limit, signals) if watched else None
    return Reading(values, (float(scalar(x, (), x.numbers, (peak[0],))), peak[1]) if peak else None)


def _peak(limit: Limit, signals: Signals) -> tuple[float, float] | None:
    """The exact peak of the one rope of a limit, or of what its load cell told of several [N], and when [s]."""
    alone = signals.peaks.get(limit.elements[0]) if len(limit.elements) == 1 else None
    cell = f"{limit.subject}.main" if limit.quantity in ("crane load", "tandem load") else limit.subject
    return alone or signals.crossings.get(f"{cell.replace(' ', '.')}.load")


def _load(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What hangs below the hook blocks of some ropes [kg]; by a chart over the radius the block counts, too, and of an
    empty hook no chart is asked."""
    found = _named(plan, limit, signals)
    if found is None or limit.over != "radius":
        return found and Reading(np.maximum(found.values, 0.0), found.exact)
    dead = sum(hook.block_mass for name, hook in hooks_of(plan).items() if name in limit.elements)
    exact = found.exact if found.exact and found.exact[0] > EMPTY * dead else None
    values = np.where(found.values > EMPTY * dead, found.values + dead, np.nan)
    return Reading(values, (exact[0] + dead, exact[1]) if exact else None)


def _lug_load(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What the slings on a lug pull together [kg]; those of beams while they are hooked there."""
    pulls = {}
    for name in (name for name in limit.elements if name in signals.tensions):
        on = next((x for lug, x in signals.lugs(name) if lug == limit.subject), False)
        tie = tie_of(plan, name)
        free = tie is None or tie.lower is not None  # that hangs there whenever it carries
        pulls[name] = signals.tensions[name] if free else np.where(on, signals.tensions[name], 0.0)
    x = Signal("load", ropes=tuple(name for name in limit.elements if name in pulls), numbers=(1.0 / plan.gravity, 0.0))
    total = evaluated(plan, x, signals, given=pulls) if pulls else np.zeros(len(signals.t))
    alone = signals.peaks.get(limit.elements[0]) if len(limit.elements) == 1 else None
    return total if total is None else Reading(total, (alone[0] / plan.gravity, alone[1]) if alone else None)


def _support(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What the most loaded of some supports carries [kg], or all of them together [N]."""
    found = [name for name in limit.elements if name in signals.tensions]
    if not found:
        return None
    forces, peak = [signals.tensions[name] for name in found], signals.peaks.get(f"{limit.subject} {limit.quantity}")
    if limit.quantity == "impact":
        return Reading(np.sum(forces, axis=0), peak)
    return Reading(np.max(forces, axis=0) / plan.gravity, (peak[0] / plan.gravity, peak[1]) if peak else None)


def _off_lead(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Angle of a hook rope to the vertical, in all or along the rails or across them, while it holds a load [rad]."""
    rope, x = rope_of(plan, limit.elements[0]), signal_of(limit, hooks_of(plan), plan.gravity)
    angle = evaluated(plan, x, signals, rope.lines) if rope and x else None
    if rope is None or angle is None:
        return None
    return Reading(np.where(carries(plan, rope, signals), np.abs(angle), np.nan))


def _design(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """A load times its factors; in a run what is simulated, without the dynamic one."""
    if limit.rest is None or (signals.dynamic and limit.rest.alone):
        return None
    found = read(plan, msgspec.structs.replace(limit, quantity=BASES[limit.quantity]), signals)
    times = product(limit, dynamic=signals.dynamic)
    return found and Reading(found.values * times, (found.exact[0] * times, found.exact[1]) if found.exact else None)


# of their own


def _pull(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """A part of a hook rope at its upper end, with its own weight [N]: the one at the drum in hoisting, or the most
    loaded one, which is the same in hoisting and the dead end in lowering."""
    rope = rope_of(plan, limit.elements[0])
    if rope is None or rope.hook.rope not in signals.tensions:
        return None
    hook, name = rope.hook, rope.hook.rope
    reeved = hook.falls, hook.drum_ends, hook.efficiency
    lead = drum_end_factor(*reeved, hoisting=True) if limit.quantity == "drum pull" else lead_factor(*reeved)
    own = hook.line / hook.falls * plan.gravity * rope_length(signals, rope)
    values, exact = lead * signals.tensions[name] / hook.falls + own, None
    if name in signals.peaks:
        peak, when = signals.peaks[name]
        exact = lead * peak / hook.falls + _near(signals, own, when), when
    return Reading(values, exact)


def _factor(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Breaking force of a part of a hook rope over what its most loaded part carries."""
    rope, pull = rope_of(plan, limit.elements[0]), _pull(plan, limit, signals)
    if rope is None or pull is None or not rope.hook.breaking:
        return None
    breaking = rope.hook.breaking
    with np.errstate(divide="ignore"):
        values: Column = breaking / pull.values
    return Reading(values, (breaking / pull.exact[0], pull.exact[1]) if pull.exact else None)


def _assembly(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What the legs of a bridle carry together, plumb [kg]; of their peaks, as if they came together."""
    total, most = np.zeros(len(signals.t)), list[tuple[float, float]]()
    for name in limit.elements:
        angle = _bridle(plan, limit, signals, name)
        if angle is not None:
            plumb = np.cos(np.nan_to_num(angle.values)) / plan.gravity
            total = total + plumb * signals.tensions[name]
            if name in signals.peaks:
                peak, when = signals.peaks[name]
                most.append((peak * _near(signals, plumb, when), when))
    return Reading(total, (sum(x for x, _ in most), max(most)[1]) if most else None)


def _bridle(plan: Plan, limit: Limit, signals: Signals, name: str = "") -> Reading | None:
    """Angle of a sling to the vertical while it is tight [rad]."""
    tie = tie_of(plan, name or limit.elements[0])
    if tie is None or tie.rope not in signals.tensions:
        return None
    values = np.full(len(signals.t), np.nan)
    tight, lugs = signals.tensions[tie.rope] > TIGHT * tie.rated, lug_places(plan.machines)
    hung = [(lugs.get(lug), tight & inside) for lug, inside in signals.lugs(tie.rope)]
    for lower, inside in [(tie.lower, tight)] if tie.lower else hung:
        line = Line(tie.upper, lower) if lower else None
        angle = evaluated(plan, Signal("off-lead"), signals, (line,)) if line else None
        if angle is None:
            return None
        values = np.where(inside, np.minimum(angle, np.pi - angle), values)
    return Reading(values)


def _side(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Horizontal pull of hook ropes on the axis that holds their trolley or crane [N]."""
    axis = ALONG if limit.over == "along" else ACROSS
    total = np.zeros(len(signals.t))
    for name in limit.elements:
        rope = rope_of(plan, name)
        d = rope_direction(signals, rope) if rope else None
        if rope is None or d is None or name not in signals.tensions:
            return None
        total = total + signals.tensions[name] * d[:, axis] / rope_length(signals, rope)
    return Reading(np.abs(total))


def _coordinate(axis: int) -> Callable[[Plan, Limit, Signals], Reading | None]:
    def reader(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
        """Where a crane stands on its rails, or a trolley on its girder [m]."""
        values = _along(plan, signals, limit.elements[0], axis)
        return None if values is None else Reading(values)

    return reader


def _along(plan: Plan, signals: Signals, body: str, axis: int) -> Column | None:
    """A coordinate of a body, from where the machine counts its own [m]."""
    if body not in signals.poses:
        return None
    carried, origin = {j.child: j for machine in plan.machines for j in machine.system.joints}, 0.0
    at = body
    while (joint := carried.get(at)) is not None:
        origin, at = origin + joint.p_PJ[axis], joint.parent
    return signals.poses[body][0][:, axis] - origin


# air


def _wind(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Speed of the strongest wind that the scene tells [m/s]: at each instant, and at the bends of its histories as far
    as a run went; of a path at rest, which knows no time, all that are before the end of the scene."""
    winds = _winds(plan)
    if not winds and not limit.known:
        return None
    ran = signals.dynamic and len(signals.t) > 0
    end = float(signals.t[-1]) if ran else np.inf if plan.end is None else plan.end
    times = sorted({0.0, *(t for s in winds for t in s.times if t <= end)} | ({end} if np.isfinite(end) else set()))
    speeds = _strongest(winds, np.array(times))
    first = int(np.argmax(speeds))
    return Reading(_strongest(winds, signals.t), (speeds[first].item(), times[first]))


def _winds(plan: Plan, name: str = "") -> list[forces.Signal]:
    """The speeds of all winds, or of that one."""
    each = (f for m in plan.mechanisms for f in m.system.forces if isinstance(f, forces.Wind))
    return [f.signal for f in each if name in ("", f.name)]


def _strongest(winds: list[forces.Signal], t: Column) -> Column:
    """(n,) the largest speed of any wind [m/s]; at a jump the larger side."""
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


READERS: dict[str, Callable[[Plan, Limit, Signals], Reading | None]] = {
    **dict.fromkeys(("signal", *KINDS), _named),
    **dict.fromkeys(LOADS, _load),
    **dict.fromkeys(BASES, _design),
    "assembly load": _assembly,
    "lug load": _lug_load,
    "support load": _support,
    "impact": _support,
    "rope factor": _factor,
    "rope peak": _pull,
    "drum pull": _pull,
    "off-lead": _off_lead,
    "off-lead along": _off_lead,
    "off-lead across": _off_lead,
    "bridle angle": _bridle,
    "side force": _side,
    "rails": _coordinate(ALONG),
    "girder": _coordinate(ACROSS),
    "wind": _wind,
}


def _near(signals: Signals, values: Column, t: float) -> float:
    """A slowly changing value at a time between instants."""
    return float(np.interp(t, signals.t, values)) if len(signals.t) else 0.0
