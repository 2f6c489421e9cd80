"""The mechanics of a scene as plain data: what the nodes declare and the kernel compiles.

Frozen dataclasses of numbers and names, without NumPy, so that a node process that only declares starts at once.
SI units; rotations are row-major 3x3 tuples; a point is (body, position in that body's frame).  Monogram notation:
`p_PJ` is the position of joint J from parent P, expressed in P.  The body "world" is the ground.
"""

from __future__ import annotations  # read late: kinds of forces may be added

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from .contacts import Contact
from .flexible import Flexible
from .forces import Force, Matrix6, Reeving, UserLaw
from .laws import Brake as Brake
from .laws import Drive as Drive
from .laws import JointSpring as JointSpring
from .laws import Law as Law
from .laws import Lock as Lock
from .laws import RigidRope as RigidRope
from .laws import Rope as Rope
from .laws import Stop as Stop
from .laws import Support as Support
from .name_order import natural
from .points import IDENTITY as IDENTITY
from .points import WORLD as WORLD
from .points import Line as Line
from .points import Matrix as Matrix
from .points import Point as Point
from .points import Vector as Vector
from .signals import Quantity as Quantity
from .signals import Threshold as Threshold

MethodName = Literal["semi-implicit-euler", "rk4", "dopri5", "dop853", "radau5"]
RemovedMethod = Literal["ros34pw2", "sdirk2", "sdirk3"]  # in older scenes: radau5 takes their place
JointKind = Literal[
    "fixed", "revolute", "prismatic", "cylindrical", "screw", "universal", "planar", "constant-velocity",
    "spherical", "free", "slider",
]  # fmt: skip


@dataclass(frozen=True)
class Body:
    """A body; its frame is that of the joint that carries it, unless the joint states otherwise.

    `flexible` adds a deformable part, whose floating frame that is; mass, com and inertia are then those of what sits
    rigidly in that frame (0: nothing).
    Where nothing has mass, moments of inertia may be any, such as those of a rotor behind its gear.
    `added` is the added mass of water about the frame's origin, in body axes, linear before angular: it resists
    acceleration and weighs nothing (Kirchhoff's equations of a body in an ideal fluid).
    """

    name: str
    mass: float  # [kg]
    com: Vector = (0.0, 0.0, 0.0)  # p_BC, centre of mass [m]
    inertia: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # about the centre of mass, body axes [kg m2]
    flexible: Flexible | None = None
    added: Matrix6 | None = None  # [kg, kg m, kg m2]


