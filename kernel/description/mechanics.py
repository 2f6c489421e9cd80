"""The mechanics of a scene as plain data: what the nodes declare and the kernel compiles.

Frozen dataclasses of numbers and names, without NumPy, so that a node process that only declares starts at once.
SI units; rotations are row-major 3x3 tuples; a point is (body, position in that body's frame).  Monogram notation:
`p_PJ` is the position of joint J from parent P, expressed in P.  The body "world" is the ground.

Everything the kernel knows of a joint type is one entry of JOINTS (spatial_v2's `jcalc`): the names of coordinates and
velocities, and what moves the child.  That is either a chain of elementary motions (slides before turns, so that every
turn passes through the child's origin), or a quaternion behind a free displacement.  `motion` reads the table for
places, velocities and accelerations.  `JOINTS.md` shows it with what may act on each joint.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Literal, get_args

from .contacts import Contact
from .flexible import Flexible
from .forces import Force, Matrix6, MooringLine, Reeving, RopeForce, TuggerLine, UserLaw
from .laws import (
    Brake as Brake,
    Drive as Drive,
    JointSpring as JointSpring,
    Law as Law,
    Lock as Lock,
    RigidRope as RigidRope,
    Rope as Rope,
    Stop as Stop,
    Support as Support,
)
from .signals import Quantity as Quantity, Threshold as Threshold
from .units import (
    IDENTITY as IDENTITY,
    WORLD as WORLD,
    Line as Line,
    Matrix as Matrix,
    Point as Point,
    Vector as Vector,
    natural,
)

MethodName = Literal["semi-implicit-euler", "rk4", "dopri5", "dop853", "radau5"]
RemovedMethod = Literal["ros34pw2", "sdirk2", "sdirk3"]  # in older scenes: radau5 takes their place
JointKind = Literal[
    "fixed", "revolute", "prismatic", "cylindrical", "screw", "universal", "planar", "constant-velocity",
    "spherical", "free", "slider",
]  # fmt: skip


AnyRope = Rope | RigidRope | RopeForce


@dataclass(frozen=True)
class SharedWater:
    """Added mass of water between a body and its neighbour `beside`.

    Maps the twist of the neighbour, in the neighbour's axes, to the momentum of the water about this body's origin in
    this body's axes, linear before angular.
    """

    beside: str
    added: Matrix6  # [kg, kg m, kg m2]


@dataclass(frozen=True)
class Body:
    """A rigid or flexible body; its frame is that of the joint that carries it, unless the joint states otherwise.

    `flexible` adds a deformable part, whose floating frame is the body's frame; mass, com and inertia are then those of
    the parts fixed rigidly to that frame (0: none). A massless body may have any moments of inertia, such as those of a
    rotor behind its gear. `added` is the added mass of water about the frame's origin, in body axes, linear before
    angular: it resists acceleration and has no weight (Kirchhoff's equations of a body in an ideal fluid).
    """

    name: str
    mass: float  # [kg]
    com: Vector = (0.0, 0.0, 0.0)  # p_BC, centre of mass [m]
    inertia: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # about the centre of mass, body axes [kg m2]
    flexible: Flexible | None = None
    added: Matrix6 | None = None  # [kg, kg m, kg m2]
    shared: SharedWater | None = None


@dataclass(frozen=True)
class Joint:
    """A joint between `child` and `parent`; its frame is (p_PJ, R_PJ) on the parent and (p_CJ, R_CJ) on the child.

    A body needs one joint of which it is the child; every further one closes a loop, as does one whose child is the
    world. The kernel chooses the joints at which loops are cut (`spanning_tree`); their q0 and v0 are not used.

    q0 and v0 hold the initial coordinates and velocities, in the order of `JOINTS` (see JOINTS.md): a quaternion is x y
    z w; the velocities of a spherical or free joint are in child axes, linear before angular. `second` is perpendicular
    to `axis`: the other axis of a universal joint (carried along by the first), the x direction in the plane whose
    normal is `axis`, or the first bending axis of the shaft `axis`.
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
    """A commanded scalar (master signal), such as the angle of a turn-over, that several actuators follow."""

    name: str
    value: float = 0.0  # at the start


@dataclass(frozen=True)
class Measured:
    """A measured scalar (master signal) that actuators can follow: the attitude of body `of` about a world axis, or a
    joint coordinate.

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
    """The complete mechanical system; `assembled` joins the declarations of several nodes."""

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
        """All force laws of the system: ropes, supports, springs, stops, brakes, then other forces."""
        return *self.ropes, *self.supports, *self.springs, *self.stops, *self.brakes, *self.forces

    @property
    def reevings(self) -> tuple[Reeving, ...]:
        """The ropes over sheaves, which are stored among the forces."""
        return tuple(f for f in self.forces if isinstance(f, Reeving))

    @property
    def outside(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The names of bodies and joints to which this system refers without declaring them, in order of appearance."""
        points = [p.body for law in (*self.laws, *self.rigid_ropes) for p in law.points]
        shapes = [shape.body for contact in self.contacts for shape in (contact.a, contact.b)]
        bodies = [body for j in self.joints for body in (j.parent, j.child)] + points + shapes
        bodies += [b.shared.beside for b in self.bodies if b.shared]
        along = [law.along[0] for law in self.laws if law.along]
        along += [drive.joint for drive in self.drives] + [lock.joint for lock in self.locks]
        own, joints = {WORLD, *(b.name for b in self.bodies)}, {j.name for j in self.joints}
        outer = tuple(body for body in dict.fromkeys(bodies) if body not in own)
        return outer, tuple(joint for joint in dict.fromkeys(along) if joint not in joints)

    @property
    def functions(self) -> tuple[str, ...]:
        """The Python functions of the user-defined laws."""
        laws = (f for f in self.forces if isinstance(f, UserLaw))
        return tuple(function for law in laws for function in (law.function, law.guards) if function)

    @property
    def mooring_lines(self) -> tuple[MooringLine, ...]:
        """The mooring lines, which are stored among the forces."""
        return tuple(f for f in self.forces if isinstance(f, MooringLine))

    @property
    def tugger_lines(self) -> tuple[TuggerLine, ...]:
        """The tugger lines, which are stored among the forces."""
        return tuple(f for f in self.forces if isinstance(f, TuggerLine))

    @property
    def all_ropes(self) -> tuple[AnyRope, ...]:
        """All ropes: elastic and rigid ropes over straight lines, ropes over sheaves, mooring and tugger lines."""
        return *self.straight_ropes, *self.reevings, *self.mooring_lines, *self.tugger_lines

    @property
    def straight_ropes(self) -> tuple[Rope | RigidRope, ...]:
        """The ropes over straight lines: elastic ones, then rigid ones."""
        return self.ropes + self.rigid_ropes


GROUPS = tuple(f.name for f in fields(System) if f.name != "gravity")


def merge(parts: Iterable[System], gravity: float) -> System:
    """Return one system that contains the elements of several systems, in their order."""
    whole: dict[str, list[Any]] = {group: [] for group in GROUPS}
    for part in parts:
        for group, items in whole.items():
            items += getattr(part, group)
    return System(**{group: tuple(items) for group, items in whole.items()}, gravity=gravity)


def assembled(declared: list[System], gravity: float) -> System:
    """Return the system of a run, joined from the declarations of all processes, with elements sorted by name."""
    whole = merge(declared, gravity)
    named = {g: tuple(sorted(getattr(whole, g), key=lambda x: natural(x.name))) for g in GROUPS}
    return System(**named, gravity=gravity)


AXIS, SECOND, THIRD = range(3)  # `axis`, `second`, and axis x second of a joint
PITCH = None


@dataclass(frozen=True)
class JointMotion:
    """An elementary motion of a joint about or along one axis: `factor` (None: the pitch) times a joint coordinate."""

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
    """A type of joint, such as a hinge, as an entry of the joint table: coordinates, velocities and elementary motions.

    `coordinates` maps the coordinates' names to their values in the undisplaced joint, `velocities` names the
    velocities; in a chain of `motions`, velocities are the rates of coordinates. `quaternion` is the index of the first
    coordinate of a unit quaternion; coordinates before it are a displacement, and the velocities are in the child's
    axes.
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
        """Joint coordinates on which springs, stops, brakes or drives can act; none for joints with a quaternion."""
        return tuple(self.coordinates) if self.quaternion is None else ()

    @property
    def axes(self) -> int:
        """Number of axes of the joint: 0, 1 (only `axis`), or 3 (`axis`, `second` and their cross product)."""
        used = {m.axis for m in self.motions}
        return 3 if used - {AXIS} else len(used)

    @property
    def pitched(self) -> bool:
        return any(m.factor is PITCH for m in self.motions)

    def turns(self, coordinate: int) -> bool:
        """Return whether a coordinate is an angle [rad]; otherwise it is a length [m]."""
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
