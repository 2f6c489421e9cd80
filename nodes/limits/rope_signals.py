"""Hook ropes and points of bodies as columns over the instants of a path or of a run: lengths, directions, places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.description.mechanics import WORLD, Line, Point
from heavylift.nodes.plan.mechanism import ties_on
from heavylift.nodes.plan.plan import Hoist, Mechanism, Plan, Tie

from .signals import Column, Signals

CARRIES = 0.02  # of the capacity of its hook: with less below it a hook is empty
EMPTY = 0.1  # of its hook block, where no capacity is known


@dataclass(frozen=True)
class HookRope:
    """A hook with the lines of its rope that end there, and the unstretched length of it at the start [m]."""

    machine: Mechanism
    hook: Hoist
    lines: tuple[Line, ...]
    L0: float


def hooks_of(plan: Plan) -> dict[str, Hoist]:
    """The hooks by the ropes that hold them."""
    return {hook.rope: hook for machine in plan.machines for hook in machine.hooks}


def rope_of(plan: Plan, name: str) -> HookRope | None:
    """The hook rope of this name, if it is straight."""
    for machine in plan.machines:
        for hook in (hook for hook in machine.hooks if hook.rope == name):
            for rope in (rope for rope in machine.system.straight_ropes if rope.name == name):
                lines = tuple(line for line in rope.lines if hook.eye.body in (line.a.body, line.b.body))
                return HookRope(machine, hook, lines, rope.L0)
    return None


def tie_of(plan: Plan, name: str) -> Tie | None:
    """The sling of this name."""
    return next((tie for machine in plan.machines for tie in machine.ties if tie.rope == name), None)


def rope_length(signals: Signals, rope: HookRope) -> Column:
    """Length of a hook rope down to its hook (n,) [m]; without poses its unstretched length."""
    d = rope_direction(signals, rope)
    if d is not None:
        return signals.once(("length", rope.hook.rope), lambda: np.linalg.norm(d, axis=1))
    return signals.lengths.get(rope.hook.rope, np.full(len(signals.t), rope.L0))


def rope_direction(signals: Signals, rope: HookRope) -> Column | None:
    """From where it leaves its crane to its hook (n, 3) [m]: the mean of the rope's lines."""
    if any(point.body not in (*signals.poses, WORLD) for line in rope.lines for point in (line.a, line.b)):
        return None

    def make() -> Column:
        whole = sum(line.share for line in rope.lines)
        each = [line.share / whole * (_placed(signals, line.b) - _placed(signals, line.a)) for line in rope.lines]
        return np.asarray(np.sum(each, axis=0))

    return signals.once(("direction", rope.hook.rope), make)


def carries(plan: Plan, rope: HookRope, signals: Signals) -> Column:
    """Whether a load hangs on a hook, at each instant (n,)."""
    slings = [tie.rope for tie in ties_on(plan.machines, rope.hook) if tie.rope in signals.tensions]
    if not slings:
        return np.ones(len(signals.t), dtype=bool)
    least = CARRIES * rope.hook.capacity if rope.hook.capacity else EMPTY * rope.hook.block_mass
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
