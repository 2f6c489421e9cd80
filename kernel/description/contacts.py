"""Rigid contacts as plain data: shapes of bodies that cannot penetrate each other, with friction and restitution."""

from msgspec import Struct

from . import units as u
from .units import IDENTITY, Matrix, Vector


class Ball(Struct, frozen=True, tag=True):
    """A ball-shaped contact surface fixed on a body; radius 0 makes it a point."""

    body: str
    p: Vector = (0.0, 0.0, 0.0)
    radius: float = 0.0


class Box(Struct, frozen=True, tag=True):
    """A box-shaped contact surface fixed on a body: centre p, edge lengths `size` along the columns of R."""

    body: str
    size: Vector
    p: Vector = (0.0, 0.0, 0.0)
    R: Matrix = IDENTITY


class Plane(Struct, frozen=True, tag=True):
    """A contact surface fixed on a body: the half space below a plane; `normal` points out of the half space."""

    body: str = "world"
    p: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)


Shape = Ball | Box | Plane


class Contact(Struct, frozen=True):
    """Rigid, unilateral contact between two shapes of different bodies, with Coulomb friction `mu` and Newton's
    coefficient of restitution."""

    name: str
    a: Ball | Box
    b: Ball | Box | Plane
    mu: u.Ratio = 0.0
    restitution: float = 0.0
