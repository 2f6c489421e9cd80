"""The keys `waves:` and `vessels:` of a scene: a regular wave on deep water, and what floats in it.

A vessel's axes are x to its bow, y to port, z up; its origin lies on the waterline at rest, and all responses are given
there.  A phase is that of the response against the wave's elevation at the origin: cos(w t + phase).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from heavylift.kernel.algebra.dense import product
from heavylift.kernel.description.mechanics import Matrix, Vector
from heavylift.nodes.scene.text import units as u
from pydantic import model_validator

from .base import Base, Place, turned
from .parts.forces import Matrix6
from .parts.mechanics import Moments

Response = tuple[Annotated[float, u.Quantity(u.RESPONSE, "zero")], u.Angle]
TurnResponse = tuple[Annotated[float, u.Quantity(u.TURN_RESPONSE, "zero")], u.Angle]
LoadResponse = tuple[u.Stiffness, u.Angle]
MomentResponse = tuple[Annotated[float, u.Quantity(u.MOMENT_RESPONSE, "zero")], u.Angle]


class Waves(Base):
    """A regular wave, which grows from still water at the start."""

    height: u.Extent  # from trough to crest
    period: u.Duration
    heading: u.Angle = 0.0  # to which it travels, from x towards y; 180 deg: against a bow that points along x
    ramp: u.Duration = 30.0  # in which it grows
    origin: Place = (0.0, 0.0, 0.0)  # where its elevation goes with the cosine of time
    density: u.Density = 1025.0  # of the water


class Responses(Base):
    """Motions of the origin per wave amplitude, and their phases."""

    surge: Response = (0.0, 0.0)
    sway: Response = (0.0, 0.0)
    heave: Response = (0.0, 0.0)
    roll: TurnResponse = (0.0, 0.0)
    pitch: TurnResponse = (0.0, 0.0)
    yaw: TurnResponse = (0.0, 0.0)


class LoadResponses(Base):
    """Forces and moments of the wave about the origin per wave amplitude, and their phases."""

    surge: LoadResponse = (0.0, 0.0)
    sway: LoadResponse = (0.0, 0.0)
    heave: LoadResponse = (0.0, 0.0)
    roll: MomentResponse = (0.0, 0.0)
    pitch: MomentResponse = (0.0, 0.0)
    yaw: MomentResponse = (0.0, 0.0)


class Mooring(Base):
    """Stiffness of its mooring at the origin."""

    surge: u.Stiffness = 0.0
    sway: u.Stiffness = 0.0
    yaw: u.TurnStiffness = 0.0


class Floating(Base):
    """What keeps a vessel up and turns it back, and what the water takes: matrices in SI units, surge to yaw."""

    waterplane: Annotated[float, u.Quantity(u.AREA, "positive")]
    GM: u.Extent  # of roll, with all that stands on it at the start
    GML: u.Extent  # of pitch
    added_mass: Matrix6 | None = None  # at the wave's frequency, as `damping`
    damping: Matrix6 | None = None
    mooring: Mooring = Mooring()
    loads: LoadResponses = LoadResponses()  # of the wave


class Vessel(Base):
    """A vessel, whose motion in the wave is `given` by its responses, or follows from `forces` on a free body."""

    mass: u.Mass  # without what stands on it
    size: tuple[u.Extent, u.Extent, u.Extent]  # of its hull, a uniform box unless `inertia` is given
    draught: u.Extent
    at: Place = (0.0, 0.0, 0.0)  # its origin
    heading: u.Angle = 0.0  # where its bow points, from x towards y; what stands on it turns with it
    com: Place = (0.0, 0.0, 0.0)
    inertia: Moments | None = None  # about its centre of mass
    motion: Literal["given", "forces"] = "given"
    responses: Responses | None = None  # if it is given
    floating: Floating | None = None  # if it follows from forces

    @property
    def attitude(self) -> Matrix:
        """Its axes in the world, at rest."""
        return turned(0.0, 0.0, self.heading)

    def place(self, p: Sequence[float]) -> Vector:
        """Where a place on it is in the world, at rest [m]."""
        x, y, z = (a + b for a, b in zip(product(self.attitude, p), self.at, strict=True))
        return x, y, z

    @model_validator(mode="after")
    def _one(self) -> Vessel:
        needs, other = ("responses", "floating") if self.motion == "given" else ("floating", "responses")
        if getattr(self, needs) is None:
            raise ValueError(f"motion: {self.motion} needs '{needs}'")
        if getattr(self, other) is not None:
            raise ValueError(f"motion: {self.motion} needs no '{other}': leave it out")
        return self
