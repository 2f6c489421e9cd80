"""The numbers of a lift that decide what of it must be modelled, from its plan and its static following.

All hooks at once are one load case: forces at each hook's largest static load, lengths where it hangs longest, speeds
and ramps the largest that the action list asks of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import pi, sin, sqrt
from typing import TYPE_CHECKING

from heavylift.nodes.scene.actions import Move, Turn
from heavylift.nodes.scene.plan import Crane, HookRope, Plan, drive_name

if TYPE_CHECKING:
    from heavylift.nodes.scene.follow import Following

__all__ = ["Case", "Hook", "case_of"]

MIRRORED = 1e-9  # [m, kg, rad] by which the halves of a lift may differ


@dataclass(frozen=True)
class Hook:
    """One hook under its largest static load; compliances in m/N, speeds of its winch in m/s."""

    rope: str
    load: float  # on the rope, with hook block and loader [kg]
    length: float  # longest while loaded [m]
    rope_mass: float  # of that length [kg]
    soft_rope: float
    soft_slings: float
    soft_girder: float
    picks: float  # fastest hoisting while the block stands
    hoists: float  # fastest winding while it hangs
    ramp: float  # [m/s2]

    def stretch(self, g: float, girder: bool = True, slings: bool = True) -> float:
        """Static deflection under the load [m]."""
        return self.load * g * (self.soft_rope + slings * self.soft_slings + girder * self.soft_girder)


@dataclass(frozen=True)
class Swing:
    """A move of what hooks hang from: ramp [m/s2], duration of ramp and cruise [s]."""

    ramp: float
    ramping: float
    cruising: float


@dataclass(frozen=True)
class Case:
    """A lift."""

    gravity: float
    hooks: tuple[Hook, ...]
    swings: tuple[Swing, ...]
    ordered: frozenset[str]  # joints that an order moves
    drives: dict[str, tuple[float, float]]  # joint -> servo stiffness [N/m], load that hangs from it [kg]
    hinges: tuple[str, ...]
    mirrored: bool  # about the plane across the rails through its middle
    determinate: bool  # statics alone share the load among the hooks
    stage: float  # duration of the shortest stage in which the block may be lifted [s]

    @property
    def longest(self) -> float:
        return max(hook.length for hook in self.hooks)

    @property
    def omega(self) -> float:
        """Slowest pendulum [rad/s]."""
        return sqrt(self.gravity / self.longest)


def case_of(plan: Plan, followed: Following) -> Case | None:
    """The numbers of a scene; None if nothing is lifted as far as it can be followed."""
    loads = _loads(plan, followed)
    if not loads:
        return None
    moves = [order for action in plan.actions for order in action.orders if isinstance(order, Move)]
    turns = any(isinstance(order, Turn) for action in plan.actions for order in action.orders)
    hooks = tuple(_hook(plan, rope, *loads[rope.name], moves) for rope in plan.rig.hook_ropes if rope.name in loads)
    hooks = tuple(replace(h, soft_girder=_girder(plan, h, hooks)) for h in hooks)
    ordered, drives = set[str](), dict[str, tuple[float, float]]()
    for crane in plan.cranes:
        for which, axis in (("gantry", crane.gantry), ("upper", crane.upper.axis), ("lower", crane.lower.axis)):
            joint = f"{crane.name}.gantry" if which == "gantry" else f"{crane.name}.{which}-slide"
            drives[joint] = axis.kp, sum(h.load for h in hooks if _hangs_from(plan, h.rope, crane, which))
            name = drive_name(crane.name, which)  # type: ignore[arg-type]
            if any(m.actuator == name for m in moves) or (turns and which != "gantry"):
                ordered.add(joint)
    hinges = tuple(f"{x.name}.hinge" for x in plan.loaders)
    swings = tuple(_swings(moves))
    stage = min((_duration(m) for m in moves if m.verb in ("hoist", "lower")), default=60.0)
    return Case(
        plan.gravity, hooks, swings, frozenset(ordered), drives, hinges, _mirrored(plan, followed, ordered),
        len(hooks) <= 3, stage,
    )  # fmt: skip


def _loads(plan: Plan, followed: Following) -> dict[str, tuple[float, float]]:
    """Rope -> largest static load [kg], longest length while loaded [m]."""
    blocks = {h.rope: h.block_mass for c in plan.cranes for h in c.hooks}
    loaders = {x.name: x.upper.mass + x.lower.mass for x in plan.loaders}
    found: dict[str, tuple[float, float]] = {}
    for step in followed.steps:
        for rope in plan.rig.hook_ropes if step.loads else ():
            share = (step.loads or {}).get(rope.carries, 0.0)
            if share > 0.0:
                assert rope.name in blocks
                m, L = found.get(rope.name, (0.0, 0.0))
                found[rope.name] = max(m, share + loaders[rope.carries]), max(L, step.state.ropes[rope.name])
    return found


def _hook(plan: Plan, rope: HookRope, load: float, length: float, moves: list[Move]) -> Hook:
    slings = [s for s in plan.rig.slings if s.loader == rope.carries]
    mine = [m for m in moves if m.actuator == rope.name]
    picking = [abs(m.speed) for m in mine if m.until is not None]
    free = [abs(m.speed) for m in mine if m.until is None]
    return Hook(
        rope=rope.name,
        load=load,
        length=length,
        rope_mass=rope.line * length,
        soft_rope=length / rope.EA,
        soft_slings=1.0 / sum(s.EA / s.L0 for s in slings) if slings else 0.0,
        soft_girder=0.0,
        picks=max(picking, default=0.0) or max(free, default=0.0),
        hoists=max(free, default=0.0),
        ramp=max((m.accel for m in mine), default=0.0),
    )


def _girder(plan: Plan, hook: Hook, hooks: tuple[Hook, ...]) -> float:
    """Deflection at a hook under all loads of its crane, per force of this hook [m/N]."""
    crane = next(c for c in plan.cranes for h in c.hooks if h.rope == hook.rope)

    def shape(h: Hook) -> float:
        of = next(x for x in crane.hooks if x.rope == h.rope)
        axis = crane.upper.axis if of.trolley == "upper" else crane.lower.axis
        return sin(pi * axis.start / crane.girder.span)

    mine = [h for h in hooks if any(x.rope == h.rope for x in crane.hooks)]
    total = sum(h.load * shape(h) for h in mine) * shape(hook)
    return total / hook.load / (pi**4 / 2.0 * crane.girder.stiffness / 48.0)


def _hangs_from(plan: Plan, rope: str, crane: Crane, which: str) -> bool:
    return any(h.rope == rope and which in ("gantry", h.trolley) for h in crane.hooks)


def _swings(moves: list[Move]) -> Iterator[Swing]:
    for m in moves:
        if m.verb in ("travel", "traverse"):
            ramping = abs(m.speed) / m.accel
            yield Swing(m.accel, ramping, max(0.0, _duration(m) - 2.0 * ramping))


def _duration(m: Move) -> float:
    """Seconds of a move whose way is known; a minute for another."""
    ramping = abs(m.speed) / m.accel if m.accel else 0.0
    return abs(m.by) / abs(m.speed) + ramping if m.by is not None and m.speed else 60.0


def _mirrored(plan: Plan, followed: Following, ordered: set[str]) -> bool:
    """Whether a lift is its own mirror image about a plane across the rails, and nothing moves along them."""
    block = plan.block
    if block is None or any(joint.endswith(".gantry") for joint in ordered) or len(plan.cranes) != 1:
        return False
    x0 = block.pose[0]
    crane = plan.cranes[0]
    if abs(crane.gantry.start - x0) > MIRRORED or abs(block.body.com[0]) > MIRRORED:
        return False
    if any(abs(q) > MIRRORED for q in block.pose[4:6]):
        return False
    slings = {s.name: s for s in plan.rig.slings}
    places = {lug.name: lug.p for lug in block.lugs}
    carried: list[tuple[float, ...]] = []
    for rope in plan.rig.hook_ropes:
        loader = next(x for x in plan.loaders if x.name == rope.carries)
        lugs = [places[s.lug] for s in slings.values() if s.loader == loader.name and s.lug]
        for p in lugs:
            carried.append((round(p[0], 9), round(p[1], 9), round(p[2], 9), round(rope.L0, 9), loader.upper.mass))
    image = sorted((-x or 0.0, *rest) for x, *rest in carried)
    orders = _orders(plan)
    return sorted((x or 0.0, *rest) for x, *rest in carried) == image and orders


def _orders(plan: Plan) -> bool:
    """Whether H1 and H2 get the same orders in every action."""
    for action in plan.actions:
        told: dict[str, list[tuple[object, ...]]] = {}
        for order in action.orders:
            if isinstance(order, Move) and order.actuator[-3:] in (".H1", ".H2"):
                told.setdefault(order.actuator[-2:], []).append((order.speed, order.accel, order.by, order.to))
        if told and told.get("H1") != told.get("H2"):
            return False
    return True
