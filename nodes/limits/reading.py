"""How each quantity of the table of limits is read from signals: one function per quantity, one row in `READERS`.

A reading is the quantity at each instant and, where a run kept the exact peak of a tension, the largest with its time.
An angle of a rope counts only while the rope holds a load: what hangs empty may swing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.description.forces import Signal, Wind
from heavylift.kernel.description.mechanics import Point, System
from heavylift.kernel.model.quantities import names, numbers, points, scalar
from heavylift.nodes.plan.limit import Limit
from heavylift.nodes.plan.mechanism import lug_places
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.spellings import BEAM_LOAD

from .reeving import drum_end_factor, lead_factor
from .rope_signals import EMPTY, block_mass, carries, hook_of, place, rope_direction, rope_length, rope_of, tie_of
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
    if limit.over == "radius" and (hook := hook_of(plan, limit.elements[0])) and hook.axis:
        eye, axis = place(signals, hook.eye), place(signals, hook.axis)
        return None if eye is None or axis is None else np.hypot(*(eye - axis)[:, :UP].T)
    rope = rope_of(plan, limit.elements[0])
    return _along(plan, signals, rope.lines[0].a.body, ACROSS) if rope else None


# loads


def _load(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What hangs below the hook blocks of some ropes [kg]; by a chart over the radius the block counts, too."""
    ropes = [name for name in limit.elements if name in signals.tensions]
    if not ropes:
        return None
    dead = sum(block_mass(plan, name) for name in ropes)
    total = np.sum([signals.tensions[name] for name in ropes], axis=0) / plan.gravity - dead
    values, least = np.maximum(total, 0.0), -np.inf
    if limit.over == "radius":  # of an empty hook no chart is asked
        values, least, dead = np.where(total > EMPTY * dead, total + dead, np.nan), (1.0 + EMPTY) * dead, 0.0
    exact = None
    alone = signals.peaks.get(ropes[0]) if len(ropes) == 1 else None
    if (found := alone or signals.crossings.get(_cell(limit))) and found[0] / plan.gravity > least:
        peak, when = found
        exact = peak / plan.gravity - dead, when
    return Reading(values, exact)


def _cell(limit: Limit) -> str:
    """The load cell that watches over a load in a run."""
    if limit.quantity in ("crane load", "tandem load"):
        return f"{limit.subject}.main.load"
    return f"{limit.subject.replace(' ', '.')}.load"


