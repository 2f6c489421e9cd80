"""Force elements as plain data: what nodes declare and the force table (`table.py`) turns into equations.

Tagged msgspec structs, so that a tuple of different kinds crosses processes as it is; no NumPy.  SI units; a point is
(body, position in its frame), "world" is the ground.
"""

from itertools import pairwise
from typing import Literal

from msgspec import Struct

from . import units as u
from .units import IDENTITY, Line, Matrix, Point

__all__ = [
    "Bushing", "Characteristic", "Force", "Immersion", "InputSignal", "Load", "Matrix6", "MooringLine", "Radiation",
    "Reeving", "RopeForce", "Sheave", "Spring", "Stream", "Torsion", "TuggerLine", "UserLaw", "Wave", "WaveSum", "Wind",
]  # fmt: skip

Row6 = tuple[u.Number, u.Number, u.Number, u.Number, u.Number, u.Number]
Matrix6 = tuple[Row6, Row6, Row6, Row6, Row6, Row6]


class Wave(Struct, frozen=True):
    """A harmonic function of the run's time t, amplitude cos(frequency t + phase), multiplied by a smooth ramp r(t).

    r = u^3 (10 - 15 u + 6 u^2) with u = min(t / ramp, 1). It is zero when equilibria are computed.
    """

    amplitude: float
    frequency: float  # [rad/s]
    ramp: float  # [s]
    phase: float = 0.0  # [rad]


class WaveSum(Struct, frozen=True):
    """An irregular signal of the run's time t: r(t) times the sum of cosines_k cos(w_k t) + sines_k sin(w_k t).

    Factor r as in `Wave`; zero when equilibria are computed. It is represented by cubic Hermite pieces of `piece`
    seconds, with an error of (w_k piece)^4 / 384 of the amplitude of harmonic k. With a second sum `by`, the signal is
    their product without the sums of frequencies, and r^2: the real part of A conj(B), where A and B are the analytic
    signals of both.
    """

    frequencies: tuple[float, ...]  # w_k [rad/s]
    cosines: tuple[float, ...]
    sines: tuple[float, ...]
    ramp: float  # [s]
    piece: float  # [s]
    by: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())  # cosines and sines of a second sum, see above


class InputSignal(Struct, frozen=True):
    """A number that changes with time: the constant `value`, or piecewise linear through (times [s], values), or driven
    by commands.

    Before the first and after the last time the end value holds; two equal times are a jump. If `driven`, it starts at
    `value` and then follows a Profile or a Master commanded at run time, as a winch does. A regular `wave` and
    irregular `waves` are added to it.
    """

    value: float = 1.0
    times: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    driven: bool = False
    wave: Wave | None = None
    waves: WaveSum | None = None


def wrong_wave(regular: Wave | None, sea: WaveSum | None) -> str:
    """Return what is wrong with the waves of a signal or drive; an empty string if nothing is."""
    for wave in (regular, sea):
        if wave and wave.ramp <= 0.0:
            return f"has a wave with a ramp of {wave.ramp:g} s; it must be positive"
    sums = (sea.cosines, sea.sines, *(sea.by if any(sea.by) else ())) if sea else ()
    if sea and ({len(x) for x in sums} != {len(sea.frequencies)} or sea.piece <= 0.0):
        return "has irregular waves that need one cosine and one sine for each frequency, and pieces longer than 0 s"
    return ""


class Element(Struct, frozen=True):
    """Base class of all force elements."""

    @property
    def points(self) -> tuple[Point, ...]:
        """The points on bodies at which the force element acts."""
        values = (getattr(self, field) for field in self.__struct_fields__)
        return tuple(p for x in values for p in (x if isinstance(x, tuple) else (x,)) if isinstance(p, Point))

    @property
    def along(self) -> tuple[str, str] | None:
        """The joint and coordinate ("" if it has only one) on which the element acts; None if it acts at points."""
        joint = getattr(self, "joint", "")
        return (joint, getattr(self, "coordinate", "")) if joint else None


class Load(Element, frozen=True, tag=True):
    """A force and a moment at a point of a body, fixed in world or body axes, times a factor or a time history."""

    name: str
    at: Point
    force: tuple[u.Push, u.Push, u.Push] = (0.0, 0.0, 0.0)
    moment: tuple[u.Twist, u.Twist, u.Twist] = (0.0, 0.0, 0.0)
    axes: Literal["world", "body"] = "world"
    signal: InputSignal = InputSignal()


class Wind(Element, frozen=True, tag=True):
    """Drag of a wind w on an area A: F = 1/2 density C A |w - v| (w - v), at a point that moves with velocity v.

    w = signal [m/s] along `direction` (a unit vector in world axes); a gust is the signal's history. To A is added the
    shadow of a box, the sum of its `sides` times |n_i (w - v)| / |w - v|, n_i: the body's axes in the world.
    """

    name: str
    at: Point
    area: u.Area
    drag: u.Ratio
    direction: u.Direction
    signal: InputSignal
    density: u.Density = 1.225
    sides: tuple[u.Area, u.Area, u.Area] = (0.0, 0.0, 0.0)  # seen along the body's axes


