"""The action list with every target resolved to its actors: phrases become orders of the plan.

Two orders in one action to the same actor contradict each other and are refused.
"""

from importlib import import_module

import msgspec
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.plan.connections import ties_on
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene.construction.rigging.edges import Sling, key_of, lugs_of, slings_of
from heavylift.nodes.scene.keys.actions import ActionLine
from heavylift.nodes.scene.keys.schema import ORDERED
from heavylift.nodes.scene.language import phrases
from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .environment.touching import landings, touches
from .levelling import Levelling, follow
from .scene_builder import SceneBuilder, by_beam, ramp_of
from .signals import Conditions, wrong_units
from .targets import OrderTarget, targets

ROUNDING = 1e-9  # relative, of a speed
TURN_TIME = 20.0  # a turn without `ramp` reaches its rate in this time [s]


def build_actions(builder: SceneBuilder) -> tuple[plan.Action, ...]:
    """Return the action list of the plan; errors are added to the scene."""
    resolver = _Resolver(builder)
    return tuple(x for i, action in enumerate(builder.scene.actions) for x in resolver.listed(i, action))


def build_orders(
    builder: SceneBuilder, path: Path, target: str, phrase: phrases.OrderPhrase
) -> tuple[actions.Order, ...]:
    """Return the orders that a phrase gives to a target during a run; errors are added to the scene.

    An order to unhook names all lugs where a sling can hang, because only the commander knows the present lug."""
    resolver = _Resolver(builder)
    resolver.hangs = {rope for slings in resolver.rigged.values() for rope in slings}
    words = target if target in resolver.targets else target.replace(".", " ", 1)  # events say "west.H1"
    return tuple(resolver.orders(path, words, phrase))


