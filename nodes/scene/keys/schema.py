"""The keys of a scene file as frozen pydantic models: every key, its unit and its default.

A key of several words is written with spaces in YAML (`may touch: ...`) and with underscores in Python.
"""

from typing import Annotated, Any, Literal

import msgspec
from heavylift.kernel.description.mechanics import IDENTITY, Matrix, MethodName, RemovedMethod, Vector
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.plan import factors as f, plan
from heavylift.nodes.plan.fidelity import OF_TENSIONS, USUAL, Asked
from heavylift.nodes.scene.text import units as u
from heavylift.recordings.format.spellings import BEAM_TYPE, BEAMS
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from .actions import ActionLine, Condition, InterlockKeys, Touching
from .base import Base, Name, Place, ProjectKeys, keys_of
from .environment import Fender, Floor, Obstacle, Vessel, Waves, WindKeys
from .nodes import ModelKeys, Process
from .parts.flexible import Hull, ModeKeys
from .parts.machines import FrameParts, MachineKeys, PartName
from .parts.mechanics import MechanismKeys, Moments
from .parts.rigging import Edge, GearKeys, Rigging, SlingType
from .parts.standing import GroundKeys
from .seas import CurrentKeys, Splash

ORDERED: Literal["ordered"] = "ordered"  # a lift that an action of the whole scene begins
RESERVED = (  # no machine and no group has such a name
    *("world", "obstacles", "block", "all", "any", "hooks", "cranes", BEAMS, "trolleys", "slings", "ropes"),
    *("kernel", "commander", "coordinator", "event", "observer", "operator"),  # nodes and topics of a run
)


def _once(asked: tuple[Asked, ...]) -> tuple[Asked, ...]:
    twice = next((quantity for i, quantity in enumerate(asked) if quantity in asked[:i]), None)
    if twice:
        raise ValueError(f"'{twice}' is listed twice in 'ask': list it once")
    return asked


OffLead = u.Swing | Literal["unknown"]


class CraneKeys(Base):
    """A crane of a machine type; all keys except `type` are parameters of the type."""

    type: str  # a bundled one, or a file of yours
    parameters: dict[str, Any] = Field(default_factory=dict)  # which stand beside the type


class Supports(Base):
    """Supports under the block, at the same places for each face on which the block can stand."""

    height: u.Length
    at: Annotated[list[tuple[u.Length, u.Length]], Field(min_length=3)]
    settlement: u.Extent = u.LENGTH.read("5 mm")  # under its share of the weight
    damping: u.Ratio = 0.3  # of critical, with its share of the weight; assumed
    friction: u.Ratio = 0.4  # assumed
    capacity: u.Mass | None = None  # of each; left out: not checked


class Mesh(Base):
    """A closed surface of triangles in a file (.stl, .glb, .gltf) that gives a block its size and mass properties."""

    file: str
    unit: Literal["m", "cm", "mm"] = "m"  # of its places
    density: u.Density | None = None  # gives the mass of the block, instead of `mass`
    slices: list[tuple[Place, tuple[u.Extent, u.Extent, u.Extent]]] = Field(default_factory=list)  # made of the file


class Block(Base):
    """The block to be lifted, a box with lugs.

    `at`: centre of the box; `com`: centre of mass relative to the centre of the box."""

    mass: u.Mass
    size: tuple[u.Extent, u.Extent, u.Extent]
    shape: Mesh | None = None  # instead of the box; what it gives need not be written
    at: Place
    com: Place = (0.0, 0.0, 0.0)
    inertia: Moments | None = None  # left out: a uniform box
    lugs: dict[Name, Place]
    beam: Hull | None = None  # left out, as `modes`: it is rigid
    modes: dict[Name, ModeKeys] = Field(default_factory=dict)  # instead: those of a table
    lug_capacity: u.Mass | None = None  # of each lug; left out: they are not checked
    supports: Supports
    on: str = "world"  # vessel on whose deck it stands: `at` and the height of its supports are in that one's frame
    splash: Splash | None = None  # if it is lowered into water

    @property
    def flexible(self) -> bool:
        """Whether the block is flexible."""
        return bool(self.beam or self.modes)


class FrameKeys(Base):
    """A frame on a hook, such as a lifting beam, with its slings; all other keys are parameters of its type."""

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
    """Limit of the static tension of a rope: a tension, or the breaking force divided by a design factor."""

    tension: u.Force | None = None
    breaking: u.Force | None = None
    factor: u.Factor = 5.0  # breaking force over the tension at rest
    partial_factor: u.Factor | None = None  # breaking force over the largest tension; left out: not checked
    source: str = "the scene"

    @model_validator(mode="after")
    def _one(self) -> "RopeLimit":
        if (self.tension is None) == (self.breaking is None):
            raise ValueError("give a rope either a 'tension' or a 'breaking' force")
        return self


