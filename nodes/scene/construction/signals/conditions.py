"""Conditions of an action list, in which names are resolved to slings, ropes, joints and the models that watch them.

A condition on an empty set of slings or ropes is an error.
"""

from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Point, System
from heavylift.kernel.description.signals import ScalarSignal, guard_of
from heavylift.nodes.plan import actions
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.language import phrases
from heavylift.nodes.scene.language.phrases import QUANTITIES
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path
from heavylift.recordings.format.spellings import called_of

from .subjects import Subjects

UNITS = {"length": "m", "angle": "rad", "force": "N", "mass": "kg", "ratio": "", "speed": "m/s"}  # by dimension
UNJUDGED = ("angle", "length")  # signals that are not known of a path or a recording


class Conditions:
    """Resolves names in conditions; each comparison of a signal with a value gets a threshold with its own name."""

    def __init__(self, builder: SceneBuilder) -> None:
        self.yard, self.source = builder, builder.source
        self.rigged = {name: slings for m in builder.machines for name, slings in m.rigged.items()}
        self.subjects = Subjects(builder)
        self.thresholds = 0

    def read(self, path: Path, phrase: phrases.ConditionPhrase | None) -> actions.Condition | None:
        """Return the condition of a phrase, with all names resolved; None if there is no phrase."""
        if phrase is None:
            return None
        parts = tuple(self._term(path, test) for test in phrase)
        where, text = self.source.where(path), " and ".join(test.text for test in phrase)
        return parts[0] if len(parts) == 1 else actions.And(all=parts, where=where, text=text)

    def crossing(
        self, path: Path, signal: ScalarSignal, model: str, value: float, rising: bool, text: str
    ) -> actions.CrossingCondition:
        """Return the condition that a signal crosses a value, for which a new threshold is made."""
        self.thresholds += 1
        guard = guard_of(f"{signal.quantity.replace(' ', '-')}-{self.thresholds}", signal)
        where = self.source.where(path)
        return actions.CrossingCondition(
            model=model, threshold=guard, value=value, rising=rising, text=text, where=where
        )

    def _term(self, path: Path, test: phrases.Test) -> actions.Condition:
        named = {"where": self.source.where(path), "text": test.text}
        match test:
            case phrases.GroundTest(state="done"):
                lifts = self.yard.scene.lifts
                if test.of not in lifts:
                    message = f"there is no lift '{test.of}' that could be done"
                    self.source.fault(path, message, closest(test.of, lifts), column=test.column)
                return actions.EndedCondition(lift=test.of, **named)
            case phrases.GroundTest() if test.on:
                model, signal = self._lands(path, test)
                return self.crossing(path, signal, model, actions.LANDS, False, test.text)
            case phrases.GroundTest():
                kind = actions.LiftedCondition if test.state == "lifted" else actions.LandedCondition
                return kind(model=self._standing(path, test), **named)
            case phrases.SlingTest():
                names = self._ropes(path, test.of, test.noun, test.column)
                return actions.SlingsCondition(names=names, each=test.each, state=test.state, **named)
            case phrases.CrossTest():
                model, signal = self.signal(path, test) or ("", ScalarSignal("height"))
                return self.crossing(path, signal, model, test.value, test.rising, test.text)
        return msgspec.structs.replace(test, where=named["where"])

    def _ropes(self, path: Path, of: str, noun: str, column: int) -> tuple[str, ...]:
        """Return the names of a set of slings or ropes; add an error if the set is empty."""
        slings = [tie.rope for tie in self.yard.slings()]
        ropes = [r.name for m in self.yard.machines for r in m.system.all_ropes if r.name not in slings]
        rigged = [sling for names in self.rigged.values() for sling in names]
        sets: dict[str, Iterable[str]] = {}
        if noun == "one":
            of = of if of in (*slings, *ropes) else ".".join(of.split())  # "west H1"
            sets = {name: [name] for name in (*slings, *ropes)}
        elif noun == "ropes":
            sets = {"": ropes, **{name: [name] for name in ropes}}
        else:
            beams = {name: (name,) for name in self.yard.hooks}
            sets = {"": [*slings, *rigged], **self.rigged}
            for name, members in {**beams, **self.yard.groups}.items():
                sets[name] = [tie.rope for tie in self.yard.slings(*members)]
        if of not in sets:
            what = "rope or sling" if noun == "one" else f"set of {noun}"
            self.source.fault(path, f"there is no {what} '{of}'", closest(of, [s for s in sets if s]), column=column)
            return ()
        names = tuple(sets[of])
        if not names:
            self.source.fault(path, f"this scene has no {noun}: the condition would test nothing", column=column)
        return names

    def _standing(self, path: Path, test: phrases.GroundTest) -> str:
        if self.yard.scene.block and test.of in ("", "block"):
            return "block"
        standing = [m.name for m in self.yard.machines if m.system.supports or m.system.contacts]
        standing = [name for name in standing if not (self.yard.scene.block and name == "block")]
        blocks = [name for name in standing if name in self.yard.scene.blocks]
        if test.of in standing:
            return test.of
        if test.of:
            missing = f"there is no block '{test.of}' that could be {test.state}"
            self.source.fault(path, missing, closest(test.of, standing), column=test.column)
            return ""
        if len(blocks) > 1:
            message = " or ".join(f"'{name} {test.state}'" for name in blocks[:2])
            self.source.fault(path, f"which block? write {message}", column=test.column)
            return ""
        if standing:
            return standing[0]
        missing = f"nothing in this scene can be {test.state}: it has no supports or contacts"
        self.source.fault(path, missing, column=test.column)
        return ""

    def _lands(self, path: Path, test: phrases.GroundTest) -> tuple[str, ScalarSignal]:
        """Return the model that watches whether a block lands on something, and the gap between them as the signal;
        they must have a contact."""
        blocks = ["block"] if self.yard.scene.block else [*self.yard.scene.blocks]
        block = test.of or (blocks[0] if len(blocks) == 1 else "")
        pairs = [(c.a.body, c.b.body) for m in self.yard.machines for c in m.system.contacts]
        met = {a if b == block else b for a, b in pairs if block in (a, b)}
        known = {*(met & {*self.subjects.boxes}), *(["floor"] if WORLD in met and self.yard.scene.floor else [])}
        if test.on in known and (found := self.subjects.signal("gap", f"{block} {test.on}")):
            return found
        message = f"'{block}' meets no '{test.on}' on which it could land" if block else "which block? write its name"
        self.source.fault(path, message, closest(test.on, known) if block else "", column=test.column)
        return "", ScalarSignal("height")

    def signal(self, path: Path, test: phrases.CrossTest) -> tuple[str, ScalarSignal] | None:
        """Return the model that watches a quantity, and the signal of the quantity; None after an error."""
        if test.share:
            return self._share(path, test)
        of, quantity = test.of, test.quantity
        known = self.subjects.known(quantity)
        if not of and QUANTITIES[quantity].of == "some" and len(self.yard.scene.blocks) == 1:
            (of,) = self.yard.scene.blocks  # as that of an instance is
        blocks = {cargo.body: cargo.body for cargo in self.yard.cargo}
        blocks |= {"": "block"} if self.yard.scene.block else {}
        if quantity in ("angle", "height") and of in blocks:
            kind: Literal["angle", "height"] = "angle" if quantity == "angle" else "height"
            return blocks[of], ScalarSignal(kind, of=blocks[of], point=None if kind == "angle" else Point(blocks[of]))
        if quantity in ("tension", "length"):
            return self._rope_signal(path, test, "tension" if quantity == "tension" else "length")
        if quantity in ("position", "speed"):
            along = {words: (m.name, *x) for m in self.yard.machines for words, x in _coordinates(m.system).items()}
            drives = [
                drive for m in self.yard.machines for drive in m.system.drives if called_of(drive.name) == (m.name, "")
            ]
            along |= {called_of(drive.name)[0]: along[drive.joint] for drive in drives}
            known = [*along]
            if of in along:
                at, joint, coordinate, turns = along[of]
                if test.value and test.turning != turns:
                    self.source.fault(path, f"'{of}' {wrong_units(turns=turns)}", column=test.column)
                return at, ScalarSignal("joint" if quantity == "position" else "speed", of=joint, coordinate=coordinate)
        if found := self.subjects.signal(quantity, of):
            return found
        if quantity in {"angle", "height"} and self.yard.scene.block:
            known = ["block", *known]
        if quantity == "wind":
            self.source.fault(path, "no wind blows in this scene: add 'wind'", column=test.column)
            return None
        two = QUANTITIES[quantity].of == "two"
        wrong = next((name for name in of.split() if name not in known), of) if two else of
        missing = f"'{quantity}' of what?" if not of else f"there is no '{wrong}' with {quantity}"
        hint = closest(wrong, known) or f"nothing in this scene has {quantity}; joints of a mechanism would have"
        if not known and quantity not in ("position", "speed", "height", "angle"):
            hint = f"nothing in this scene has {quantity}"
        self.source.fault(path, missing, hint, column=test.column)
        return None

    def _share(self, path: Path, test: phrases.CrossTest) -> tuple[str, ScalarSignal] | None:
        """Return the model that watches a load or tension relative to its rated value, and the signal; for a set of
        ropes the largest ratio."""
        rows, word = self.subjects.ratings[test.quantity], ".".join(test.of.split())
        *front, noun = test.of.split() or [""]
        if test.quantity == "tension" and noun in ("slings", "ropes"):
            ropes = self._ropes(path, " ".join(front), noun, test.column)
            limits = [row.value if (row := rows.get(rope)) else None for rope in ropes]
            for rope, value in zip(ropes, limits, strict=True):
                if value is None:
                    message = f"'{test.of}' are not all rated: no tension of {rope} is known"
                    self.source.fault(path, message, "write an absolute value", column=test.column)
                    return None
            uses = tuple(1.0 / value for value in limits if value)
            return (self._watching(ropes), ScalarSignal("use", ropes=ropes, numbers=uses)) if ropes else None
        row = rows.get(word)
        if row is None:
            message = f"there is no '{test.of}' with a rated {test.quantity}"
            self.source.fault(path, message, closest(word, rows), column=test.column)
            return None
        found = self.subjects.share(row)
        if found is None:
            message = f"{row.subject} has no one rated {test.quantity}: write an absolute value"
            self.source.fault(path, message, row.note, column=test.column)
        return found

    def _rope_signal(
        self, path: Path, test: phrases.CrossTest, kind: Literal["tension", "length"]
    ) -> tuple[str, ScalarSignal] | None:
        *front, last = test.of.split() or [""]
        noun = last if last in {"slings", "ropes"} else "one"
        ropes = self._ropes(path, " ".join(front) if noun != "one" else test.of, noun, test.column)
        return (self._watching(ropes), ScalarSignal(kind, ropes=ropes)) if ropes else None

    def _watching(self, ropes: Sequence[str]) -> str:
        """Return the model that watches these ropes: the one that they belong to or, if several, the block."""
        models = sorted({self.subjects.ropes[rope] for rope in ropes})
        return "block" if len(models) > 1 and self.yard.scene.block else models[0]


def wrong_units(*, turns: bool) -> str:
    """Return the error message for a length where an angle is needed, or the other way round."""
    return "turns: write degrees or radians, not metres" if turns else "slides: write metres, not degrees or radians"


def _coordinates(system: System) -> dict[str, tuple[str, str, bool]]:
    """Return (joint, coordinate, whether it is an angle) by name; the name is that of the joint or, if it has several
    coordinates, joint.coordinate."""
    found = {}
    for joint in system.joints:
        kind = JOINTS[joint.kind]
        for i, c in enumerate(kind.actable):
            several = len(kind.actable) > 1
            found[f"{joint.name}.{c}" if several else joint.name] = joint.name, c if several else "", kind.turns(i)
    return found


def unit_of(test: phrases.Test) -> str | None:
    """Return the SI unit of the quantity that a condition compares with a value; None if the unit is unknown."""
    if not isinstance(test, phrases.CrossTest) or test.quantity in UNJUDGED:
        return None
    return "" if test.share else UNITS.get(QUANTITIES[test.quantity].dimension.name)
