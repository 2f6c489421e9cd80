"""Passing the splash zone: slack slings, and the largest load on a hook, while a block is lowered into water.

The static weight at a depth is the weight less the buoyancy there. The amplitude of the water's dynamic force, given in
the scene, is added to the simulated forces, upward and downward. DNV-RP-N103 requires an upward dynamic force of at
most 0.9 of the static weight, so that slings stay taut. Both curves are also evaluated at their corners between two
samples.
"""

from collections.abc import Callable

import numpy as np
from heavylift.kernel.description.forces import Immersion
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.plan import Plan

from .named import hooks_of
from .signals import Column, SignalColumns, place

FLOATS = 1e-3  # of its weight: a block that weighs less than this in water floats


class SplashZone:
    """A block in the splash zone: its depth [m] and the vertical sling forces [N] of each hook, at samples (n,)."""

    def __init__(self, plan: Plan, block: str, signals: SignalColumns) -> None:
        machine, self.cargo = next((m, x) for m in plan.machines for x in m.cargo if x.body == block)
        self.water = next(f for f in machine.system.forces if isinstance(f, Immersion) and f.at.body == block)
        self.weight = self.cargo.mass * plan.gravity
        at = place(signals, self.water.at)
        self.depth = np.full(len(signals.t), np.nan) if at is None else self.water.level + self.water.below - at[:, 2]
        self.corners = sorted({*self.water.x, *(x for x, _ in self.cargo.amplitude)})
        pulls = {rope: _pull(plan, block, rope, signals) for rope in hooks_of(plan.machines)}
        self.pulls = {rope: pull for rope, (pull, _) in pulls.items()}
        pads = [f.name for f in machine.system.supports if f.point.body == block and f.name in signals.tensions]
        stands = np.sum([np.zeros(len(signals.t)), *(signals.tensions[name] for name in pads)], axis=0) > 0.0
        self.hangs = np.any([on for _, on in pulls.values()], axis=0) & ~stands

    @property
    def pull(self) -> Column:
        """Vertical force (n,) of all slings on the block [N]."""
        return np.asarray(np.sum([*self.pulls.values()], axis=0))

    def static(self, depth: Column) -> Column:
        """Return the static weight of the block in water [N] at these depths [m]."""
        return self.weight - np.interp(depth, self.water.x, self.water.effort)

    def amplitude(self, depth: Column) -> Column:
        """Return the amplitude of the dynamic force on the block [N] at these depths [m]."""
        x, force = zip(*self.cargo.amplitude or ((0.0, 0.0),), strict=True)
        return np.asarray(np.interp(depth, x, force))

    def along(self, f: Callable[[Column, Column], Column], rest: Column) -> Column:
        """Return the largest values (n,) that a function of the depth has taken since the previous sample.

        It is nan if the block is above still water or does not hang. `rest`: a quantity that changes linearly from
        sample to sample; the curves are constant below their last points."""
        d, hangs = self.depth, self.hangs
        values = np.where(hangs & (d >= 0.0), f(d, rest), np.nan)
        for x in self.corners:
            for k in np.flatnonzero((d[:-1] - x) * (d[1:] - x) < 0.0):
                if hangs[k] and hangs[k + 1]:
                    share = (x - d[k]) / (d[k + 1] - d[k])
                    there = f(np.array([x]), rest[k : k + 1] + share * (rest[k + 1] - rest[k]))
                    values[k + 1] = np.fmax(values[k + 1], there[0])
        return values


def slack_sling(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column:
    """Return the ratio (n,) of upward dynamic force to static weight of the block in water; at 1 a sling goes slack."""
    zone = _zone(plan, limit, signals)

    def share(depth: Column, missing: Column) -> Column:
        static = np.maximum(zone.static(depth), FLOATS * zone.weight)
        return np.asarray((missing + zone.amplitude(depth)) / static)

    return zone.along(share, zone.static(zone.depth) - zone.pull)


def splash_load(plan: Plan, limit: RatedLimit, signals: SignalColumns, load: Column) -> Column:
    """Return the load on a hook [kg] (n,), including its share of the dynamic force of the water.

    `load`: the load on the hook without this share."""
    zone = _zone(plan, limit, signals)
    pull, all_ = zone.pulls[limit.elements[0]], zone.pull
    share = np.divide(pull, all_, out=np.zeros(len(pull)), where=all_ > 0.0) / plan.gravity
    rest = load / np.where(share > 0.0, share, np.nan) - zone.static(zone.depth)
    return np.asarray(share * zone.along(lambda x, other: other + zone.static(x) + zone.amplitude(x), rest))


def _zone(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> SplashZone:
    return signals.once(("splash", limit.elements[-1]), lambda: SplashZone(plan, limit.elements[-1], signals))


def _pull(plan: Plan, block: str, rope: str, signals: SignalColumns) -> tuple[Column, Column]:
    """Return the vertical force (n,) [N] of a hook's slings on a block, and whether any of them is hooked to it."""
    total, hangs = np.zeros(len(signals.t)), np.zeros(len(signals.t), dtype=bool)
    lugs = {name: x for name, x in lug_places(plan.machines).items() if x.body == block}
    for tie in ties_on(plan.machines, hooks_of(plan.machines)[rope]):
        hung = [(lugs[lug], on) for lug, on in signals.lugs(tie.rope) if lug in lugs]
        if tie.lower and tie.lower.body == block:
            hung = [(tie.lower, np.ones(len(total), dtype=bool))]
        for end, on in hung:
            a, b, T = place(signals, tie.upper), place(signals, end), signals.tensions.get(tie.rope)
            if a is None or b is None or T is None:
                continue
            d = a - b
            total += np.where(on, T * d[:, 2] / np.sqrt(np.sum(d * d, axis=1)), 0.0)
            hangs |= on
    return total, hangs
