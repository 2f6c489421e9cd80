"""The keys of a scene file, as frozen pydantic models: every key, its unit, its default.

A key of several words is written with blanks in YAML (`upper trolley: 60.4 m`) and with underscores in
Python. Defaults of a crane are those of a credible 900 t yard; a scene overrides them with its own.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from heavylift.kernel.description.mechanics import MethodName, RemovedMethod
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.plan import factors as f
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.fidelity import OF_TENSIONS, USUAL, Asked
from heavylift.nodes.plan.spellings import BEAM_TYPE, BEAMS
from heavylift.nodes.scene.text import units as u
from pydantic import AfterValidator, ConfigDict, Field, ModelWrapValidatorHandler, model_validator

from .actions import ActionLine, Condition, InterlockKeys, Touching
from .base import Base, Name, Place, ProjectKeys
from .described import keys_of
from .environment import Floor, Obstacle, Vessel, Waves, WindKeys
from .nodes import ModelKeys, Process
from .parts.flexible import Hull, ModeKeys
from .parts.machines import FrameParts, MachineKeys, PartName, PortalParts
from .parts.mechanics import Chart, MechanismGroup, MechanismKeys, Moments, Ramp
from .parts.rigging import Edge, GearKeys, Rigging, SlingType
from .parts.standing import GroundKeys

ORDERED: Literal["ordered"] = "ordered"  # a lift that an action of the whole scene begins
RESERVED = (  # no machine and no group has such a name
    *("world", "obstacles", "block", "all", "any", "hooks", "cranes", BEAMS, "trolleys", "slings", "ropes"),
    *("kernel", "commander", "coordinator", "event", "observer", "operator"),  # nodes and topics of a run
)


def _ordered(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError(f"the first end must be below the second, but {pair[0]:g} m >= {pair[1]:g} m")
    return pair


def _once(asked: tuple[Asked, ...]) -> tuple[Asked, ...]:
    twice = next((quantity for i, quantity in enumerate(asked) if quantity in asked[:i]), None)
    if twice:
        raise ValueError(f"'{twice}' is asked twice: once is enough")
    return asked


Range = Annotated[tuple[u.Length, u.Length], AfterValidator(_ordered)]
OffLead = u.Swing | Literal["unknown"]


class CraneKeys(Base):
    """A crane on rails: portal along x; upper trolley (H1, H2) and lower trolley (H3) along y.

    What is left out its type says, `parts` it makes; the defaults are those of the smallest bundled one.
    """

    type: str  # of the family, or a file of it
    at: u.Length  # x of its centre
    upper_trolley: u.Length | None = None  # y; left out: where its lugs are
    lower_trolley: u.Length | None = None
    rails: Range = (0.0, 400.0)  # x that the centre can reach
    span: u.Extent = u.LENGTH.read("150 m")  # rails at y = 0 and y = span
    width: u.Extent = u.LENGTH.read("34 m")  # of the portal along x, over the buffers
    girder: Range = (10.0, 140.0)  # y that the trolleys can reach
    trolley_length: u.Extent = u.LENGTH.read("10 m")  # along y
    main_mass: u.Mass = u.MASS.read("4200 t")  # with the girder
    girder_mass: u.Mass = u.MASS.read("2500 t")
    girder_stiffness: u.Stiffness = u.STIFFNESS.read("58.8 MN/m")  # at midspan, between the legs
    girder_damping: u.Ratio = 0.01  # of critical, of its first mode; assumed
    upper_mass: u.Mass = u.MASS.read("300 t")
    lower_mass: u.Mass = u.MASS.read("150 t")
    upper_exit: u.Extent = u.LENGTH.read("102 m")  # z where the ropes leave
    lower_exit: u.Extent = u.LENGTH.read("88 m")
    hook_spacing: u.Extent = u.LENGTH.read("6 m")  # H1, H2 at -+ this x from the centre
    highest_hook: u.Extent = u.LENGTH.read("80 m")  # z of the hook eye at the upper limit
    shortest_rope: u.Extent = u.LENGTH.read("8 m")
    drum: u.Extent = u.LENGTH.read("100 m")  # longest rope
    gantry_speed: u.Speed = u.SPEED.read("30 m/min")
    trolley_speed: u.Speed = u.SPEED.read("20 m/min")
    hoist_speed: u.Speed = u.SPEED.read("3 m/min")  # loaded
    empty_hoist_speed: u.Speed = u.SPEED.read("10 m/min")
    ramp: Ramp = u.ACCELERATION.read("0.05 m/s2")  # or of gantry and trolleys `one swing`, `0.1 m/s2 in two pulses`
    emergency: u.Ramp | None = None  # deceleration by `stop` and interlocks; left out: the ramp
    servo_frequency: u.Frequency = 1.0  # of the gantry and trolley drives
    servo_damping: u.Ratio = 0.7  # of critical, of the gantry and trolley drives; assumed
    hook_capacity: u.Mass = u.MASS.read("450 t")
    capacity_chart: Chart | None = None  # of a hook by its trolley's y, instead of the hook capacity
    upper_capacity: u.Mass = u.MASS.read("900 t")
    lower_capacity: u.Mass = u.MASS.read("450 t")
    capacity: u.Mass = u.MASS.read("900 t")
    tandem: u.Ratio = 0.75  # of the capacity, where two cranes lift together
    hook_block: u.Mass = u.MASS.read("25 t")
    falls: Annotated[int, Field(ge=1)] = 20
    drum_ends: Literal[1, 2] | None = None  # of the hook's rope; left out: two where the falls can be halved, assumed
    sheave_efficiency: u.Efficiency | None = None  # of each sheave; left out: 0.98 with rolling bearings, assumed
    drum_pull: u.Force | None = None  # that a drum end may pull; left out: not judged
    gantry_drive: u.Force | None = None  # that moves the crane; left out: not judged
    gantry_brake: u.Force | None = None  # that holds the crane; left out: not judged
    trolley_drive: u.Force | None = None  # that moves a trolley; left out: not judged
    trolley_brake: u.Force | None = None  # that holds a trolley; left out: not judged
    off_lead_along: OffLead | None = None  # of its ropes along the rails; left out: that of the scene's limits
    off_lead_across: OffLead | None = None  # of its ropes across the rails; left out: that of the scene's limits
    fall_EA: u.Force = u.FORCE.read("93.5088 MN")  # 44 mm 6x36: 890.6 mm2, 105 GPa
    fall_mass: u.MassPerLength = u.MASS_PER_LENGTH.read("7.92 kg/m")
    fall_breaking: u.Force = u.FORCE.read("1351 kN")
    rope_damping: u.Ratio = 0.03  # of critical, with what it carries at the start; assumed
    mechanism_group: MechanismGroup = "M6"  # of the hoists: gives the rope factor by ISO 4308-1
    rope_factor: u.Factor | None = None  # breaking force over its most loaded part; left out: by the mechanism group
    rope_partial_factor: u.Factor | None = None  # breaking force over its largest tension; left out: 2.77, EN 13001-3-2
    parts: PortalParts | None = None  # made by the type, not to be written

    @model_validator(mode="wrap")
    @classmethod
    def _of_its_type(cls, data: Any, handler: ModelWrapValidatorHandler[CraneKeys]) -> CraneKeys:
        """Parameters of the type stand for keys that are left out, and do not count as set."""
        theirs = data.get("parameters") if isinstance(data, dict) else None
        if not isinstance(theirs, dict):
            return handler(data)
        own = {key: value for key, value in data.items() if key != "parameters"}
        crane = handler({**theirs, **own})
        kept = {name for name, field in cls.model_fields.items() if {name, field.alias} & {*own}}
        object.__setattr__(crane, "__pydantic_fields_set__", kept)
        return crane


class Supports(Base):
    """Stools under the block: the same places serve on either face."""

    height: u.Length
    at: Annotated[list[tuple[u.Length, u.Length]], Field(min_length=3)]
    settlement: u.Extent = u.LENGTH.read("5 mm")  # under its share of the weight
    damping: u.Ratio = 0.3  # of critical, with its share of the weight; assumed
    friction: u.Ratio = 0.4  # assumed
    capacity: u.Mass | None = None  # of each; left out: not judged


class Mesh(Base):
    """A closed surface of triangles in a file .stl, .glb or .gltf, which gives the block's size and mass properties."""

    file: str
    unit: Literal["m", "cm", "mm"] = "m"  # of its places
    density: u.Density | None = None  # gives the mass of the block, instead of `mass`
    slices: list[tuple[Place, tuple[u.Extent, u.Extent, u.Extent]]] = Field(default_factory=list)  # made of the file