class _Resolver:
    """Resolves the action list from first to last, since orders depend on the state that earlier actions leave."""

    def __init__(self, builder: SceneBuilder) -> None:
        self.yard, self.source = builder, builder.source
        self.targets = targets(builder)
        self.lugs = lugs_of(builder.scene)
        self.conditions = Conditions(builder)
        self.condition = self.conditions.read
        self.levelling = Levelling(builder, self.conditions)
        self.turned = ""  # the block that is
        self.rigged = {x: slings for name in builder.scene.rigging for x, slings in self._entries(name).items()}
        self.held = {rope for slings in self.rigged.values() for rope, x in slings.items() if x.holds in self.lugs}
        self.hangs = {rope for slings in self.rigged.values() for rope, x in slings.items() if x.hooked}
        self.loose = set[str]()  # tugger lines that are

    def listed(self, index: int, action: ActionLine) -> list[plan.Action]:
        """Return the actions of the plan for one action of the scene; orders such as levelling need several."""
        first, after = self.action(index, action), list[tuple[actions.Order, ...]]()
        for target, phrase in action.orders.items():
            path: Path = ("actions", index, target)
            match VERBS[phrase.verb].becomes:
                case "level" if found := self._actors(path, target, phrase):
                    hooks = [actor for hook in phrase.hooks for actor in self.targets.get(hook, ())]
                    now, *later = self.levelling.moves(path, phrase, found[0].model, hooks) or [()]
                    first = msgspec.structs.replace(first, orders=(*first.orders, *now))
                    after += later
                case "stop" if phrase.height:
                    first = self._keeps(path, self._actors(path, target, phrase), first)
                case "stop" if VERBS[phrase.verb].engages:
                    after.append(self._brakes(path, self._actors(path, target, phrase)))
        self.levelling.follow(first.orders)
        return [first, *(plan.Action(orders=orders, where=first.where) for orders in after if orders)]

    def _brakes(self, path: Path, found: tuple[OrderTarget, ...]) -> tuple[actions.Order, ...]:
        """Return orders that engage the brakes of drives stopped by `hold`."""
        systems = [(machine.name, machine.system) for machine in self.yard.machines]
        names = {actor.name for actor in found}
        joints = {drive.joint for _, system in systems for drive in system.drives if drive.name in names}
        brakes = [(name, brake.name) for name, system in systems for brake in system.brakes if brake.joint in joints]
        where = self.source.where(path)
        return tuple(actions.BrakeOrder(model=m, brake=b, engaged=True, where=where) for m, b in brakes)

    def _keeps(self, path: Path, found: tuple[OrderTarget, ...], action: plan.Action) -> plan.Action:
        """Return the action with luffing moves during which the given winches keep their hooks at the same height."""
        luffs = [x for x in action.orders if isinstance(x, actions.Move) and x.verb == "luff"]
        for actor in found:
            move = next((x for x in luffs if x.model == actor.model), None)
            if move is None:
                message = f"'{actor.name}' holds its height while its boom luffs: let it luff in the same action"
                self.source.fault(path, message)
                continue
            kept = follow(self.yard.machines, move, actor.name, self.source.where(path))
            if isinstance(kept, str):
                self.source.fault(path, kept)
                continue
            led = msgspec.structs.replace(move, keeps=(*move.keeps, kept))
            action = msgspec.structs.replace(action, orders=tuple(led if x == move else x for x in action.orders))
        return action

    def action(self, index: int, action: ActionLine) -> plan.Action:
        path: Path = ("actions", index)
        orders: list[actions.Order] = []
        busy: dict[str, str] = {}
        for target, phrase in action.orders.items():
            here = (*path, target)
            found = self._actors(here, target, phrase)
            for actor in found:
                other = busy.setdefault(f"{actor.model} {actor.name}", target)
                if other != target:
                    both = f"'{other}' and '{target}' give {actor.name} two orders at the same time"
                    self.source.fault(here, both, on_key=True)
            off = {x.sling for x in orders if isinstance(x, actions.UnhookSling)}  # by a hook, and by its own name
            orders += [x for x in self._orders(here, found, phrase) if getattr(x, "sling", "") not in off]
        for target, phrase in action.orders.items() if any(isinstance(x, actions.Turn) for x in orders) else ():
            if VERBS[phrase.verb].becomes == "move" and VERBS[phrase.verb].along != "x":
                follows = f"'{target}' must not {phrase.verb} while the block turns: it follows the turn"
                self.source.fault((*path, target), follows, on_key=True)
        when, where = self.condition((*path, "when"), action.when), self.source.where(path)
        made = plan.Action(stage=action.stage, when=when, timeout=action.timeout, orders=tuple(orders), where=where)
        may = (*touches(self.source, path, action.may_touch), *landings(self.yard, path, action))
        return msgspec.structs.replace(made, may_touch=may)

    def orders(self, path: Path, target: str, phrase: phrases.OrderPhrase) -> list[actions.Order]:
        return self._orders(path, self._actors(path, target, phrase), phrase)

    def _actors(self, path: Path, target: str, phrase: phrases.OrderPhrase) -> tuple[OrderTarget, ...]:
        words = " ".join(target.split())
        found = self.targets.get(words)
        machines = tuple(dict.fromkeys(actor.model for actor in found or ()))
        whole = words in machines or words.removeprefix("all ") == "cranes"
        if found and whole and VERBS[phrase.verb].becomes == "stop":
            found = tuple(actor for machine in machines for actor in self.of_machine(machine))
        if found is None:
            known = [*self.targets, "stage", "when", "timeout", "may touch"]
            self.source.fault(path, f"there is no '{target}' to give an order to", closest(words, known), on_key=True)
            return ()
        obeying = tuple(actor for actor in found if actor.obeys(VERBS[phrase.verb]))
        if found and not obeying:
            fitting = [fit.name for fit in VERBS.values() if any(actor.obeys(fit) for actor in found)]
            why = ": no drive moves a hook along y" if VERBS[phrase.verb].becomes == "turn" else ""
            self.source.fault(path, f"'{target}' cannot {phrase.verb}{why}", f"it can: {', '.join(fitting)}")
        return obeying

    def of_machine(self, machine: str) -> tuple[OrderTarget, ...]:
        """Return all targets of a machine that accept the order to stop."""
        found = (actor for actors in self.targets.values() for actor in actors if actor.model == machine)
        return tuple({actor.name: actor for actor in found if actor.obeys(VERBS["stop"])}.values())

    def _orders(self, path: Path, found: tuple[OrderTarget, ...], phrase: phrases.OrderPhrase) -> list[actions.Order]:
        if not found:
            return []
        where, verb = self.source.where(path), VERBS[phrase.verb]
        if (slings := self.rigged.get(str(path[-1]))) and verb.becomes in ("hook", "unhook", "release"):
            return self._rigging(path, slings, phrase, where)
        until = self.condition(path, phrase.until)
        match verb.becomes:
            case "own":
                return [*import_module(verb.module).orders(found, phrase, where)]
            case "wait":
                return [actions.Wait(seconds=phrase.seconds, where=where)]
            case "turn":
                accel = phrase.ramp if isinstance(phrase.ramp, float) else phrase.speed / TURN_TIME
                to = phrase.to or 0.0
                block = found[0].model
                if self.turned not in ("", block):
                    message = f"'{self.turned}' is turned before, and one list can turn only one block"
                    self.source.fault(path, f"{message}: leave '{block}' as it is")
                self.turned = block
                return [actions.Turn(block=block, rate=phrase.speed, accel=accel, to=to, until=until, where=where)]
            case "begin":
                (lift,) = found
                if self.yard.scene.lifts[lift.name].start != ORDERED:
                    self.source.fault(path, f"{lift.name} begins by itself: write `start: {ORDERED}` there")
                return [actions.Begin(lift=lift.name, where=where)]
            case "hook":
                return self._hookups(path, found, phrase, where)
            case "unhook":
                off = [*dict.fromkeys(s for a in found for s in self._slings_of(a))]
                if not off:
                    self.source.fault(path, f"nothing hangs on {found[0].name} that could be unhooked")
                self.hangs -= {*off}
                self.loose |= {a.name for a in found if a.kind == "tugger"}
                return [actions.UnhookSling(sling=s, where=where) for s in off]
            case "level":
                return []
            case "stop" if phrase.height:
                if path[0] != "actions":
                    self.source.fault(path, "only an action of the list can let a hook hold its height")
                return []
            case "stop":
                return self._stops(path, found, phrase, where)
            case "brake" | "release":
                if found[0].kind in ("sling", "rope", "tugger"):
                    self.loose |= {a.name for a in found if a.kind == "tugger"}
                    return [actions.UnhookSling(sling=a.name, parted=True, where=where) for a in found]
                locks = {m.name: [latch.brake for latch in m.latches] for m in self.yard.machines}
                brakes = ((a.beam or a.model, b) for a in found for b in (locks[a.beam] if a.beam else [a.name]))
                return [actions.BrakeOrder(model=m, brake=b, engaged=verb.engages, where=where) for m, b in brakes]
            case "move":
                if isinstance(phrase.ramp, phrases.SwingRamp) and found[0].kind in ("hook", "winch"):
                    self.source.fault(path, f"{verb.name} causes no swing: write an acceleration after 'ramp'")
                moves = [self._move(path, actor, phrase, until, where) for actor in found]
                return [*(self._together(path, moves) if phrase.together else moves)]

    def _move(
        self, path: Path, actor: OrderTarget, phrase: phrases.OrderPhrase, until: actions.Condition | None, where: str
    ) -> actions.Move:
        winding = actor.kind in {"hook", "winch"}
        if phrase.to is not None and winding != phrase.of_rope:
            how = "a winch knows the length of its rope, not a height: write 'to 61 m of rope'"
            self.source.fault(path, how if winding else f"'to' needs a position, '{actor.name}' has no rope")
        for lug in (lug for lug in phrase.above if lug not in self.lugs):
            self.source.fault(path, f"the block has no lug '{lug}'", closest(lug, self.lugs))
        if phrase.turning != actor.turns:
            self.source.fault(path, f"'{actor.name}' {wrong_units(turns=actor.turns)}")
        elif actor.speed is not None and phrase.speed > actor.speed * (1.0 + ROUNDING):
            of = units.RATE if actor.turns else units.TENSION_RATE if actor.kind == "tugger" else units.SPEED
            most = of.show(actor.speed)
            self.source.fault(path, f"'{actor.name}' can {phrase.verb} at {most} at most")
        if actor.name in self.loose:
            self.source.fault(path, f"'{actor.name}' was released by an earlier order, so it cannot pull")
        if actor.kind == "tugger" and (phrase.to or 0.0) < 0.0:
            self.source.fault(path, f"'{actor.name}' is a line, which cannot push: order a tension of 0 kN or more")
        sign = float(VERBS[phrase.verb].sign or 1)
        endless = phrase.by is None and phrase.to is None and not phrase.above
        ramp, pulses = ramp_of(phrase.ramp) if phrase.ramp else (actor.accel, actor.pulses)
        return actions.Move(
            verb=phrase.verb, model=actor.model, actuator=actor.name,
            speed=sign * phrase.speed if endless else phrase.speed, accel=ramp, pulses=pulses,
            by=None if phrase.by is None else (sign if winding else 1.0) * phrase.by, to=phrase.to, above=phrase.above,
            until=until, where=where,
        )  # fmt: skip

    def _entries(self, name: str) -> dict[str, dict[str, Sling]]:
        """Return, by name, all ropes of a rigging entry, and for each of its slings the ropes that represent its
        possible attachments."""
        ropes = slings_of(self.yard.scene, name)
        several = {rope: {x: y for x, y in ropes.items() if y.number == sling.number} for rope, sling in ropes.items()}
        return {name: ropes} | {rope: each for rope, each in several.items() if ropes[rope].hooked}

    def _rigging(
        self, path: Path, slings: dict[str, Sling], phrase: phrases.OrderPhrase, where: str
    ) -> list[actions.Order]:
        """Return the orders to slings of a rigging entry, which depend on where earlier actions hooked them."""
        if phrase.verb != "hook":
            parted = phrase.verb == "release"
            found = [rope for rope in slings if rope in self.hangs] or [rope for rope, x in slings.items() if x.hooked]
            self.hangs -= {*found}
            return [actions.UnhookSling(sling=rope, parted=parted, where=where) for rope in found]
        if unknown := [lug for lug in phrase.lugs if lug not in self.lugs]:
            self.source.fault(path, f"no block has a lug '{unknown[0]}'", closest(unknown[0], self.lugs))
            return []
        n = 1 + max(x.number for x in slings.values()) - min(x.number for x in slings.values())
        if phrase.lugs and len(set(phrase.lugs)) != n:
            self.source.fault(path, f"{n} slings need {n} different lugs, not {len(set(phrase.lugs))}")
            return []
        first = min(x.number for x in slings.values())
        asked = [
            r for r, x in slings.items() if (x.holds == phrase.lugs[x.number - first] if phrase.lugs else x.hooked)
        ]
        self.hangs |= {*asked}
        return [actions.Hookup(sling=rope, where=where) for rope in asked]

    def _stops(
        self, path: Path, found: tuple[OrderTarget, ...], phrase: phrases.OrderPhrase, where: str
    ) -> list[actions.Order]:
        given = phrase.ramp if isinstance(phrase.ramp, float) else None
        for actor in found if given else ():
            if actor.kind == "tugger":
                self.source.fault(path, f"'{actor.name}' stops at the rate of its order: leave 'ramp' out")
            elif phrase.turning != actor.turns:
                self.source.fault(path, f"'{actor.name}' {wrong_units(turns=actor.turns)}")
        return [
            actions.StopOrder(model=a.model, actuator=a.name, accel=given or a.emergency, where=where) for a in found
        ]

    def _together(self, path: Path, moves: list[actions.Move]) -> list[actions.Move]:
        """Return the moves with a common ramp, the one with the lowest acceleration."""
        if len(moves) == 1 or moves[0].by is None or moves[0].pulses:
            message = (
                "several drives or winches move together by the same distance and with an ordinary ramp: write 'by'"
            )
            self.source.fault(path, message)
        names, accel = tuple(move.actuator for move in moves), min(move.accel for move in moves)
        return [msgspec.structs.replace(move, together=names, accel=accel) for move in moves]

    def _hookups(
        self, path: Path, found: tuple[OrderTarget, ...], phrase: phrases.OrderPhrase, where: str
    ) -> list[actions.Order]:
        slings = [s for actor in found for s in self._slings_of(actor)]
        held = {rope.name: rope.lines[-1].b.body for frame in self.yard.frames for rope in frame.system.ropes}
        if found[0].kind == "rope":
            if phrase.lugs:
                self.source.fault(path, f"'{found[0].name}' has a fixed end in the scene: write 'hook' without lugs")
            return [actions.Hookup(sling=s, where=where) for s in slings]
        if not phrase.lugs:
            self.source.fault(path, "name the lugs, such as 'hook [P1, P2]'")
            return []
        unknown = [lug for lug in phrase.lugs if lug not in self.lugs]
        for lug in unknown:
            self.source.fault(path, f"the block has no lug '{lug}'", closest(lug, self.lugs))
        if unknown:
            return []
        if len(set(phrase.lugs)) != len(slings):
            n = len(slings)
            self.source.fault(path, f"{n} slings need {n} different lugs, not {len(set(phrase.lugs))}")
            return []
        orders: list[actions.Order] = []
        left = list(phrase.lugs)
        for own in (self._slings_of(actor) for actor in found):
            hooked, left = by_beam(left[: len(own)], {lug: self.lugs[lug].p[0] for lug in left}), left[len(own) :]
            for sling, lug in zip(own, hooked, strict=True):
                if (body := held.get(sling)) not in (None, self.lugs[lug].body):
                    self.source.fault(
                        path, f"{sling} can be hooked to lugs of {body} only, {lug} is one of another block"
                    )
                orders.append(actions.Hookup(sling=sling, lug=key_of(lug, self.lugs[lug]), where=where))
        return orders

    def _slings_of(self, actor: OrderTarget) -> list[str]:
        if actor.kind in ("sling", "rope", "tugger"):
            return [actor.name]
        if actor.beam:
            return [tie.rope for tie in self.yard.slings(actor.beam)]
        hooks = (hook for machine in self.yard.machines for hook in machine.hooks if hook.rope == actor.name)
        ties = (tie.rope for hook in hooks for tie in ties_on(self.yard.machines, hook))
        return [rope for rope in ties if rope in self.hangs & self.held]
