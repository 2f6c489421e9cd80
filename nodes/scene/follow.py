"""The action list followed statically: where everything stands after each action, as far as that can be known.

Ropes hang plumb and do not stretch, the block hangs from whichever loaders are taut.  Each action gives one `Step`
(a turn gives several); the checks of geometry and capacity look at the steps.  An action that ends on a state that
only the dynamics can tell (a tension, an angle) ends the following: what comes after it is not judged.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from . import actions, plan, schema
from .machines import HOOKS, exit_height
from .statics import Hang, shares

SLACK = 0.06  # a sling this short of its length counts as taut [m]
SAMPLES = 12  # steps of a turn


@dataclass(frozen=True)
class State:
    """Where everything stands; keys are the names of cranes, drives, ropes and slings."""

    cranes: dict[str, float]  # x [m]
    trolleys: dict[tuple[str, str], float]  # y [m]
    ropes: dict[str, float]  # unstretched length [m]
    lugs: dict[str, str]  # of hooked slings
    at: tuple[float, float, float]  # middle of the block [m]
    theta: float  # [rad]
    grounded: bool


@dataclass(frozen=True)
class Step:
    """A state, the action or order that led to it, what the taut loaders carry then."""

    where: str
    stage: str
    state: State
    loads: dict[str, float] | None = (
        None  # sling load by loader [kg]; None: nothing hangs or nothing can hold it
    )
    lean: float = 0.0  # the centre of mass is so far from what could hold it [m]


@dataclass
class Following:
    """All steps, and the faults met on the way as (where, sentence)."""

    steps: list[Step] = field(default_factory=list)
    faults: list[tuple[str, str]] = field(default_factory=list)
    known: bool = True
    told_stages: list[str] = field(
        default_factory=list
    )  # those a table shows: of a turn every 30 degrees or so


def follow(scene: schema.Scene, built: plan.Plan) -> Following:
    """Follows the whole action list of a scene with a block and cranes."""
    follower = Follower(scene, built)
    follower.walk()
    return follower.told


class Follower:
    """Walks through the action list; `state` is where everything stands now."""

    def __init__(self, scene: schema.Scene, built: plan.Plan) -> None:
        assert scene.block is not None
        self.scene, self.plan, self.block = scene, built, scene.block
        self.told = Following()
        self.ropes = {rope.name: rope for rope in built.rig.hook_ropes}
        self.rope_of = {rope.carries: rope.name for rope in built.rig.hook_ropes}
        self.slings = {sling.name: sling for sling in built.rig.slings}
        self.state = State(
            cranes={c.name: c.gantry.start for c in built.cranes},
            trolleys={(c.name, t.name): t.axis.start for c in built.cranes for t in (c.upper, c.lower)},
            ropes={rope.name: rope.L0 for rope in built.rig.hook_ropes},
            lugs={sling.name: sling.lug for sling in built.rig.slings if sling.lug},
            at=scene.block.at,
            theta=0.0,
            grounded=True,
        )

    def walk(self) -> None:
        """Every action in turn, until one cannot be followed."""
        self.told.steps.append(Step("", "at the start", self.state))
        for number, action in enumerate(self.plan.actions, 1):
            stage = action.stage or f"action {number}"
            self._spoken_of(action.when)
            for order in action.orders:
                self._order(order)
            if not self.told.known:
                return
            self._settle()
            self._step(action.where, stage)
            for order in action.orders:
                if isinstance(order, actions.Turn):
                    self._turn(order, stage)

    # where things are

    def eye(self, loader: str) -> tuple[float, float, float]:
        """The hook eye of a loader under its plumb rope [m]."""
        rope = self.ropes[self.rope_of[loader]]
        crane = self.scene.cranes[rope.crane]
        trolley, side = HOOKS[rope.hook]
        x = self.state.cranes[rope.crane] + side * crane.hook_spacing
        z = exit_height(crane, rope.hook) - self.state.ropes[rope.name]
        return (x, self.state.trolleys[rope.crane, trolley], z)

    def offset(self, p: tuple[float, float, float], theta: float | None = None) -> tuple[float, float, float]:
        """From the middle of the block to one of its points, in world axes [m]."""
        t = self.state.theta if theta is None else theta
        u, v, w = p
        return (u, v * math.cos(t) + w * math.sin(t), w * math.cos(t) - v * math.sin(t))

    def place(self, lug: str) -> tuple[float, float, float]:
        """World position of a lug [m]."""
        x, y, z = self.offset(self.block.lugs[lug])
        return (self.state.at[0] + x, self.state.at[1] + y, self.state.at[2] + z)

    def carriers(self) -> dict[str, list[str]]:
        """Loaders with hooked slings -> their lugs."""
        found: dict[str, list[str]] = {}
        for sling, lug in self.state.lugs.items():
            found.setdefault(self.slings[sling].loader, []).append(lug)
        return found

    def hangs_at(self, loader: str, lugs: list[str]) -> float:
        """Height of the middle of the block if it hung from this loader without slack [m]."""
        given = self._loader(loader)
        mean = sum(self.offset(self.block.lugs[lug])[2] for lug in lugs) / len(lugs)
        return self.eye(loader)[2] - given.height - given.sling - mean

    def taut(self, loaders: Iterable[str] | None = None) -> list[str]:
        """The loaders whose slings are taut, among these."""
        carriers = self.carriers()
        wanted = carriers if loaders is None else [name for name in loaders if name in carriers]
        return [name for name in wanted if self.hangs_at(name, carriers[name]) > self.state.at[2] - SLACK]

    def rest(self) -> float:
        """Height of the middle of the block when it stands on its stools [m]."""
        return self.block.supports.height + self.block.size[2] / 2

    def _loader(self, name: str) -> schema.Loader:
        assert self.scene.rig is not None
        return self.scene.rig.loaders[name]

    # what happens

    def _order(self, order: actions.Order) -> None:
        match order:
            case actions.Hookup():
                self.state = replace(self.state, lugs={**self.state.lugs, order.sling: order.lug})
                self._reach(order)
            case actions.Unhook():
                lugs = {sling: lug for sling, lug in self.state.lugs.items() if sling != order.sling}
                self.state = replace(self.state, lugs=lugs)
            case actions.Move():
                self._move(order)
                if order.until:
                    self._spoken_of(order.until)
            case actions.Turn():
                if self.state.grounded:
                    self._fault(order.where, "the block stands on its stools and cannot turn: hoist it first")
            case actions.Brake() | actions.Wait():
                pass

    def _reach(self, order: actions.Hookup) -> None:
        """A sling is hooked only if it reaches."""
        told = reach(self, order.sling, order.lug)
        if told:
            self._fault(order.where, told)

    def _move(self, move: actions.Move) -> None:
        if move.model not in self.scene.cranes:
            return
        crane = self.scene.cranes[move.model]
        loaders = self._moved_loaders(move)
        if move.verb in {"travel", "traverse"}:
            limit = crane.gantry_speed if move.verb == "travel" else crane.trolley_speed
            tied = self.taut(loaders) if self.state.grounded else []
            if tied:
                told = f"{move.model} would {move.verb} while the block stands on its stools and {tied[0]} is taut"
                self._fault(move.where, f"{told}: slacken or unhook the slings first")
        else:
            loaded = bool(self.taut(loaders)) and not self.state.grounded
            limit = crane.hoist_speed if loaded else crane.empty_hoist_speed
        if abs(move.speed) > limit * (1 + 1e-9):
            told = f"{move.verb} {abs(move.speed) * 60:g} m/min is faster than {move.model} can: {limit * 60:g} m/min"
            self._fault(move.where, told)
        now = self._coordinate(move)
        goal = move.to if move.to is not None else None if move.by is None else now + move.by
        if move.until is not None and goal is None:
            goal = self._until(move, move.until, now, loaders)
        if goal is None:
            self.told.known = False
            return
        self._set(move, goal)

    def _until(
        self, move: actions.Move, until: actions.Condition, now: float, loaders: list[str]
    ) -> float | None:
        """Where a move ends that ends on a condition; None if only the dynamics know."""
        sign = math.copysign(1.0, move.speed)
        match until:
            case actions.And():
                goals = [self._until(move, each, now, loaders) for each in until.all]
                known = [goal for goal in goals if goal is not None]
                return (max(known) if sign > 0 else min(known)) if len(known) == len(goals) else None
            case actions.After():
                return now + move.speed * until.seconds
            case actions.Slings() if move.verb in {"hoist", "lower"}:
                gap = 0.0 if until.state == "taut" else 2 * SLACK
                low = (
                    self.rest()
                    if sign > 0 and not self.state.grounded and self._all(until)
                    else self.state.at[2]
                )
                return self._length_at(loaders, low, now, gap)
            case actions.Lifted():
                return now
            case actions.Landed():
                return self._length_at(loaders, self.rest(), now, 0.0)
            case actions.Crossing() if until.threshold.quantity == "height" and until.model == "block":
                return now + self.state.at[2] - until.value
        return None

    def _all(self, until: actions.Slings) -> bool:
        hooked = set(self.state.lugs)
        return hooked <= set(until.names)

    def _length_at(self, loaders: list[str], z: float, now: float, gap: float) -> float:
        """Rope length at which the slings of a loader are just taut (gap 0) with the block at this height [m]."""
        carriers = self.carriers()
        for loader in loaders:
            if loader in carriers:
                return now + self.hangs_at(loader, carriers[loader]) - z + gap
        return now

    def _moved_loaders(self, move: actions.Move) -> list[str]:
        found = []
        for name, rope in ((r.carries, r) for r in self.ropes.values()):
            drive = plan.drive_name(rope.crane, "upper" if HOOKS[rope.hook][0] == "upper" else "lower")
            if move.actuator in {rope.name, drive, plan.drive_name(rope.crane, "gantry")}:
                found.append(name)
        return found

    def _coordinate(self, move: actions.Move) -> float:
        if move.verb == "travel":
            return self.state.cranes[move.model]
        if move.verb == "traverse":
            return self.state.trolleys[self._trolley(move)]
        return self.state.ropes[move.actuator]

    def _trolley(self, move: actions.Move) -> tuple[str, str]:
        upper = move.actuator == plan.drive_name(move.model, "upper")
        return (move.model, "upper" if upper else "lower")

    def _set(self, move: actions.Move, goal: float) -> None:
        s = self.state
        if move.verb == "travel":
            self.state = replace(s, cranes={**s.cranes, move.model: goal})
        elif move.verb == "traverse":
            self.state = replace(s, trolleys={**s.trolleys, self._trolley(move): goal})
        else:
            self.state = replace(s, ropes={**s.ropes, move.actuator: goal})

    def _turn(self, order: actions.Turn, stage: str) -> None:
        """Trolleys and winches follow the turn; the middle of mass stays where it is."""
        start, carriers, com = self.state, self.carriers(), self.block.com
        cx, cy, cz = (a + b for a, b in zip(start.at, self.offset(com), strict=True))
        for i in range(1, SAMPLES + 1):
            theta = start.theta + (order.to - start.theta) * i / SAMPLES
            trolleys, ropes = dict(start.trolleys), dict(start.ropes)
            for loader, lugs in carriers.items():
                rope = self.ropes[self.rope_of[loader]]
                before, after = self._mean(lugs, start.theta), self._mean(lugs, theta)
                trolley = (rope.crane, HOOKS[rope.hook][0])
                trolleys[trolley] = start.trolleys[trolley] + after[0] - before[0]
                ropes[rope.name] = start.ropes[rope.name] - (after[1] - before[1])
            o = self.offset(com, theta)
            at = (cx - o[0], cy - o[1], cz - o[2])
            self.state = replace(start, theta=theta, trolleys=trolleys, ropes=ropes, at=at)
            self._step(order.where, f"{stage}, {math.degrees(theta):.0f} deg", told=i % (SAMPLES // 3) == 0)

    def _mean(self, lugs: list[str], theta: float) -> tuple[float, float]:
        places = [self.offset(self.block.lugs[lug], theta) for lug in lugs]
        com = self.offset(self.block.com, theta)
        return (
            sum(p[1] for p in places) / len(places) - com[1],
            sum(p[2] for p in places) / len(places) - com[2],
        )

    def _settle(self) -> None:
        """The block goes where the taut ropes leave it: lifted, hanging, or back on its stools."""
        carriers = self.carriers()
        if not carriers:
            return
        s, rest = self.state, self.rest()
        heights = {name: self.hangs_at(name, lugs) for name, lugs in carriers.items()}
        z = max(heights.values())
        flat = abs(math.sin(s.theta)) < 0.1
        lifted = z > (s.at[2] if s.grounded else rest) + SLACK or (not s.grounded and not flat)
        if not lifted:
            self.state = replace(s, grounded=True, at=(s.at[0], s.at[1], rest)) if flat else s
            return
        held = [name for name in heights if heights[name] > z - SLACK]
        x = sum(self.eye(n)[0] - self._lug_mean(carriers[n], 0) for n in held) / len(held)
        y = sum(self.eye(n)[1] - self._lug_mean(carriers[n], 1) for n in held) / len(held)
        self.state = replace(s, grounded=False, at=(x, y, z))

    def _lug_mean(self, lugs: list[str], axis: int) -> float:
        return sum(self.offset(self.block.lugs[lug])[axis] for lug in lugs) / len(lugs)

    def _step(self, where: str, stage: str, *, told: bool = True) -> None:
        if told:
            self.told.told_stages.append(stage)
        if self.state.grounded:
            self.told.steps.append(Step(where, stage, self.state))
            return
        taut, everyone = self.taut(), list(self.carriers())
        loads, lean = shares(self._hangs(taut), self.block.mass)
        if loads is None and taut != everyone:  # the block tilts until the others carry, too
            loads, lean = shares(self._hangs(everyone), self.block.mass)
        self.told.steps.append(Step(where, stage, self.state, loads, lean))

    def _hangs(self, loaders: list[str]) -> list[Hang]:
        carriers, com = self.carriers(), self.offset(self.block.com)
        found = []
        for name in loaders:
            rope, lugs = self.ropes[self.rope_of[name]], carriers[name]
            slings = [s for s in self.slings.values() if s.loader == name and s.name in self.state.lugs]
            soft = self.state.ropes[rope.name] / rope.EA + 1 / sum(s.EA / s.L0 for s in slings)
            x, y = (self._lug_mean(lugs, axis) - com[axis] for axis in (0, 1))
            found.append(Hang(name, x, y, 1 / soft))
        return found

    def _spoken_of(self, condition: actions.Condition | None) -> None:
        """A condition on slings needs one that is hooked."""
        for term in _terms(condition):
            if isinstance(term, actions.Slings) and set(term.names) <= set(self.slings):
                hooked = [name for name in term.names if name in self.state.lugs]
                if not hooked:
                    told = f"'{term.text}' says nothing here: none of {len(term.names)} slings is hooked then"
                    self._fault(term.where, told)

    def _fault(self, where: str, sentence: str) -> None:
        self.told.faults.append((where, sentence))


def reach(at: Follower, sling: str, lug: str) -> str:
    """A sentence if a sling is too short for its lug or hangs too far beside it, else nothing."""
    given = at.slings[sling]
    eye, p = at.eye(given.loader), at.place(lug)
    beam = (eye[0] + given.beam.p[0], eye[1] + given.beam.p[1], eye[2] - at._loader(given.loader).height)
    gap = math.dist(beam, p) - given.L0
    beside = math.hypot(beam[0] - p[0], beam[1] - p[1])
    if gap <= SLACK / 10:
        return ""
    if beside > 0.05 * given.L0:
        told = (
            f"the hook stands {beside:.1f} m beside the lug {lug}, too far for the {given.L0:g} m of {sling}"
        )
        return f"{told} ({gap * 1000:.0f} mm are missing): move crane or trolley first"
    told = f"{sling} is {gap * 1000:.0f} mm too short for the lug {lug}"
    return f"{told}: lower the hook or take a longer sling than {given.L0:g} m"


def _terms(condition: actions.Condition | None) -> Iterator[actions.Condition]:
    if isinstance(condition, actions.And):
        for each in condition.all:
            yield from _terms(each)
    elif condition is not None:
        yield condition
