"""The plan: a scene after reading, with resolved names, numbers in SI units and one actor for every order.

`heavylift.nodes.scene` builds the plan from a scene file, and `heavylift.nodes.models` builds the DEVS models from the
plan. It is sent to every node process and stored in the recording, so it is plain frozen msgspec data (finite numbers
only) and needs no pydantic. `where` ("turnover.yaml:31:5") lets an error at run time name the line that caused it.

Orders and conditions are in `actions`. An actuator is addressed by the name of its drive, winch rope or master; a model
by the name of the machine.
"""

import msgspec
from heavylift.kernel.description.mechanics import MethodName, RemovedMethod
from heavylift.kernel.trust import named
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.recordings.format.spellings import driven as driven

from .actions import Action as Action, Item, Touch
from .factors import Place
from .fidelity import Fidelity as Fidelity
from .interlock import Interlock as Interlock
from .limit import RatedLimit
from .mechanism import (
    Actuator as Actuator,
    Driven as Driven,
    Hoist as Hoist,
    Mechanism as Mechanism,
    Shape as Shape,
    Tie as Tie,
)
from .user_models import UserModel

TOLERANCE_OF_ACCURACY = 1e-2  # tolerance of an integration step / accuracy of the rope tensions that it serves
LOOSEST = 1e-4  # tolerance: a looser one lets stiff modes rattle, peaks are wrong by a fifth, and steps are no cheaper


class ActionList(Item, frozen=True, kw_only=True):
    """One of several action lists of a plan: name, number of its first action, and the machines that get its orders.

    The list without machines belongs to the whole scene and begins the other lists. `fidelity` and `start` are those of
    the lift."""

    name: str
    first: int
    machines: tuple[str, ...]
    fidelity: Fidelity = Fidelity()
    start: float = 0.0


class Gear(Item, frozen=True, kw_only=True):
    """An item of rigging gear: number of pieces, working load limit [kg], mass [kg] (0: unknown), places of use."""

    name: str
    kind: str
    number: int
    WLL: float = 0.0
    mass: float = 0.0
    standard: str = ""
    termination: str = ""
    certificate: str = ""
    at: tuple[str, ...] = ()


class Plan(Item, frozen=True, kw_only=True):
    """A resolved scene. The run ends at `end` [s] or, if there is no `end`, after the last action."""

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
    machines: tuple[Mechanism, ...] = ()  # in the order of their nodes
    fidelity: Fidelity = Fidelity()
    limits: tuple[RatedLimit, ...] = ()
    gear: tuple[Gear, ...] = ()
    place: Place | None = "onshore"  # where it is lifted, if that is known
    accepts_assumed: bool = False  # limits that heavylift assumes count as the scene's own
    models: tuple[UserModel, ...] = ()
    interlocks: tuple[Interlock, ...] = ()
    actions: tuple[Action, ...] = ()
    may_touch: tuple[Touch, ...] = ()  # at any time
    lists: tuple[ActionList, ...] = ()  # carried out side by side; none: all actions are one list
    driven: tuple[Driven, ...] = ()

    @property
    def first(self) -> int:
        """The number of the first action in this plan."""
        return self.lists[0].first if self.lists else 0

    def action(self, number: int) -> Action:
        """Return the action with the given number."""
        return self.actions[number - self.first]

    def leader(self, actuator: str) -> str:
        """Return the user model whose set-points control an actuator, or "" if there is none."""
        return next((own.name for own in self.models for led in own.leads if led.move.actuator == actuator), "")


_DECODER = msgspec.json.Decoder(Plan)  # made where this is imported, before processes of nodes are forked
_encoded: list[tuple[Plan, bytes]] = []  # the last ones
MOST = 8


def encode(plan: Plan) -> bytes:
    """Encode the plan as canonical JSON: equal plans have equal bytes."""
    found = next((text for known, text in _encoded if known is plan), b"") or _canonical(plan)
    _encoded[:] = [(plan, found), *(x for x in _encoded if x[0] is not plan)][:MOST]
    return found


def _canonical(plan: Plan) -> bytes:
    once = _DECODER.decode(msgspec.json.encode(plan))  # encoders tell defaults from equal values by identity
    return msgspec.json.encode(once)


def decode(data: bytes) -> Plan:
    """Decode a plan from canonical JSON; raises msgspec.ValidationError for an invalid plan."""
    plan = _DECODER.decode(data)
    named(functions(plan))
    return plan


def functions(plan: Plan) -> list[str]:
    """Return the names of the Python code that the force laws and user models of a plan use."""
    laws = [function for machine in plan.machines for function in machine.system.functions]
    return [*laws, *(own.reference for own in plan.models)]
