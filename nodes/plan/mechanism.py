"""A machine in the plan, made of parts: its mechanical system, its drives, winches and hooks, and its shapes."""

from typing import Literal

import msgspec
from heavylift.kernel.description.flexible import Flexible
from heavylift.kernel.description.mechanics import Point, System, Vector

from .actions import Item

OBSTACLES = "obstacles"  # name of the machine that all obstacles of a scene are


class Actuator(Item, frozen=True, kw_only=True):
    """An actuator of a machine, which is a drive or a winch rope, with its speeds and end positions.

    `start`: position at the start; `accel`: acceleration of its ramp; `lower`, `upper`: end positions (None: endless);
    `pulses`: number of pulses in a ramp without swing; `verb`: the verb with which an order to the machine moves this
    actuator; `speed`: the highest speed that orders may demand, `loaded`: the same with a load; `highest`: height of
    the hook at which the winch stops; `emergency`: deceleration of an emergency stop; `held`: why the actuator cannot
    move, if its joint is not modelled.
    """

    name: str
    start: float
    accel: float
    lower: float | None = None
    upper: float | None = None
    pulses: int = 0
    verb: str = ""
    speed: float | None = None
    loaded: float | None = None
    highest: float | None = None
    emergency: float | None = None
    held: str = ""


class Hoist(Item, frozen=True, kw_only=True):
    """A hook of a machine: its rope with all falls, and the point `eye` where the rope holds the hook block.

    `capacity`: allowed mass below the block [kg], 0 if not given; `chart`: (radius [m], allowed mass with block and
    rigging [kg]); `axis`: point from which the radius is measured. `on`: the body from which the rope hangs; `line`:
    mass per length of all falls together, as limits count it [kg/m]; `ends`: upper end of the rope and position of the
    eye at the start, in the world frame [m]; `below`: mass on the rope at the start, with the block [kg]; `falls` and
    `drum_ends`: number of rope falls and of rope ends on the drum; `efficiency`: of each sheave; `breaking`: breaking
    force of one fall [N], 0 if not given; `rated`: tension that is 100 % utilisation [N].
    """

    rope: str
    eye: Point
    block_mass: float
    capacity: float = 0.0
    axis: Point | None = None
    chart: tuple[tuple[float, float], ...] = ()
    on: str = ""
    line: float = 0.0
    ends: tuple[Vector, Vector] | None = None
    below: float = 0.0
    falls: int = 1
    drum_ends: int = 1
    efficiency: float = 1.0
    breaking: float = 0.0
    rated: float = 0.0


class Tie(Item, frozen=True, kw_only=True):
    """A sling that can be hooked and unhooked; `lug`: the lug where it is hooked at the start, or "".

    `lower`: its lower end, if it can be hooked nowhere else; `rated`: tension at 100 % utilisation [N]; `rigging`: name
    by which several slings are ordered together; `spans`: its length under load at the start, if that differs from its
    unstretched length [m].
    """

    rope: str
    upper: Point
    lug: str = ""
    lower: Point | None = None
    rated: float = 0.0
    rigging: str = ""
    spans: float = 0.0


class Cell(Item, frozen=True, kw_only=True):
    """A load cell, which reports when the total tension of its ropes exceeds `rated` [N].

    `capacity`: allowed load below the hooks [kg]."""

    name: str
    body: str
    ropes: tuple[str, ...]
    rated: float
    capacity: float = 0.0


class BrakeLatch(Item, frozen=True, kw_only=True):
    """A brake that is engaged while none of these slings is hooked."""

    brake: str
    ties: tuple[str, ...]


class Cargo(Item, frozen=True, kw_only=True):
    """A lifted body.

    Its mass [kg], centre of mass and lugs [m], moments of inertia about the centre of mass [kg m2], edges of its box
    [m] (zeros if not given), the face on which each support is, and the rotation at the start [rad] if its attitude is
    reported; `marks`: lines in the scene that define its lugs and, under "", its centre of mass; `amplitude`: amplitude
    of the water's dynamic force [N] over the depth of the body's lowest point [m].
    """

    body: str
    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)
    moments: Vector = (0.0, 0.0, 0.0)
    size: Vector = (0.0, 0.0, 0.0)
    marks: dict[str, str] = msgspec.field(default_factory=dict)
    lugs: dict[str, Vector] = msgspec.field(default_factory=dict)
    faces: dict[str, str] = msgspec.field(default_factory=dict)
    turned: float | None = None
    amplitude: tuple[tuple[float, float], ...] = ()


class Heavy(Item, frozen=True, kw_only=True):
    """A rope that has mass at the more detailed model levels.

    `line` is the mass per length [kg/m] of all falls together. The falls come first among the rope's lines.

    At the start, in the world frame: `ends`, the mean upper and lower ends of the falls; `beside`, the offsets of the
    falls from these means; `lead`, the length of the rope in its other lines [m]; `below`, the load on the rope [kg];
    `on`, the body from which it hangs; `why`, the reason why it can have no mass, or "".
    """

    rope: str
    line: float
    beside: tuple[Vector, ...] = ()
    ends: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    lead: float = 0.0
    below: float = 0.0
    on: str = ""
    why: str = ""


