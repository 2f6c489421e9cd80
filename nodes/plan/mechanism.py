"""A machine made of parts, in the plan: its system, the motions of its drives and winches, its hooks, its shapes."""

from collections.abc import Iterator, Sequence
from typing import Literal

import msgspec
from heavylift.kernel.description.flexible import Flexible
from heavylift.kernel.description.mechanics import WORLD, Joint, Point, System, Vector

from .actions import Item


class Actuator(Item, frozen=True, kw_only=True):
    """An actuator of a machine, drive or winch rope, with its speeds and end positions.

    `start`; `accel` of its ramp; end positions `lower`, `upper` (None: endless); `pulses` of a ramp without swing;
    `verb`: for orders addressed to the machine; `speed`: the highest that orders may demand, `loaded`: with a load;
    `highest`: height of the hook at which the winch stops; `emergency`: deceleration of a stop; `held`: why it cannot
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
    """A hook of a machine: its rope with all falls, and the point where it holds the hook block.

    `capacity`: what may hang below the block [kg], 0: not given; `chart`: (radius [m], mass with block and rigging
    [kg]), `axis`: from where its radius is measured; `on`: the body that its rope leaves; `line`: mass of all falls, as
    limits count it [kg/m]; `ends` of rope and eye at the start, in the world [m], if at rest as written;
    `below`: what hangs on it then, with its block [kg]; `falls` and `drum_ends` of the rope, `efficiency` of each
    sheave, `breaking` force of one fall [N], 0: not given; `rated`: the tension at 100 % utilisation [N].
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
    """A sling that can be hooked and unhooked; `lug`: its lug at the start, or "".

    `lower`: its lower end, if it can be hooked nowhere else; `rated`: tension at 100 % utilisation [N]; `rigging`: the
    name by which several are ordered together; `spans`: its length under its load at the start, if that differs from
    its own [m].
    """

    rope: str
    upper: Point
    lug: str = ""
    lower: Point | None = None
    rated: float = 0.0
    rigging: str = ""
    spans: float = 0.0


class Cell(Item, frozen=True, kw_only=True):
    """A load cell: reports when the total tension of its ropes exceeds `rated` [N]; `capacity`: allowed load below the
    hooks [kg]."""

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
    """A lifted body: mass [kg], centre of mass and lugs [m], moments about it [kg m2], edges of its box [m] (zeros: not
    given), face of each support, rotation at the start [rad] if its attitude is reported; `marks`: lines in the scene
    of its lugs and, "", of its centre of mass."""

    body: str
    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)
    moments: Vector = (0.0, 0.0, 0.0)
    size: Vector = (0.0, 0.0, 0.0)
    marks: dict[str, str] = msgspec.field(default_factory=dict)
    lugs: dict[str, Vector] = msgspec.field(default_factory=dict)
    faces: dict[str, str] = msgspec.field(default_factory=dict)
    turned: float | None = None


class Heavy(Item, frozen=True, kw_only=True):
    """A rope that has a mass at some model levels: `line` [kg/m] of all its falls, which are the first of its lines.

    At the start, in the world: `ends`, the middles of the falls above and below; `beside`, offsets of the falls from
    there; `lead`, length of the rope in its other lines [m]; `below`, the load on it [kg]; `on`: the body that it
    leaves; `why`: why it can have no mass, or "".
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
    """A force on a beam at the start, in its body's frame [N], at station x; `rope`: the rope that exerts it (a line
    with that `share`), "": a weight."""

    x: float
    p: Vector
    force: Vector
    rope: str = ""
    share: float = 0.0


class Bend(Item, frozen=True, kw_only=True):
    """A body that bends at some model levels, as a beam along its x from its frame: bending mass [kg], gravity in its
    frame [m/s2] and forces at the start.

    A girder is one along its y between legs at 0 and its length, with the joints that slide on it, the stiffness at
    midspan [N/m] (0: no girder) and the height of its neutral axis [m].
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
        """Length of its beam [m]."""
        return self.flexible.beam.length if self.flexible.beam else 0.0


class Servo(Item, frozen=True, kw_only=True):
    """A prescribed drive that yields at some model levels: stiffness [N/m or N m/rad], damping [N s/m or N m s/rad]."""

    drive: str
    stiffness: float
    damping: float = 0.0


class Shape(Item, frozen=True, kw_only=True):
    """A box of a body for collision checks and drawing: centre and edges in its frame [m]. `thing`: its name for
    planners, `part`: part of that thing."""

    body: str
    centre: Vector
    size: Vector
    overlap: float = 0.0  # that is no finding, with what it touches by corners alone [m]
    thing: str = ""
    part: str = ""


