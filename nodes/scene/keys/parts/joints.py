"""The joints of `mechanism:` in a scene file: one model of keys for each type of joint, with its own units, and the
kernel's joint made from them.

`at` and `rotation` place the joint's frame on its parent; axes are written in that frame. `start` and `speed` follow
the order of the coordinates in the kernel's table of joints. `limits` and `friction` of a coordinate are end stops and
a brake that is always engaged, written with the joint.
"""

from collections.abc import Iterable, Iterator
from functools import reduce
from math import pi
from operator import itemgetter, or_
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_args

from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.mechanics import JOINTS
from heavylift.nodes.scene.keys.base import (
    Base,
    Direction,
    Place,
    Quaternion,
    Station,
    across,
    keys_of,
    one,
    turned,
    unit,
    written,
)
from heavylift.nodes.scene.text.units import Angle, AnyDamping, AnyStiffness, Effort, Length, Rate, Stroke, Velocity
from pydantic import Field, WrapValidator, create_model

Range = tuple[Stroke, Stroke]
ENDS = {key: one("range", Range, itemgetter(i)) for i, key in enumerate(("lower", "upper"))}  # of a stop
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
POSITIONS, SPEEDS = ("start", "position", "attitude"), ("speed", "velocity", "rate")  # keys that q0 and v0 are made of


class Limits(keys_of(k.Stop, "joint", "coordinate", **ENDS)):  # type: ignore[misc]
    """Elastic end stops of a joint coordinate."""


class Friction(Base):
    """Friction of a joint coordinate: viscous (effort per velocity) and dry.

    `dry` is the effort at which a spring and damper begin to slip."""

    viscous: AnyDamping = 0.0
    dry: Effort | None = None
    stiffness: AnyStiffness = 0.0
    damping: AnyDamping = 0.0


class AnyJoint(Base):
    """Keys that all joints have.

    `at child`: place of the joint on the child; `rotation`: angles by which the joint's frame is rotated about the
    parent's x, y and z axes, in this order."""

    type: k.JointKind
    parent: str = "world"
    child: str
    at: Station = (0.0, 0.0, 0.0)
    at_child: Place = (0.0, 0.0, 0.0)
    rotation: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    limits: dict[str, Limits] = Field(default_factory=dict)
    friction: dict[str, Friction] = Field(default_factory=dict)

    directions: ClassVar[tuple[str, ...]] = ()  # keys of `axis` and, if it has one, `second` of the kernel's joint

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the joint coordinates on which laws can act."""
        return JOINTS[self.type].actable

    def turns(self, coordinate: str) -> bool:
        """Return whether a joint coordinate is an angle."""
        return JOINTS[self.type].turns(self.coordinates.index(coordinate))

    def values(self, keys: Iterable[str]) -> tuple[float, ...]:
        """Return the values of the given keys, as far as this type of joint has them; quaternions are normalised."""
        found: list[float] = []
        for key in keys:
            value = getattr(self, key, ())
            value = unit(value) if key == "attitude" and value else value
            found += value if isinstance(value, tuple) else (value,)
        return tuple(found)

    def built(self, name: str) -> k.Joint:
        """Return the kernel's joint; if it closes a loop, the kernel computes its missing coordinates and speeds."""
        written = self.model_fields_set
        q0, v0 = (self.values(keys) if written & {*keys} else () for keys in (POSITIONS, SPEEDS))
        axes = [getattr(self, key.replace(" ", "_")) for key in self.directions]
        axis = axes[0] if axes else Z
        second = axes[1] or across(axis) if len(axes) > 1 else X
        place = (self.parent, self.child, self.at, turned(*self.rotation))
        pitch = getattr(self, "lead", 0.0) / (2.0 * pi)
        return k.Joint(name, self.type, *place, unit(axis), unit(second), pitch, q0=q0, v0=v0, p_CJ=self.at_child)

    def laws(self, name: str) -> Iterator[k.Stop | k.Brake | k.JointSpring]:
        """Yield the force laws of the kernel made from the keys `limits` and `friction` of a joint."""
        for c, x in self.limits.items():
            yield x.built(f"{name}.{c}.limits", name, coordinate=c)
        for c, f in self.friction.items():
            if f.viscous:
                yield k.JointSpring(f"{name}.{c}.viscous", name, d=f.viscous, coordinate=c)
            if f.dry:
                yield k.Brake(f"{name}.{c}.dry", name, f.dry, f.stiffness, f.damping, engaged=True, coordinate=c)