class Stream(Element, frozen=True, tag=True):
    """Force and yaw moment of a wind or current w on a body, by coefficients that depend on its direction.

    Coefficients (C_x, C_y, C_z) of its direction beta in the body's x-y plane, 0 where it flows from astern to the bow:
    1/2 density u^2 area (C_x, C_y), and the moment 1/2 density u^2 area length C_z; u = w - v at a point that moves
    with velocity v. w = signal [m/s] along `direction` (a unit vector in world axes). The coefficients are those of
    beta from 0 to pi in equal steps, alike on both sides; in between they are a trigonometric polynomial.
    """

    name: str
    at: Point
    area: u.Area
    length: u.Gap
    direction: u.Direction
    signal: InputSignal
    density: u.Density
    coefficients: tuple[tuple[float, float, float], ...]


class Spring(Element, frozen=True, tag=True):
    """A spring and damper between two points that pulls and pushes: tension = k (l - rest) + d l'."""

    name: str
    a: Point
    b: Point
    rest: u.Gap
    k: u.Stiffness = 0.0
    d: u.Damping = 0.0


class Torsion(Element, frozen=True, tag=True):
    """A torsional spring and damper between two bodies about `axis` in the frame of the first.

    moment = k (rest - angle) - d angle'.

    The angle is the twist of body b about `axis` against a, over any number of turns: of the relative rotation, the
    part about that axis (swing-twist decomposition). The law is valid while the axis tilts by less than 175 degrees.
    """

    name: str
    a: str
    b: str
    axis: u.Direction
    k: u.TurnStiffness = 0.0
    d: u.TurnDamping = 0.0
    rest: u.Angle = 0.0

    @property
    def points(self) -> tuple[Point, ...]:
        return Point(self.a), Point(self.b)


class Bushing(Element, frozen=True, tag=True):
    """A linear 6x6 spring and damper between the frame (a, R_a) and the frame (b, R_b): f = -K x - D x'.

    x = (displacement of b's origin from a's in a's axes, rotation vector of b's axes against a's): energy x^T K x / 2.
    K and D are symmetric and not negative; the law is valid for rotations below 175 degrees, or for any rotation if the
    joints between a and b allow turns about one axis only, on which R_a and R_b agree.
    """

    name: str
    a: Point
    b: Point
    K: Matrix6  # [N/m, N, N m/rad]
    D: Matrix6  # [N s/m, N s, N m s/rad]
    R_a: Matrix = IDENTITY
    R_b: Matrix = IDENTITY


class Radiation(Element, frozen=True, tag=True):
    """Radiation force of a floating body on still water, f(t) = -int K(t - s) v(s) ds (Cummins 1962).

    v: twist of a point of the body (linear, angular) in the axes R of the world. The kernel K(t) = G^T exp(F t) G is
    represented by states x of the water: x' = F x + G v and f = -G^T x; it is passive, since F + F^T is negative
    semidefinite. The body itself has the added mass at infinite frequency (`Body.added`). A second body, `beside`, may
    share the states: x' = F x + G v + G_beside v_beside.
    """

    name: str
    at: Point
    F: tuple[tuple[float, ...], ...]  # (n, n) [1/s]
    G: tuple[Row6, ...]  # (n, 6) [kg^1/2/s, m kg^1/2/s]
    R: Matrix = IDENTITY
    beside: Point | None = None
    G_beside: tuple[Row6, ...] = ()
    R_beside: Matrix = IDENTITY


class Characteristic(Element, frozen=True, tag=True):
    """An actuator characteristic: effort [N or N m] along a joint = signal * f(coordinate or speed).

    f is piecewise linear through (x, effort), x rising; the end values hold outside.
    """

    name: str
    joint: str
    of: Literal["position", "speed"]
    x: tuple[float, ...]
    effort: tuple[float, ...]
    signal: InputSignal = InputSignal()
    coordinate: str = ""  # of a joint that has several


class Immersion(Element, frozen=True, tag=True):
    """An upward force on a body that depends on its depth: piecewise linear through points (`x` [m], `effort` [N]).

    The depth is counted from the height `level` to a place `below` the point. The force is piecewise linear, x rising;
    the end values hold outside. It acts at the point, so that it does not turn the body about it.
    """

    name: str
    at: Point
    below: u.Gap
    level: u.Length
    x: tuple[float, ...]
    effort: tuple[float, ...]


class UserLaw(Element, frozen=True, tag=True):
    """A user-defined law: `function` is "package.module:function" or "file.py:function" (see `user_laws.py`).

    It acts along a joint or on `ends`. `guards` names a function that returns `modes` numbers; mode i keeps the sign of
    number i during a step and changes at the located event, so select(modes[i] > 0, ...) may jump.
    """

    name: str
    function: str
    joint: str = ""
    ends: tuple[Point, ...] = ()
    parameters: tuple[u.Number, ...] = ()
    signal: InputSignal = InputSignal()
    guards: str = ""
    modes: int = 0
    coordinate: str = ""  # of a joint that has several


