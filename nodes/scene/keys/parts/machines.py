"""Machines written as parts, as their types make them."""

from __future__ import annotations

from typing import Annotated, Literal

from heavylift.nodes.scene.keys.base import Base, BodyPoint, Name, Place, part_name
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator, Field

from .mechanics import Parts
from .standing import Stands

PartName = Annotated[str, AfterValidator(part_name)]  # `west.boom` of the machine `west`


class PortalBody(Base):
    """A body of a crane on rails: `main`, `upper` or `lower` trolley."""

    mass: u.Mass
    com: Place
    box: tuple[u.Extent, u.Extent, u.Extent]


class PortalDrive(Base):
    """The servo of `gantry`, `upper` or `lower` trolley, with the bodies whose mass it moves."""

    moves: list[Literal["main", "upper", "lower"]]
    frequency: u.Frequency
    damping: u.Ratio


class PortalHook(Base):
    """Where the ropes of a hook leave their trolley."""

    on: Literal["upper", "lower"]
    at: Place


class PortalBodies(Base):
    """The portal with its girder, the upper and the lower trolley."""

    main: PortalBody
    upper: PortalBody
    lower: PortalBody


class PortalDrives(Base):
    """The servos of the gantry on its rails and of the trolleys on the girder."""

    gantry: PortalDrive
    upper: PortalDrive
    lower: PortalDrive


class PortalParts(Base):
    """What the type of a crane on rails makes of its parameters."""

    bodies: PortalBodies
    drives: PortalDrives
    hooks: dict[Name, PortalHook]
    stands: Stands | None = None
    wind: u.Speed | None = None  # up to which it works


class MachineKeys(Parts[PartName]):
    """A machine as its type makes it: a mechanism whose parts have its name in front."""


class Eye(Base):
    """Where a frame hangs: the falls of a hook hold the origin of a body, so far apart along its x."""

    body: str
    apart: u.Extent


class FrameParts(Parts[PartName]):
    """What the type of a frame on a hook makes of its parameters."""

    eye: Eye
    slings: Annotated[list[BodyPoint], Field(min_length=1)]  # where they hang
    locked_while_empty: list[str] = Field(default_factory=list)  # brakes
