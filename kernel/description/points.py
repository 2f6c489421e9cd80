"""Places as plain data: what bodies, joints and forces are described with.

SI units; rotations are row-major 3x3 tuples; a point is (body, position in that body's frame).
"""

from dataclasses import dataclass

from .units import Ratio

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

WORLD = "world"
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Point:
    """A point fixed on a body."""

    body: str
    p: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Line:
    """A straight part of a rope; `share`: its weight in the rope's length."""

    a: Point
    b: Point
    share: Ratio = 1.0