def _lug_load(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """What the slings on a lug pull together [kg]; those of beams while they are hooked there."""
    total = np.zeros(len(signals.t))
    for name in (name for name in limit.elements if name in signals.tensions):
        on = next((x for lug, x in signals.lugs(name) if lug == limit.subject), None)
        tie = tie_of(plan, name)
        free = tie is None or tie.lower is not None  # that hangs there whenever it carries
        pull = signals.tensions[name] / plan.gravity
        total = total + (pull if free else 0.0 if on is None else np.where(on, pull, 0.0))
    alone = signals.peaks.get(limit.elements[0]) if len(limit.elements) == 1 else None
    return Reading(total, (alone[0] / plan.gravity, alone[1]) if alone else None)


def _tension(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """The tension of one sling, or of several together [N]."""
    found = [signals.tensions[name] for name in limit.elements if name in signals.tensions]
    if not found:
        return None
    alone = signals.peaks.get(limit.elements[0]) if len(limit.elements) == 1 else None
    exact = alone or signals.crossings.get(_cell(limit))
    return Reading(np.sum(found, axis=0), exact)


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


# directions


def _off_lead(*axes: int) -> Callable[[Plan, Limit, Signals], Reading | None]:
    def reader(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
        """Angle of a hook rope to the vertical, in all or along the rails or across them, while it holds a load
        [rad]."""
        rope = rope_of(plan, limit.elements[0])
        d = rope_direction(signals, rope) if rope else None
        if rope is None or d is None:
            return None
        aside = np.abs(d[:, axes[0]]) if len(axes) == 1 else np.hypot(*(d[:, axis] for axis in axes))
        angle = np.arctan2(aside, np.abs(d[:, UP]))
        return Reading(np.where(carries(plan, rope, signals), angle, np.nan))

    return reader


def _bridle(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Angle of a sling to the vertical while it is tight [rad]."""
    tie = tie_of(plan, limit.elements[0])
    if tie is None or tie.rope not in signals.tensions:
        return None
    values = np.full(len(signals.t), np.nan)
    tight = signals.tensions[tie.rope] > TIGHT * tie.rated
    upper = place(signals, tie.upper)
    on = (
        [(tie.lower, tight)] if tie.lower else [(_lug(plan, x), tight & inside) for x, inside in signals.lugs(tie.rope)]
    )
    for lug, inside in on:
        end = place(signals, lug) if lug else None
        if upper is None or end is None:
            return None
        d = end - upper
        angle = np.arctan2(np.hypot(d[:, ALONG], d[:, ACROSS]), np.abs(d[:, UP]))
        values = np.where(inside, angle, values)
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


# places


def _eye(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Height of a hook eye [m]."""
    rope = rope_of(plan, limit.elements[0])
    eye = place(signals, rope.hook.eye) if rope else None
    return None if eye is None else Reading(eye[:, UP])


def _unwound(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """Unstretched length of a hook rope that is off its drum [m]."""
    lengths = signals.lengths.get(limit.elements[0])
    return None if lengths is None else Reading(lengths)


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
    winds = [f.signal for m in plan.machines for f in m.system.forces if isinstance(f, Wind)]
    if not winds and not limit.known:
        return None
    ran = signals.dynamic and len(signals.t) > 0
    end = float(signals.t[-1]) if ran else np.inf if plan.end is None else plan.end
    times = sorted({0.0, *(t for s in winds for t in s.times if t <= end)} | ({end} if np.isfinite(end) else set()))
    speeds = _strongest(winds, np.array(times))
    first = int(np.argmax(speeds))
    return Reading(_strongest(winds, signals.t), (speeds[first].item(), times[first]))


def _strongest(winds: list[Signal], t: Column) -> Column:
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


# signals of the one table, by its formulas


def _signal(plan: Plan, limit: Limit, signals: Signals) -> Reading | None:
    """A signal at each instant, in its unit of SI; of a rope that is on no record nothing."""
    x = limit.signal
    assert x is not None
    ropes = tuple(rope for machine in plan.machines for rope in machine.system.ropes)
    places = [place(signals, point) for point in points(x, System(ropes=ropes))]
    values = [signals.tensions.get(name) for name in names(x)]
    if x.quantity == "wind":
        winds = [f.signal for m in plan.machines for f in m.system.forces if f.name == x.of and isinstance(f, Wind)]
        values = [_strongest(winds, signals.t)]
    known_places, known = [p for p in places if p is not None], [v for v in values if v is not None]
    if len(known_places) < len(places) or len(known) < len(values):
        return None
    given = numbers(x, System(ropes=ropes))
    rows = ([p[k].tolist() for p in known_places] for k in range(len(signals.t)))
    at = zip(rows, *(v.tolist() for v in known), strict=True)
    return Reading(np.array([float(scalar(x, row, given, list(each))) for row, *each in at]))


READERS: dict[str, Callable[[Plan, Limit, Signals], Reading | None]] = {
    "hook load": _load,
    "trolley load": _load,
    "crane load": _load,
    "tandem load": _load,
    BEAM_LOAD: _tension,
    "frame load": _load,
    "shackle load": _load,
    "lug load": _lug_load,
    "sling tension": _tension,
    "sling peak": _tension,
    "rope tension": _tension,
    "rope factor": _factor,
    "rope peak": _pull,
    "drum pull": _pull,
    "off-lead": _off_lead(ALONG, ACROSS),
    "off-lead along": _off_lead(ALONG),
    "off-lead across": _off_lead(ACROSS),
    "bridle angle": _bridle,
    "side force": _side,
    "hook height": _eye,
    "rope length": _unwound,
    "rails": _coordinate(ALONG),
    "girder": _coordinate(ACROSS),
    "wind": _wind,
    "signal": _signal,
}


def _lug(plan: Plan, name: str) -> Point | None:
    return lug_places(plan.machines).get(name)


def _near(signals: Signals, values: Column, t: float) -> float:
    """A slowly changing value at a time between instants."""
    return float(np.interp(t, signals.t, values)) if len(signals.t) else 0.0
