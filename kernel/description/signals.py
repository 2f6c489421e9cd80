"""What can be sampled of a scene: the quantities of thresholds, and the swing of a rope."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from .mechanics import Point

__all__ = ["Sampled", "Signal"]

Sampled: TypeAlias = Literal["height", "tension", "angle", "joint", "speed", "length", "swing along", "swing across"]


@dataclass(frozen=True)
class Signal:
    """A scalar of a scene; fields and quantities are those of `Threshold`.

    "swing along" and "swing across": angle of ropes[0] to the vertical in the planes x, z and y, z [rad], positive
    where its lower end is ahead in +x or +y.
    """

    quantity: Sampled
    of: str = ""
    point: Point | None = None
    ropes: tuple[str, ...] = ()
    axis: int = 0
    coordinate: str = ""  # of a joint that has several
