"""The action list with every target resolved to its actors: phrases become orders of the plan.

All targets that a scene understands stand in one table (name -> actors), so that an unknown target is answered with
the nearest known one.  Two orders of one action for the same actor contradict each other and are refused, as is a
condition over nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from heavylift.kernel.describe import Point, Threshold

from . import actions, phrases, plan, schema
from .faults import closest
from .machines import Yard, by_beam
from .source import Fault, Path

Kind = Literal["gantry", "trolley", "hook", "block", "drive", "winch", "brake", "none"]
KINDS: dict[str, tuple[Kind, ...]] = {
    "travel": ("gantry",),
    "traverse": ("trolley",),
    "hoist": ("hook", "winch"),
    "lower": ("hook", "winch"),
    "drive": ("drive",),
    "turn": ("block",),
    "hook": ("hook",),
    "unhook": ("hook",),
    "lock": ("hook",),
    "unlock": ("hook",),
    "engage": ("brake",),
    "release": ("brake",),
    "wait": ("none",),
}
TURN_TIME = 20.0  # a turn without `ramp` reaches its rate in this time [s]


@dataclass(frozen=True)
class Actor:
    """Something an order can address: the model that has it, its name there, and its ramp [m/s2 or rad/s2]."""

    kind: Kind
    model: str
    name: str
    accel: float = 0.0
    loader: str = ""


def build_actions(yard: Yard, mechanism: plan.Mechanism | None) -> tuple[plan.Action, ...]:
    """The action list of the plan; what is wrong is added to the faults of the scene."""
    resolver = _Resolver(yard, mechanism)
    return tuple(resolver.action(i, action) for i, action in enumerate(yard.scene.actions))


def targets(yard: Yard, mechanism: plan.Mechanism | None) -> dict[str, tuple[Actor, ...]]:
    """Every target of this scene with its actors."""
    table: dict[str, tuple[Actor, ...]] = {}
    on_hook = {(c, h): loader for loader, (c, h) in yard.hooks.items()}
    hooks: dict[str, Actor] = {}
    for crane in yard.cranes:
        table[crane.name] = (
            Actor("gantry", crane.name, plan.drive_name(crane.name, "gantry"), crane.gantry.accel),
        )
        for trolley in (crane.upper, crane.lower):
            drive = plan.drive_name(crane.name, trolley.name)
            actor = Actor("trolley", crane.name, drive, trolley.axis.accel)
            table[f"{crane.name} {trolley.name} trolley"] = (actor,)
        for hook in crane.hooks:
            loader = on_hook[crane.name, hook.name]
            hooks[loader] = Actor("hook", crane.name, hook.rope, hook.accel, loader)
            table[f"{crane.name} {hook.name}"] = table[loader] = (hooks[loader],)
    for group, loaders in yard.groups.items():
        table[f"{group} hooks"] = tuple(hooks[loader] for loader in loaders if loader in hooks)
    if yard.cranes:
        table["cranes"] = tuple(table[c.name][0] for c in yard.cranes)
        for which in ("upper", "lower"):
            table[f"{which} trolleys"] = tuple(table[f"{c.name} {which} trolley"][0] for c in yard.cranes)
        table["trolleys"] = table["upper trolleys"] + table["lower trolleys"]
        table["hooks"] = tuple(hooks.values())
    for plural in ("cranes", "upper trolleys", "lower trolleys", "trolleys", "hooks"):
        if plural in table:
            table[f"all {plural}"] = table[plural]
    if yard.block:
        table["block"] = (Actor("block", "block", "turn"),)
    if mechanism:
        winches = {r.name for r in mechanism.system.ropes if r.winch}
        for actuator in mechanism.actuators:
            kind: Kind = "winch" if actuator.name in winches else "drive"
            table[actuator.name] = (Actor(kind, mechanism.name, actuator.name, actuator.accel),)
        for brake in mechanism.system.brakes:
            table[brake.name] = (Actor("brake", mechanism.name, brake.name),)
    table["wait"] = (Actor("none", "", "wait"),)
    return table


class _Resolver:
    """Walks through the action list once."""

    def __init__(self, yard: Yard, mechanism: plan.Mechanism | None) -> None:
        self.yard, self.mechanism = yard, mechanism
        self.targets = targets(yard, mechanism)
        self.lugs = {lug.name: lug.p for lug in yard.block.lugs} if yard.block else {}
        self.thresholds = 0

    def action(self, index: int, action: schema.Action) -> plan.Action:
        path: Path = ("actions", index)
        orders: list[actions.Order] = []
        busy: dict[str, str] = {}
        for target, phrase in action.orders.items():
            found = self._actors((*path, target), target, phrase)
            for actor in found:
                other = busy.setdefault(f"{actor.model} {actor.name}", target)
                if other != target:
                    told = f"'{other}' and '{target}' give {actor.name} two orders at the same time"
                    self._fault((*path, target), told, on_key=True)
            orders += self._orders((*path, target), found, phrase)
        if "block" in action.orders and isinstance(action.orders["block"], phrases.Turning):
            self._alone(path, action.orders)
        when = None if action.when is None else self.condition((*path, "when"), action.when)
        where = self.yard.source.where(path)
        return plan.Action(
            stage=action.stage, when=when, timeout=action.timeout, orders=tuple(orders), where=where
        )

    def condition(self, path: Path, test: phrases.Test) -> actions.Condition:
        """A condition with its names resolved."""
        where, text = self.yard.source.where(path), test.text
        match test:
            case phrases.AllTests():
                parts = tuple(self.condition(path, each) for each in test.tests)
                return actions.And(all=parts, where=where, text=text)
            case phrases.AfterTest():
                return actions.After(seconds=test.seconds, where=where, text=text)
            case phrases.DoneTest():
                return actions.MovesDone(verbs=test.verbs, where=where, text=text)
            case phrases.GroundTest():
                model = self._standing(path, test)
                kind = actions.Lifted if test.state == "lifted" else actions.Landed
                return kind(model=model, where=where, text=text)
            case phrases.SlingTest():
                names = self._ropes(path, test.of, test.noun, test.column)
                return actions.Slings(names=names, each=test.each, state=test.state, where=where, text=text)
            case phrases.CrossTest():
                return self._crossing(path, test, where)

    # orders

    def _actors(self, path: Path, target: str, phrase: phrases.OrderPhrase) -> tuple[Actor, ...]:
        words = " ".join(target.split())
        found = self.targets.get(words)
        if found is None:
            known = [*self.targets, "stage", "when", "timeout"]
            self._fault(
                path, f"there is no '{target}' to give an order to", closest(words, known), on_key=True
            )
            return ()
        verb = _verb(phrase)
        if found and found[0].kind not in KINDS[verb]:
            fitting = [v for v, kinds in KINDS.items() if found[0].kind in kinds]
            self._fault(path, f"'{target}' cannot {verb}", f"it can: {', '.join(fitting)}")
            return ()
        return found

    def _orders(
        self, path: Path, found: tuple[Actor, ...], phrase: phrases.OrderPhrase
    ) -> list[actions.Order]:
        where = self.yard.source.where(path)
        if not found:
            return []
        match phrase:
            case phrases.Waiting():
                return [actions.Wait(seconds=phrase.seconds, where=where)]
            case phrases.Turning():
                until = None if phrase.until is None else self.condition(path, phrase.until)
                accel = phrase.ramp or phrase.rate / TURN_TIME
                return [actions.Turn(rate=phrase.rate, accel=accel, to=phrase.to, until=until, where=where)]
            case phrases.Hooking():
                return self._hookups(path, found, phrase, where)
            case phrases.Simple("unhook"):
                return [actions.Unhook(sling=s, where=where) for a in found for s in self._slings_of(a)]
            case phrases.Simple():
                engaged = phrase.verb in {"lock", "engage"}
                return [
                    actions.Brake(
                        model=actor.loader or actor.model,
                        brake=f"{actor.loader}.hinge.lock" if actor.loader else actor.name,
                        engaged=engaged,
                        where=where,
                    )
                    for actor in found
                ]
            case phrases.Motion():
                until = None if phrase.until is None else self.condition(path, phrase.until)
                return [self._move(path, actor, phrase, until, where) for actor in found]

    def _move(
        self,
        path: Path,
        actor: Actor,
        phrase: phrases.Motion,
        until: actions.Condition | None,
        where: str,
    ) -> actions.Move:
        winding = actor.kind in {"hook", "winch"}
        if phrase.to is not None and winding != phrase.of_rope:
            told = f"'to' needs a position, '{actor.name}' has no rope"
            if winding:
                told = "a winch knows the length of its rope, not a height: write 'to 61 m of rope'"
            self._fault(path, told)
        sign = -1.0 if phrase.verb == "hoist" else 1.0
        endless = phrase.by is None and phrase.to is None
        by = None if phrase.by is None else (sign if winding else 1.0) * phrase.by
        return actions.Move(
            verb=phrase.verb,
            model=actor.model,
            actuator=actor.name,
            speed=sign * phrase.speed if endless else phrase.speed,
            accel=phrase.ramp or actor.accel,
            by=by,
            to=phrase.to,
            until=until,
            where=where,
        )

    def _hookups(
        self, path: Path, found: tuple[Actor, ...], phrase: phrases.Hooking, where: str
    ) -> list[actions.Order]:
        slings = [s for actor in found for s in self._slings_of(actor)]
        unknown = [lug for lug in phrase.lugs if lug not in self.lugs]
        for lug in unknown:
            self._fault(path, f"the block has no lug '{lug}'", closest(lug, self.lugs))
        if unknown:
            return []
        if len(set(phrase.lugs)) != len(slings):
            told = f"{len(slings)} slings need {len(slings)} different lugs, not {len(set(phrase.lugs))}"
            self._fault(path, told)
            return []
        orders: list[actions.Order] = []
        for i in range(0, len(slings), 2):
            pair = by_beam(list(phrase.lugs[i : i + 2]), {lug: self.lugs[lug][0] for lug in phrase.lugs})
            orders += [
                actions.Hookup(sling=s, lug=lug, where=where)
                for s, lug in zip(slings[i : i + 2], pair, strict=True)
            ]
        return orders

    def _slings_of(self, actor: Actor) -> list[str]:
        return [s.name for s in self.yard.slings if s.loader == actor.loader]

    def _alone(self, path: Path, orders: dict[str, phrases.OrderPhrase]) -> None:
        for target, phrase in orders.items():
            if isinstance(phrase, phrases.Motion) and phrase.verb != "travel":
                told = f"'{target}' must not {phrase.verb} while the block turns: trolleys and winches follow the turn"
                self._fault((*path, target), told, on_key=True)

    # conditions

    def _ropes(self, path: Path, of: str, noun: str, column: int) -> tuple[str, ...]:
        """The names of a set of slings or ropes; empty sets are faults."""
        slings, ropes = [s.name for s in self.yard.slings], [r.name for r in self.yard.ropes]
        if self.mechanism:
            ropes += [r.name for r in self.mechanism.system.ropes]
        sets: dict[str, Iterable[str]] = {}
        if noun == "one":
            sets = {name: [name] for name in (*slings, *ropes)}
        elif noun == "ropes":
            sets = {"": ropes, **{name: [name] for name in ropes}}
        else:
            loaders = {name: (name,) for name in self.yard.hooks}
            sets = {"": slings}
            for name, members in {**loaders, **self.yard.groups}.items():
                sets[name] = [s.name for s in self.yard.slings if s.loader in members]
        if of not in sets:
            what = "rope or sling" if noun == "one" else f"set of {noun}"
            self._fault(
                path, f"there is no {what} '{of}'", closest(of, [s for s in sets if s]), column=column
            )
            return ()
        names = tuple(sets[of])
        if not names:
            told = f"this scene has no {noun}: a condition over nothing says nothing"
            self._fault(path, told, column=column)
        return names

    def _standing(self, path: Path, test: phrases.GroundTest) -> str:
        if self.yard.block:
            return "block"
        if self.mechanism and self.mechanism.system.supports:
            return self.mechanism.name
        self._fault(
            path, f"nothing in this scene can be {test.state}: it has no supports", column=test.column
        )
        return ""

    def _crossing(self, path: Path, test: phrases.CrossTest, where: str) -> actions.Condition:
        self.thresholds += 1
        name = f"{test.quantity}-{self.thresholds}"
        model, threshold = self._threshold(path, test, name)
        threshold = threshold or Threshold(name, "height")
        return actions.Crossing(
            model=model,
            threshold=threshold,
            value=test.value,
            rising=test.rising,
            where=where,
            text=test.text,
        )

    def _threshold(self, path: Path, test: phrases.CrossTest, name: str) -> tuple[str, Threshold | None]:
        of, system = test.of, self.mechanism.system if self.mechanism else None
        at = self.mechanism.name if self.mechanism else ""
        known: list[str] = []
        if test.quantity in {"angle", "height"} and self.yard.block:
            known.append("block")
            if of in {"", "block"}:
                point = Point("block") if test.quantity == "height" else None
                kind: Literal["height", "angle"] = "height" if test.quantity == "height" else "angle"
                return "block", Threshold(name, kind, of="block", point=point)
        if test.quantity == "height":
            bodies = [body.name for body in system.bodies] if system else []
            known += [*self.yard.hooks, *bodies]
            if of in self.yard.hooks:
                return of, Threshold(name, "height", point=Point(f"{of}.upper"))
            if of in bodies:
                return at, Threshold(name, "height", point=Point(of))
        if test.quantity in {"position", "speed"}:
            joints = [joint.name for joint in system.joints] if system else []
            known += joints
            if of in joints:
                return at, Threshold(name, "joint" if test.quantity == "position" else "speed", of=of)
        if test.quantity in {"tension", "length"}:
            return self._rope_threshold(path, test, name)
        told = f"'{test.quantity}' of what?" if not of else f"there is no '{of}' with {test.quantity}"
        self._fault(path, told, closest(of, known), column=test.column)
        return "", None

    def _rope_threshold(self, path: Path, test: phrases.CrossTest, name: str) -> tuple[str, Threshold | None]:
        *front, last = test.of.split() or [""]
        noun = last if last in {"slings", "ropes"} else "one"
        ropes = self._ropes(path, " ".join(front) if noun != "one" else test.of, noun, test.column)
        if not ropes:
            return "", None
        owners = {s.name: s.loader for s in self.yard.slings} | {r.name: r.crane for r in self.yard.ropes}
        models = {owners.get(rope, self.mechanism.name if self.mechanism else "") for rope in ropes}
        model = models.pop() if len(models) == 1 else "block"
        kind: Literal["tension", "length"] = "tension" if test.quantity == "tension" else "length"
        return model, Threshold(name, kind, ropes=ropes)

    def _fault(
        self, path: Path, sentence: str, hint: str = "", *, on_key: bool = False, column: int = 0
    ) -> None:
        self.yard.source.faults.append(Fault(path, sentence, hint, on_key, column))


def _verb(phrase: phrases.OrderPhrase) -> str:
    match phrase:
        case phrases.Motion() | phrases.Simple():
            return phrase.verb
        case phrases.Turning():
            return "turn"
        case phrases.Hooking():
            return "hook"
        case phrases.Waiting():
            return "wait"
