"""How far the ropes of a hanging load lean in a stated wind, at rest.

A load of weight W that wind pushes with the force F hangs on one hook at rest where F / W is the tangent of the lean of
its rope. Several hooks move sideways together: a rope with its slings, of height h and with the share T of the weight,
leans by F / (h sum(T / h)), which is F / W for equal heights. Wind comes from any direction, so this adds to the
off-lead without wind.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.factors import Factors
from heavylift.nodes.plan.limit import IN_WIND, RatedLimit, RestLoad
from heavylift.nodes.plan.mechanism import Cargo, Hoist
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import StaticState
from msgspec.structs import replace
from numpy.typing import NDArray

from .factors import wind_force
from .named import hooks_of, signal_of
from .reading import evaluated
from .signals import Column, SignalColumns, place, signals_of


def leads_in_wind(plan: Plan, given: Factors, states: Sequence[StaticState]) -> Iterator[RatedLimit]:
    """Yield, for each hook with a load, the limit of its off-lead in the stated wind.

    The utilisation at rest is that of the worst state. If a hook has several off-lead limits, only the limit with the
    highest utilisation is yielded."""
    force, formula = wind_force(given)
    if not force:
        return
    signals, worst = signals_of(states), dict[str, tuple[float, RatedLimit]]()
    each = [*_hung(plan, signals)]
    for limit in (x for x in plan.limits if x.quantity.startswith("off-lead") and each):
        signal, (rope,) = signal_of(limit, plan.machines, plan.gravity), limit.elements
        lead = evaluated(plan, signal, signals) if signal else None
        stiffness = np.fmin.reduce([np.full(len(signals.t), np.nan), *(x[rope] for x in each if rope in x)])
        if lead is None or not np.isfinite(stiffness).any():
            continue
        lead = np.abs(lead)
        leans = np.arctan(np.tan(lead) + force / stiffness)
        k = int(np.nanargmax(leans))
        several = " of weight by the heights of its ropes" if any(len(x) > 1 for x in each if rope in x) else ""
        own = f"{formula} over {stiffness[k] / 1e3:.4g} kN{several}, beside {np.degrees(lead[k]):.2f} deg at rest"
        rest = RestLoad(value=float(leans[k]), bound=limit.value or 0.0, stage=states[k].stage, alone=True)
        note = "; ".join(x for x in (limit.note, own) if x)
        use = limit.use(rest.value) if limit.known else -1.0
        if use > worst.get(limit.subject, (-np.inf,))[0]:
            worst[limit.subject] = use, replace(limit, quantity=IN_WIND, note=note, rest=rest)
    yield from (row for _, row in worst.values())


def _hung(plan: Plan, signals: SignalColumns) -> Iterator[Mapping[str, Column]]:
    """Yield for each load the force over the lean (n,) [N] of each rope that carries it: the weight if one hook does,
    or several of equal height; nan while the load stands."""
    pads, none = [s for m in plan.machines for s in m.system.supports], np.zeros(len(signals.t))
    for cargo in (cargo for machine in plan.machines for cargo in machine.cargo):
        loads = [signals.tensions.get(x.name, none) for x in pads if x.point.body == cargo.body]
        stands, heights, spring = np.any([none > 0.0, *(load > 0.0 for load in loads)], axis=0), {}, none
        for hook in hooks_of(plan.machines).values():
            held, height = _height(plan, hook, cargo, signals)
            lead = evaluated(plan, ScalarSignal("off-lead", ropes=(hook.rope,), point=hook.eye), signals)
            if lead is not None and held.any():
                heights[hook.rope] = np.where(held & ~stands, height, np.nan)
                spring = spring + np.where(held, signals.tensions[hook.rope] * np.cos(lead) / height, 0.0)
        yield {rope: height * spring for rope, height in heights.items()}


def _height(plan: Plan, hook: Hoist, cargo: Cargo, signals: SignalColumns) -> tuple[NDArray[np.bool_], Column]:
    """Return whether a load hangs on a hook by a taut sling (n,), and the height [m] of rope and slings above it."""
    none, lugs = np.zeros(len(signals.t)), lug_places(plan.machines)
    held, total, top = none > 0.0, none, _top(plan, hook, signals)
    for tie in ties_on(plan.machines, hook):
        taut = signals.tensions.get(tie.rope, none) > 0.0
        on = [(tie.lower, taut)] if tie.lower else [(lugs[lug], taut & at) for lug, at in signals.lugs(tie.rope)]
        for point, mine in on:
            low = place(signals, point) if point.body == cargo.body else None
            if low is not None:
                total, held = total + np.where(mine & ~held, top - low[:, 2], 0.0), held | mine
    return held, np.where(held, total, np.nan)


def _top(plan: Plan, hook: Hoist, signals: SignalColumns) -> Column:
    """Return the height (n,) [m] of the upper end of a hook's rope."""
    ropes = (rope for machine in plan.machines for rope in machine.system.straight_ropes if rope.name == hook.rope)
    ends = [place(signals, point) for rope in ropes for line in rope.lines for point in (line.a, line.b)]
    return np.asarray(np.max([x[:, 2] for x in ends if x is not None], axis=0))
