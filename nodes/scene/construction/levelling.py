"""The verb `level`: hooks that are hoisted, then lowered, until the block lies level.

Level is what the block's places on these hooks and on the others are at, along the way on which they are apart in the
attitude that the block is to have: the angle of the order or of the last turn before it, however it slews.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from heavylift.kernel.algebra.dense import dot, norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Point, Vector
from heavylift.kernel.description.signals import Signal
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.source import Path

from .signals import Conditions
from .targets import Actor
from .yard import Yard

Pair = tuple[actions.Order, ...]
APART = 1e-3  # [m], level, of two places that one can be hoisted about the other


class Levelling:
    """What each hook does: it hoists what is low on its side, lowers what is high; one of the two has nothing to do.

    `held`: where slings hold the block as the list is read, by hook rope and sling [m]; `turned`: its angle [rad].
    """

    def __init__(self, yard: Yard, mechanisms: Sequence[plan.Mechanism], conditions: Conditions) -> None:
        self.yard, self.conditions, self.turned = yard, conditions, 0.0
        self.lugs = {lug.name: lug.p for block in yard.all_blocks for lug in block.lugs}
        ropes = {rope.carries: rope.name for rope in yard.ropes}
        self.on = {sling.name: ropes[sling.loader] for sling in yard.slings}
        self.ends = {sling.name: self.lugs[sling.lug] for sling in yard.slings if sling.lug}
        self.held = dict(self.ends)
        for machine in mechanisms:
            lines = {rope.name: rope for rope in machine.system.all_ropes if rope.lines[-1].b.body == "block"}
            for hook in machine.hooks:
                slings = [sling for slings in hook.slings.values() for sling in slings if sling in lines]
                self.on |= dict.fromkeys(slings, hook.rope)
                self.ends |= {sling: lines[sling].lines[-1].b.p for sling in slings}
                self.held |= {sling: self.ends[sling] for sling in slings if lines[sling].hooked}

    def follow(self, orders: Sequence[actions.Order]) -> None:
        """What an action changes: slings that are hooked and taken off, and the angle."""
        for order in orders:
            match order:
                case actions.Hookup() if order.sling in self.on:
                    self.held[order.sling] = self.lugs[order.lug] if order.lug else self.ends[order.sling]
                case actions.Unhook():
                    self.held.pop(order.sling, None)
                case actions.Turn():
                    self.turned = order.to

    def moves(self, path: Path, phrase: OrderPhrase, found: Sequence[Actor]) -> list[Pair]:
        """What the hooks hoist, then what they lower; a fault if they hold nothing, or everything."""
        actors = {actor.name: actor for actor in found}
        own = [p for sling, p in self.held.items() if self.on[sling] in actors]
        others = [p for sling, p in self.held.items() if self.on[sling] not in actors]
        places = apart(own, others, self.turned if phrase.to is None else phrase.to) if own and others else None
        if places is None:
            told = f"{', '.join(phrase.hooks)} cannot level the block: name hooks that hold it beside others"
            self.yard.source.fault(path, told)
            return []
        signal = Signal("height difference", point=Point("block", places[0]), origin=Point("block", places[1]))
        way = norm([a - b for a, b in zip(*places, strict=True)])
        least, words = way * float(sin(phrase.within)), f"level within {degrees(phrase.within):g} deg"
        holding = {rope: actor for rope, actor in actors.items() if rope in self.on.values()}
        return [
            tuple(
                actions.Move(
                    verb=verb, model=actor.model, actuator=rope, speed=sign * phrase.speed, accel=actor.accel,
                    until=self.conditions.crossing(path, signal, "block", sign * least, sign < 0.0, words), trims=True,
                    where=self.yard.source.where(path),
                )
                for rope, actor in holding.items()
            )
            for verb, sign in (("hoist", -1.0), ("lower", 1.0))
        ]  # fmt: skip


def apart(own: list[Vector], others: list[Vector], turned: float) -> tuple[Vector, Vector] | None:
    """The middles of two sets of places, the first one moved upright to where both are level in a block that is turned
    by an angle [rad]; None if they are above one another.
    """
    up = (0.0, -float(sin(turned)), float(cos(turned)))  # in the block
    a, b = ([sum(p[i] for p in places) / len(places) for i in range(3)] for places in (own, others))
    above = dot([x - y for x, y in zip(a, b, strict=True)], list(up))
    p = (a[0] - above * up[0], a[1] - above * up[1], a[2] - above * up[2])
    way = norm([x - y for x, y in zip(p, b, strict=True)])
    return (p, (b[0], b[1], b[2])) if way > APART else None
