"""A static state as the rules of a lift see it: where cranes, trolleys and hooks stand, what every loader carries."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import pi, sqrt

import msgspec
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import Body
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move, Turn

from .action_preview import Followed, first_rest
from .state import Pose, StaticState

Place = tuple[float, float, float]
SLACK = 1.0  # [N] of a sling that carries nothing
SHOWN = pi / 6.0  # [rad] of a turn that has a row of its own in tables
ROUND = 1e-6  # [rad]
SETTLES = 5  # a hundredth of what friction holds after each three
WRITTEN = 1e-6  # [m, rad] by which a start may be off its rest: rounding of what is written


@dataclass(frozen=True)
class State:
    """Where everything of a lift stands; keys are the names of cranes, drives, ropes and slings."""

    cranes: dict[str, float]  # x [m]
    trolleys: dict[tuple[str, str], float]  # y [m]
    ropes: dict[str, float]  # unstretched length [m]
    lugs: dict[str, str]  # of hooked slings
    at: Place  # middle of the block [m]
    theta: float  # [rad]
    grounded: bool


@dataclass(frozen=True)
class Step:
    """A static state of a lift, the action that led to it, and its name; `told`: whether tables have a row for it."""

    plan: plan.Plan
    where: str
    stage: str
    static: StaticState
    told: bool

    @cached_property
    def state(self) -> State:
        """Where everything stands."""
        return lift_state(self.plan, self.static)

    @cached_property
    def loads(self) -> dict[str, float] | None:
        """What the block weighs on each loader [kg]; None while it stands on its stools."""
        return None if self.static.grounded else loads_of(self.plan, self.static)


@dataclass(frozen=True)
class Begun:
    """The state before an action, and whether a sling is taut behind it."""

    before: State
    taut: bool


@dataclass(frozen=True)
class Following:
    """All states of a lift, and each action that could be followed."""

    path: Followed
    steps: tuple[Step, ...]
    acted: tuple[Begun, ...]

    @property
    def known(self) -> bool:
        """Whether the whole list could be followed."""
        return self.path.known


def following(built: plan.Plan, path: Followed) -> Following:
    """A path as the states of a lift."""
    ends = [*(a.action != b.action for a, b in pairwise(path.states)), *([True] if path.states else [])]
    steps = tuple(_step(built, x, end) for x, end in zip(path.states, ends, strict=True))
    after = [*(x.before for x in path.acted[1:]), *path.states[-1:]]
    hung = {s.loader for s in built.rig.slings}
    taut = [any(is_taut(built, x, loader) for loader in hung) for x in after]
    acted = (Begun(lift_state(built, x.before), t) for x, t in zip(path.acted, taut, strict=False))
    return Following(path, steps, tuple(acted))


def _step(built: plan.Plan, x: StaticState, told: bool) -> Step:
    action = built.actions[x.action - 1] if x.action else None
    stage = x.stage
    if action and any(isinstance(order, Turn) for order in action.orders):
        theta = x.references["turn"]
        if abs(theta / SHOWN - round(theta / SHOWN)) < ROUND and abs(theta - built.start) > ROUND:
            stage, told = f"{stage}, {180.0 / pi * theta:.0f} deg", True
    return Step(built, action.where if action else "", stage, x, told)


def lift_state(built: plan.Plan, x: StaticState) -> State:
    """Where a lift stands in a static state."""
    assert built.block is not None
    p, R = x.poses[built.block.name]
    at = {c.name: c for c in built.cranes}
    theta, led = atan2(R[1][2], R[2][2]), x.references.get("turn", built.start)
    return State(
        cranes={c: x.references[plan.drive_name(c, "gantry")] for c in at},
        trolleys={(c, t): x.references[plan.drive_name(c, t)] for c in at for t in ("upper", "lower")},
        ropes={rope.name: x.references[rope.name] for rope in built.rig.hook_ropes},
        lugs=dict(x.hooked),
        at=p,
        theta=theta + 2.0 * pi * round((led - theta) / (2.0 * pi)),
        grounded=x.grounded,
    )


def world(x: StaticState, body: str, p: Place) -> Place:
    """World position of a point of a body [m]."""
    o, R = x.poses[body]
    a, b, c = (o[i] + R[i][0] * p[0] + R[i][1] * p[1] + R[i][2] * p[2] for i in range(3))
    return a, b, c


def loads_of(built: plan.Plan, x: StaticState) -> dict[str, float]:
    """What the block weighs on each loader [kg]: the vertical part of its slings' tensions, or what is on its hook rope
    where these bend over edges."""
    assert built.block is not None
    lugs = {lug.name: lug.p for lug in built.block.lugs}
    found = {loader.name: 0.0 for loader in built.loaders}
    own = {loader.name: loader.upper.mass + loader.lower.mass for loader in built.loaders}
    bent = {sling.loader for sling in built.rig.slings if sling.over}
    for rope in (rope for rope in built.rig.hook_ropes if rope.carries in bent):
        ends = [(world(x, n.a.body, n.a.p), world(x, n.b.body, n.b.p)) for n in rope.lines]
        way = [sum(a[i] - b[i] for a, b in ends) for i in range(3)]
        lifted = x.tensions[rope.name] * way[2] / sqrt(sum(d * d for d in way)) / built.gravity
        found[rope.carries] = max(0.0, lifted - own[rope.carries])
    for sling in (sling for sling in built.rig.slings if not sling.over):
        lug = x.hooked.get(sling.name)
        tension = x.tensions[sling.name]
        if lug is None or tension <= 0.0:
            continue
        a, b = world(x, sling.beam.body, sling.beam.p), world(x, built.block.name, lugs[lug])
        dx, dy, dz = (p - q for p, q in zip(a, b, strict=True))
        found[sling.loader] += tension * dz / sqrt(dx * dx + dy * dy + dz * dz) / built.gravity
    return found


def is_taut(built: plan.Plan, x: StaticState, loader: str) -> bool:
    """Whether a sling of a loader carries."""
    return any(x.tensions[s.name] > SLACK for s in built.rig.slings if s.loader == loader and s.name in x.hooked)


def goals(built: plan.Plan, action: plan.Action, before: State) -> State:
    """Where the moves of an action are to lead whose ends are known."""
    cranes, trolleys, ropes = dict(before.cranes), dict(before.trolleys), dict(before.ropes)
    for m in action.orders:
        if not isinstance(m, Move) or (m.to is None and m.by is None):
            continue
        if m.actuator in ropes:
            ropes[m.actuator] = end_of(m, ropes[m.actuator])
        for c in built.cranes:
            if m.actuator == plan.drive_name(c.name, "gantry"):
                cranes[c.name] = end_of(m, cranes[c.name])
            for t in ("upper", "lower"):
                if m.actuator == plan.drive_name(c.name, t):
                    trolleys[c.name, t] = end_of(m, trolleys[c.name, t])
    return State(cranes, trolleys, ropes, before.lugs, before.at, before.theta, before.grounded)


def end_of(m: Move, now: float) -> float:
    """Where a move ends whose end is known."""
    return m.to if m.to is not None else now + (m.by or 0.0)


def goal_states(built: plan.Plan, path: Followed) -> list[StaticState]:
    """Where all stands at the start, and where the moves of each action were to lead, though limits may have stopped
    them: places only, nothing hangs."""
    found = [_empty(x) for x in path.states[:1]]
    for number, acted in enumerate(path.acted, 1):
        action, before = built.actions[number - 1], acted.before
        if not any(isinstance(m, Move) for m in action.orders):
            continue
        old = lift_state(built, before)
        new = goals(built, action, old)
        poses, references = {}, {**new.ropes}
        for c in built.cranes:
            dx = new.cranes[c.name] - old.cranes[c.name]
            poses[f"{c.name}.main"] = _moved(before, f"{c.name}.main", (dx, 0.0, 0.0))
            for hook in c.hooks:
                rope = next(r for r in built.rig.hook_ropes if r.name == hook.rope)
                dy = new.trolleys[c.name, hook.trolley] - old.trolleys[c.name, hook.trolley]
                poses[f"{c.name}.{hook.trolley}"] = _moved(before, f"{c.name}.{hook.trolley}", (dx, dy, 0.0))
                way = (dx, dy, old.ropes[rope.name] - new.ropes[rope.name])
                poses[rope.eye.body] = _moved(before, rope.eye.body, way)
        stage = action.stage or f"action {number}"
        found.append(replace(_empty(before), action=number, stage=stage, poses=poses, references=references))
    return found


def _empty(x: StaticState) -> StaticState:
    return replace(x, event="", tensions={}, supports={}, hooked={})


def standing(built: plan.Plan, first: StaticState) -> plan.Plan:
    """The plan with its block as it rests on its stools at the start, where it is not written so to `WRITTEN`."""
    if built.block is None:
        return built
    flexible = built.block.flexible
    p, R = first.poses[built.block.name]
    turned = max(abs(R[i][j] - (i == j)) for i in range(3) for j in range(3))
    written = max(turned, *(abs(a - b) for a, b in zip(p, built.block.pose, strict=False))) <= WRITTEN
    if written and flexible is None:
        return built
    bent = replace(flexible, start=first.modes.get(built.block.name, ())) if flexible else None
    rests = msgspec.structs.replace(built.block, pose=_rest((p, R)), flexible=bent)
    return msgspec.structs.replace(built, block=rests)


def settled(built: plan.Plan) -> plan.Plan:
    """The plan with flexible blocks bent as they rest at the start: friction, which begins where they stand, holds them
    less each time."""
    for _ in range(SETTLES):
        built = rigged(built, first_rest(built))
    return built


def rigged(built: plan.Plan, first: StaticState) -> plan.Plan:
    """The plan with block, hooks and frames as they rest at the start, and the ropes that carry there."""
    machines = []
    for machine in built.mechanisms:
        hung = {machine.name, *(hook.rope for hook in machine.hooks)}
        joints = (
            replace(j, q0=_rest(first.poses[j.child])) if j.kind == "free" and j.child in hung else j
            for j in machine.system.joints
        )
        taut = tuple(r.name for r in machine.system.all_ropes if r.hooked and first.tensions[r.name] > 0.0)
        bodies = (_bent(b, first) if b.name in hung else b for b in machine.system.bodies)
        system = replace(machine.system, joints=tuple(joints), bodies=tuple(bodies))
        machines.append(msgspec.structs.replace(machine, system=system, taut=taut))
    return msgspec.structs.replace(standing(built, first), mechanisms=tuple(machines))


def _bent(body: Body, first: StaticState) -> Body:
    bends = body.flexible
    return replace(body, flexible=replace(bends, start=first.modes.get(body.name, ()))) if bends else body


def _rest(pose: Pose) -> tuple[float, float, float, float, float, float, float]:
    """Place and quaternion of a body that is turned by less than 120 degrees."""
    p, R = pose
    w = 0.5 * sqrt(1.0 + R[0][0] + R[1][1] + R[2][2])
    x, y, z = ((R[i][j] - R[j][i]) / (4.0 * w) for i, j in ((2, 1), (0, 2), (1, 0)))
    return (*p, x, y, z, w)


def _moved(x: StaticState, body: str, way: Place) -> Pose:
    p, R = x.poses[body]
    return (p[0] + way[0], p[1] + way[1], p[2] + way[2]), R
