"""Machines written as parts, as their types make them."""

from __future__ import annotations

from typing import Annotated, Literal

from heavylift.nodes.scene.keys.base import Base, Name, Place, part_name
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator

from .mechanics import Parts

PartName = Annotated[str, AfterValidator(part_name)]  # `west.boom` of the machine `west`


class GoliathBody(Base):
    """A body of a goliath: `main`, `upper` or `lower` trolley."""

    mass: u.Mass
    com: Place
    box: tuple[u.Extent, u.Extent, u.Extent]


class GoliathDrive(Base):
    """The servo of `gantry`, `upper` or `lower` trolley, with the bodies whose mass it moves."""

    moves: list[Literal["main", "upper", "lower"]]
    frequency: u.Frequency
    damping: u.Ratio


class GoliathHook(Base):
    """Where the ropes of a hook leave their trolley."""

    on: Literal["upper", "lower"]
    at: Place


class GoliathBodies(Base):
    """The portal with its girder, the upper and the lower trolley."""

    main: GoliathBody
    upper: GoliathBody
    lower: GoliathBody


class GoliathDrives(Base):
    """The servos of the gantry on its rails and of the trolleys on the girder."""

    gantry: GoliathDrive
    upper: GoliathDrive
    lower: GoliathDrive


class GoliathParts(Base):
    """What the type of a goliath makes of its parameters."""

    bodies: GoliathBodies
    drives: GoliathDrives
    hooks: dict[Name, GoliathHook]


class Machine(Parts[PartName]):
    """A machine as its type makes it: a mechanism whose parts have its name in front."""