class Footing(Item, frozen=True, kw_only=True):
    """The base of a machine: below `body`, with its centre `at` a point of its frame.

    The base is `length` along the x of that body and `width` along its y [m]: for outriggers or wheels between the
    middles of the corners; for tracks the bearing length, and the distance of their middles. `each`: width of a track
    [m], area of a pad [m2], number of wheels at a corner; `mat`: area [m2] and mass [kg] of the mats below each of
    them.
    """

    kind: Literal["tracks", "outriggers", "wheels"]
    body: str
    at: Vector = (0.0, 0.0, 0.0)
    length: float
    width: float
    each: float
    mat: tuple[float, float] | None = None


class Driven(Item, frozen=True, kw_only=True):
    """An actuator that follows the log of a machine: at rest until the first time [ns], then linearly from speed to
    speed (the first is 0), and at the end to rest with `accel`; `source`: the column of the log."""

    actuator: str
    source: str
    accel: float
    times: tuple[int, ...]
    speeds: tuple[float, ...]


class Mechanism(Item, frozen=True, kw_only=True, forbid_unknown_fields=False):  # as recorded before
    """A machine or a user's system of bodies, joints and laws; becomes one coupled model.

    `system` has no thresholds; its parts may name bodies and joints of other machines.
    `taut`, `closed`: ropes and supports that carry at the start; `pieces`: of ropes with lumps, with their parts of the
    falls; `configuration`: boom, counterweight, falls, base, in words.
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

    @property
    def girders(self) -> tuple[Bend, ...]:
        """The girders among what bends."""
        return tuple(row for row in self.bends if row.stiffness)

    @property
    def rigged(self) -> dict[str, tuple[str, ...]]:
        """The slings by the name of their rigging."""
        names = dict.fromkeys(x.rigging for x in self.ties if x.rigging)
        return {name: tuple(x.rope for x in self.ties if x.rigging == name) for name in names}

    def standing(self, body: str) -> str:
        """Return the name under which a body's supports are reported; the body's own name for bodies of the lift."""
        return f"{self.name}:{body}" if body in self.system.outside[0] else body


def frames_on_hooks(machines: Sequence[Mechanism]) -> dict[str, Hoist]:
    """Machines without hooks that hold on to the rope of a hook themselves, by name, each with its hook."""
    eyes = {hook.eye.body: hook for machine in machines for hook in machine.hooks}
    bodies = ((machine.name, body.name) for machine in machines if not machine.hooks for body in machine.system.bodies)
    return {name: eyes[body] for name, body in bodies if body in eyes}


def ties_on(machines: Sequence[Mechanism], hook: Hoist) -> Iterator[Tie]:
    """Yield the slings below a hook, including those of frames and connected bodies."""
    joined, before, ties = {hook.eye.body}, 0, [tie for machine in machines for tie in machine.ties]
    loads = {cargo.body for machine in machines for cargo in machine.cargo}
    pairs = [{j.parent, j.child} for m in machines for j in m.system.joints if WORLD not in (j.parent, j.child)]
    frames = [(tie.upper.body, tie.lower.body) for tie in ties if tie.lower and tie.lower.body not in loads]
    while len(joined) > before:
        before = len(joined)
        for ends in pairs:
            joined |= ends if ends & joined else set()
        joined |= {lower for upper, lower in frames if upper in joined}
    return (tie for tie in ties if tie.upper.body in joined)


def carried_hooks(machine: Mechanism, body: str) -> list[Hoist]:
    """Return the hooks whose ropes leave a body, or bodies that joints of its machine carry on it, sorted by rope."""
    own = (hook for hook in machine.hooks if body in (hook.on, *(joint.parent for joint in beneath(machine, hook.on))))
    return sorted(own, key=lambda hook: hook.rope)


def beneath(machine: Mechanism, body: str) -> Iterator[Joint]:
    """The joints of a machine that carry a body, from it downwards."""
    carried = {joint.child: joint for joint in reversed(machine.system.joints)}
    while (joint := carried.get(body)) is not None:
        yield joint
        body = joint.parent


def is_root(machine: Mechanism, body: str) -> bool:
    """Return whether no joint of a machine carries this body on another body."""
    return all(joint.parent == WORLD for joint in machine.system.joints if joint.child == body)


def lug_places(machines: Sequence[Mechanism]) -> dict[str, Point]:
    """Return the lugs of lifted bodies with their points."""
    return {name: Point(c.body, p) for machine in machines for c in machine.cargo for name, p in c.lugs.items()}
