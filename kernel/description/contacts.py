"""Rigid contacts as plain data: shapes of bodies that cannot pass each other, with friction and restitution."""

from msgspec import Struct

from . import units as u
from .units import IDENTITY, Matrix, Vector


class Ball(Struct, frozen=True, tag=True):
    """A ball on a body; radius 0: a point."""

    body: str
    p: Vector = (0.0, 0.0, 0.0)
    radius: float = 0.0


class Box(Struct, frozen=True, tag=True):
    """A box of a body: centre p, edges `size` along the columns of R."""

    body: str
    size: Vector
    p: Vector = (0.0, 0.0, 0.0)
    R: Matrix = IDENTITY


class Plane(Struct, frozen=True, tag=True):
    """The half space below a plane of a body; `normal` points out of it."""

    body: str = "world"
    p: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)


Shape = Ball | Box | Plane


class Contact(Struct, frozen=True):
    """Two shapes of different bodies: rigid, unilateral, Coulomb friction `mu`, Newton's `restitution`."""

    name: str
    a: Ball | Box
    b: Ball | Box | Plane
    mu: u.Ratio = 0.0
    restitution: float = 0.0
