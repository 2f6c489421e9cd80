"""Machines written as parts, as their types make them."""

from __future__ import annotations

from typing import Annotated

from heavylift.nodes.scene.keys.base import Base, BodyPoint, part_name
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator, Field

from .mechanics import Parts

PartName = Annotated[str, AfterValidator(part_name)]  # `west.boom` of the machine `west`


class MachineKeys(Parts[PartName]):
    """A machine as computed by its type: a mechanism with prefixed part names."""


class Eye(Base):
    """Suspension of a frame: the falls hold the origin of a body, spread along its x."""

    body: str
    apart: u.Extent


class FrameParts(Parts[PartName]):
    """Parts of a frame on a hook as computed by its type."""

    eye: Eye
    slings: Annotated[list[BodyPoint], Field(min_length=1)]  # where they hang
    locked_while_empty: list[str] = Field(default_factory=list)  # brakes
