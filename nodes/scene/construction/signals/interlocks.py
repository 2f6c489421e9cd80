"""Interlocks of the plan, made from machine types and the scene: watched quantity, stopped actuators, blocked
directions."""

import msgspec
from heavylift.kernel.algebra.dense import dot
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.description.mechanics import Point, System, merge
from heavylift.kernel.description.signals import guard_of
from heavylift.nodes.plan.interlock import BarredActuator, Interlock
from heavylift.nodes.plan.verbs import VERBS, Verb
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.construction.targets import OrderTarget, targets
from heavylift.nodes.scene.keys.actions import InterlockKeys as Keys
from heavylift.nodes.scene.keys.parts.kinematics import Poses, place, poses
from heavylift.nodes.scene.language.phrases import CrossTest
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .conditions import Conditions, unit_of

RESETS = 0.03  # of the value: so far behind it an interlock is reset
CLEARS = 0.1  # [m] the same, of heights and gaps
LENGTHS = ("height", "height difference", "gap")
MOVES = ("drive", "hook", "winch", "tugger")  # kinds of actors that can be stopped


def build_interlocks(yard: SceneBuilder) -> tuple[Interlock, ...]:
    """Return the interlocks of the scene and of machine types; each interlock stops motions of a single machine."""
    if not yard.scene.interlocks:
        return ()
    builder = _Builder(yard)
    return tuple(x for name, given in yard.scene.interlocks.items() for x in builder.built(name, given))