class Block(Base):
    """The block: a box with lugs; `at` is the middle of the box, `com` its centre of mass from there."""

    mass: u.Mass
    size: tuple[u.Extent, u.Extent, u.Extent]
    shape: Mesh | None = None  # instead of the box; what it gives need not be written
    at: Place
    com: Place = (0.0, 0.0, 0.0)
    inertia: Moments | None = None  # left out: a uniform box
    lugs: dict[Name, Place]
    beam: Hull | None = None  # left out, as `modes`: it is rigid
    modes: dict[Name, ModeKeys] = Field(default_factory=dict)  # instead: those of a table
    lug_capacity: u.Mass | None = None  # of each lug; left out: they are not judged
    supports: Supports
    on: str = "world"  # vessel on whose deck it stands: `at` and the height of its supports are in that one's frame

    @property
    def flexible(self) -> bool:
        """Whether it bends."""
        return bool(self.beam or self.modes)


class FrameKeys(Base):
    """A frame on a hook, such as a lifting beam on a hinge below the hook block, and the slings from it.

    What else is written are parameters of its type."""

    type: str = BEAM_TYPE  # a bundled one, or a file of yours
    hook: str  # "west H1"
    sling: u.Extent
    lugs: Annotated[list[str], Field(min_length=1)] | None = None  # hooked at the start, one for each sling
    over_edges: list[str] = Field(default_factory=list)  # that its slings bend over where they meet them
    rope: u.Extent | None = None  # unstretched rope length at the start; left out: the rig's slack
    capacity: u.Mass = u.MASS.read("300 t")  # of its slings
    parts: FrameParts  # made by the type, as all below; not to be written
    parameters: dict[str, Any]


