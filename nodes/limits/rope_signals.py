"""Hook ropes and points of bodies as columns over the instants of a path or of a run: lengths, directions, places."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.description.mechanics import WORLD, Point
from heavylift.nodes.plan.plan import Hoist, HookRope, Plan

from .signals import Column, Signals

CARRIES = 0.02  # of the capacity of its hook: with less below its loader a hook is empty


def rope_of(plan: Plan, name: str) -> HookRope | None:
    """The hook rope of this name."""
    return next((rope for rope in plan.rig.hook_ropes if rope.name == name), None)


def hook_of(plan: Plan, rope: str) -> Hoist | None:
    """The hook of a machine made of parts that a rope holds."""
    return next((hook for machine in plan.mechanisms for hook in machine.hooks if hook.rope == rope), None)


def block_mass(plan: Plan, rope: str) -> float:
    """Mass of the hook block on a rope [kg]."""
    goliaths = {hook.rope: hook.block_mass for crane in plan.cranes for hook in crane.hooks}
    other = hook_of(plan, rope)
    return goliaths.get(rope, other.block_mass if other else 0.0)


def rope_length(signals: Signals, rope: HookRope) -> Column:
    """Length of a hook rope from trolley to hook (n,) [m]; without poses its unstretched length."""
    d = rope_direction(signals, rope)
    if d is not None:
        return signals.once(("length", rope.name), lambda: np.linalg.norm(d, axis=1))
    return signals.lengths.get(rope.name, np.full(len(signals.t), rope.L0))


def rope_direction(signals: Signals, rope: HookRope) -> Column | None:
    """From a trolley to its hook (n, 3) [m]: the mean of the rope's lines."""
    if any(point.body not in (*signals.poses, WORLD) for line in rope.lines for point in (line.a, line.b)):
        return None

    def make() -> Column:
        each = [line.share * (_placed(signals, line.b) - _placed(signals, line.a)) for line in rope.lines]
        return np.asarray(np.sum(each, axis=0))

    return signals.once(("direction", rope.name), make)


def carries(plan: Plan, rope: HookRope, signals: Signals) -> Column:
    """Whether a load hangs below the loader of a rope, at each instant (n,)."""
    slings = [s.name for s in plan.rig.slings if s.loader == rope.carries and s.name in signals.tensions]
    if not slings:
        return np.ones(len(signals.t), dtype=bool)
    capacity = next(hook.capacity for crane in plan.cranes for hook in crane.hooks if hook.rope == rope.name)
    return np.asarray(np.sum([signals.tensions[s] for s in slings], axis=0) > CARRIES * capacity * plan.gravity)


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
