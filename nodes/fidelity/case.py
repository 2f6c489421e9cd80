"""The numbers of a lift that decide what of it must be modelled, from its plan and its static following.

All hooks at once are one load case: largest static loads, greatest lengths, largest speeds and ramps of the list.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, pi, sqrt

from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.models.levels.girders import sag
from heavylift.nodes.plan.actions import Action, Brake, Hookup, Lifted, Move, Turn, Unhook
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.verbs import VERBS

from .following import Following, Step
from .hooks import Hook
from .lifts import Axis, Crane, HookRope, Loader, drive_name, lift_of
from .moving import Parting, by_ways, lasts, lifting, tilted, turning
from .response import Swings, answer, frequencies
from .rests import awaiting, begins, bouncing, changes, flies_up, recoils, swinging

CREEP = 1e-4  # slowest speed of a winch that picks up [m/s]
MIRRORED = 1e-9  # [m, kg, rad] by which the halves of a lift may differ


@dataclass(frozen=True)
class Case:
    """A lift."""

    gravity: float
    hooks: tuple[Hook, ...]
    swings: Swings
    awaits: float  # largest swing while an event of the load is awaited [m]
    ordered: frozenset[str]  # joints that an order moves
    drives: dict[str, tuple[float, float]]  # joint -> servo stiffness [N/m], load that hangs from it [kg]
    hinges: tuple[str, ...]
    determinate: bool  # statics alone share the load among the hooks
    mirrored: bool  # about the plane across the rails through its middle
    turns: bool  # the block, on its master
    tilted: float  # how far winches wind against each other while it hangs [m]
    again: bool  # it may part from its stools once more after it has hung
    even: bool  # all winches that may lift the block go at one speed
    changes: bool  # a hook is taken from the block, or given to it, while it hangs
    recoils: bool  # one is taken from it that carries something
    flies_up: bool  # a hook, let go with more on it than it weighs itself
    awaited: bool  # the winches stop when the block is seen to be lifted, not after a way
    way: float  # longest of a move [m]
    lasts: float  # of the whole action list, about [s]
    stages: int  # of it: each begins and ends with a jump of the forces

    @property
    def damped(self) -> bool:
        """Whether its ropes damp a bounce."""
        return all(hook.rubs for hook in self.hooks)

    @property
    def reach(self) -> float:
        """Length of the slowest pendulum [m]."""
        return max(h.reach for h in self.hooks)


def case_of(plan: Plan, followed: Following) -> Case | None:
    """The numbers of a scene; None if nothing is lifted as far as it can be followed."""
    if not (loads := _loads(plan, followed)) or lift_of(plan).block is None:
        return None
    plan = by_ways(plan, followed)
    moves = [order for action in plan.actions for order in action.orders if isinstance(order, Move)]
    turns = any(isinstance(order, Turn) for action in plan.actions for order in action.orders)
    ropes = [rope for rope in lift_of(plan).rig.hook_ropes if rope.name in loads]
    places = {rope.name: _places(plan, rope, followed) for rope in ropes}
    bends = {rope.name: max(_bend(plan, rope, y) for y in places[rope.name]) for rope in ropes}
    sags = {
        c.name: sum(loads[r.name][0] * bends[r.name] for r in ropes if r.crane == c.name) for c in lift_of(plan).cranes
    }
    gives = (loads[r.name][0] * sum(_soft(plan, r, loads[r.name][1])) + bends[r.name] * sags[r.crane] for r in ropes)
    partings = lifting(plan, followed, plan.gravity * max(gives))
    still = (_hook(plan, r, *loads[r.name], moves, partings, places[r.name], sags[r.crane]) for r in ropes)
    hooks = tuple(replace(h, rings=_rings(plan, followed, h)) for h in still)
    longest, shortest = max(h.reach for h in hooks), min(h.length + h.depth for h in hooks)
    shortest = shortest if len(hooks) > 1 else longest  # several hooks hold a block level: it swings on its ropes alone
    slow, fast = sqrt(plan.gravity / longest), sqrt(plan.gravity / shortest)
    way = max((abs(m.by) for m in moves if m.by is not None), default=1.0)
    rests = swinging(plan, followed, 0, way), swinging(plan, followed, 1, way)
    swings = Swings(rests, (slow, fast), begins(followed))
    ordered, drives = set[str](), dict[str, tuple[float, float]]()
    for crane in lift_of(plan).cranes:
        for which, axis in (("gantry", crane.gantry), ("upper", crane.upper.axis), ("lower", crane.lower.axis)):
            joint = f"{crane.name}.gantry" if which == "gantry" else f"{crane.name}.{which}-slide"
            drives[joint] = axis.kp, sum(h.load for h in hooks if _hangs_from(plan, h.rope, crane, which))
            name = drive_name(crane.name, which)
            if any(m.actuator == name for m in moves) or (turns and which != "gantry"):
                ordered.add(joint)
    return Case(
        gravity=plan.gravity,
        hooks=hooks,
        swings=swings,
        awaits=swings.at(tuple(awaiting(plan, followed))),
        ordered=frozenset(ordered),
        drives=drives,
        hinges=tuple(f"{x.name}.hinge" for x in lift_of(plan).loaders),
        determinate=len(hooks) <= 3,
        mirrored=_mirrored(plan, ordered, {rope.crane for rope in ropes}),
        turns=turns,
        tilted=tilted(followed, [h.rope for h in hooks]),
        again=any(not x.before.grounded for p in partings for x in followed.acted[: p.action]),
        even=all(len({abs(m.speed) for m in x.moves if m.actuator in loads}) <= 1 for x in partings),
        changes=changes(plan, followed),
        recoils=recoils(plan, followed),
        flies_up=flies_up(plan, followed),
        awaited=any(isinstance(t, Lifted) for m in moves for t in terms(m.until)),
        way=way,
        lasts=min(sum(lasts(action) for action in plan.actions) + turning(plan), plan.end or inf),
        stages=len(plan.actions),
    )


def _loads(plan: Plan, followed: Following) -> dict[str, tuple[float, Step]]:
    """Rope -> the largest share of the block that hangs on it [kg], and the step with its longest rope."""
    found: dict[str, tuple[float, Step]] = {}
    for step in followed.steps:
        for rope in lift_of(plan).rig.hook_ropes if step.loads else ():
            share = (step.loads or {}).get(rope.carries, 0.0)
            if share > 0.0:
                before, longest = found.get(rope.name, (0.0, step))
                longer = step.state.ropes[rope.name] > longest.state.ropes[rope.name]
                found[rope.name] = max(before, share), step if longer else longest
    return found


def _hook(
    plan: Plan, rope: HookRope, share: float, step: Step, moves: list[Move], partings: list[Parting],
    places: list[float], sags: float,
) -> Hook:  # fmt: skip
    """`partings`: may lift the block; `places`: of its trolley then [m]; `sags`: the crane's shares times bends."""
    assert lift_of(plan).block is not None
    crane = next(c for c in lift_of(plan).cranes if c.name == rope.crane)
    loader = next(x for x in lift_of(plan).loaders if x.name == rope.carries)
    slings = [s for s in lift_of(plan).rig.slings if s.loader == rope.carries]
    mine = [m for m in moves if m.actuator == rope.name]
    picking = [abs(m.speed) for x in partings for m in x.moves if m.actuator == rope.name]
    length, load = step.state.ropes[rope.name], share + loader.upper.mass + loader.lower.mass
    pose, com = lift_of(plan).block.pose, lift_of(plan).block.body.com
    soft_rope, soft_slings = _soft(plan, rope, step)
    below = loader.pose[2] - pose[2] - com[2]  # of the hook, as it stands
    stools = sum(p.support.k for p in lift_of(plan).block.pads if p.closed) / len(lift_of(plan).rig.hook_ropes)
    trolley, axis = _hangs_on(crane, rope)
    bend = max(_bend(plan, rope, y) for y in places)
    phases = [pi * y / crane.girder.span for y in places]
    traversed = max((abs(m.by) for m in moves if VERBS[m.verb].along == "y" and m.by is not None), default=0.0)
    hangs = (load + trolley) * plan.gravity / axis.kp
    heavy = plan.fidelity.ropes == "massive" or plan.fidelity.rope_mass == "lumped"
    parts = crane.parts
    bent = sag(parts, parts.girders[0], heavy=heavy)
    lever = abs(sum(line.a.p[2] for line in rope.lines) / len(rope.lines) - crane.girder.height)
    per_way = pi / crane.girder.span
    steep = per_way * max(abs(cos(x)) for x in phases)
    return Hook(
        rope=rope.name,
        crane=rope.crane,
        load=load,
        share=share,
        length=length,
        reach=length + below,
        rubs=rope.damping * soft_rope,
        rope_mass=rope.line * length,
        place=(loader.pose[0] - pose[0] - com[0], loader.pose[1] - pose[1] - com[1]),
        depth=-loader.hinge[2] - loader.lower.com[2],
        beam=max([s.beam.p[0] for s in slings], default=1.0) - min([s.beam.p[0] for s in slings], default=0.0),
        soft_rope=soft_rope,
        soft_slings=soft_slings,
        soft_girder=bend * sags / share,
        bend=bend,
        aside=lever * per_way * max(abs(cos(x)) / sin(x) for x in phases),
        slides=2.0 * hangs * steep * (bent + bend * sags * plan.gravity),
        tilts=(bent + bend * sags * plan.gravity) * per_way * per_way * (lever + hangs),
        traverses=traversed,
        rings=0.0,  # known once the girders' parts are
        picks=max(CREEP, *picking) * _grip(stools, soft_rope + soft_slings),
        ramp=max((m.accel for m in mine), default=0.0),
    )


