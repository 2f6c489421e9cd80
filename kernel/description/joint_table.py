"""The joint table: everything the kernel knows of a joint type stands in one entry (spatial_v2's `jcalc`).

An entry is plain data without NumPy: the names of coordinates and velocities, and what moves the child.  That is
either a chain of elementary motions (slides before turns, so that every turn passes through the child's origin), or a
quaternion behind a free displacement.  `motion` reads the table for places, velocities and accelerations; a new joint
is a new entry.  `JOINTS.md` shows it with what may act on each joint.
"""

from dataclasses import dataclass, field
from typing import get_args

from .mechanics import JointKind

AXIS, SECOND, THIRD = range(3)  # `axis`, `second`, and axis x second of a joint
PITCH = None


@dataclass(frozen=True)
class JointMotion:
    """A turn about or a slide along an axis of the joint by factor * coordinate; factor None: the joint's pitch."""

    turns: bool
    axis: int
    coordinate: int
    factor: float | None = 1.0


def _turn(axis: int, coordinate: int, factor: float = 1.0) -> JointMotion:
    return JointMotion(True, axis, coordinate, factor)


def _slide(axis: int, coordinate: int, factor: float | None = 1.0) -> JointMotion:
    return JointMotion(False, axis, coordinate, factor)


@dataclass(frozen=True)
class JointType:
    """A row of the joint table.

    `coordinates` maps the coordinates' names to their values in the undisplaced joint, `velocities` names the
    velocities; in a chain of `motions` they are the coordinates' rates.  `quaternion` is where a unit one starts
    among the coordinates; what stands before it is a displacement, and the velocities are in the child's axes.
    """

    coordinates: dict[str, float] = field(default_factory=dict)
    velocities: tuple[str, ...] = ()
    motions: tuple[JointMotion, ...] = ()
    quaternion: int | None = None

    @property
    def rest(self) -> tuple[float, ...]:
        return tuple(self.coordinates.values())

    @property
    def n_q(self) -> int:
        return len(self.coordinates)

    @property
    def n_v(self) -> int:
        return len(self.velocities)

    @property
    def actable(self) -> tuple[str, ...]:
        """Coordinates that springs, stops, brakes or drives can act on: those whose rate is a velocity."""
        return tuple(self.coordinates) if self.quaternion is None else ()

    @property
    def axes(self) -> int:
        """Number of axes: none, `axis` only, or three with `second` (and their cross product)."""
        used = {m.axis for m in self.motions}
        return 3 if used - {AXIS} else len(used)

    @property
    def pitched(self) -> bool:
        return any(m.factor is PITCH for m in self.motions)

    def turns(self, coordinate: int) -> bool:
        """Whether a coordinate is an angle [rad], otherwise a length [m]."""
        return any(m.turns for m in self.motions if m.coordinate == coordinate)


QUATERNION = {"qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0}

JOINTS: dict[JointKind, JointType] = {
    "fixed": JointType(),
    "revolute": JointType({"angle": 0.0}, ("rate",), (_turn(AXIS, 0),)),
    "prismatic": JointType({"travel": 0.0}, ("speed",), (_slide(AXIS, 0),)),
    "cylindrical": JointType({"travel": 0.0, "angle": 0.0}, ("speed", "rate"), (_slide(AXIS, 0), _turn(AXIS, 1))),
    "screw": JointType({"angle": 0.0}, ("rate",), (_slide(AXIS, 0, PITCH), _turn(AXIS, 0))),
    "universal": JointType(
        {"angle1": 0.0, "angle2": 0.0}, ("rate1", "rate2"), (_turn(AXIS, 0), _turn(SECOND, 1))
    ),
    "planar": JointType(
        {"x": 0.0, "y": 0.0, "angle": 0.0}, ("vx", "vy", "rate"),
        (_slide(SECOND, 0), _slide(THIRD, 1), _turn(AXIS, 2)),
    ),
    # two universal joints in mirror image: the relative angular velocity has no part along the sum of both shafts
    "constant-velocity": JointType(
        {"angle1": 0.0, "angle2": 0.0}, ("rate1", "rate2"),
        (_turn(SECOND, 0), _turn(THIRD, 1, 2.0), _turn(SECOND, 0)),
    ),
    # along a flexible beam: the place on the beam moves (`flexible.attachment`), and nothing in the joint's own frame
    "slider": JointType({"travel": 0.0}, ("speed",), (_slide(AXIS, 0, 0.0),)),
    "spherical": JointType(QUATERNION, ("wx", "wy", "wz"), quaternion=0),
    "free": JointType(
        {"x": 0.0, "y": 0.0, "z": 0.0, **QUATERNION}, ("vx", "vy", "vz", "wx", "wy", "wz"), quaternion=3
    ),
}  # fmt: skip

assert set(JOINTS) == set(get_args(JointKind)), "each kind of joint is one row of the table"
