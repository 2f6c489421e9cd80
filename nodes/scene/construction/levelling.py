"""The verb `level`: hooks hoist, then lower, until a block is level.

The block is level when its attachment points on these hooks and on the other hooks have the same height, in the
attitude that the block is to have: the angle of the order or of the last turn before it, whatever its slewing angle.
Below a frame a point rises with the hooks above by the lever law.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import degrees

from heavylift.kernel.algebra.dense import dot, least_norm, norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Point, Vector
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan import actions
from heavylift.nodes.plan.mechanism import lug_places, ties_on
from heavylift.nodes.scene.keys.parts.rigging import Frame
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.source import Path

from .rigging.slings import lugs_of, slings_of
from .scene_builder import SceneBuilder
from .signals import Conditions
from .targets import OrderTarget

Pair = tuple[actions.Order, ...]
APART = 1e-3  # [m], level, of two places that one can be hoisted about the other
IN_LINE = 1e-9  # of the largest singular value: what holds a frame tells nothing beside its line


class Levelling:
    """Direction of each hook: hoist on the low side, lower on the high side; one set remains at rest.

    `hangs`: for each sling its upper attachment (the rope of a hook, or a point of a frame) and its lower end; `held`:
    the slings hooked at this point of the action list; `turned`: the angle of each block [rad].
    """

    def __init__(self, builder: SceneBuilder, conditions: Conditions) -> None:
        self.yard, self.conditions, self.turned = builder, conditions, dict[str, float]()
        scene, lugs = builder.scene, lugs_of(builder.scene)
        self.lugs = lug_places(builder.machines)
        hooks = [hook for crane in builder.cranes for hook in crane.hooks]
        self.hangs: dict[str, tuple[str | Point, Point]] = {
            tie.rope: (hook.rope, self.lugs.get(tie.lug, Point("block")))
            for hook in hooks
            for tie in ties_on(builder.machines, hook)
        }
        self.held = {tie.rope for tie in builder.slings() if tie.lug}
        frames = {name: frame for name, frame in scene.rigging.items() if isinstance(frame, Frame)}
        points = {name: Point(name) for name in frames}
        points |= {f"{name}.{at}": Point(name, p) for name, frame in frames.items() for at, p in frame.points.items()}
        for name, given in scene.rigging.items():
            for rope, sling in slings_of(scene, name).items():
                assert not isinstance(given, Frame)
                holder = " ".join(given.holders[sling.number].split())
                ends = given.to if given.type == "equaliser" else [sling.holds]
                for i, word in enumerate(ends):
                    if end := lugs.get(word) or points.get(word):
                        own = f"{rope}/{i}" if i else rope  # the second end of an equaliser
                        self.hangs[own] = points.get(holder) or holder.replace(" ", ".", 1), end
                        self.held |= {own} if sling.hooked else set()

    def follow(self, orders: Sequence[actions.Order]) -> None:
        """Apply an action: slings hooked and unhooked, and the angle."""
        for order in orders:
            match order:
                case actions.Hookup() if order.sling in self.hangs:
                    on, end = self.hangs[order.sling]
                    self.hangs[order.sling] = on, self.lugs.get(order.lug, end)
                    self.held |= {order.sling, f"{order.sling}/1"} & {*self.hangs}
                case actions.UnhookSling():
                    self.held -= {order.sling, f"{order.sling}/1"}
                case actions.Turn():
                    self.turned[order.block] = order.to

    def _rises(self, on: str | Point, hooks: Collection[str]) -> float:
        """Return the rise of a sling's attachment relative to that of the hooks."""
        if isinstance(on, str):
            return float(on in hooks)
        above = [self.hangs[sling] for sling in sorted(self.held) if self.hangs[sling][1].body == on.body]
        rows = [[1.0 for _ in above], *([end.p[i] for _, end in above] for i in (0, 1))]
        shares = least_norm(rows, [1.0, on.p[0], on.p[1]], IN_LINE) if above else []
        return sum(share * self._rises(x, hooks) for share, (x, _) in zip(shares, above, strict=True))

    def moves(self, path: Path, phrase: OrderPhrase, block: str, found: Sequence[OrderTarget]) -> list[Pair]:
        """Return the moves of hooks that hoist, then of hooks that lower; a fault if they hold nothing or
        everything."""
        actors = {actor.name: actor for actor in found}
        holds = [self.hangs[sling] for sling in sorted(self.held) if self.hangs[sling][1].body == block]
        places = [(end.p, self._rises(on, actors)) for on, end in holds]
        turned = self.turned.get(block, 0.0) if phrase.to is None else phrase.to
        ends = apart(places, turned)
        if ends is None:
            message = f"{', '.join(phrase.hooks)} cannot level the block: name hooks that hold it beside others"
            self.yard.source.fault(path, message)
            return []
        signal = ScalarSignal("height difference", point=Point(block, ends[0]), origin=Point(block, ends[1]))
        distance = norm([a - b for a, b in zip(*ends, strict=True)])
        least, words = distance * float(sin(phrase.within)), f"level within {degrees(phrase.within):g} deg"
        holding = {rope: x for rope, x in actors.items() if any(self._rises(on, [rope]) for on, _ in holds)}
        return [
            tuple(
                actions.Move(
                    verb=verb, model=actor.model, actuator=rope, speed=sign * phrase.speed, accel=actor.accel,
                    until=self.conditions.crossing(path, signal, block, sign * least, sign < 0.0, words), trims=True,
                    where=self.yard.source.where(path),
                )
                for rope, actor in holding.items()
            )
            for verb, sign in (("hoist", -1.0), ("lower", 1.0))
        ]  # fmt: skip


def apart(places: Sequence[tuple[Vector, float]], turned: float) -> tuple[Vector, Vector] | None:
    """Return the centres of the lugs that rise with hooks and of the others, or None if one is above the other.

    The first is moved vertically until the block is level or turned by an angle [rad]. `places`: each with its share of
    the rise.
    """
    parts = sum(part for _, part in places), sum(1.0 - part for _, part in places)
    if min(parts) < IN_LINE:
        return None
    up = (0.0, -float(sin(turned)), float(cos(turned)))  # in the block
    a = [sum(p[i] * part for p, part in places) / parts[0] for i in range(3)]
    b = [sum(p[i] * (1.0 - part) for p, part in places) / parts[1] for i in range(3)]
    above = dot([x - y for x, y in zip(a, b, strict=True)], list(up))
    p = (a[0] - above * up[0], a[1] - above * up[1], a[2] - above * up[2])
    distance = norm([x - y for x, y in zip(p, b, strict=True)])
    return (p, (b[0], b[1], b[2])) if distance > APART else None
