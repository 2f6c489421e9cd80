"""The plan: a scene after reading, its names resolved, its numbers in SI units, one actor for every order.

What `heavylift.nodes.scene` makes of a scene file and what `heavylift.nodes.models` builds the DEVS models
from. It goes to every node process and into the recording, so it is plain frozen msgspec data (finite
numbers only) and needs no pydantic.  `where` ("turnover.yaml:31:5") lets a sentence at run time point at
the line that caused it.

Names of mechanical elements follow from the names in the plan (C = crane, L = loader, B = block):
    bodies   C.main C.upper C.lower    L.upper L.lower    B
    joints   C.gantry C.upper-slide C.lower-slide    L.free L.hinge    B.free
    drives   C.gantry.drive C.upper-slide.drive C.lower-slide.drive
    ropes    as named in the rig (by custom C.H1 and L.sling-1)
    others   brake (hinge lock) L.hinge.lock, stop L.hinge.stop, Master "turn", Measured B.theta
Orders and conditions stand in `actions`.  An actuator is addressed by the name of its Drive, winch rope or
Master; a model by the name of the machine.
"""

from __future__ import annotations

from typing import Literal

import msgspec
from heavylift.kernel.description.flexible import Flexible
from heavylift.kernel.description.forces import Sheave
from heavylift.kernel.description.mechanics import Line, Matrix, MethodName, Point, RemovedMethod, Support, Vector
from heavylift.kernel.trust import named
from heavylift.nodes.devs.execution.rules import LIMIT

from .actions import Action as Action
from .actions import Item, Touch
from .fidelity import Fidelity as Fidelity
from .interlock import Interlock as Interlock
from .limit import Limit
from .mechanism import Actuator as Actuator
from .mechanism import Driven as Driven
from .mechanism import Hoist as Hoist
from .mechanism import Mechanism as Mechanism
from .mechanism import Shape as Shape
from .mechanism import Tie as Tie
from .mechanism import driven as driven
from .own import Own

TOLERANCE_OF_ACCURACY = 1e-2  # tolerance of an integration step / accuracy of the rope tensions that it serves
LOOSEST = 1e-4  # tolerance: a looser one lets stiff modes rattle, peaks are wrong by a fifth, and steps are no cheaper


class Inertia(Item, frozen=True, kw_only=True):
    """Mass [kg], centre of mass in the body frame [m], moments and products (Ixy, Ixz, Iyz) about it along the body
    axes [kg m2]."""

    mass: float
    com: Vector = (0.0, 0.0, 0.0)
    moments: Vector
    products: Vector = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Matrix:
        """(3, 3)."""
        (xx, yy, zz), (xy, xz, yz) = self.moments, self.products
        return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


class Axis(Item, frozen=True, kw_only=True):
    """A servo-driven sliding joint: start and end positions [m], ramp [m/s2], gains [N/m] and [N s/m]; `pulses`: of a
    ramp without swing; `emergency`: deceleration when it is stopped [m/s2], None: the ramp."""

    start: float
    lower: float
    upper: float
    accel: float
    kp: float
    kv: float
    pulses: int = 0
    emergency: float | None = None


class Trolley(Item, frozen=True, kw_only=True):
    """A trolley of a crane; its frame has the main body's axes, origin at y = 0, z = 0; capacity [kg]."""

    name: Literal["upper", "lower"]
    body: Inertia
    axis: Axis  # coordinate y [m], world y of the trolley
    capacity: float


class Hook(Item, frozen=True, kw_only=True):
    """A hook of a crane with its winch; lengths are unstretched lengths of the rope named `rope`."""

    name: str  # "H1"
    rope: str  # "west.H1", a HookRope of the rig
    trolley: Literal["upper", "lower"]
    accel: float  # of the winch [m/s2]
    shortest: float  # [m]
    drum: float  # longest: then the drum is empty [m]
    highest: float  # world z of the hook eye where the upper limit switch trips [m]
    capacity: float  # of what hangs below the hook block [kg]
    block_mass: float  # hook block, which the rope carries besides [kg]
    emergency: float | None = None  # deceleration of the winch when it is stopped [m/s2]; None: its ramp


