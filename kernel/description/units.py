"""What the numbers of a description are, as annotations of its fields; scenes write them with units of that kind.

`Unit` names a kind of quantity as `nodes.scene.text.units` has it, and how small a scene may make it.  Values of the
kernel are in SI units and it checks them itself.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple


class Unit(NamedTuple):
    """A kind of quantity, and whether it must be zero or more, or positive."""

    dimension: str
    least: Literal["", "zero", "positive"] = ""


Number = Annotated[float, Unit("ratio")]
Ratio = Annotated[float, Unit("ratio", "zero")]
Length = Annotated[float, Unit("length")]  # [m]
Gap = Annotated[float, Unit("length", "zero")]
Angle = Annotated[float, Unit("angle")]  # [rad]
Area = Annotated[float, Unit("area", "zero")]  # [m2]
Density = Annotated[float, Unit("density", "zero")]  # [kg/m3]
Push = Annotated[float, Unit("force")]  # [N]
Twist = Annotated[float, Unit("moment")]  # [N m]
Stiffness = Annotated[float, Unit("stiffness", "zero")]  # [N/m]
Damping = Annotated[float, Unit("damping", "zero")]  # [N s/m]
TurnStiffness = Annotated[float, Unit("torsional stiffness", "zero")]  # [N m/rad]
TurnDamping = Annotated[float, Unit("torsional damping", "zero")]  # [N m s/rad]

# of a coordinate that slides or turns
Stroke = Annotated[float, Unit("length or angle")]  # [m] or [rad]
Effort = Annotated[float, Unit("force or moment", "positive")]  # [N] or [N m]
AnyStiffness = Annotated[float, Unit("stiffness or torsional stiffness", "zero")]  # [N/m] or [N m/rad]
AnyDamping = Annotated[float, Unit("damping or torsional damping", "zero")]  # [N s/m] or [N m s/rad]

Direction = Annotated[tuple[float, float, float], Unit("direction")]  # of length 1; a scene may give it any
