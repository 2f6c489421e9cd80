"""The keys `floor:` and `obstacles:` of a scene: what blocks can meet, as rigid contacts with friction."""

from __future__ import annotations

from typing import Literal

from heavylift.nodes.scene.text import units as u

from .base import Base, Place


class Floor(Base):
    """A level floor that all blocks meet."""

    height: u.Length = 0.0
    friction: u.Ratio = 0.0
    restitution: u.Ratio = 0.0


class Obstacle(Base):
    """A box that is fixed in the yard or on a vessel, such as a wall, a guide, a quay: all blocks meet it."""

    box: tuple[u.Extent, u.Extent, u.Extent]
    at: Place  # its middle, in the frame of what it is on
    rotation: tuple[u.Angle, u.Angle, u.Angle] = (0.0, 0.0, 0.0)  # about x, then y, then z
    on: str = "world"  # or a vessel
    meets: Literal["boxes", "corners", "lower corners"] = (
        "boxes"  # of blocks: lower corners cost half, and miss its own
    )
    friction: u.Ratio = 0.0
    restitution: u.Ratio = 0.0
