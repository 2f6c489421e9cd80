"""The action list followed statically: where everything stands after each action, as far as it can be known.

Ropes hang plumb and do not stretch, the block hangs from whichever loaders are taut.  Each action gives
one `Step` (a turn gives several); the checks of geometry and capacity look at the steps.  An action that
ends on a state that only the dynamics can tell (a tension, an angle) ends the following: what comes after
it is not judged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from heavylift.nodes.models.conditions import terms

from . import actions, plan, schema
from .findings import Findings
from .standing import SLACK, Standing, State, reach
from .statics import Hang, shares
from .yard import HOOKS

SAMPLES = 12  # steps of a turn


@dataclass(frozen=True)
class Step:
    """A state, the action or order that led to it, what the taut loaders carry then."""

    where: str
    stage: str
    state: State
    loads: dict[str, float] | None = None  # sling load by loader [kg]; None: nothing hangs or nothing can hold it
    lean: float = 0.0  # the centre of mass is so far from what could hold it [m]


@dataclass(frozen=True)
class Acted:
    """The state before an action, and whether a sling is taut behind it."""

    before: State
    taut: bool


@dataclass
class Following:
    """All steps, and what was found wrong on the way."""

    steps: list[Step] = field(default_factory=list)
    acted: list[Acted] = field(default_factory=list)  # for each action that could be followed
    findings: Findings = field(default_factory=Findings)
    known: bool = True
    told_stages: list[str] = field(default_factory=list)  # those a table shows: of a turn every 30 degrees or so


def follow(scene: schema.Scene, built: plan.Plan) -> Following:
    """Follows the whole action list of a scene with a block and cranes."""
    follower = Follower(scene, built)
    follower.walk()
    return follower.told


class Follower(Standing):
    """Walks through the action list and changes the state."""

    def __init__(self, scene: schema.Scene, built: plan.Plan) -> None:
        super().__init__(scene, built)
        self.told = Following()
        self.lifting = False  # by the dynamics of this action

    def walk(self) -> None:
        """Every action in turn, until one cannot be followed."""
        self.told.steps.append(Step("", "at the start", self.state))
        for number, action in enumerate(self.plan.actions, 1):
            stage = action.stage or f"action {number}"
            self._spoken_of(action.when)
            before = self.state
            for order in action.orders:
                self._order(order)
            if self.told.findings.sentences or not self.told.known:
                return
            self._settle()
            self.told.acted.append(Acted(before, bool(self.taut())))
            self._step(action.where, stage)
            for order in action.orders:
                if isinstance(order, actions.Turn):
                    self._turn(order, stage)

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
                    told = "the block stands on its stools and cannot turn: hoist it first"
                    self._fault("turn", "block", order.where, told)
            case actions.Brake() | actions.Wait():
                pass

    def _reach(self, order: actions.Hookup) -> None:
        """A sling is hooked only if it reaches."""
        told = reach(self, order.sling, order.lug)
        if told:
            self._fault("reach", self.slings[order.sling].loader, order.where, told)

    def _move(self, move: actions.Move) -> None:
        if move.model not in self.scene.cranes:
            return
        crane = self.scene.cranes[move.model]
        loaders = self._moved_loaders(move)
        if move.verb in {"travel", "traverse"}:
            limit = crane.gantry_speed if move.verb == "travel" else crane.trolley_speed
            tied = self.taut(loaders) if self.state.grounded else []
            if tied:
                told = f"{move.model} would {move.verb} while the block is on its stools and {tied[0]} taut"
                self._fault("tied", move.actuator, move.where, f"{told}: slacken or unhook the slings first")
        else:
            hangs = self.taut(loaders) and not self.state.grounded
            limit = crane.hoist_speed if hangs else crane.empty_hoist_speed
        self._fast(move, limit)
        now = self._coordinate(move)
        goal = move.to if move.to is not None else None if move.by is None else now + move.by
        if move.until is not None and goal is None:
            goal = self._until(move, move.until, now, loaders)
        if goal is None:
            self.told.known = False
            return
        self._set(move, goal)
        seen = any(isinstance(term, actions.Lifted) for term in terms(move.until))
        if move.verb == "hoist" and self.state.grounded and (seen or self.above(loaders)):
            self._fast(move, crane.hoist_speed, " with a load")

    def _fast(self, move: actions.Move, limit: float, how: str = "") -> None:
        """No actuator is faster than it can."""
        if abs(move.speed) > limit * (1 + 1e-9):
            told = f"{move.verb} {abs(move.speed) * 60:g} m/min is faster than {move.model} can{how}"
            self._fault("speed", move.actuator, move.where, f"{told}: {limit * 60:g} m/min")

    def _until(self, move: actions.Move, until: actions.Condition, now: float, loaders: list[str]) -> float | None:
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
                low = self.rest() if sign > 0 and not self.state.grounded and self._all(until) else self.state.at[2]
                return self._length_at(loaders, low, now, gap)
            case actions.Lifted():
                self.lifting = True
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
        """Rope length with the slings just taut (gap 0) and the block at this height [m]."""
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
        """Trolleys and winches follow the turn; the centre of mass stays where it is."""
        start, carriers, com = self.state, self.carriers(), self.block.com
        before = self.offset(com)
        cx, cy, cz = (a + b for a, b in zip(start.at, before, strict=True))
        for i in range(1, SAMPLES + 1):
            theta = start.theta + (order.to - start.theta) * i / SAMPLES
            after, trolleys, ropes = self.offset(com, theta), dict(start.trolleys), dict(start.ropes)
            for loader, lugs in carriers.items():
                rope = self.ropes[self.rope_of[loader]]
                old, new = self.mean(lugs, start.theta), self.mean(lugs, theta)
                trolley = (rope.crane, HOOKS[rope.hook][0])
                y = start.trolleys[trolley] + (new[1] - after[1]) - (old[1] - before[1])
                if abs(trolleys[trolley] - y) > SLACK and trolleys[trolley] != start.trolleys[trolley]:
                    told = f"the {trolley[1]} trolley of {rope.crane} cannot follow a turn"
                    self._fault("one", rope.crane, order.where, f"{told}: its hooks carry different lugs")
                trolleys[trolley] = y
                ropes[rope.name] = start.ropes[rope.name] - (new[2] - after[2]) + (old[2] - before[2])
            last, at = self.state, (cx - after[0], cy - after[1], cz - after[2])
            self.state = replace(start, theta=theta, trolleys=trolleys, ropes=ropes, at=at)
            self._turn_speeds(order, last, abs(order.to - start.theta) / SAMPLES / order.rate)
            told_here = i % (SAMPLES // 3) == 0
            self._step(order.where, f"{stage}, {math.degrees(theta):.0f} deg", told=told_here)

    def _turn_speeds(self, order: actions.Turn, last: State, seconds: float) -> None:
        """No winch and no trolley has to follow faster than it can."""
        for rope in self.ropes.values():
            crane = self.scene.cranes[rope.crane]
            trolley = (rope.crane, HOOKS[rope.hook][0])
            wound = self.state.ropes[rope.name] - last.ropes[rope.name]
            moved = self.state.trolleys[trolley] - last.trolleys[trolley]
            ways = (rope.name, wound, crane.hoist_speed), (" ".join(trolley), moved, crane.trolley_speed)
            for name, way, limit in ways:
                if seconds > 0 and abs(way) / seconds > limit * (1 + 1e-9):
                    told = f"{name} would have to follow the turn at {abs(way) / seconds * 60:.1f} m/min"
                    self._fault("follow", name, order.where, f"{told}, it can {limit * 60:g} m/min")

    def _settle(self) -> None:
        """The block goes where the taut ropes leave it: lifted, hanging, or back on its stools."""
        carriers = self.carriers()
        if not carriers:
            return
        s, rest = self.state, self.rest()
        heights = {name: self.hangs_at(name, lugs) for name, lugs in carriers.items()}
        z = max(heights.values())
        flat = abs(math.sin(s.theta)) < 0.1
        lifted = self.lifting or z > (s.at[2] if s.grounded else rest) + SLACK
        lifted, self.lifting = lifted or not (s.grounded or flat), False
        if not lifted:
            self.state = replace(s, grounded=True, at=(s.at[0], s.at[1], rest)) if flat else s
            return
        held = [name for name in heights if heights[name] > z - SLACK]
        x = sum(self.eye(n)[0] - self.mean(carriers[n])[0] for n in held) / len(held)
        y = sum(self.eye(n)[1] - self.mean(carriers[n])[1] for n in held) / len(held)
        self.state = replace(s, grounded=False, at=(x, y, z))

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
            mean = self.mean(lugs)
            found.append(Hang(name, mean[0] - com[0], mean[1] - com[1], 1 / soft))
        return found

    def _spoken_of(self, condition: actions.Condition | None) -> None:
        """A condition on slings needs one that is hooked."""
        for term in terms(condition):
            if isinstance(term, actions.Slings) and set(term.names) <= set(self.slings):
                hooked = [name for name in term.names if name in self.state.lugs]
                if not hooked:
                    told = f"'{term.text}' says nothing here: none of {len(term.names)} slings is hooked then"
                    self._fault("empty", term.text, term.where, told)

    def _fault(self, check: str, subject: str, where: str, sentence: str) -> None:
        """Takes a fault of this action; of several subjects with one trouble the first is told in full."""
        told = iter([(subject, where, sentence)])
        self.told.findings.take(f"{where} {check}", told, where=where)