def _rings(plan: Plan, followed: Following, h: Hook) -> float:
    """Largest dynamic part of a hook's load from all moves up and down, and hooks that are taken away, as it hangs."""
    found = 0.0
    for girder in (True, False):
        knots = bouncing(plan, followed, h.rope, h.soft(girder))
        w = h.omega(girder)
        damping = h.rubs * h.soft_rope / h.soft(girder) * w / 2.0
        largest = max(answer(knots, x, damping).largest for x in frequencies((w, w)))
        found = max(found, largest / h.soft(girder) / h.load / plan.gravity)
    return found


def _soft(plan: Plan, rope: HookRope, step: Step) -> tuple[float, float]:
    """Compliances of a rope and of what hangs from it [m/N]."""
    slings = [s for s in lift_of(plan).rig.slings if s.loader == rope.carries]
    return step.state.ropes[rope.name] / rope.EA, 1.0 / sum(s.EA / s.L0 for s in slings) if slings else 0.0


def _grip(stools: float, soft: float) -> float:
    """Part of the winch's speed with which the block parts from stools that give way as the ropes do."""
    return stools * soft / (1.0 + stools * soft) if stools else 1.0


def _places(plan: Plan, rope: HookRope, followed: Following) -> list[float]:
    """Where the trolley of a hook stands on its girder as hoisting begins under a taut sling, or at the start [m]."""
    crane = next(c for c in lift_of(plan).cranes if c.name == rope.crane)
    trolley = next(h.trolley for h in crane.hooks if h.rope == rope.name)
    begun = zip(plan.actions, followed.acted, strict=False)
    hoists = (at for x, at in begun if any(isinstance(m, Move) and m.actuator == rope.name for m in x.orders))
    lifts = [at.before for at in hoists if at.taut and at.before.grounded]
    return [before.trolleys[crane.name, trolley] for before in lifts] or [_hangs_on(crane, rope)[1].start]


