"""The keys of `mechanism:` in a scene file: user-defined bodies, joints and laws.

The frame of a body is that of its joint. A law names the joint on which it acts and, if the joint has several
coordinates, one of them; the coordinate determines whether the units are those of a displacement or of an angle.
"""

from math import inf
from typing import Annotated, Any, Generic, Literal, TypeVar

from heavylift.kernel.description import laws as k
from heavylift.kernel.description.forces import Sheave
from heavylift.kernel.description.units import Line
from heavylift.nodes.scene.keys.base import Base, BodyPoint, Name, Place, keys_of, one, rising
from heavylift.nodes.scene.language.grammar import read_ramp
from heavylift.nodes.scene.language.phrases import SwingRamp
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, GetCoreSchemaHandler, Tag
from pydantic_core import CoreSchema, core_schema

from .contacts import ContactKeys
from .flexible import BeamKeys, Matrices, Optional
from .forces import Force as ForceElement
from .joints import ENDS, Joint, Range
from .standing import Stands


def _shape(given: object) -> str:
    """Return whether a list of moments of inertia includes products of inertia; raises ValueError if it does not have 3
    or 6 values."""
    if isinstance(given, list | tuple) and len(given) not in (3, 6):
        raise ValueError(f"Ixx, Iyy, Izz or Ixx, Iyy, Izz, Ixy, Ixz, Iyz are needed here, not {len(given)} values")
    return "with products" if isinstance(given, list | tuple) and len(given) > 3 else "moments"


class RampQuantity(u.Quantity):
    """Parser of a ramp in a scene: a positive acceleration, or a ramp without swing as in orders."""

    def ramp(self, value: object) -> float | SwingRamp:
        """Return a ramp as an acceleration in SI units or as a ramp without swing."""
        found = read_ramp(value, self.dimension)
        return found if isinstance(found, SwingRamp) else self.read(value)

    def __get_pydantic_core_schema__(self, kind: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.ramp)


Ramp = Annotated[float | SwingRamp, RampQuantity(u.ACCELERATION, "positive")]
StrokeRamp = Annotated[float | SwingRamp, RampQuantity(u.STROKE_RAMP, "positive")]


def _counted(given: object) -> object:
    _shape(given)
    return given


Moments = Annotated[
    Annotated[tuple[u.Inertia, u.Inertia, u.Inertia], Tag("moments")]
    | Annotated[tuple[u.Inertia, u.Inertia, u.Inertia, u.Product, u.Product, u.Product], Tag("with products")],
    Discriminator(_shape),
    BeforeValidator(_counted),
]


ROUNDING = 1e-9  # relative, of lengths and masses that are the same
PartKey = TypeVar("PartKey", bound=str)
MechanismGroup = Literal["M1", "M2", "M3", "M4", "M5", "M6", "M7", "M8"]
OwnOffLead = u.Swing | Literal["unknown", "as in limits"]
Chart = Annotated[list[tuple[u.Length, u.Mass]], Field(min_length=2), AfterValidator(rising)]


class BodyKeys(Base):
    """A body, with its inertia about the centre of mass: Ixx, Iyy, Izz, optionally Ixy, Ixz, Iyz. A body that carries
    bodies with mass may have no mass itself.

    `box`: the body has the moments of inertia of a uniform box with these edges, and is drawn as one. `beam` or
    `matrices` make the body flexible; mass, com and inertia then describe only the parts fixed rigidly to its frame.
    """

    mass: u.AnyMass | None = None
    com: Place = (0.0, 0.0, 0.0)
    inertia: Moments = (0.0, 0.0, 0.0)
    box: tuple[u.Extent, u.Extent, u.Extent] | None = None
    beam: BeamKeys | None = None
    matrices: Matrices | None = None


class LineKeys(keys_of(Line)):  # type: ignore[misc]
    """A straight part of a rope; the lengths of all parts, each times a factor, add up to the length of the rope."""


class Winch(Base):
    """A winch that winds the rope: its ramp, and the shortest and longest unstretched length of the rope."""

    ramp: u.Ramp
    shortest: u.Extent
    longest: u.Extent


class Over(keys_of(Sheave, "edge", "span")):  # type: ignore[misc]
    """A point or sheave over which a rope runs; it runs around a sheave in the positive sense of the sheave's axis.

    If the rope slips, the ratio of tensions is exp(friction * wrap) / efficiency. The rope leaves a sheave with a
    radius when its wrap angle falls to zero, and can return to it.
    """

    @property
    def plain(self) -> bool:
        """Whether this is a point without radius and friction, and not a sheave."""
        return not (self.radius or self.friction) and self.efficiency == 1.0


