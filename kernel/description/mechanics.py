"""The mechanics of a scene as plain data: what the nodes declare and the kernel compiles.

Frozen dataclasses of numbers and names, without NumPy, so that a node process that only declares starts at once.
SI units; rotations are row-major 3x3 tuples; a point is (body, position in that body's frame).  Monogram notation:
`p_PJ` is the position of joint J from parent P, expressed in P.  The body "world" is the ground.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Literal

from .contacts import Contact
from .flexible import Flexible
from .forces import Force, Reeving, UserLaw
from .name_order import natural
from .points import IDENTITY as IDENTITY
from .points import WORLD as WORLD
from .points import Line as Line
from .points import Matrix as Matrix
from .points import Point as Point
from .points import Vector as Vector

MethodName = Literal[
    "semi-implicit-euler", "rk4", "dopri5", "dop853", "ros34pw2", "radau5",
    "scipy-dop853", "scipy-radau", "scipy-bdf", "scipy-lsoda",
]  # fmt: skip
JointKind = Literal[
    "fixed", "revolute", "prismatic", "cylindrical", "screw", "universal", "planar", "constant-velocity",
    "spherical", "free", "slider",
]  # fmt: skip


@dataclass(frozen=True)
class Body:
    """A body; its frame is the frame of the joint that carries it, unless that joint says otherwise.

    `flexible` adds a deformable part, whose floating frame that is; mass, com and inertia are then those of what sits
    rigidly in that frame (0: nothing).
    Where nothing has mass, moments of inertia may be any, such as those of a rotor behind its gear.
    """

    name: str
    mass: float  # [kg]
    com: Vector = (0.0, 0.0, 0.0)  # p_BC, centre of mass [m]
    inertia: Matrix = (
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    )  # about the centre of mass, body axes [kg m2]
    flexible: Flexible | None = None


@dataclass(frozen=True)
class Joint:
    """A joint places `child` on `parent`; its frame on the parent is (p_PJ, R_PJ), on the child (p_CJ, R_CJ).

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


class AlongJoint:
    """A law of one coordinate of a joint ("" where it has only one)."""

    joint: str
    coordinate: str
    points = ()

    @property
    def along(self) -> tuple[str, str]:
        """The joint that it acts along, with the coordinate."""
        return self.joint, self.coordinate


@dataclass(frozen=True)
class JointSpring(AlongJoint):
    """A linear spring and damper on a coordinate of a joint: force = k (q_rest - q) - d v."""

    name: str
    joint: str
    k: float = 0.0  # [N/m] or [N m/rad]
    d: float = 0.0  # [N s/m] or [N m s/rad]
    q_rest: float = 0.0
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Stop(AlongJoint):
    """Unilateral end stops of a coordinate of a joint; k and d act beyond the limits only."""

    name: str
    joint: str
    lower: float
    upper: float
    k: float
    d: float
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Brake(AlongJoint):
    """Dry brake on a coordinate of a joint: a spring-damper that slips at `moment`.

    One that is always engaged is the joint's dry friction.
    """

    name: str
    joint: str
    moment: float  # [N] or [N m]
    k: float
    d: float
    engaged: bool = False
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Lock:
    """A joint that can be locked and freed while the simulation runs; `engaged`: locked at the start.

    Locked in motion it stops at once: the impulse changes the velocities of its whole tree, and what kinetic energy
    it takes is this lock's heat.
    """

    name: str
    joint: str
    engaged: bool = False


@dataclass(frozen=True)
class Drive(AlongJoint):
    """An actuator of a coordinate of a joint; what it follows is sent at run time, see `references`.

    prescribed: q is the reference itself (rheonomic).  servo: force = kp (ref - q) + kv (ref' - v).
    speed: force = kv (ref' - v).
    """

    name: str
    joint: str
    kind: Literal["prescribed", "servo", "speed"]
    kp: float = 0.0
    kv: float = 0.0
    coordinate: str = ""  # of a joint that has several


class Straight:
    """A rope over straight lines."""

    lines: tuple[Line, ...]
    along = None

    @property
    def points(self) -> tuple[Point, ...]:
        """The ends of its lines."""
        return tuple(p for line in self.lines for p in (line.a, line.b))