def _hangs_on(crane: Crane, rope: HookRope) -> tuple[float, Axis]:
    """Mass and axis of the trolley of a hook."""
    of = next(x for x in crane.hooks if x.rope == rope.name)
    trolley = crane.upper if of.trolley == "upper" else crane.lower
    return trolley.body.mass, trolley.axis


def _bend(plan: Plan, rope: HookRope, y: float) -> float:
    """sin(pi y / L) / sqrt(k) of the girder's first mode, k = pi^4 EI / 2 L^3 [1 / sqrt(N/m)]."""
    crane = next(c for c in lift_of(plan).cranes if c.name == rope.crane)
    return float(sin(pi * y / crane.girder.span)) / sqrt(pi * pi * pi * pi / 2.0 * crane.girder.stiffness / 48.0)


def _hangs_from(plan: Plan, rope: str, crane: Crane, which: str) -> bool:
    return any(h.rope == rope and which in ("gantry", h.trolley) for h in crane.hooks)


def _mirrored(plan: Plan, ordered: set[str], carrying: set[str]) -> bool:
    """Whether a lift is its own mirror image about the plane across the rails through the block's centre of mass, and
    nothing moves along them; of cranes those count that carry."""
    block = lift_of(plan).block
    if block is None or any(joint.endswith(".gantry") for joint in ordered):
        return False
    middle = block.pose[0] + block.body.com[0]
    turned = any(abs(q) > MIRRORED for q in block.pose[4:6]) or any(block.products[:2])
    if abs(block.body.com[0]) > MIRRORED or turned:
        return False
    places = {lug.name: lug.p for lug in block.lugs}
    cranes = [c for c in lift_of(plan).cranes if c.name in carrying]
    hung: list[Sided] = [(c.gantry.start - middle, *_crane(c)) for c in cranes]
    sides: dict[str, float] = {drive: c.gantry.start - middle for c in cranes for drive in _trolleys(c)}
    for rope in (r for r in lift_of(plan).rig.hook_ropes if r.crane in carrying):
        loader = next(x for x in lift_of(plan).loaders if x.name == rope.carries)
        sides[rope.name] = loader.pose[0] - middle
        hung.append((sides[rope.name], *loader.pose[1:3], rope.L0, rope.EA, *_loader(loader)))
        sides[loader.name] = sides[rope.name]
        for s in lift_of(plan).rig.slings:
            if s.loader == loader.name:
                sides[s.name] = sides[rope.name] + s.beam.p[0]
            if s.loader == loader.name and s.lug:
                x, *rest = places[s.lug]
                hung.append((x - block.body.com[0], *rest, s.L0, s.EA))
                hung.append((sides[rope.name] + s.beam.p[0], *s.beam.p[1:], s.L0))
    return _its_own_image(hung) and all(_its_own_image([*_moves(action, sides)]) for action in plan.actions)


