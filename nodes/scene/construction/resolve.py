"""The action list with every target resolved to its actors: phrases become orders of the plan.

Two orders of one action for the same actor contradict each other and are refused.
"""

from __future__ import annotations

from heavylift.nodes.plan import actions, plan
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.language import phrases
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Fault, Path

from .conditions import Conditions
from .targets import Actor, targets
from .yard import Yard, by_beam

TURN_TIME = 20.0  # a turn without `ramp` reaches its rate in this time [s]


def build_actions(yard: Yard, mechanism: plan.Mechanism | None) -> tuple[plan.Action, ...]:
    """The action list of the plan; what is wrong is added to the faults of the scene."""
    resolver = _Resolver(yard, mechanism)
    return tuple(resolver.action(i, action) for i, action in enumerate(yard.scene.actions))


def build_orders(
    yard: Yard, mechanism: plan.Mechanism | None, path: Path, target: str, phrase: phrases.OrderPhrase
) -> tuple[actions.Order, ...]:
    """One order to a target; what is wrong is added to the faults of the yard's source."""
    resolver = _Resolver(yard, mechanism)
    words = target if target in resolver.targets else target.replace(".", " ", 1)  # events say "west.H1"
    return tuple(resolver.orders(path, words, phrase))


class _Resolver:
    """Walks through the action list once."""

    def __init__(self, yard: Yard, mechanism: plan.Mechanism | None) -> None:
        self.yard, self.mechanism = yard, mechanism
        self.targets = targets(yard, mechanism)
        self.lugs = {lug.name: lug.p for lug in yard.block.lugs} if yard.block else {}
        self.condition = Conditions(yard, mechanism).read

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
        return plan.Action(stage=action.stage, when=when, timeout=action.timeout, orders=tuple(orders), where=where)

    def orders(self, path: Path, target: str, phrase: phrases.OrderPhrase) -> list[actions.Order]:
        return self._orders(path, self._actors(path, target, phrase), phrase)

    def _actors(self, path: Path, target: str, phrase: phrases.OrderPhrase) -> tuple[Actor, ...]:
        words = " ".join(target.split())
        found = self.targets.get(words)
        if found is None:
            known = [*self.targets, "stage", "when", "timeout"]
            self._fault(path, f"there is no '{target}' to give an order to", closest(words, known), on_key=True)
            return ()
        verb = _verb(phrase)
        if found and found[0].kind not in VERBS[verb].kinds:
            fitting = [fit.name for fit in VERBS.values() if found[0].kind in fit.kinds]
            self._fault(path, f"'{target}' cannot {verb}", f"it can: {', '.join(fitting)}")
            return ()
        return found

    def _orders(self, path: Path, found: tuple[Actor, ...], phrase: phrases.OrderPhrase) -> list[actions.Order]:
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
                engaged = VERBS[phrase.verb].engages
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
        sign = float(VERBS[phrase.verb].sign or 1)
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
                actions.Hookup(sling=s, lug=lug, where=where) for s, lug in zip(slings[i : i + 2], pair, strict=True)
            ]
        return orders

    def _slings_of(self, actor: Actor) -> list[str]:
        return [s.name for s in self.yard.slings if s.loader == actor.loader]

    def _alone(self, path: Path, orders: dict[str, phrases.OrderPhrase]) -> None:
        for target, phrase in orders.items():
            if isinstance(phrase, phrases.Motion) and VERBS[phrase.verb].along != "x":
                told = f"'{target}' must not {phrase.verb} while the block turns: it follows the turn"
                self._fault((*path, target), told, on_key=True)

    def _fault(self, path: Path, sentence: str, hint: str = "", *, on_key: bool = False, column: int = 0) -> None:
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
