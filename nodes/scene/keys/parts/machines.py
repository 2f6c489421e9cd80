"""Machines as lists of parts, in the form that their types generate."""

from typing import Annotated

from heavylift.nodes.scene.keys.base import Base, BodyPoint, part_name
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator, Field

from .mechanics import Parts

PartName = Annotated[str, AfterValidator(part_name)]  # `west.boom` of the machine `west`


class MachineKeys(Parts[PartName]):
    """Keys of a machine that its type has generated: a mechanism whose parts have the machine's name as prefix."""


class Eye(Base):
    """Eye of a frame: two rope falls hold it at +- `apart` / 2 [m] along the x axis of a body."""

    body: str
    apart: u.Extent


class FrameParts(Parts[PartName]):
    """The parts of a frame on a hook, as the type of the frame generates them."""

    eye: Eye
    slings: Annotated[list[BodyPoint], Field(min_length=1)]  # where they hang
    locked_while_empty: list[str] = Field(default_factory=list)  # brakes
