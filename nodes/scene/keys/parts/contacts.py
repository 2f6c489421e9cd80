"""The keys of `mechanism: contacts:` in a scene file, and the kernel's contacts made from them.

A contact is between one body and another body or, if none is named, the ground: a `box`, or a ball of some `radius`
(without it: a point), against the plane, box or ball given under `against`.
"""

from heavylift.kernel.constraints.contact.pairs import gap
from heavylift.kernel.description.contacts import Ball, Box, Contact, Plane, Shape
from heavylift.kernel.description.units import WORLD
from heavylift.nodes.scene.keys.base import Base, Direction, Place, Quaternion, quaternion_matrix
from heavylift.nodes.scene.text.units import Extent, Ratio
from pydantic import Field

from .kinematics import Poses

Sizes = tuple[Extent, Extent, Extent]


class _Side(Base):
    at: Place = (0.0, 0.0, 0.0)
    box: Sizes | None = None
    radius: Extent | None = None
    attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)


class Against(_Side):
    """The second side of a contact: a plane by default, or a box or ball if a box or a radius is given."""

    body: str = WORLD
    normal: Direction = (0.0, 0.0, 1.0)


class ContactKeys(_Side):
    """A rigid contact with friction; `restitution`: ratio of the speeds after and before an impact."""

    body: str
    against: Against = Field(default_factory=Against)
    friction: Ratio = 0.0
    restitution: Ratio = 0.0


def built(name: str, x: ContactKeys) -> Contact:
    """Return the kernel's contact made from the keys."""
    b: Shape = Plane(x.against.body, x.against.at, x.against.normal)
    if x.against.box or x.against.radius:
        b = _solid(x.against.body, x.against)
    return Contact(name, _solid(x.body, x), b, x.friction, x.restitution)


def _solid(body: str, x: _Side) -> Ball | Box:
    if x.box:
        return Box(body, x.box, x.at, quaternion_matrix(x.attitude))
    return Ball(body, x.at, x.radius or 0.0)


def touches(contact: Contact, at: Poses, width: float) -> bool:
    """Return whether the two shapes of a contact are closer than `width` [m]."""
    return gap(contact, at[contact.a.body], at[contact.b.body]) < width
