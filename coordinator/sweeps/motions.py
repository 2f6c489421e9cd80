"""Speed and acceleration of all moves of a kind as one number: `hoist accel`, `trolley speed`, `turn speed`.

All orders of these verbs keep their proportions: the number is that of the fastest order, the others are scaled with
it.
"""

import re
from dataclasses import dataclass
from typing import Literal

from heavylift.kernel.errors import SceneError
from heavylift.nodes.plan.actions import Move, Turn
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.language.phrases import SwingRamp
from heavylift.nodes.scene.text.source import read
from heavylift.nodes.scene.text.spelling import NUMBER
from heavylift.nodes.scene.text.units import ACCELERATION, ANGULAR_ACCELERATION, RATE, SPEED, Dimension

NOUNS = {"hoist": ("hoist", "lower"), "trolley": ("traverse",), "gantry": ("travel",)}
MOVING = (verb for verb in VERBS.values() if verb.becomes in ("move", "turn") and verb.units != "pulling")
VERBS_OF = {verb.name: (verb.name,) for verb in MOVING} | NOUNS
WORDS: dict[str, Literal["speed", "accel"]] = {
    "speed": "speed", "rate": "speed", "accel": "accel", "acceleration": "accel", "ramp": "accel"
}  # fmt: skip

DIMENSIONS = {("speed", False): SPEED, ("speed", True): RATE,
              ("accel", False): ACCELERATION, ("accel", True): ANGULAR_ACCELERATION}  # fmt: skip


@dataclass(frozen=True)
class MotionOrder:
    """A move that the action list orders, with its speed or acceleration [SI], which a search can vary."""

    path: str
    text: str
    number: float


@dataclass(frozen=True)
class MotionGroup:
    """All moves of one kind in a scene, such as hoisting, whose speed or acceleration a search varies together."""

    name: str
    orders: tuple[MotionOrder, ...]
    what: Literal["speed", "accel"]
    dimension: Dimension

    @property
    def unit(self) -> str:
        """The unit in which speeds or accelerations of the group are shown."""
        return next(iter(self.dimension.units))

    @property
    def value(self) -> float:
        """The largest speed or acceleration among the moves of the group, in its unit."""
        return max(order.number for order in self.orders) / float(self.dimension.units[self.unit])

    def setting(self, text: str) -> list[str]:
        """Return the settings that give the fastest move of the group this value and scale the others alike; raises
        SceneError."""
        try:
            part = self.dimension.read(text) / max(order.number for order in self.orders)
        except ValueError as error:
            raise SceneError(f"{self.name}: {error}") from None
        return [f"{order.path}={self._with(order, part)}" for order in self.orders]

    def _with(self, order: MotionOrder, part: float) -> str:
        own = f"{order.number * part / float(self.dimension.units[self.unit]):.12g} {self.unit}"
        found = re.fullmatch(
            rf"(?P<verb>\s*\w+\s+)(?P<speed>{NUMBER}\s*\S+)(?P<ramp>\s+ramp\s.+?)?(?P<rest>\s(by|to|until)\s.*)",
            order.text,
        )
        assert found is not None, order.text
        if self.what == "speed":
            return f"{found['verb']}{own}{found['ramp'] or ''}{found['rest']}"
        return f"{found['verb']}{found['speed']} ramp {own}{found['rest']}"


def motion_of(scene: LoadedScene, name: str) -> MotionGroup | None:
    """Return the moves that a name such as `hoist speed` stands for; None if the name is unknown or the scene has no
    such moves."""
    noun, _, word = name.strip().rpartition(" ")
    if noun not in VERBS_OF or word not in WORDS:
        return None
    what, orders, turning = WORDS[word], [], False
    source = read(scene.merged or scene.text, scene.path.name)
    for number, (written, action) in enumerate(zip(scene.scene.actions, scene.plan.actions, strict=True)):
        for target, phrase in written.orders.items():
            if phrase.verb not in VERBS_OF[noun]:
                continue
            if what == "accel" and isinstance(phrase.ramp, SwingRamp):
                continue  # as long as a swing, whatever acceleration that is
            turning = phrase.turning
            own = [
                x.accel for x in action.orders if isinstance(x, Turn) or (isinstance(x, Move) and x.verb == phrase.verb)
            ]
            ramp = phrase.ramp if isinstance(phrase.ramp, float) else max(own, default=0.0)
            size = phrase.speed if what == "speed" else ramp
            orders.append(MotionOrder(f"actions[{number}].{target}", str(source.at(("actions", number, target))), size))
    if not orders:
        return None
    return MotionGroup(name.strip(), tuple(orders), what, DIMENSIONS[what, turning])


def motions(scene: LoadedScene) -> list[str]:
    """Return the names of all groups of moves in a scene."""
    nouns = [*NOUNS, "turn", "drive"]
    return [f"{noun} {what}" for noun in nouns for what in ("speed", "accel") if motion_of(scene, f"{noun} {what}")]