class LiftLimits(Base):
    """Default limits of all machines; a limit with the value `unknown` is reported as not checked."""

    off_lead: OffLead = u.ANGLE.read("3 deg")  # of ropes that carry a load; assumed
    off_lead_along: OffLead | None = None  # along the rails or in the plane of a boom, instead of off-lead
    off_lead_across: OffLead | None = None  # across the rails; side lead of a boom
    clearance: u.Gap = u.LENGTH.read("0.5 m")  # between what can meet; assumed
    bridle_warning: u.Swing = u.ANGLE.read("45 deg")  # of slings to the vertical: beyond it they are reported
    bridle: u.Swing = u.ANGLE.read("60 deg")  # of slings to the vertical; EN 13414-1
    heave: u.Extent | None = None  # up and down between a hook and a vessel that does not carry it, as its winch stands
    impact: u.Factor = 1.5  # on all supports of a block as it lands, over its weight; assumed
    touch: u.Speed = u.SPEED.read("2 m/min")  # of hooks as a block lifts off or lands; assumed
    wind: u.Speed | None = None  # in which is lifted; left out: not checked
    signals: list[Condition] = Field(default_factory=list)  # what must hold: `gap west east >= 3 m`
    ropes: dict[str, RopeLimit] = Field(default_factory=dict)  # of any ropes, those of a mechanism too


class RigKeys(Base):
    """The rig that connects the machines: beams on hooks, slings to lugs, and names for groups of hooks."""

    beams: dict[Name, FrameKeys]
    sling: SlingType = SlingType()
    shackle: u.Mass | None = None  # what its shackles may carry, each; left out: they are not checked
    slack: u.Gap = u.LENGTH.read("0.3 m")  # of all slings at the start
    groups: dict[Name, Annotated[list[str], Field(min_length=1)]] = Field(default_factory=dict)


class FidelityKeys(keys_of(plan.Fidelity, "where")):  # type: ignore[misc]
    """Model level of the machines: which parts are elastic, have mass, or are locked."""


class FactorKeys(keys_of(f.Factors, "where")):  # type: ignore[misc]
    """Load factors from static loads to design loads, for which hooks, slings, shackles and lugs are chosen."""


class Instance(Base):
    """One of several lifts in a scene: the scene that it extends, its origin, and the start of its action list.

    Further keys replace keys of the extended scene, as with `extends`."""

    model_config = ConfigDict(extra="allow")
    extends: str | None = None  # a file beside the scene, or a bundled one; left out: all its keys stand here
    at: tuple[u.Length, u.Length] = (0.0, 0.0)  # where the origin of its scene is, along x and y
    start: u.Duration | Literal["ordered"] | None = None  # of its action list; left out: at once; ordered: by an action


class Scene(Base):
    """The keys of a scene file."""

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
    cranes: dict[Name, CraneKeys] = Field(default_factory=dict)  # as their types make them: `machines`
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
    current: CurrentKeys | None = None
    floor: Floor | None = None
    ground: GroundKeys = GroundKeys()
    obstacles: dict[Name, Obstacle] = Field(default_factory=dict)
    vessels: dict[Name, Vessel] = Field(default_factory=dict)
    fenders: dict[Name, Fender] = Field(default_factory=dict)
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
        """All blocks by name."""
        return {**({"block": self.block} if self.block else {}), **self.blocks}

    @property
    def all_factors(self) -> f.Factors:
        """The load factors of the scene; the default wind area is that of the largest face of all blocks."""
        given: f.Factors = self.factors.built()
        sizes = [block.size for block in self.all_blocks.values()]
        area = given.area or max((x * y * z / min(x, y, z) for x, y, z in sizes), default=0.0)
        return msgspec.structs.replace(given, area=area)

    def put(self, name: str) -> tuple[Vector, Matrix]:
        """Return the centre of a block at the start in the world frame [m], and the block's rotation matrix."""
        block = self.all_blocks[name]
        deck = self.vessels.get(block.on)
        return (deck.place(block.at), deck.attitude) if deck else (block.at, IDENTITY)

    @property
    def step_tolerance(self) -> float:
        """Tolerance of an integration step, as given or derived from the accuracy."""
        wanted = self.accuracy or (USUAL if self.ask else OF_TENSIONS)
        return self.tolerance or min(wanted * plan.TOLERANCE_OF_ACCURACY, plan.LOOSEST)