class RopeLimit(Base):
    """What a rope may carry at rest: a tension, or its breaking force over a design factor."""

    tension: u.Force | None = None
    breaking: u.Force | None = None
    factor: u.Factor = 5.0  # breaking force over the tension at rest
    partial_factor: u.Factor | None = None  # breaking force over the largest tension; left out: not judged
    source: str = "the scene"

    @model_validator(mode="after")
    def _one(self) -> RopeLimit:
        if (self.tension is None) == (self.breaking is None):
            raise ValueError("give a rope either a 'tension' or a 'breaking' force")
        return self


class LiftLimits(Base):
    """What must not be exceeded, of all machines that say nothing else; `unknown`: reported, and not judged."""

    off_lead: OffLead = u.ANGLE.read("3 deg")  # of ropes that carry a load; assumed
    off_lead_along: OffLead | None = None  # along the rails, instead of off-lead
    off_lead_across: OffLead | None = None  # across the rails, instead of off-lead
    clearance: u.Gap = u.LENGTH.read("0.5 m")  # between what can meet; assumed
    bridle_warning: u.Swing = u.ANGLE.read("45 deg")  # of slings to the vertical: beyond it they are reported
    bridle: u.Swing = u.ANGLE.read("60 deg")  # of slings to the vertical; EN 13414-1
    impact: u.Factor = 1.5  # on all supports of a block as it lands, over its weight; assumed
    touch: u.Speed = u.SPEED.read("2 m/min")  # of hooks as a block lifts off or lands; assumed
    wind: u.Speed | None = None  # in which is lifted; left out: not judged
    signals: list[Condition] = Field(default_factory=list)  # what must hold: `gap west east >= 3 m`
    ropes: dict[str, RopeLimit] = Field(default_factory=dict)  # of any ropes, those of a mechanism too


class RigKeys(Base):
    """What connects the machines: beams on hooks, slings to lugs; and names for groups of hooks."""

    beams: dict[Name, FrameKeys]
    sling: SlingType = SlingType()
    shackle: u.Mass | None = None  # what its shackles may carry, each; left out: they are not judged
    slack: u.Gap = u.LENGTH.read("0.3 m")  # of all slings at the start
    groups: dict[Name, Annotated[list[str], Field(min_length=1)]] = Field(default_factory=dict)


