"""The keys of a machine's base and of the ground below it."""

from typing import Annotated

from heavylift.nodes.scene.keys.base import Base, Name, Place
from heavylift.nodes.scene.text import units as u
from pydantic import Field, model_validator


class Tracks(Base):
    """Two crawler tracks, parallel to the x axis of their body."""

    length: u.Extent  # of each that bears
    width: u.Extent  # of each
    apart: u.Extent  # from middle to middle


class Outriggers(Base):
    """Four outriggers, at the corners of a rectangle."""

    length: u.Extent  # between front and rear ones
    width: u.Extent  # between left and right ones
    pad: Annotated[u.Area, Field(gt=0)]  # of each


class Wheels(Base):
    """Wheels at the four corners of a rectangle, on rails or on the ground."""

    length: u.Extent  # between front and rear corners
    width: u.Extent  # between left and right corners
    each: Annotated[int, Field(ge=1)]  # of wheels at a corner
    capacity: u.Mass | None = None  # of each wheel; left out: not checked


class Stands(Base):
    """The base of a machine: tracks, outriggers, wheels or, by default, a foundation, which is not checked."""

    on: str  # the body that has them
    at: Place = (0.0, 0.0, 0.0)  # middle of the base on the ground, in the frame of that body
    tracks: Tracks | None = None
    outriggers: Outriggers | None = None
    wheels: Wheels | None = None

    @model_validator(mode="after")
    def _one(self) -> "Stands":
        if sum(x is not None for x in (self.tracks, self.outriggers, self.wheels)) > 1:
            raise ValueError("a machine can stand on only one of 'tracks', 'outriggers' and 'wheels'")
        return self


class Mats(Base):
    """Mats below each track or outrigger of a crane."""

    area: Annotated[u.Area, Field(gt=0)]  # that bears
    mass: u.AnyMass = 0.0


class GroundKeys(Base):
    """The ground below cranes on tracks or outriggers: its allowed pressure, and the mats."""

    bearing: u.Pressure | None = None  # permissible pressure; left out: not checked
    mats: dict[Name, Mats] = Field(default_factory=dict)  # by crane