Sided = tuple[float, ...]  # place along the rails from the plane [m], and what must be the same on the other side


def _crane(c: Crane) -> Sided:
    """What must be the same of two cranes."""
    g, trolleys = c.girder, (c.upper, c.lower)
    moved = (v for t in trolleys for v in (t.body.mass, t.axis.kp, t.axis.kv, t.axis.start))
    return g.span, g.height, g.stiffness, g.mass, g.damping, c.main.mass, c.gantry.kp, c.gantry.kv, *moved


def _loader(x: Loader) -> Sided:
    """The same of two loaders."""
    return x.upper.mass, x.lower.mass, *x.hinge[1:], *x.upper.com[1:], *x.lower.com[1:], x.damping


def _its_own_image(things: list[Sided]) -> bool:
    """Whether there is one like it on the other side for each."""
    here = sorted((round(x, 9) + 0.0, *(round(v, 9) for v in rest)) for x, *rest in things)
    there = sorted((round(-x, 9) + 0.0, *(round(v, 9) for v in rest)) for x, *rest in things)
    return here == there


def _trolleys(crane: Crane) -> tuple[str, str]:
    return drive_name(crane.name, "upper"), drive_name(crane.name, "lower")


def _moves(action: Action, sides: dict[str, float]) -> Iterator[Sided]:
    """The orders of an action: where, which, and of moves speed, acceleration, way and goal."""
    for order in action.orders:
        if isinstance(order, Move) and order.actuator in sides:
            across = float(VERBS[order.verb].along == "y")
            yield sides[order.actuator], across, order.speed, order.accel, order.by or 0.0, order.to or 0.0
        elif isinstance(order, Hookup | Unhook) and order.sling in sides:
            yield sides[order.sling], 2.0 + isinstance(order, Hookup)
        elif isinstance(order, Brake):
            yield sides.get(order.brake.removesuffix(".hinge.lock"), inf), 4.0 + order.engaged
