"""What hangs on hooks, and places of points of bodies, as columns over the instants of a path or of a run."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.description.mechanics import WORLD, Point
from heavylift.nodes.plan.mechanism import ties_on
from heavylift.nodes.plan.plan import Hoist, Plan, Tie

from .signals import Column, Signals

CARRIES = 0.02  # of the capacity of its hook: with less below it a hook is empty
EMPTY = 0.1  # of its hook block, where no capacity is known


def tie_of(plan: Plan, name: str) -> Tie | None:
    """The sling of this name."""
    return next((tie for machine in plan.machines for tie in machine.ties if tie.rope == name), None)


def carries(plan: Plan, hook: Hoist, signals: Signals) -> Column:
    """Whether a load hangs on a hook, at each instant (n,)."""
    slings = [tie.rope for tie in ties_on(plan.machines, hook) if tie.rope in signals.tensions]
    if not slings:
        return np.ones(len(signals.t), dtype=bool)
    least = CARRIES * hook.capacity if hook.capacity else EMPTY * hook.block_mass
    return np.asarray(np.sum([signals.tensions[s] for s in slings], axis=0) > least * plan.gravity)


def place(signals: Signals, point: Point) -> Column | None:
    """Places (n, 3) of a point of a body [m]; None if the body is not on record."""
    return _placed(signals, point) if point.body in signals.poses or point.body == WORLD else None


def _placed(signals: Signals, point: Point) -> Column:
    if point.body == WORLD:
        return np.tile(np.array(point.p, dtype=float), (len(signals.t), 1))
    p, R = signals.poses[point.body]

    def make() -> Column:
        found = p  # column by column: what lies one after the other in memory is summed in one go
        for i, x in enumerate(point.p):
            if x:
                found = found + x * R[:, :, i]
        return found

    return signals.once((point.body, point.p), make)
