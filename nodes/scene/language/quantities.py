"""The quantities that can be named in conditions, interlocks, limits of signals and user models: one row each."""

from dataclasses import dataclass
from typing import Literal

from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.units import Dimension


@dataclass(frozen=True)
class NamedQuantity:
    """Dimension of a quantity, the number of names it needs ("some": one, or the block); `rated`: also in %."""

    dimension: Dimension
    of: Literal["none", "some", "one", "two"] = "one"
    rated: bool = False


QUANTITIES = {
    "angle": NamedQuantity(units.ANGLE, "some"),
    "height difference": NamedQuantity(units.LENGTH, "two"),
    "height": NamedQuantity(units.LENGTH, "some"),
    "position": NamedQuantity(units.STROKE),
    "speed": NamedQuantity(units.STROKE_SPEED),
    "length": NamedQuantity(units.LENGTH),
    "tension": NamedQuantity(units.FORCE, rated=True),
    "load": NamedQuantity(units.MASS, rated=True),
    "moment": NamedQuantity(units.RATIO),
    "radius": NamedQuantity(units.LENGTH),
    "off-lead": NamedQuantity(units.ANGLE),
    "swing along": NamedQuantity(units.ANGLE),
    "swing across": NamedQuantity(units.ANGLE),
    "gap": NamedQuantity(units.LENGTH, "two"),
    "wind": NamedQuantity(units.SPEED, "none"),
}
