"""The verb `level`: hooks that are hoisted, then lowered, until the block lies level."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from heavylift.kernel.description.signals import Signal
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.source import Path

from .signals import Conditions
from .targets import Actor
from .yard import Yard

__all__ = ["Levelling"]

Pair = tuple[actions.Order, ...]


class Levelling:
    """What each hook does: it hoists what is low on its side, lowers what is high; one of the two has nothing to do."""

    def __init__(self, yard: Yard, mechanisms: Sequence[plan.Mechanism], conditions: Conditions) -> None:
        self.yard, self.conditions = yard, conditions
        self.hung: dict[str, list[tuple[float, float]]] = {}  # by rope: where it holds the block, u and v
        lugs = {lug.name: lug.p for lug in yard.block.lugs} if yard.block else {}
        ropes = {rope.carries: rope.name for rope in yard.ropes}
        for sling in (sling for sling in yard.slings if sling.lug):
            self.hung.setdefault(ropes[sling.loader], []).append(lugs[sling.lug][:2])
        for machine in mechanisms:
            lines = {rope.name: rope.lines[-1].b for rope in machine.system.all_ropes}
            for hook in machine.hooks:
                held = (lines[sling].p for slings in hook.slings.values() for sling in slings)
                self.hung[hook.rope] = [(x, y) for x, y, _ in held]

    def moves(self, path: Path, phrase: OrderPhrase, found: Sequence[Actor]) -> list[Pair]:
        """What the hooks hoist, then what they lower; a fault if they hold nothing, or everything."""
        actors = {actor.name: actor for actor in found if actor.name in self.hung}
        own = [place for rope in actors for place in self.hung[rope]]
        others = [place for rope, places in self.hung.items() for place in places if rope not in actors]
        if not own or not others:
            told = f"{', '.join(phrase.hooks)} cannot level the block: name hooks that hold it beside others"
            self.yard.source.fault(path, told)
            return []
        apart = [sum(x[i] for x in own) / len(own) - sum(x[i] for x in others) / len(others) for i in (0, 1)]
        axis = 0 if abs(apart[1]) >= abs(apart[0]) else 1  # a positive angle about either lowers the positive side
        signal, above = Signal("angle", of="block", axis=axis), apart[1 - axis] > 0.0
        pairs: list[Pair] = []
        for verb, sign, low in (("hoist", -1.0, above), ("lower", 1.0, not above)):
            value = phrase.within if low else -phrase.within
            words = f"level within {degrees(phrase.within):g} deg"
            pairs.append(
                tuple(
                    actions.Move(
                        verb=verb, model=actor.model, actuator=rope, speed=sign * phrase.speed, accel=actor.accel,
                        until=self.conditions.crossing(path, signal, "block", value, not low, words), trims=True,
                        where=self.yard.source.where(path),
                    )
                    for rope, actor in actors.items()
                )
            )  # fmt: skip
        return pairs