class RopeKeys(Base):
    """A tension-only elastic rope, or an inextensible one if `rigid`. `length` is its unstretched length. A `rigid`
    rope has no EA and damping.

    It runs from `start` to `end`, possibly `over` points and sheaves or `over edges`, or along separate `lines` with
    the same tension.
    """

    start: BodyPoint | None = None
    end: BodyPoint | None = None
    over: list[Over] = Field(default_factory=list)
    over_edges: list[str] = Field(default_factory=list)
    lines: list[LineKeys] = Field(default_factory=list)
    EA: u.Force | None = None
    rigid: bool = False
    length: u.Extent
    damping: u.Damping | None = None
    winch: Winch | None = None
    hooked: bool = True

    @property
    def plain(self) -> bool:
        """Whether the rope runs over frictionless points only."""
        return not self.over_edges and all(x.plain for x in self.over)


class SupportKeys(keys_of(k.Support, "on")):  # type: ignore[misc]
    """A point of a body that a horizontal pad can push up and hold by friction, but never pull down."""


class SpringKeys(keys_of(k.JointSpring)):  # type: ignore[misc]
    """A linear spring and damper on a joint coordinate."""


class StopKeys(keys_of(k.Stop, **ENDS)):  # type: ignore[misc]
    """End stops of a joint coordinate."""


class BrakeKeys(keys_of(k.Brake, moment=one("holds", u.Effort))):  # type: ignore[misc]
    """A dry-friction brake on a joint, which slips at the effort `holds`."""


class LockKeys(keys_of(k.Lock)):  # type: ignore[misc]
    """A lock of a joint, which orders can engage and release. `engaged`: the joint is locked at the start."""


class DriveKeys(keys_of(k.Drive, "wave", "waves")):  # type: ignore[misc]
    """A drive of a joint, controlled by the action list.

    If it has a `verb`, orders with this verb to its machine move the drive."""

    stiffness: u.AnyStiffness = 0.0  # servo: per displacement
    damping: u.AnyDamping = 0.0  # servo and speed: per velocity
    ramp: StrokeRamp  # or without swing: `one swing`, `0.1 m/s2 in two pulses`
    range: Range | None = None
    verb: Literal["travel", "traverse", "slew", "luff"] | None = None
    speed: u.StrokeSpeed | None = None  # the highest that orders may give it
    emergency: u.StrokeRamp | None = None  # deceleration by `stop` and interlocks; left out: the ramp
    force: u.Effort | None = None  # or moment with which it moves what it carries and what ropes pull
    brake: u.Effort | None = None  # that its brake holds


class BoomChart(Base):
    """Capacity over radius for one boom length and counterweight."""

    boom: u.Extent
    counterweight: u.Mass | None = None
    outriggers: u.Extent | None = None
    chart: Chart


class HookKeys(Base):
    """A hook on the falls of a winch.

    One elastic rope from the body `on` stands for all falls. If a `drum` is given, a single part of the rope continues
    from `at` to the drum, so that the hook moves when `at` moves relative to the drum, for example in luffing."""

    on: str
    at: Place
    drum: BodyPoint | None = None
    falls: Annotated[int, Field(ge=1)] = 1
    apart: u.Gap = 0.0  # of the outer falls, along the y of `on`: gives the yaw stiffness T b2 / 4L
    block: u.Mass  # of the hook block
    height: u.Extent = u.LENGTH.read("2 m")  # of the hook block, from its ropes down to the slings
    capacity: u.Mass | None = None  # of what hangs below the hook block
    capacity_by_place: Chart | None = None  # (y of what its rope leaves, mass below the hook block), instead
    capacity_chart: Chart | None = None  # (radius, mass with hook block and rigging): the next longer radius counts
    capacity_charts: list[BoomChart] = Field(default_factory=list)  # instead, by boom length and counterweight
    boom: u.Extent | None = None  # of which the chart is looked up: that of the next longer one
    counterweight: u.Mass | None = None  # of which the chart is looked up: that of the next lighter one
    outriggers: u.Extent | None = (
        None  # width of the base of which the chart is looked up: that of the next narrower one
    )
    radius_from: str = ""  # body from whose origin the radius of the chart is measured
    fall_EA: u.Force
    fall_mass: u.MassPerLength | None = None  # where the fidelity gives ropes a mass; left out: of steel wire so stiff
    fall_breaking: u.Force | None = None  # left out: the rope is not checked
    mechanism_group: MechanismGroup = "M6"  # gives the rope factor by ISO 4308-1
    rope_factor: u.Factor | None = None  # breaking force over its most loaded part; left out: by the mechanism group
    rope_partial_factor: u.Factor | None = None  # breaking force over its largest tension; left out: by EN 13001-3-2
    drum_ends: Literal[1, 2] | None = None  # of its rope; left out: two where the falls can be halved, assumed
    sheave_efficiency: u.Efficiency | None = None  # of each sheave; left out: 0.98 with rolling bearings, assumed
    drum_pull: u.Force | None = None  # that its rope may pull at a drum end
    off_lead_along: OwnOffLead | None = None  # of its ropes along x; left out: in any direction, as the limits say
    off_lead_across: OwnOffLead | None = None  # of its ropes along y
    damping: u.Ratio = 0.03  # of critical, with what it carries at the start
    speed: u.Speed
    loaded_speed: u.Speed | None = None  # with a load; left out: the same
    ramp: Ramp
    emergency: u.Ramp | None = None  # deceleration by limit switch, `stop` and interlocks; left out: the ramp
    shortest: u.Extent  # rope at the hook, unstretched
    longest: u.Extent
    highest: u.Length | None = None  # z of the hook where the upper limit switch trips
    over_edges: list[str] = Field(default_factory=list)  # that its rope bends over where it meets them
    unused: Literal["kept", "left out"] = "kept"  # left out: it is not modelled where nothing hangs on it
    hangs: u.Extent | None = None  # below `at` at the start; left out: as its rigging asks, else as short as can be

    @property
    def chart(self) -> list[tuple[float, float]] | None:
        """The capacity chart that applies to the crane's boom, counterweight and base; None if the hook has no chart.

        It is the chart for the same or the next longer boom, the same or the next lighter counterweight, and the same
        or the next narrower base. Raises ValueError if no chart applies."""
        if not self.capacity_charts:
            return self.capacity_chart
        boom, more = (self.boom or inf) * (1.0 - ROUNDING), 1.0 + ROUNDING
        heavy, wide = (self.counterweight or 0.0) * more, (self.outriggers or 0.0) * more
        fit = [x for x in self.capacity_charts if x.boom >= boom]
        fit = [x for x in fit if (x.counterweight or 0.0) <= heavy and (x.outriggers or 0.0) <= wide]
        if not fit:
            raise ValueError(
                "there is no chart for this boom length, counterweight and base; choose others or add a chart"
            )
        return min(fit, key=lambda x: (x.boom, -(x.counterweight or 0.0), -(x.outriggers or 0.0))).chart