class BeamLoad(Item, frozen=True, kw_only=True):
    """A force [N] on a beam at the start, at distance x along the beam, in the frame of its body.

    `rope`: the rope that exerts the force (with the `share` of one line), or "" for a weight."""

    x: float
    p: Vector
    force: Vector
    rope: str = ""
    share: float = 0.0


class Bend(Item, frozen=True, kw_only=True):
    """A body that bends, at the more detailed model levels, as a beam along the x axis of its frame.

    It has its flexible mass [kg], gravity in its frame [m/s2] and forces on it at the start.

    A girder is a beam along the y axis, between legs at 0 and at its length, with the joints that slide on it, the
    stiffness at midspan [N/m] (0: no girder) and the height of its neutral axis [m].
    """

    body: str
    mass: float
    flexible: Flexible
    gravity: Vector = (0.0, 0.0, 0.0)
    loads: tuple[BeamLoad, ...] = ()
    slides: tuple[str, ...] = ()
    stiffness: float = 0.0
    height: float = 0.0

    @property
    def span(self) -> float:
        """Length of the beam [m]."""
        return self.flexible.beam.length if self.flexible.beam else 0.0


class Servo(Item, frozen=True, kw_only=True):
    """A prescribed drive that is compliant at the more detailed model levels: stiffness [N/m or N m/rad], damping."""

    drive: str
    stiffness: float
    damping: float = 0.0


class Shape(Item, frozen=True, kw_only=True):
    """A box on a body, for collision checks and drawings: centre and edges in the body's frame [m].

    `thing`: the object, as named in reports, to which the box belongs; `part`: its part of this object."""

    body: str
    centre: Vector
    size: Vector
    overlap: float = 0.0  # that is no finding, with what it touches by corners alone [m]
    stiffness: float = 0.0  # with which it yields as a block hits it [N/m]; 0: not known
    thing: str = ""
    part: str = ""


class Footing(Item, frozen=True, kw_only=True):
    """The base on which a machine stands: below `body`, centred at the point `at` of its frame.

    `length` and `width` [m] are measured along the body's x and y axes: for outriggers or wheels between the middles of
    the corners, for tracks the bearing length and the distance between the tracks. `each`: width of a track [m], area
    of a pad [m2], or number of wheels at a corner; `mat`: area [m2] and mass [kg] of the mats below each of them.
    """

    kind: Literal["tracks", "outriggers", "wheels"]
    body: str
    at: Vector = (0.0, 0.0, 0.0)
    length: float
    width: float
    each: float
    mat: tuple[float, float] | None = None


class Driven(Item, frozen=True, kw_only=True):
    """An actuator that replays a measured log.

    It is at rest until the first time [ns], then changes linearly from speed to speed (the first is 0), and at the end
    comes to rest with the deceleration `accel`; `source`: the column of the log."""

    actuator: str
    source: str
    accel: float
    times: tuple[int, ...]
    speeds: tuple[float, ...]


class Mechanism(Item, frozen=True, kw_only=True, forbid_unknown_fields=False):  # as recorded before
    """A machine or a user's system of bodies, joints and laws, which becomes one coupled model.

    `system` contains no thresholds (they come from the conditions); its elements may refer to bodies and joints of
    other machines. `taut` and `closed` name the ropes and supports that carry a load at the start. `pieces`: pieces of
    ropes with lumps, with their shares of the length. `configuration`: how the machine is set up, in words: boom,
    counterweight, falls, base. `lacks`: features of the file that the machine was read from which are not modelled.
    """

    name: str
    system: System
    actuators: tuple[Actuator, ...] = ()
    taut: tuple[str, ...] = ()
    closed: tuple[str, ...] = ()
    hooks: tuple[Hoist, ...] = ()
    shapes: tuple[Shape, ...] = ()
    ties: tuple[Tie, ...] = ()
    cells: tuple[Cell, ...] = ()
    latches: tuple[BrakeLatch, ...] = ()
    cargo: tuple[Cargo, ...] = ()
    heavy: tuple[Heavy, ...] = ()
    bends: tuple[Bend, ...] = ()
    servos: tuple[Servo, ...] = ()
    pieces: dict[str, dict[str, float]] = msgspec.field(default_factory=dict)
    footing: Footing | None = None
    configuration: dict[str, str] = msgspec.field(default_factory=dict)
    lacks: tuple[str, ...] = ()

    @property
    def girders(self) -> tuple[Bend, ...]:
        """The flexible bodies of the machine that represent girders."""
        return tuple(row for row in self.bends if row.stiffness)

    @property
    def rigged(self) -> dict[str, tuple[str, ...]]:
        """The names of the slings in each rigging entry, by the name of the entry."""
        names = dict.fromkeys(tie.rigging for tie in self.ties if tie.rigging)
        return {name: tuple(tie.rope for tie in self.ties if tie.rigging == name) for name in names}

    def standing(self, body: str) -> str:
        """Return the name by which reports refer to the supports of a body: MACHINE:BODY if the body belongs to another
        machine, else the name of the body."""
        return f"{self.name}:{body}" if body in self.system.outside[0] else body