class Girder(Item, frozen=True, kw_only=True):
    """The part of a crane's main body that bends: mass [kg], stiffness at midspan [N/m], from y = 0 to `span` [m]."""

    mass: float = 2.5e6
    stiffness: float = 5.88e7
    span: float = 150.0
    height: float = 95.0  # z of its neutral axis [m]
    damping: float = 0.01  # of its first mode, as a part of critical damping


class Crane(Item, frozen=True, kw_only=True):
    """A goliath crane: main body on rails along x, upper and lower trolley along y.

    The main body's frame has world axes and its origin at y = z = 0; the coordinate of the gantry is the
    world x of the crane's centre.
    """

    name: str
    main: Inertia
    gantry: Axis
    upper: Trolley
    lower: Trolley
    hooks: tuple[Hook, ...]
    capacity: float  # [kg], already reduced where two cranes lift together
    girder: Girder = Girder()
    width: float = 34.0  # of the portal along x, over the buffers [m]
    at: tuple[float, float] = (0.0, 0.0)  # x and y of the world from which its coordinates count [m]


class Loader(Item, frozen=True, kw_only=True):
    """A block loader: upper body on a free joint (frame at the hook eye), lower body on a hinge about y.

    `pose` x y z qx qy qz qw of the upper body at the start; `hinge` in its frame, the lower body's frame is there.  The
    lock holds the hinge while no sling of the loader is hooked.
    """

    name: str
    pose: tuple[float, float, float, float, float, float, float]
    upper: Inertia
    lower: Inertia
    hinge: Vector
    damping: float  # of the hinge [N m s/rad]
    stop_lower: float  # [rad]
    stop_upper: float  # [rad]
    stop_k: float  # [N m/rad]
    stop_d: float  # [N m s/rad]
    lock_moment: float  # of the locked hinge [N m]
    lock_k: float
    lock_d: float
    capacity_N: float  # sum of its sling tensions above which it reports overload [N]


class Lug(Item, frozen=True, kw_only=True):
    """A lug of the block, in the block's frame [m]."""

    name: str
    p: Vector


class Pad(Item, frozen=True, kw_only=True):
    """A support of the block; `face` groups the pads it stands on together; `closed`: bears at the start."""

    support: Support
    face: str
    closed: bool


class Block(Item, frozen=True, kw_only=True):
    """The block: a body on a free joint, frame in the middle of its box (`size` [m]); theta turns +w towards +y."""

    name: str = "block"
    body: Inertia
    size: Vector = (0.0, 0.0, 0.0)  # zeros: not given
    slices: tuple[tuple[Vector, Vector], ...] = ()  # boxes, middle and edges, that hold its shape if it is no box
    pose: tuple[float, float, float, float, float, float, float]
    lugs: tuple[Lug, ...]
    pads: tuple[Pad, ...]
    flexible: Flexible | None = None
    com_where: str = ""


class HookRope(Item, frozen=True, kw_only=True):
    """A hook rope (winch) from a crane's trolley to what hangs on the hook; its lines share its length."""

    name: str
    crane: str
    hook: str
    carries: str  # loader (or block) on the hook
    eye: Point  # whose height is the hook's height
    lines: tuple[Line, ...]
    L0: float
    EA: float
    damping: float
    falls: int = 1
    line: float = 0.0  # mass per length of all falls together [kg/m]
    rated: float = 0.0  # tension that counts as 100 % of use [N]; 0: none given
    drum_ends: int = 1  # of the rope; the others end at a dead end, or at an equaliser
    efficiency: float = 1.0  # of each sheave: tension behind over tension before
    breaking: float = 0.0  # of one fall [N]; 0: none given


class Sling(Item, frozen=True, kw_only=True):
    """A sling from a point of a loader's beam to a lug of the block; `lug` "" = not hooked at the start."""

    name: str
    loader: str
    beam: Point
    lug: str
    L0: float
    EA: float
    damping: float
    taut: bool = False
    over: tuple[Sheave, ...] = ()  # edges that it may bend over
    rated: float = 0.0  # tension that counts as 100 % of use [N]; 0: none given


