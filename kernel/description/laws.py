"""Laws of joints, ropes and pads as plain data: springs, stops, brakes, drives, locks, ropes, supports.

SI units; a point is (body, position in its frame).
"""

from dataclasses import dataclass
from typing import Literal

from . import units as u
from .forces import Force, Wave, WaveSum
from .units import Line, Point

__all__ = ["Brake", "Drive", "JointSpring", "Law", "Lock", "RigidRope", "Rope", "Stop", "Support"]


class AlongJoint:
    """A force law on one coordinate of a joint; the name of the coordinate is "" if the joint has only one."""

    joint: str
    coordinate: str
    points = ()

    @property
    def along(self) -> tuple[str, str]:
        """The joint on which the law acts, and the name of the coordinate."""
        return self.joint, self.coordinate


@dataclass(frozen=True)
class JointSpring(AlongJoint):
    """A linear spring and damper on a coordinate of a joint: force = k (q_rest - q) - d v."""

    name: str
    joint: str
    k: u.AnyStiffness = 0.0
    d: u.AnyDamping = 0.0
    q_rest: u.Stroke = 0.0
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Stop(AlongJoint):
    """Unilateral end stops of a joint coordinate; k and d act beyond the limits only."""

    name: str
    joint: str
    lower: u.Stroke
    upper: u.Stroke
    k: u.AnyStiffness
    d: u.AnyDamping = 0.0
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Brake(AlongJoint):
    """Dry brake on a joint coordinate: a spring-damper that slips at the effort `moment` [N or N m].

    A brake that is always engaged represents the joint's dry friction.
    """

    name: str
    joint: str
    moment: u.Effort
    k: u.AnyStiffness
    d: u.AnyDamping = 0.0
    engaged: bool = False
    coordinate: str = ""  # of a joint that has several


@dataclass(frozen=True)
class Lock:
    """A joint that can be locked and released while the simulation runs; `engaged`: whether it is locked at the start.

    A joint locked in motion stops at once: the impulse changes the velocities of its whole tree, and the kinetic energy
    that is lost counts as heat of this lock.
    """

    name: str
    joint: str
    engaged: bool = False


@dataclass(frozen=True)
class Drive(AlongJoint):
    """An actuator of a joint coordinate; its reference is commanded at run time, see `references`.

    prescribed: q is the reference itself (rheonomic). servo: force = kp (ref - q) + kv (ref' - v). speed: force = kv
    (ref' - v). A `wave`, or an irregular one (`waves`), is added to the reference of a prescribed drive.
    """

    name: str
    joint: str
    kind: Literal["prescribed", "servo", "speed"]
    kp: u.AnyStiffness = 0.0
    kv: u.AnyDamping = 0.0
    coordinate: str = ""  # of a joint that has several
    wave: Wave | None = None
    waves: WaveSum | None = None


class Straight:
    """Base class of elastic and rigid ropes that consist of straight lines between points of bodies."""

    lines: tuple[Line, ...]
    along = None

    @property
    def points(self) -> tuple[Point, ...]:
        """The end points of all straight lines of the rope."""
        return tuple(p for line in self.lines for p in (line.a, line.b))


@dataclass(frozen=True)
class Rope(Straight):
    """An elastic, tension-only rope over one or more straight lines, with the same tension in all.

    length l = sum(share * |a - b|), elongation e = l - L0, taut: T = max(0, EA e/L0 + damping (l' - L0')). `mass`: of
    all lines, weighted by their shares; it acts at the ends (see `forces.ropes`); T is then the tension in the middle,
    while samples show the tension at the lower ends b. If `winch`, L0 follows a Profile or Follow sent at run time.
    `hooked`: whether it is hooked at the start.
    """

    name: str
    lines: tuple[Line, ...]
    EA: u.AxialStiffness
    L0: u.Extent  # unstretched length
    damping: u.Damping = 0.0
    winch: bool = False
    hooked: bool = True
    mass: u.Mass = 0.0


@dataclass(frozen=True)
class RigidRope(Straight):
    """An inextensible rope over one or more straight lines: sum(share * |a - b|) is at most L0.

    Taut, it pulls with whatever tension keeps its length; snapping taut, it stops its ends inelastically. If `winch`,
    L0 follows a Profile or Follow sent at run time. `mass` as of a `Rope`.
    """

    name: str
    lines: tuple[Line, ...]
    L0: u.Extent
    winch: bool = False
    hooked: bool = True
    mass: u.Mass = 0.0


@dataclass(frozen=True)
class Support:
    """A point of a body that a pad at `height`, fixed in the world or on a body, can push up and hold by friction.

    N = max(0, k depth + d depth'); tangential spring-damper (kt, dt) anchored at touch-down, at most mu N. `on`: the
    body in whose frame the height counts and whose z the pad pushes along; "": the world. `size`: of the pad along the
    x and y of that frame, about its origin, beside which it exerts no force; None: it has no ends.
    """

    name: str
    point: Point
    height: u.Length
    k: u.Stiffness
    d: u.Damping = 0.0
    mu: u.Ratio = 0.0
    kt: u.Stiffness = 0.0
    dt: u.Damping = 0.0
    on: str = ""
    size: tuple[u.Extent, u.Extent] | None = None

    along = None

    @property
    def points(self) -> tuple[Point, ...]:
        return (self.point, Point(self.on)) if self.on else (self.point,)


Law = Rope | Support | JointSpring | Stop | Brake | Force
