"""The quantities that conditions, interlocks, limits of signals and models of a user's own name: one row each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.units import Dimension


@dataclass(frozen=True)
class Quantity:
    """Its dimension, and how many names it is of; "some": one, or the block's where there is none; of what is `rated`
    a value may be a share."""

    dimension: Dimension
    of: Literal["none", "some", "one", "two"] = "one"
    rated: bool = False


QUANTITIES = {
    "angle": Quantity(units.ANGLE, "some"),
    "height difference": Quantity(units.LENGTH, "two"),
    "height": Quantity(units.LENGTH, "some"),
    "position": Quantity(units.STROKE),
    "speed": Quantity(units.STROKE_SPEED),
    "length": Quantity(units.LENGTH),
    "tension": Quantity(units.FORCE, rated=True),
    "load": Quantity(units.MASS, rated=True),
    "moment": Quantity(units.RATIO),
    "radius": Quantity(units.LENGTH),
    "off-lead": Quantity(units.ANGLE),
    "swing along": Quantity(units.ANGLE),
    "swing across": Quantity(units.ANGLE),
    "gap": Quantity(units.LENGTH, "two"),
    "wind": Quantity(units.SPEED, "none"),
}