@dataclass(frozen=True)
class Rope(Straight):
    """An elastic, tension-only rope of one tension over one or more straight lines.

    length l = sum(share * |a - b|), elongation e = l - L0, taut: T = max(0, EA e/L0 + damping (l' - L0')).
    `mass`, of all its lines by their shares: its ends bear it (see `rope_mass`); T is then the tension in the middle,
    and
    the one that is told, that at the lower ends b.
    `winch`: L0 follows a Profile or Follow sent at run time.  `hooked` is its state at the start.
    """

    name: str
    lines: tuple[Line, ...]
    EA: float  # [N]
    L0: float  # unstretched length [m]
    damping: float = 0.0  # [N s/m]
    winch: bool = False
    hooked: bool = True
    mass: float = 0.0  # [kg]


@dataclass(frozen=True)
class RigidRope(Straight):
    """An inextensible rope over one or more straight lines: sum(share * |a - b|) is at most L0.

    Taut, it pulls with whatever tension keeps its length; snapping taut, it stops its ends inelastically.  `winch`: L0
    follows a Profile or Follow sent at run time.  `mass` as of a `Rope`.
    """

    name: str
    lines: tuple[Line, ...]
    L0: float  # [m]
    winch: bool = False
    hooked: bool = True
    mass: float = 0.0  # [kg]


@dataclass(frozen=True)
class Support:
    """A point of a body that a horizontal pad at `height` (world) can push up and rub, never pull.

    N = max(0, k depth + d depth'); tangential spring-damper (kt, dt) anchored at touch-down, at most mu N.
    """

    name: str
    point: Point
    height: float
    k: float
    d: float
    mu: float = 0.0
    kt: float = 0.0
    dt: float = 0.0

    along = None

    @property
    def points(self) -> tuple[Point, ...]:
        return (self.point,)


@dataclass(frozen=True)
class Master:
    """A commanded scalar (such as the block angle of a turn) that several actuators follow."""

    name: str
    value: float = 0.0  # at the start


@dataclass(frozen=True)
class Measured:
    """A measured scalar that actuators can follow: attitude of `of` about world axis, or a joint coordinate.

    kind "angle": rotation of body `of` about the horizontal axis `axis` (0 = x, 1 = y), positive as +w towards
    +y for axis 0 (the lift's theta).  kind "joint": coordinate of joint `of`.
    """

    name: str
    kind: Literal["angle", "joint"]
    of: str
    axis: int = 0
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Threshold:
    """A guard on a scalar; it reports when the scalar crosses a value that is set at run time.

    quantity: "height" (world z of `point`), "tension" (sum over `ropes`), "angle" (as Measured), "joint"
    (coordinate of joint `of`), "speed" (velocity of joint `of`), "length" (unstretched length of ropes[0]).
    """

    name: str
    quantity: Literal["height", "tension", "angle", "joint", "speed", "length"]
    of: str = ""
    point: Point | None = None
    ropes: tuple[str, ...] = ()
    axis: int = 0
    coordinate: str = ""  # of a joint that has several


Law = Rope | Support | JointSpring | Stop | Brake | Force


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
        """The ropes among its forces."""
        return tuple(f for f in self.forces if isinstance(f, Reeving))

    @property
    def functions(self) -> tuple[str, ...]:
        """The Python functions that its laws name."""
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


def merge(parts: list[System], gravity: float) -> System:
    """One system from several, in the order given."""
    groups = [f.name for f in fields(System) if f.name != "gravity"]
    return System(**{g: tuple(x for p in parts for x in getattr(p, g)) for g in groups}, gravity=gravity)


def assembled(declared: list[System], gravity: float) -> System:
    """The system of a run from the declarations of its nodes, its elements in the order of their names."""
    whole = merge(declared, gravity)
    groups = [f.name for f in fields(System) if f.name != "gravity"]
    named = {g: tuple(sorted(getattr(whole, g), key=lambda x: natural(x.name))) for g in groups}
    return System(**named, gravity=gravity)