class _Builder:
    def __init__(self, builder: SceneBuilder) -> None:
        self.yard, self.source, self.conditions = builder, builder.source, Conditions(builder)
        self.moving: dict[str, dict[str, OrderTarget]] = {}
        for actors in targets(builder).values():
            for actor in (actor for actor in actors if actor.kind in MOVES):
                self.moving.setdefault(actor.model, {})[actor.name] = actor

    def built(self, name: str, given: Keys) -> list[Interlock]:
        """Split an interlock of the scene into one interlock for each machine that it stops."""
        path: Path = ("interlocks", name)
        tests = [test for test in given.when if isinstance(test, CrossTest)]
        if len(given.when) != 1 or not tests:
            hint = "such as 'off-lead of any hook >= 3 deg'"
            self.source.fault((*path, "when"), f"an interlock watches one measured quantity, {hint}")
            return []
        test = tests[0]
        machines = [given.on] if isinstance(given.on, str) and given.on else list(given.on) or list(self.moving)
        for machine in (machine for machine in machines if machine not in self.moving):
            message = f"there is no machine '{machine}' with drives or winches"
            self.source.fault((*path, "on"), message, closest(machine, self.moving))
            return []
        if not given.stops:
            machines = machines[:1]  # what only tells need not be reported twice
        if test.quantity == "wind" and not self.conditions.subjects.winds and "." in name:
            return []  # of a type, in a scene without wind
        resets = self._resets((*path, "until"), given, test)
        found = []
        for machine in machines:
            own = name if name.startswith(f"{machine}.") else f"{machine}.{name}"
            signals = [x for of in self._each(machine, test) if (x := self.conditions.signal((*path, "when"), of))]
            if self.source.faults:
                return []
            guards = tuple(
                guard_of(own if len(signals) == 1 else f"{own}~{i}", signal) for i, (_, signal) in enumerate(signals, 1)
            )
            watched = tuple(
                rope for _, x in signals if x.quantity in ("load", "moment", "use by place") for rope in x.ropes
            )
            found.append(
                Interlock(
                    name=own,
                    machine=machine,
                    guards=guards,
                    value=test.value,
                    resets=resets,
                    rising=test.rising,
                    stops=tuple(self._stops(path, machine, given, test)),
                    unit=unit_of(test),
                    text=test.text,
                    tells=given.tells,
                    hooks=watched,
                    where=self.source.where(path),
                )
            )
        return found

    def _each(self, machine: str, test: CrossTest) -> list[CrossTest]:
        """Return the tests that an interlock of a machine watches: one for each hook or sling if the test says `any`,
        else one, with the machine's name put before the names of its parts."""
        subjects = self.conditions.subjects
        if test.of == "any hook":
            ropes = dict.fromkeys(hook.rope for hook in subjects.hooks.values() if subjects.ropes[hook.rope] == machine)
            return [msgspec.structs.replace(test, of=rope) for rope in ropes]
        if test.of == "any sling":
            slings = [row.subject for row in subjects.ratings["tension"].values() if row.quantity == "sling tension"]
            return [msgspec.structs.replace(test, of=sling) for sling in slings]
        known = {*subjects.points, *subjects.hooks, *subjects.ropes, *subjects.boxes}
        known |= {*(subjects.ratings[test.quantity] if test.share else ())}
        known |= {joint.name for m in self.yard.machines for joint in m.system.joints}
        words = [own if (own := f"{machine}.{word}") in known else word for word in test.of.split()]
        return [msgspec.structs.replace(test, of=" ".join(words))]

    def _resets(self, path: Path, given: Keys, test: CrossTest) -> float:
        """Return the value at which an interlock resets: as given, or slightly on the safe side of the trip value."""
        away = -1.0 if test.rising else 1.0
        if given.until is None:
            by = CLEARS if test.quantity in LENGTHS else RESETS * abs(test.value)
            return test.value + away * by
        until = given.until[0]
        if not isinstance(until, CrossTest) or (until.quantity, until.of) != (test.quantity, test.of):
            self.source.fault(
                path, f"an interlock is reset by the quantity that trips it: write '{_behind(test)}' or leave it out"
            )
        elif until.rising == test.rising or (until.value - test.value) * away < 0.0:
            self.source.fault(
                path, f"it would be reset where it trips: write '{_behind(test)}' with a value on the safe side"
            )
        return until.value if isinstance(until, CrossTest) else test.value

    def _stops(self, path: Path, machine: str, given: Keys, test: CrossTest) -> list[BarredActuator]:
        actors = self.moving[machine].values()
        if given.stops == "all":
            return [BarredActuator(actuator=x.name, emergency=_emergency(given, x)) for x in actors]
        found = []
        for i, words in enumerate(given.stops):
            at: Path = (*path, "stops", i)
            verb, distance = self._way(at, words)
            obeying = [x for x in actors if verb and x.obeys(verb)]
            if verb and not obeying and given.on:
                self.source.fault(at, f"'{machine}' has nothing that can {verb.name}")
            for x in obeying:
                distances = self._towards(path, x, test) if given.towards else distance
                found.append(BarredActuator(actuator=x.name, way=distances, emergency=_emergency(given, x)))
        return found

    def _way(self, path: Path, words: str) -> tuple[Verb | None, int]:
        """Return the verb and the direction that a phrase such as `hoist` or `luff out` means."""
        name, _, distance = " ".join(words.split()).partition(" ")
        verb = VERBS.get(name)
        known = [x.name for x in VERBS.values() if x.becomes == "move"]
        known += [f"{x.name} {word}" for x in VERBS.values() for word in x.ways if word]
        if verb is None or verb.becomes != "move" or (distance and distance not in verb.ways):
            self.source.fault(path, f"nothing can '{words}'", closest(words, known))
            return None, 0
        return verb, verb.sign if not distance else 1 if distance == verb.ways[0] else -1

    def _towards(self, path: Path, actor: OrderTarget, test: CrossTest) -> int:
        """Return the direction (+1 or -1) in which a straight drive closes a gap, from the positions at the start."""
        boxes, sides = self.conditions.subjects.boxes, dict[bool, Array]()
        axis, poses = self._axis(actor)
        for model, point, _ in (boxes[name] for name in test.of.split() if test.quantity == "gap" and name in boxes):
            if point.body in poses:
                sides[model == actor.model] = place(point, poses)
        distance = dot(axis, (sides[False] - sides[True]).tolist()) if len(sides) == 2 else 0.0
        if not distance:
            message = "it is known of a gap between two machines, of which this one travels or traverses to the other"
            self.source.fault((*path, "towards"), message)
        return 1 if distance > 0.0 else -1

    def _axis(self, actor: OrderTarget) -> tuple[list[float], Poses]:
        """Return the direction of a straight drive in the world frame at the start, and the poses of all bodies."""
        whole = merge([m.system for m in self.yard.machines], self.yard.scene.gravity)
        moved = System(whole.bodies, whole.joints)
        at = poses(moved) if not any(moved.outside) else {}
        joints = {drive.name: joint for drive in whole.drives for joint in whole.joints if joint.name == drive.joint}
        joint = joints.get(actor.name)
        if joint is not None and joint.kind == "prismatic" and joint.parent in at:
            x, y, z = (dot(row, joint.axis) for row in joint.R_PJ)
            return (place(Point(joint.parent, (x, y, z)), at) - place(Point(joint.parent), at)).tolist(), at
        return [0.0, 0.0, 0.0], at


def _emergency(given: Keys, actor: OrderTarget) -> float | None:
    return actor.emergency if given.deceleration is None or actor.turns else given.deceleration


def _behind(test: CrossTest) -> str:
    return f"{test.quantity}{f' of {test.of}' if test.of else ''} {'<=' if test.rising else '>='} ..."