class Rig(Item, frozen=True, kw_only=True):
    """All connections between the machines, which the commander owns."""

    hook_ropes: tuple[HookRope, ...] = ()
    slings: tuple[Sling, ...] = ()


class ActionList(Item, frozen=True, kw_only=True):
    """One of several action lists: it begins with the action of number `first`, and orders these machines; without
    any it is that of the whole scene, which begins others.  `fidelity`, `start`: as those of a plan, of this lift."""

    name: str
    first: int
    machines: tuple[str, ...]
    fidelity: Fidelity = Fidelity()
    start: float = 0.0


class Plan(Item, frozen=True, kw_only=True):
    """A resolved scene.  With `end` [s] the run ends there, without it when the last action is done."""

    name: str
    gravity: float = 9.80665
    tolerance: float = 1e-6
    method: MethodName | RemovedMethod = "dopri5"
    step: float | None = None  # of fixed steps [s]
    seed: int = 0
    microsteps: int = LIMIT  # in which no time passes, and that are a loop
    samples_hz: float = 10.0
    start: float = 0.0  # value of the Master "turn" at the start: the block's theta [rad]
    end: float | None = None
    cranes: tuple[Crane, ...] = ()
    loaders: tuple[Loader, ...] = ()
    block: Block | None = None
    blocks: tuple[Block, ...] = ()  # of several lifts, in place of it
    mechanisms: tuple[Mechanism, ...] = ()
    rig: Rig = Rig()
    fidelity: Fidelity = Fidelity()
    limits: tuple[Limit, ...] = ()
    accepts_assumed: bool = False  # limits that heavylift assumes count as the scene's own
    models: tuple[Own, ...] = ()
    interlocks: tuple[Interlock, ...] = ()
    actions: tuple[Action, ...] = ()
    may_touch: tuple[Touch, ...] = ()  # at any time
    lists: tuple[ActionList, ...] = ()  # carried out side by side; none: all actions are one list
    driven: tuple[Driven, ...] = ()

    @property
    def lift(self) -> bool:
        """Whether goliaths lift a block, so that the rules of such lifts hold."""
        return self.block is not None and bool(self.cranes)

    @property
    def tied(self) -> bool:
        """Whether a mechanism acts on the lift."""
        return any(any(mechanism.system.outside) for mechanism in self.mechanisms)

    @property
    def machines(self) -> tuple[Crane | Loader | Block | Mechanism, ...]:
        """All machines, in the order of their nodes."""
        return (*self.cranes, *self.loaders, *self.all_blocks, *self.mechanisms)

    @property
    def all_blocks(self) -> tuple[Block, ...]:
        """The block of its lift, or those of several."""
        return (self.block, *self.blocks) if self.block else self.blocks

    @property
    def first(self) -> int:
        """The number of its first action, which in the part of one of several lists is that in the whole scene."""
        return self.lists[0].first if self.lists else 0

    def action(self, number: int) -> Action:
        """The action of a number."""
        return self.actions[number - self.first]

    def leader(self, actuator: str) -> str:
        """The model whose set-points lead an actuator; "" if none does."""
        return next((own.name for own in self.models for led in own.leads if led.move.actuator == actuator), "")


def drive_name(crane: str, axis: Literal["gantry", "upper", "lower"]) -> str:
    """Name of the actuator that moves a crane or one of its trolleys."""
    return f"{crane}.gantry.drive" if axis == "gantry" else f"{crane}.{axis}-slide.drive"


_DECODER = msgspec.json.Decoder(Plan)  # made where this is imported, before processes of nodes are forked


def encode(plan: Plan) -> bytes:
    """The plan as canonical JSON: equal plans have equal bytes."""
    once = _DECODER.decode(msgspec.json.encode(plan))  # defaults are told from equal values by identity
    return msgspec.json.encode(once)


def decode(data: bytes) -> Plan:
    """The plan from its canonical JSON, which is data of others; raises msgspec.ValidationError if it is none."""
    plan = _DECODER.decode(data)
    named(functions(plan))
    return plan


def functions(plan: Plan) -> list[str]:
    """The code that its laws and models name."""
    laws = [function for mechanism in plan.mechanisms for function in mechanism.system.functions]
    return [*laws, *(own.reference for own in plan.models)]