class FidelityKeys(keys_of(plan.Fidelity, "where")):  # type: ignore[misc]
    """How much of the machines is modelled."""


class FactorKeys(keys_of(f.Factors, "where")):  # type: ignore[misc]
    """Factors between the load at rest and that for which hooks, slings, shackles and lugs are chosen."""


class Instance(Base):
    """A scene as one of several lifts; what else is written here is laid over it, as over one that is extended."""

    model_config = ConfigDict(extra="allow")
    extends: str  # a file beside the scene, or a bundled one
    at: tuple[u.Length, u.Length] = (0.0, 0.0)  # where the origin of its scene is, along x and y
    start: u.Duration | Literal["ordered"] | None = None  # of its action list; left out: at once; ordered: by an action


class Scene(Base):
    """A scene file."""

    heavylift: Literal[1]
    name: Name
    project: ProjectKeys | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)  # named values for arithmetic, as in `mass: =2*half`
    gravity: u.Gravity = 9.80665
    accuracy: u.Accuracy | None = None  # of what is asked, by default 1 %; alone: of rope tensions
    ask: Annotated[tuple[Asked, ...], AfterValidator(_once)] = ()  # model what these require, no more
    samples: u.Sampling = 2.0
    method: Literal[MethodName, RemovedMethod] = "dopri5"  # of integration
    tolerance: Annotated[float, Field(ge=1e-12, le=0.1)] | None = None  # of a step, instead of accuracy's
    tolerance_of: Literal["state", "rope tension"] = "state"  # of older scenes; it is always that of the state
    step: u.Duration | None = None  # fixed steps instead of steps as long as the accuracy allows
    seed: Annotated[int, Field(ge=0)] = 0
    microsteps: Annotated[int, Field(ge=1, le=2**31 - 1)] = LIMIT  # so many steps in no time are a loop
    end: u.Duration | None = None
    cranes: dict[Name, CraneKeys] = Field(default_factory=dict)  # of other types: their parameters
    block: Block | None = None
    blocks: dict[Name, Block] = Field(default_factory=dict)  # several, which machines made of parts lift
    rig: RigKeys | None = None
    fidelity: FidelityKeys = FidelityKeys()
    limits: LiftLimits = LiftLimits()
    practice: f.Practice | None = None  # fills the factors that the scene leaves out, where its clause was read
    factors: FactorKeys = FactorKeys()  # of design loads
    assumed: Literal["accept"] | None = None  # accept: the limits that heavylift assumes are confirmed
    mechanism: MechanismKeys | None = None
    wind: WindKeys | None = None
    waves: Waves | None = None
    floor: Floor | None = None
    ground: GroundKeys = GroundKeys()
    obstacles: dict[Name, Obstacle] = Field(default_factory=dict)
    vessels: dict[Name, Vessel] = Field(default_factory=dict)
    machines: dict[Name, MachineKeys] = Field(default_factory=dict)  # in parts, as types make them
    rigging: dict[Name, Rigging] = Field(default_factory=dict)  # what hangs on their hooks
    gear: dict[str, GearKeys] = Field(default_factory=dict)  # items of rigging by ID, or files of them
    edges: dict[Name, Edge] = Field(default_factory=dict)  # that ropes bend over
    lifts: dict[Name, Instance] = Field(default_factory=dict)  # several scenes side by side
    interlocks: dict[PartName, InterlockKeys] = Field(
        default_factory=dict
    )  # what stops machines, besides their types' own
    models: dict[Name, ModelKeys] = Field(default_factory=dict)  # of a user's own, beside the kernel
    placement: dict[Name, Process] = Field(default_factory=dict)  # which process hosts which nodes
    may_touch: Touching = Field(default_factory=list)  # what the lift means to touch, besides `landed on`
    actions: list[ActionLine] = Field(default_factory=list)

    @property
    def all_blocks(self) -> dict[str, Block]:
        """The block of the scene and its several, by name."""
        return {**({"block": self.block} if self.block else {}), **self.blocks}

    @property
    def step_tolerance(self) -> float:
        """Of a step, as written, or by the accuracy of what it asks itself."""
        wanted = self.accuracy or (USUAL if self.ask else OF_TENSIONS)
        return self.tolerance or min(wanted * plan.TOLERANCE_OF_ACCURACY, plan.LOOSEST)
