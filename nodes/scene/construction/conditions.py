"""Conditions of an action list with their names resolved to slings, ropes, joints and the models that watch.

A condition over nothing is refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.description.mechanics import Point, System, Threshold
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.scene.language import phrases
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Fault, Path

from .yard import Yard


class Conditions:
    """Resolves conditions; each crossing gets a threshold with a name of its own."""

    def __init__(self, yard: Yard, mechanism: plan.Mechanism | None) -> None:
        self.yard, self.mechanism = yard, mechanism
        self.thresholds = 0

    def read(self, path: Path, test: phrases.Test) -> actions.Condition:
        """A condition with its names resolved."""
        where, text = self.yard.source.where(path), test.text
        match test:
            case phrases.AllTests():
                parts = tuple(self.read(path, each) for each in test.tests)
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

    def _ropes(self, path: Path, of: str, noun: str, column: int) -> tuple[str, ...]:
        """The names of a set of slings or ropes; empty sets are faults."""
        slings, ropes = [s.name for s in self.yard.slings], [r.name for r in self.yard.ropes]
        if self.mechanism:
            ropes += [r.name for r in self.mechanism.system.all_ropes]
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
            self._fault(path, f"there is no {what} '{of}'", closest(of, [s for s in sets if s]), column=column)
            return ()
        names = tuple(sets[of])
        if not names:
            told = f"this scene has no {noun}: a condition over nothing says nothing"
            self._fault(path, told, column=column)
        return names

    def _standing(self, path: Path, test: phrases.GroundTest) -> str:
        if self.yard.block:
            return "block"
        if self.mechanism and (self.mechanism.system.supports or self.mechanism.system.contacts):
            return self.mechanism.name
        self._fault(
            path, f"nothing in this scene can be {test.state}: it has no supports or contacts", column=test.column
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
            along = _coordinates(system) if system else {}
            known += along
            if of in along:
                joint, coordinate = along[of]
                quantity: Literal["joint", "speed"] = "joint" if test.quantity == "position" else "speed"
                return at, Threshold(name, quantity, of=joint, coordinate=coordinate)
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

    def _fault(self, path: Path, sentence: str, hint: str = "", *, on_key: bool = False, column: int = 0) -> None:
        self.yard.source.faults.append(Fault(path, sentence, hint, on_key, column))


def _coordinates(system: System) -> dict[str, tuple[str, str]]:
    """Joint and coordinate by the words for them: the joint, or joint.coordinate where there are several."""
    found = {}
    for joint in system.joints:
        names = JOINTS[joint.kind].actable
        for c in names:
            found[joint.name if len(names) == 1 else f"{joint.name}.{c}"] = joint.name, c if len(names) > 1 else ""
    return found
