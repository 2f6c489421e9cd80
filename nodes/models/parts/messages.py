"""The messages between models: orders, reports, inputs of the kernel and its state events.

    commander --Order--> model --KernelInput--> kernel --StateEvent--> model --Report--> commander
An order names one actor by its mechanical element (drive, winch rope, sling, brake, threshold, master),
contains an actor command of the plan, and has an id; the actor reports Done with that id when it has carried
it out.  Coordinates are the actuator's own: joint coordinate of a drive, UNSTRETCHED LENGTH of a winch rope
(hoisting is negative), value of a master.  SI units.
"""

from collections.abc import Mapping
from typing import ClassVar

from heavylift.nodes.devs import Message
from heavylift.nodes.plan.actions import ActorCommand
from heavylift.nodes.plan.places import LED

from .kernel_messages import (
    ACCELERATION,
    PLACE,
    SPEED,
    Hook as Hook,
    KernelInput as KernelInput,
    SetBrake as SetBrake,
    SetFollow as SetFollow,
    SetLock as SetLock,
    SetProfile as SetProfile,
    StateEvent as StateEvent,
    Unhook as Unhook,
    Unwatch as Unwatch,
    Watch as Watch,
)

# with models beside the kernel, by ports of their own


class Sample(Message, frozen=True):
    """The value of a signal at this time [SI]."""

    value: float


class SetPoint(Message, frozen=True):
    """Set-point of an actuator's speed, signed along its coordinate."""

    units: ClassVar[Mapping[str, str]] = {"value": SPEED}
    value: float


# from the commander


class Order(Message, frozen=True):
    """An order to an actor; `at`: the numbers of its action and of the order in it, from 0.

    For an operator's command the number of the action is -2; for a user model's set-point `at` is (-3,). An order to
    watch a threshold has (action, order, term): the term of a condition of that order's `until`, or, with order -1, of
    the action's `when`. The plan has the lines of the scene (`places`). An `EndOrder` has the id of the order that it
    ends.
    """

    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION, "by": PLACE, "to": PLACE}
    actor: str
    id: int
    at: tuple[int, ...]
    what: ActorCommand

    @property
    def led(self) -> bool:
        """Whether the order comes from a user model's set-point."""
        return self.at == (LED,)


# to the commander


class Report(Message, frozen=True):
    """A report of the actor of a mechanical element."""

    actor: str


class Done(Report, frozen=True):
    """An order is done; `position` of the actuator (0 if it has none)."""

    units: ClassVar[Mapping[str, str]] = {"position": PLACE}
    id: int
    position: float = 0.0


class Limit(Report, frozen=True):
    """The actuator stopped at an end position or limit switch: "travel limit", "drum empty", ..."""

    units: ClassVar[Mapping[str, str]] = {"position": PLACE}
    limit: str
    position: float


class RopeState(Report, frozen=True):
    """A rope or sling became taut or slack; tension [N]."""

    units: ClassVar[Mapping[str, str]] = {"tension": "N"}
    state: str
    tension: float


class Hooked(Report, frozen=True):
    """The sling is hooked to this lug."""

    lug: str


class Unhooked(Report, frozen=True):
    """The sling is off."""


class BrakeState(Report, frozen=True):
    """The brake or hinge lock is engaged or released."""

    engaged: bool


class Overload(Report, frozen=True):
    """The tension [N] exceeded its rated value (over), or is below it again."""

    units: ClassVar[Mapping[str, str]] = {"tension": "N", "rated": "N"}
    tension: float
    rated: float
    over: bool


class Tripped(Report, frozen=True):
    """An interlock tripped (over) or was reset; `bypassed`: it stops nothing."""

    over: bool
    bypassed: bool = False


class Reached(Report, frozen=True):
    """The watched threshold was reached, at this value."""

    value: float


class Attitude(Report, frozen=True):
    """The measured angle of the body [rad] passed this value, upwards (rising) or downwards."""

    units: ClassVar[Mapping[str, str]] = {"angle": "rad"}
    angle: float
    rising: bool


class Begun(Report, frozen=True):
    """The action list of this lift may begin."""


class Ended(Report, frozen=True):
    """The action list of this lift is done."""


class Lifted(Report, frozen=True):
    """The last support of the body opened."""


class Touched(Report, frozen=True):
    """The first support of the body closed."""

    support: str


class Landed(Report, frozen=True):
    """All supports of this face of the body are closed."""

    face: str


class Trip(Message, frozen=True):
    """Inside a machine: an interlock stops, or frees, the drives that it blocks."""

    interlock: str
    bars: bool


class Latch(Message, frozen=True):
    """Inside a lifting beam: a sling was hooked or unhooked."""

    sling: str
    hooked: bool


# with an operator


class OperatorCommand(Message, frozen=True):
    """A command of the operator: its text, and an Action of the plan as MessagePack; empty: end the run."""

    text: str
    action: bytes = b""


class OperatorAnswer(Message, frozen=True):
    """Answer to the command given at `t_ns`: accepted, or why not; `at`: the conflicting order of the list."""

    text: str
    t_ns: int
    refused: str = ""
    at: tuple[int, ...] = ()


# on record


class Stage(Message, frozen=True):
    """A stage of the action list begins."""

    name: str
    action: int


class Skipped(Message, frozen=True):
    """An order was not begun because its `until` held already."""

    action: int
    actor: str


class Finished(Message, frozen=True):
    """The last action is done; the run ends at this tag."""