class Sheave(Struct, frozen=True):
    """A sheave of a rope, fixed on a body; the rope runs around it in the positive sense of its axis (body frame).

    Where the rope slips, the tension ratio is exp(friction * wrap) / efficiency. A radius of 0 is a point, which the
    rope never leaves; it can leave a sheave with a radius and return. An `edge` is a sheave along whose axis the rope
    slides, too, without friction.
    """

    at: Point
    axis: u.Direction = (0.0, 1.0, 0.0)
    radius: u.Gap = 0.0
    friction: u.Ratio = 0.0
    efficiency: u.Ratio = 1.0
    edge: str = ""  # its name
    span: tuple[float, float] = (0.0, 0.0)  # of an edge: its ends along the axis from `at` [m]


class Reeving(Element, frozen=True, tag=True):
    """A massless, elastic, tension-only rope from a over sheaves to b; its signal is its unstretched length [m].

    Without friction it has one tension, as with an equaliser; with friction each sheave sticks or slips (see
    `reeving.py`). `damping` [N s/m] is that of the whole rope. A driven signal is a winch at a.
    """

    name: str
    a: Point
    sheaves: tuple[Sheave, ...]
    b: Point
    EA: u.AxialStiffness
    signal: InputSignal
    damping: u.Damping = 0.0
    hooked: bool = True  # at the start

    @property
    def points(self) -> tuple[Point, ...]:
        return self.a, *(s.at for s in self.sheaves), self.b

    @property
    def edges(self) -> tuple[Sheave, ...]:
        """Those sheaves of the rope that are edges, along which the rope may slide; empty if there are none."""
        return tuple(s for s in self.sheaves if s.edge)

    @property
    def apart(self) -> bool:
        """Whether the edges over which the rope may slide belong to several bodies."""
        return len({s.at.body for s in self.edges}) > 1

    @property
    def lines(self) -> tuple[Line, ...]:
        """The straight lines from sheave centre to sheave centre, for drawing."""
        return tuple(Line(a, b) for a, b in pairwise(self.points))

    @property
    def winch(self) -> bool:
        """Whether a winch changes the length of the rope, which is then a driven signal."""
        return self.signal.driven

    @property
    def L0(self) -> float:
        """The unstretched length of the rope at the start [m]."""
        return self.signal.value


class MooringLine(Element, frozen=True, tag=True):
    """A mooring line: an elastic catenary from an anchor a to a fairlead b, in equilibrium at each instant.

    Its own inertia, damping and drag are neglected.

    The line has its mass in water. With a `seabed`, level at the height of the anchor, a part of the line may lie
    there; `friction` on the seabed reduces the force at the anchor, but does not enter the strain of that part. The
    line breaks at the tension `breaking`.
    """

    name: str
    a: Point
    b: Point
    length: u.Extent  # unstretched
    EA: u.AxialStiffness
    mass: u.MassPerLength  # less that of the displaced water
    seabed: bool = True
    friction: u.Ratio = 0.0
    breaking: u.Tension = 0.0  # 0: it never parts
    hooked: bool = True  # at the start
    winch = False

    @property
    def lines(self) -> tuple[Line, ...]:
        """The straight line from anchor to fairlead, for drawing."""
        return (Line(self.a, self.b),)

    @property
    def L0(self) -> float:
        """The unstretched length of the mooring line [m]."""
        return self.length


class TuggerLine(Element, frozen=True, tag=True):
    """A tugger line from a winch at a to a load at b: a massless rope that the winch keeps at a set tension.

    T = tension (1 + spread x / sqrt(1 + x^2)) with x = l' / speed of its length l: the winch pays out at a higher and
    takes in at a lower tension, which damps the load. Beyond its stroke, `shortest` to `longest`, the run ends. With a
    `rate`, the highest at which orders may change it, the tension is a driven signal.
    """

    name: str
    a: Point
    b: Point
    tension: u.Pull
    spread: u.Ratio = 0.0  # below 1
    speed: u.LineSpeed = 0.05  # at which 0.7 of the spread is reached
    shortest: u.Gap = 0.0
    longest: u.Gap = 0.0  # 0: there is rope enough
    capacity: u.Tension = 0.0  # of winch, rope and attachment; 0: not known
    rate: u.TensionRate = 0.0  # 0: the winch takes no orders
    hooked: bool = True  # at the start
    winch = False  # that winds a length by orders
    L0 = 0.0  # a winch that has any length

    @property
    def lines(self) -> tuple[Line, ...]:
        """The straight line from winch to load, for drawing."""
        return (Line(self.a, self.b),)


RopeForce = Reeving | MooringLine | TuggerLine
Force = (
    Load | Wind | Stream | Spring | Torsion | Bushing | Radiation | Characteristic | Immersion
    | UserLaw | RopeForce
)  # fmt: skip
