"""A static state as the rules of a lift see it: where cranes, trolleys and hooks stand, what every hook carries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import pi, sqrt

from heavylift.kernel.algebra.elementary import atan2
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Turn
from heavylift.nodes.statics import Followed, StaticState
from heavylift.nodes.statics.goals import SLACK, world

from .lifts import drive_name, lift_of

Place = tuple[float, float, float]
SHOWN = pi / 6.0  # [rad] of a turn that has a row of its own in tables
ROUND = 1e-6  # [rad]


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
    ends = [*(a.action != b.action for a, b in pairwise(path.states)), True][: len(path.states)]
    steps = tuple(_step(built, x, end) for x, end in zip(path.states, ends, strict=True))
    after = [*(x.before for x in path.acted[1:]), *path.states[-1:]]
    hung = {s.loader for s in lift_of(built).rig.slings}
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
    block = lift_of(built).block
    assert block is not None
    p, R = x.poses[block.name]
    at = {c.name: c for c in lift_of(built).cranes}
    theta, led = atan2(R[1][2], R[2][2]), x.references.get("turn", built.start)
    return State(
        cranes={c: x.references[drive_name(c, "gantry")] for c in at},
        trolleys={(c, t): x.references[drive_name(c, t)] for c in at for t in ("upper", "lower")},
        ropes={rope.name: x.references[rope.name] for rope in lift_of(built).rig.hook_ropes},
        lugs=dict(x.hooked),
        at=p,
        theta=theta + 2.0 * pi * round((led - theta) / (2.0 * pi)),
        grounded=x.grounded,
    )


def loads_of(built: plan.Plan, x: StaticState) -> dict[str, float]:
    """What the block weighs on each loader [kg]: the vertical part of its slings' tensions, or what is on its hook rope
    where these bend over edges."""
    block = lift_of(built).block
    assert block is not None
    lugs = {lug.name: lug.p for lug in block.lugs}
    found = {loader.name: 0.0 for loader in lift_of(built).loaders}
    own = {loader.name: loader.upper.mass + loader.lower.mass for loader in lift_of(built).loaders}
    bent = {sling.loader for sling in lift_of(built).rig.slings if sling.over}
    for rope in (rope for rope in lift_of(built).rig.hook_ropes if rope.carries in bent):
        ends = [(world(x, n.a.body, n.a.p), world(x, n.b.body, n.b.p)) for n in rope.lines]
        way = [sum(a[i] - b[i] for a, b in ends) for i in range(3)]
        lifted = x.tensions[rope.name] * way[2] / sqrt(sum(d * d for d in way)) / built.gravity
        found[rope.carries] = max(0.0, lifted - own[rope.carries])
    for sling in (sling for sling in lift_of(built).rig.slings if not sling.over):
        lug = x.hooked.get(sling.name)
        tension = x.tensions[sling.name]
        if lug is None or tension <= 0.0:
            continue
        a, b = world(x, sling.beam.body, sling.beam.p), world(x, block.name, lugs[lug])
        dx, dy, dz = (p - q for p, q in zip(a, b, strict=True))
        found[sling.loader] += tension * dz / sqrt(dx * dx + dy * dy + dz * dz) / built.gravity
    return found


def is_taut(built: plan.Plan, x: StaticState, loader: str) -> bool:
    """Whether a sling of a loader carries."""
    return any(
        x.tensions[s.name] > SLACK for s in lift_of(built).rig.slings if s.loader == loader and s.name in x.hooked
    )
