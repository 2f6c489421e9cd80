"""The keys of `mechanism: forces:` in a scene file, generated from the kernel's force elements.

A history is a list of [time, value], linear in between; the value is a factor of the force, or the wind speed.
`heavylift.kernel.description.forces` defines the force laws and their sign conventions.
"""

import re
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast, get_args

from heavylift.kernel.description import forces as f
from heavylift.kernel.trust import named
from heavylift.nodes.scene.keys.base import Described, Spelling, history, keys_of, one
from heavylift.nodes.scene.text import units as u
from msgspec.structs import replace
from pydantic import Field

Row6 = tuple[u.Number, u.Number, u.Number, u.Number, u.Number, u.Number]
Matrix6 = tuple[Row6, Row6, Row6, Row6, Row6, Row6]
OVER = one("over", Literal["position", "speed"])


def _column(i: int) -> Spelling:
    """Return the spelling of one column of a curve: the positions or speeds (i = 0) or the efforts (i = 1)."""
    curve = Annotated[list[tuple[u.Reach, u.Thrust]], Field(min_length=1)]
    return one("curve", curve, lambda pairs: tuple(pair[i] for pair in pairs))


def _matrix(key: str, word: str, slide: Any, turn: Any) -> Spelling:
    """Return the spelling of a matrix that is given completely or by its diagonal."""
    zero = (0.0, 0.0, 0.0)
    keys = {word: (tuple[slide, slide, slide], zero), f"turning_{word}": (tuple[turn, turn, turn], zero)}
    return Spelling(
        {**keys, key: (Matrix6 | None, None)},
        lambda x: getattr(x, key) or _diagonal((*getattr(x, word), *getattr(x, f"turning_{word}"))),
    )


class WindForceKeys(keys_of(f.Wind, word="wind", signal=history("speed", "gusts", u.Velocity, 0.0))):  # type: ignore[misc]
    """Drag force of the wind on an area at a point of a body, or on the `sides` of a box.

    `gusts`: history of the wind speed."""

    area: u.Area = 0.0


MATRICES = {
    "K": _matrix("K", "stiffness", u.Stiffness, u.TurnStiffness),
    "D": _matrix("D", "damping", u.Damping, u.TurnDamping),
}


class BushingKeys(keys_of(f.Bushing, word="bushing", **MATRICES)):  # type: ignore[misc]
    """A spring and damper between two frames, in all six directions; K and D are full matrices in SI units."""


class CharacteristicKeys(keys_of(f.Characteristic, word="characteristic", x=_column(0), effort=_column(1), of=OVER)):  # type: ignore[misc]
    """An actuator characteristic: effort on a joint as `curve` over position or speed, times `factor` or `history`."""


class LawKeys(keys_of(f.UserLaw, word="law")):  # type: ignore[misc]
    """A user's force law, given as "package.module:function", or "file.py:function" in the scene's folder."""

    modes: int = Field(default=0, ge=0)

    def built(self, *first: str, folder: Path | None = None, **other: Any) -> Any:
        """Return the force law with its functions; files are searched in the scene's folder."""
        assert folder is not None
        function, guards = (_beside(x, folder) for x in (self.function, self.guards))
        named(x for x in (function, guards) if x)
        return replace(super().built(*first), function=function, guards=guards)


WRITTEN = {f.Wind: WindForceKeys, f.Bushing: BushingKeys, f.Characteristic: CharacteristicKeys, f.UserLaw: LawKeys}
OTHERS = (f.Reeving, f.Radiation, f.Stream, f.Immersion)  # of a rope, hulls and a block in scenes
KINDS = [kind for kind in get_args(f.Force) if kind not in OTHERS]
WORDS = {kind: re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__).lower() for kind in KINDS}
MODELS = [WRITTEN.get(kind) or keys_of(kind, word=word, module=__name__) for kind, word in WORDS.items()]
if TYPE_CHECKING:
    Force = Described
else:
    Force = Annotated[reduce(or_, MODELS), Field(discriminator="type")]


def _diagonal(values: tuple[float, ...]) -> Matrix6:
    return cast(Matrix6, tuple(tuple(x if i == j else 0.0 for j in range(6)) for i, x in enumerate(values)))


def _beside(function: str, folder: Path) -> str:
    """Return a reference to a function, with the full path of its file if it is in the scene's folder."""
    module, colon, name = function.rpartition(":")
    return f"{(folder / module).resolve()}{colon}{name}" if module.endswith(".py") else function