class Spherical(AnyJoint):
    """A joint that turns about all axes.

    `attitude` is a quaternion (x, y, z, w), `rate` the angular velocity in the child's axes."""

    type: Literal["spherical"]
    attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)
    rate: tuple[Rate, Rate, Rate] = (0.0, 0.0, 0.0)


class Free(AnyJoint):
    """A joint with all six degrees of freedom; velocity and angular velocity are given in the child's axes."""

    type: Literal["free"]
    position: Place = (0.0, 0.0, 0.0)
    attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    rate: tuple[Rate, Rate, Rate] = (0.0, 0.0, 0.0)


TYPES: dict[k.JointKind, tuple[str, dict[str, Any]]] = {  # of the other joints: what they do, their keys
    "fixed": ("No motion.", {}),
    "revolute": ("Turns about `axis`.", {"axis": Direction}),
    "prismatic": ("Slides along `axis`.", {"axis": Direction}),
    "cylindrical": ("Slides along and turns about `axis`: travel, angle.", {"axis": Direction}),
    "screw": ("Turns about `axis` and advances along it by `lead` a turn.", {"axis": Direction, "lead": Length}),
    "universal": (
        "Turns about `axis` of the parent, then about `second axis`, which the first turn carries along.",
        {"axis": Direction, "second_axis": Direction},
    ),
    "planar": (
        "Slides in the plane across `normal` and turns about it: x along `x axis`, y, angle.",
        {"normal": Direction, "x_axis": Direction | None},
    ),
    "constant-velocity": (
        "Bends a shaft along `shaft` about two axes across it, the first of which may be given as `bend axis`.",
        {"shaft": Direction, "bend_axis": Direction | None},
    ),
    "slider": ("Slides along a flexible beam; `start` is its place there, `at` an arm from the beam's axis.", {}),
}


ABOVE: Literal["above its lugs"] = "above its lugs"
"""Start value of a joint that slides along y: above the lugs of the load below, else in the middle of its range."""


def _model(kind: k.JointKind, about: str, own: dict[str, Any]) -> Any:
    """Return the model of keys for a type of joint, with its axes and start values."""
    turns = [JOINTS[kind].turns(i) for i in range(JOINTS[kind].n_q)]
    fields: dict[str, Any] = {"type": (Literal[kind], ...)}
    fields |= {key: (each, None if NoneType in get_args(each) else ...) for key, each in own.items()}
    for key, slide, turn in (("start", Length, Angle), ("speed", Velocity, Rate)):
        each = tuple(turn if x else slide for x in turns)
        if kind == "prismatic" and key == "start":
            fields[key] = (Annotated[Length, WrapValidator(lambda x, read: x if x == ABOVE else read(x))], 0.0)
        elif each:
            fields[key] = (tuple[each], (0.0,) * len(each)) if len(each) > 1 else (each[0], 0.0)  # type: ignore[valid-type]
    name = kind.title().replace("-", "")
    model: Any = create_model(name, __base__=AnyJoint, __doc__=about, **fields)
    model.directions = tuple(written(key) for key in own if key != "lead")
    return model


if TYPE_CHECKING:
    Joint = AnyJoint
else:
    MODELS = (*(_model(kind, *row) for kind, row in TYPES.items()), Spherical, Free)
    Joint = Annotated[reduce(or_, MODELS), Field(discriminator="type")]
