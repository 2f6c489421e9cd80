"""The verb `level`, with which hooks hoist and others lower until a block is level, and the order `hold height`.

A block is level when the centre of its attachment points on the hooks that move is at the same height as the centre of
the other attachment points, at the turn angle given by the order or by the last turn before it, whatever the slewing
angle. Below a frame, an attachment point rises with the hooks above it by the lever law.

A winch that holds the height of its hook pays out as much rope as the boom tip rises, plus the growth of the distance
from tip to drum divided by the number of falls. The kernel's law for followers, k1 s + kc cos s + ks sin s,
approximates this function of the boom angle s within a tenth of a millimetre. The stretch of the rope is taken from the
start.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from math import degrees, pi

import msgspec
import numpy as np
from heavylift.kernel.algebra.dense import cross, dot, least_norm, norm, solve
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Joint, Line, Measured, Point, System, Vector, merge
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.plan.actions import Follow, Move
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.scene.construction.rigging.edges import lugs_of, slings_of
from heavylift.nodes.scene.keys.parts.kinematics import Array, Poses, place, poses
from heavylift.nodes.scene.keys.parts.rigging import Frame
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.source import Path

from .scene_builder import SceneBuilder
from .signals import Conditions
from .targets import OrderTarget, targets

Pair = tuple[actions.Order, ...]
APART = 1e-3  # [m], level, of two places that one can be hoisted about the other
IN_LINE = 1e-9  # of the largest singular value: what holds a frame tells nothing beside its line


class Levelling:
    """Chooses the hooks that level a load: hooks on its low side hoist, hooks on its high side lower, others rest.

    `hangs`: for each sling its upper attachment (the rope of a hook, or a point of a frame) and its lower end; `held`:
    slings hooked at the present place in the action list; `turned`: turn angle of each block [rad].
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
        """Update the hooked slings and the turn angles of blocks by the orders of an action."""
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
        """Return how far a sling's attachment rises when the given hooks rise by one metre."""
        if isinstance(on, str):
            return float(on in hooks)
        above = [self.hangs[sling] for sling in sorted(self.held) if self.hangs[sling][1].body == on.body]
        rows = [[1.0 for _ in above], *([end.p[i] for _, end in above] for i in (0, 1))]
        shares = least_norm(rows, [1.0, on.p[0], on.p[1]], IN_LINE) if above else []
        return sum(share * self._rises(x, hooks) for share, (x, _) in zip(shares, above, strict=True))

    def moves(self, path: Path, phrase: OrderPhrase, block: str, found: Sequence[OrderTarget]) -> list[Pair]:
        """Return the moves that level a block, first of the hooks that hoist, then of the hooks that lower.

        An error is added if these hooks hold none or all of the block's attachment points."""
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
    """Return the centres of the lugs that the moving hooks raise and of all other lugs; None if they are too close.

    The first centre is moved vertically to where it is when the block is level at the angle `turned` [rad]. `places`:
    each lug with the share (0 to 1) by which it rises with the hooks.
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


NODES = tuple(float(cos(pi * (2 * i + 1) / 8)) for i in range(4))  # of Chebyshev, in -1 to 1
LEVEL = 1e-9  # of an axis that is level


def measuring(builder: SceneBuilder) -> list[plan.Mechanism]:
    """Return the machines, with a measured angle added to each boom whose hook must keep its height."""
    asked = [t for action in builder.scene.actions for t, phrase in action.orders.items() if phrase.height]
    known = targets(builder) if asked else {}
    ropes = {actor.name for target in asked for actor in known.get(" ".join(target.split()), ())}
    found = []
    for machine in builder.machines:
        led: dict[str, list[str]] = {}
        for rope in sorted(ropes):
            if boom := _boom(machine, rope):
                led.setdefault(boom.name, []).append(rope)
        angles = tuple(Measured(angle_of(x), "joint", x, followers=tuple(each)) for x, each in led.items())
        seen = replace(machine.system, measured=(*machine.system.measured, *angles))
        found.append(msgspec.structs.replace(machine, system=seen) if angles else machine)
    return found


def angle_of(joint: str) -> str:
    """Return the name of the measured angle of a boom's joint."""
    return f"{joint}.angle"


def follow(mechanisms: Sequence[plan.Mechanism], move: Move, rope: str, where: str) -> Follow | str:
    """Return the law by which a winch keeps its hook at one height while the boom luffs, or why there is none."""
    own = next(m for m in mechanisms if m.name == move.model)
    luffs = next(d.joint for d in own.system.drives if d.name == move.actuator)
    boom, actuator = _boom(own, rope), next(a for a in own.actuators if a.name == move.actuator)
    if boom is None or boom.name != luffs:
        return f"'{rope}' does not hang from what '{move.actuator}' luffs"
    whole = merge([m.system for m in mechanisms], 0.0)
    at = poses(System(whole.bodies, whole.joints))
    x, y, z = (dot(row, boom.axis) for row in boom.R_PJ)
    axis = place(Point(boom.parent, (x, y, z)), at) - place(Point(boom.parent), at)
    if abs(float(axis[2])) > LEVEL or actuator.lower is None or actuator.upper is None:
        return f"'{rope}' holds its height below a boom that luffs about a level axis, in a 'range' of its drive"
    length = _length(own.system, boom, rope, at, axis)
    middle, half = (actuator.upper + actuator.lower) / 2, (actuator.upper - actuator.lower) / 2
    angles = [middle + half * node for node in NODES]
    rows = [[s, float(cos(s)), float(sin(s)), 1.0] for s in angles]
    k1, kc, ks, _ = solve(rows, [length(s) for s in angles])
    return Follow(model=own.name, actuator=rope, master=angle_of(boom.name), law=(k1, kc, ks), where=where)


def _boom(machine: plan.Mechanism, rope: str) -> Joint | None:
    """Return the joint that moves the tip of a hook's rope by a single angle; None if there is none."""
    lines = next((r.lines for r in machine.system.ropes if r.name == rope and r.winch), ())
    return next(
        (j for j in machine.system.joints if lines and j.child == lines[0].a.body and j.kind == "revolute"), None
    )


def _length(system: System, boom: Joint, rope: str, at: Poses, axis: Array) -> Callable[[float], float]:
    """Return a function of the boom angle [rad] that gives the height of the tip plus the length from tip to drum
    divided by the number of falls [m]."""
    lines = next(r.lines for r in system.ropes if r.name == rope)
    start, o = (boom.q0 or (0.0,))[0], place(Point(boom.parent, boom.p_PJ), at)

    def turned(end: Point, s: float) -> Array:
        p = place(end, at) - o
        if end.body != boom.child:
            return o + p
        c, n = float(cos(s - start)), float(sin(s - start))
        k, q = axis.tolist(), p.tolist()
        return o + c * p + n * np.array(cross(k, q)) + (1.0 - c) * dot(k, q) * axis

    def part(line: Line, s: float) -> float:
        a, b = turned(line.a, s), turned(line.b, s)
        plumb = line.b.body == lines[0].b.body
        return line.share * (float(a[2]) if plumb else norm((a - b).tolist()))

    return lambda s: sum(part(line, s) for line in lines)
