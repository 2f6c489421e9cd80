"""The user models under a scene's key `models`: their signals and set-points, named as in conditions and orders."""

import re

from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.models import UserModelNode
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.user_models import Led, UserModel
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.construction.targets import OrderTarget, targets
from heavylift.nodes.scene.keys.nodes import ModelKeys as Keys
from heavylift.nodes.scene.language.phrases import QUANTITIES, CrossTest
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.files import within
from heavylift.nodes.scene.text.source import Path, SourceText
from heavylift.recordings.format.spellings import called_of

from .conditions import Conditions

LED_BY = {"drive": "drive", "hook": "lower", "winch": "lower"}  # by kind


def build_models(builder: SceneBuilder) -> tuple[UserModel, ...]:
    """Return the user models of the plan; errors are added to the scene."""
    return _Models(builder).all()


def check_models(source: SourceText, built: plan.Plan) -> None:
    """Build each user model once, to check that its code is trusted and has the named ports."""
    if source.faults:
        return
    for own in built.models:
        try:
            UserModelNode(own)
        except HeavyliftError as error:
            source.fault(("models", own.name, "model"), str(error).removeprefix(f"{own.name}: "))


class _Models:
    def __init__(self, builder: SceneBuilder) -> None:
        self.builder, self.source = builder, builder.source
        self.targets = targets(builder) if builder.scene.models else {}
        self.conditions = Conditions(builder)
        self.leaders: dict[str, str] = {}

    def all(self) -> tuple[UserModel, ...]:
        found = tuple(self.one(name, given) for name, given in self.builder.scene.models.items())
        for i, action in enumerate(self.builder.scene.actions if self.leaders else ()):
            for target in action.orders:
                for actor in self.targets.get(" ".join(target.split()), ()):
                    if who := self.leaders.get(actor.name):
                        message = f"{actor.name} is controlled by the model '{who}' and takes no other orders"
                        self.source.fault(("actions", i, target), message, on_key=True)
        return found

    def one(self, name: str, given: Keys) -> UserModel:
        path: Path = ("models", name)
        if name in (*self.builder.scene.machines, *(machine.name for machine in self.builder.machines)):
            self.source.fault(path, f"the name '{name}' is given twice: one of the machines has it, too", on_key=True)
        signals = {port: self.signal((*path, "signals", port), text) for port, text in given.signals.items()}
        leads = (self.led((*path, "orders", port), name, port, target) for port, target in given.orders.items())
        return UserModel(
            name=name, model=self.code((*path, "model"), given.model), period=round(given.period * 1e9),
            delay=round(given.delay * 1e9), signals={port: signal for port, signal in signals.items() if signal},
            leads=tuple(led for led in leads if led), parameters=dict(given.parameters), where=self.source.where(path),
        )  # fmt: skip

    def code(self, path: Path, model: str) -> str:
        """Return the reference to a user model's code; a file in the scene's folder is given by its absolute path."""
        file, colon, name = model.partition(":")
        if not file.endswith((".py", ".fmu")):
            return model
        try:
            return f"{within(self.source.root, self.source.root / file)}{colon}{name}"
        except ValueError as error:
            self.source.fault(path, str(error))
            return model

    def signal(self, path: Path, text: str) -> ScalarSignal | None:
        """Return the signal that a port of a user model receives; `text` names the quantity as conditions do."""
        words = " ".join(text.split())
        match = re.fullmatch(rf"({'|'.join(sorted(QUANTITIES, key=lambda x: -len(x)))})(?: (?:of )?(.+))?", words)
        if match is None:
            quantity = words.partition(" of ")[0]
            self.source.fault(path, f"there is no signal '{quantity}'", closest(quantity, QUANTITIES))
            return None
        quantity, of = match[1], (match[2] or "").removesuffix(" in %").removeprefix("all ")
        share = words.endswith(" in %")
        if share and not QUANTITIES[quantity].rated:
            self.source.fault(path, f"no {quantity} is rated: remove 'in %'")
            return None
        actor = next(iter(self.targets.get(of, ())), None)
        if quantity in ("position", "speed") and actor and (moved := self.moved(actor)):
            return ScalarSignal("joint" if quantity == "position" else "speed", of=moved[0], coordinate=moved[1])
        roped = not share and quantity in ("tension", "length", "swing along", "swing across")
        of = actor.name if actor and actor.kind == "hook" and roped else of
        test = CrossTest(quantity=quantity, of=of, rising=True, value=0.0, turning=False, column=0, share=share)
        found = self.conditions.signal(path, test)
        return found[1] if found else None

    def moved(self, actor: OrderTarget) -> tuple[str, str] | None:
        """Return the joint and the coordinate that a drive moves; None for other targets."""
        drives = (drive for m in self.builder.machines for drive in m.system.drives)
        return next(((drive.joint, drive.coordinate) for drive in drives if drive.name == actor.name), None)

    def led(self, path: Path, model: str, port: str, target: str) -> Led | None:
        """Return the actuator that a port's set-points control; if there is none, add an error and return None."""
        words = " ".join(target.split())
        found = self.targets.get(words, ())
        found = tuple(x for x in found if called_of(x.name) == (words, "")) or found  # the drive called as its machine
        actor = found[0] if len(found) == 1 else None
        if actor is None or actor.kind not in LED_BY:
            known = [words for words, some in self.targets.items() if len(some) == 1 and some[0].kind in LED_BY]
            self.source.fault(
                path, f"'{target}' is not a drive or winch that a model can control", closest(target, known)
            )
            return None
        if other := self.leaders.get(actor.name):
            self.source.fault(
                path, f"{actor.name} is controlled by the model '{other}' already; only one model can control it"
            )
        self.leaders.setdefault(actor.name, model)
        return Led(port=port, move=self.move(actor, self.source.where(path)))

    def move(self, actor: OrderTarget, where: str) -> Move:
        verb = VERBS[actor.verb or LED_BY[actor.kind]]
        speed, name = actor.loaded or actor.speed or 0.0, verb.name
        return Move(verb=name, model=actor.model, actuator=actor.name, speed=speed, accel=actor.accel, where=where)