class Drawn(Base):
    """A box, given by centre and edges, that replaces the `box` of a body in drawings and collision checks."""

    at: Place = (0.0, 0.0, 0.0)
    size: tuple[u.Extent, u.Extent, u.Extent]
    part: str = ""  # what of it that is
    thing: str = ""  # what planners call it with its machine, if it is not the body: the `portal` of west


class LoadCellKeys(Base):
    """A load cell for all hooks on a body; `capacity`: largest total load below the hook blocks."""

    capacity: u.Mass
    tandem: u.Ratio = 1.0  # of it, where machines lift together


class ModelFile(Base):
    """A URDF or MJCF file with the parts of a machine; `lacks` (written by heavylift): features not converted."""

    file: str
    lacks: list[str] = Field(default_factory=list)


class Parts(Base, Generic[PartKey]):
    """Bodies, joints and laws of a mechanism, by name."""

    model_file: ModelFile | str | None = Field(default=None, alias="from")  # robot.urdf or model.xml
    name: Name = "mechanism"
    bodies: dict[PartKey, BodyKeys] = Field(default_factory=dict)
    joints: dict[PartKey, Joint] = Field(default_factory=dict)
    ropes: dict[PartKey, RopeKeys] = Field(default_factory=dict)
    supports: dict[PartKey, SupportKeys] = Field(default_factory=dict)
    springs: dict[PartKey, SpringKeys] = Field(default_factory=dict)
    stops: dict[PartKey, StopKeys] = Field(default_factory=dict)
    brakes: dict[PartKey, BrakeKeys] = Field(default_factory=dict)
    locks: dict[PartKey, LockKeys] = Field(default_factory=dict)
    drives: dict[PartKey, DriveKeys] = Field(default_factory=dict)
    forces: dict[PartKey, ForceElement] = Field(default_factory=dict)
    contacts: dict[PartKey, ContactKeys] = Field(default_factory=dict)
    hooks: dict[PartKey, HookKeys] = Field(default_factory=dict)
    elastic: dict[PartKey, Optional] = Field(default_factory=dict)  # bodies, drives and ropes, in levels that ask it
    load_cells: dict[PartKey, LoadCellKeys] = Field(default_factory=dict)  # bodies
    shapes: dict[PartKey, list[Drawn]] = Field(default_factory=dict)  # bodies
    configuration: dict[str, str | int | float] = Field(default_factory=dict)  # more of how it is set up, in words
    stands: Stands | None = None  # on what; left out: no pressure is checked
    wind: u.Speed | None = None  # up to which it works; left out: that of the scene's limits

    @property
    def laws(self) -> dict[str, dict[PartKey, Any]]:
        """All force laws along joint coordinates, by the section of the scene in which they are written."""
        return {"springs": self.springs, "stops": self.stops, "brakes": self.brakes, "drives": self.drives}


class MechanismKeys(Parts[Name]):
    """A system of bodies, joints and laws, which becomes one coupled model.

    In a scene with a lift it may refer to bodies and joints of the lift, and need not have any of its own."""
