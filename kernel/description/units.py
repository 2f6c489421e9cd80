"""Dimension, SI unit and sign of the numbers of a description, as annotations of its fields; points and lines; order of
names.

Scenes write numbers with a unit of that dimension (`nodes.scene.text.units` has the tables). Rotations are row-major
3x3 tuples; a point is (body, position in that body's frame). Names are sorted naturally, "H2" before "H10". Elements
are sorted once, where a description is assembled, so that no result depends on the order in which they were declared.
"""

import re
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_type_hints


class Unit(NamedTuple):
    """The dimension of a quantity, and whether the quantity must be positive, zero or more, or one or more."""

    dimension: str
    least: Literal["", "zero", "positive", "one"] = ""


Number = Annotated[float, Unit("ratio")]
Ratio = Annotated[float, Unit("ratio", "zero")]
Length = Annotated[float, Unit("length")]  # [m]
Gap = Annotated[float, Unit("length", "zero")]
Angle = Annotated[float, Unit("angle")]  # [rad]
Extent = Annotated[float, Unit("length", "positive")]
Mass = Annotated[float, Unit("mass", "zero")]  # [kg]
Pull = Annotated[float, Unit("force", "positive")]  # [N]
AxialStiffness = Annotated[float, Unit("force", "positive")]  # EA [N]
Area = Annotated[float, Unit("area", "zero")]  # [m2]
Tension = Annotated[float, Unit("force", "zero")]  # EA of what may be rigid: 0 [N]
Rigidity = Annotated[float, Unit("bending stiffness", "zero")]  # EI, GJ [N m2]
MassPerLength = Annotated[float, Unit("mass per length", "positive")]  # [kg/m]
RotaryInertia = Annotated[float, Unit("moment of inertia per length", "zero")]  # [kg m]
Density = Annotated[float, Unit("density", "zero")]  # [kg/m3]
Push = Annotated[float, Unit("force")]  # [N]
Twist = Annotated[float, Unit("moment")]  # [N m]
Stiffness = Annotated[float, Unit("stiffness", "zero")]  # [N/m]
Damping = Annotated[float, Unit("damping", "zero")]  # [N s/m]
TensionRate = Annotated[float, Unit("rate of tension", "zero")]  # [N/s]
LineSpeed = Annotated[float, Unit("speed", "positive")]  # [m/s]
TurnStiffness = Annotated[float, Unit("torsional stiffness", "zero")]  # [N m/rad]
TurnDamping = Annotated[float, Unit("torsional damping", "zero")]  # [N m s/rad]

# of a coordinate that slides or turns
Stroke = Annotated[float, Unit("length or angle")]  # [m] or [rad]
Effort = Annotated[float, Unit("force or moment", "zero")]  # [N] or [N m]
AnyStiffness = Annotated[float, Unit("stiffness or torsional stiffness", "zero")]  # [N/m] or [N m/rad]
AnyDamping = Annotated[float, Unit("damping or torsional damping", "zero")]  # [N s/m] or [N m s/rad]

Direction = Annotated[tuple[float, float, float], Unit("direction")]  # of length 1; a scene may give it any


def wrong_sign(x: Any) -> tuple[str, str]:
    """Return the first field of an item with an invalid sign, and the error as text; otherwise "", ""."""
    for field, least in _signs(x.__class__):
        value = getattr(x, field)
        low = min(value) if isinstance(value, tuple) else value
        if not (low > 0.0 if least == "positive" else low >= 0.0):
            if isinstance(value, tuple):
                return field, f"are {value}; none can be negative"
            return field, f"is {value:g}; it {'must be positive' if least == 'positive' else 'cannot be negative'}"
    return "", ""


@cache
def _signs(kind: type) -> tuple[tuple[str, str], ...]:
    """Return the fields with restricted sign, each with its minimum."""
    found = []
    for field, hint in get_type_hints(kind, include_extras=True).items():
        inner = get_args(hint)
        units = [x for x in (*inner, *(get_args(inner[0]) if inner else ())) if isinstance(x, Unit)]
        found += [(field, x.least) for x in units[:1] if x.least]
    return tuple(found)


Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

WORLD = "world"
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Point:
    """A point fixed on a body, given in the frame of that body."""

    body: str
    p: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Line:
    """A straight part of a rope between two points; `share`: factor of its length in the length of the rope."""

    a: Point
    b: Point
    share: Ratio = 1.0


Key = tuple[tuple[str | tuple[int, str], ...], str]


@lru_cache(maxsize=4096)
def natural(name: str) -> Key:
    """Return the natural sort key of a name: its text and number parts in turn.

    Names with equal numbers, such as "1" and "01", are then ordered by their characters.
    """
    parts = re.split(r"([0-9]+)", name)
    numbers = (part.lstrip("0") for part in parts)  # in order of their lengths: no name is too long for that
    return tuple((len(x), x) if i % 2 else parts[i] for i, x in enumerate(numbers)), name