@dataclass(frozen=True)
class Joint:
    """A joint between `child` and `parent`; its frame is (p_PJ, R_PJ) on the parent and (p_CJ, R_CJ) on the child.

    A body needs one joint of which it is the child; every further one closes a loop, as does one whose child is the
    world.  Which of them are cut is found by the kernel (`spanning_tree`); of those q0 and v0 are not used.

    q0 and v0 hold the initial coordinates and velocities, in the order of `joint_table.JOINTS` (see JOINTS.md): a
    quaternion is x y z w; the velocities of a spherical or free joint are in child axes, linear before angular.
    `second` is perpendicular to `axis`: the other axis of a universal joint (carried along by the first), the x
    direction in the plane whose normal is `axis`, or the first bending axis of the shaft `axis`.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    p_PJ: Vector = (0.0, 0.0, 0.0)
    R_PJ: Matrix = IDENTITY
    axis: Vector = (0.0, 0.0, 1.0)  # unit vector in the joint frame
    second: Vector = (1.0, 0.0, 0.0)  # unit vector in the joint frame, for joints that have one
    pitch: float = 0.0  # of a screw: advance along the axis per angle [m/rad]
    q0: tuple[float, ...] = ()
    v0: tuple[float, ...] = ()
    p_CJ: Vector = (0.0, 0.0, 0.0)
    R_CJ: Matrix = IDENTITY


@dataclass(frozen=True)
class Master:
    """A commanded scalar followed by several actuators, such as the angle of a turn."""

    name: str
    value: float = 0.0  # at the start


@dataclass(frozen=True)
class Measured:
    """A measured scalar that actuators can follow: attitude of `of` about world axis, or a joint coordinate.

    kind "angle": rotation of body `of` about the horizontal axis `axis` (0 = x, 1 = y), positive as +w towards
    +y for axis 0 (the lift's theta).  kind "joint": coordinate of joint `of`.  `followers`: the only actuators that may
    follow it; none named: all may.
    """

    name: str
    kind: Literal["angle", "joint"]
    of: str
    axis: int = 0
    coordinate: str = ""  # of a joint that has several
    followers: tuple[str, ...] = ()


@dataclass(frozen=True)
class System:
    """Everything the kernel needs; declarations of several nodes are joined with `assembled`."""

    bodies: tuple[Body, ...] = ()
    joints: tuple[Joint, ...] = ()
    springs: tuple[JointSpring, ...] = ()
    stops: tuple[Stop, ...] = ()
    brakes: tuple[Brake, ...] = ()
    locks: tuple[Lock, ...] = ()
    drives: tuple[Drive, ...] = ()
    ropes: tuple[Rope, ...] = ()
    rigid_ropes: tuple[RigidRope, ...] = ()
    supports: tuple[Support, ...] = ()
    forces: tuple[Force, ...] = ()  # kinds of the force table
    contacts: tuple[Contact, ...] = ()
    masters: tuple[Master, ...] = ()
    measured: tuple[Measured, ...] = ()
    thresholds: tuple[Threshold, ...] = ()
    gravity: float = field(default=9.80665)  # downwards along -z [m/s2]

    @property
    def laws(self) -> tuple[Law, ...]:
        """All entries of the force table: ropes, supports, springs, stops and brakes, then forces."""
        return *self.ropes, *self.supports, *self.springs, *self.stops, *self.brakes, *self.forces

    @property
    def reevings(self) -> tuple[Reeving, ...]:
        """Ropes over sheaves among its forces."""
        return tuple(f for f in self.forces if isinstance(f, Reeving))

    @property
    def outside(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Bodies and joints that its parts refer to and others declare, in order of appearance."""
        points = [p.body for law in (*self.laws, *self.rigid_ropes) for p in law.points]
        shapes = [shape.body for contact in self.contacts for shape in (contact.a, contact.b)]
        bodies = [body for j in self.joints for body in (j.parent, j.child)] + points + shapes
        along = [law.along[0] for law in self.laws if law.along]
        along += [drive.joint for drive in self.drives] + [lock.joint for lock in self.locks]
        own, joints = {WORLD, *(b.name for b in self.bodies)}, {j.name for j in self.joints}
        outer = tuple(body for body in dict.fromkeys(bodies) if body not in own)
        return outer, tuple(joint for joint in dict.fromkeys(along) if joint not in joints)

    @property
    def functions(self) -> tuple[str, ...]:
        """Python functions of its laws."""
        laws = (f for f in self.forces if isinstance(f, UserLaw))
        return tuple(function for law in laws for function in (law.function, law.guards) if function)

    @property
    def all_ropes(self) -> tuple[Rope | RigidRope | Reeving, ...]:
        """Ropes of straight lines, elastic and rigid ones, then those over sheaves."""
        return *self.straight_ropes, *self.reevings

    @property
    def straight_ropes(self) -> tuple[Rope | RigidRope, ...]:
        """Elastic ropes, then rigid ones."""
        return self.ropes + self.rigid_ropes


GROUPS = tuple(f.name for f in fields(System) if f.name != "gravity")


def merge(parts: Iterable[System], gravity: float) -> System:
    """One system from several, in order."""
    whole: dict[str, list[Any]] = {group: [] for group in GROUPS}
    for part in parts:
        for group, items in whole.items():
            items += getattr(part, group)
    return System(**{group: tuple(items) for group, items in whole.items()}, gravity=gravity)


def assembled(declared: list[System], gravity: float) -> System:
    """The system of a run from its nodes' declarations, with elements sorted by name."""
    whole = merge(declared, gravity)
    named = {g: tuple(sorted(getattr(whole, g), key=lambda x: natural(x.name))) for g in GROUPS}
    return System(**named, gravity=gravity)
