"""The messages between models: orders, reports, inputs to the kernel and state events from the kernel.

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
    SetSignal as SetSignal,
    StateEvent as StateEvent,
    Unhook as Unhook,
    Unwatch as Unwatch,
    Watch as Watch,
)

# with models beside the kernel, by ports of their own


class Sample(Message, frozen=True):
    """Message with the value of a signal at the present time, in SI units."""

    value: float


class SetPoint(Message, frozen=True):
    """The speed that a user model demands of an actuator, signed along the actuator's coordinate."""

    units: ClassVar[Mapping[str, str]] = {"value": SPEED}
    value: float


# from the commander


class Order(Message, frozen=True):
    """Message with an order of the commander to an actor. `at`: the number of its action and the number of the order in
    it, from 0.

    For an operator's command the number of the action is -2; for a user model's set-point `at` is (-3,). An order to
    watch a threshold has (action, order, term), where term is the index of the term in the `until` of that order or, if
    order is -1, in the `when` of the action. The plan maps these numbers to lines of the scene (`places`). An
    `EndOrder` has the id of the order that it ends.
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
    """Base class of reports from the actor of a mechanical element."""

    actor: str


class Done(Report, frozen=True):
    """Report that an order is done, with the `position` of the actuator (0 if it has none)."""

    units: ClassVar[Mapping[str, str]] = {"position": PLACE}
    id: int
    position: float = 0.0


class Limit(Report, frozen=True):
    """Report that the actuator stopped at a limit, such as "travel limit" or "drum empty"."""

    units: ClassVar[Mapping[str, str]] = {"position": PLACE}
    limit: str
    position: float


class RopeState(Report, frozen=True):
    """Report that a rope or sling has become taut or slack, with its tension [N]."""

    units: ClassVar[Mapping[str, str]] = {"tension": "N"}
    state: str
    tension: float


class Hooked(Report, frozen=True):
    """Report that a sling was hooked to the lug `lug`."""

    lug: str


class Unhooked(Report, frozen=True):
    """Report that a sling was unhooked."""


class BrakeState(Report, frozen=True):
    """Report that a brake or joint lock was engaged or released."""

    engaged: bool


class Overload(Report, frozen=True):
    """Report that the tension of a load cell [N] exceeds its rated value (`over`), or has fallen below it again."""

    units: ClassVar[Mapping[str, str]] = {"tension": "N", "rated": "N"}
    tension: float
    rated: float
    over: bool


class Tripped(Report, frozen=True):
    """Report that an interlock tripped (`over` is true) or was reset.

    An interlock that is `bypassed` reports, but stops nothing."""

    over: bool
    bypassed: bool = False


class Reached(Report, frozen=True):
    """Report that a watched threshold was reached, with the value of the threshold."""

    value: float


class Attitude(Report, frozen=True):
    """Report that the angle of a body [rad] has passed this value, upwards (`rising`) or downwards."""

    units: ClassVar[Mapping[str, str]] = {"angle": "rad"}
    angle: float
    rising: bool


class Begun(Report, frozen=True):
    """Report that an order has allowed the action list of this lift to begin."""


class Ended(Report, frozen=True):
    """Report that the action list of this lift is done."""


class Lifted(Report, frozen=True):
    """Report that a body has left the last of its supports."""


class Touched(Report, frozen=True):
    """Report that a body has touched the first of its supports."""

    support: str


class Landed(Report, frozen=True):
    """Report that all supports at one face of a body are in contact."""

    face: str


class Trip(Message, frozen=True):
    """Message inside a machine: an interlock blocks its drives (`bars`), or frees them."""

    interlock: str
    bars: bool


class Latch(Message, frozen=True):
    """Message inside a lifting beam: a sling was hooked or unhooked."""

    sling: str
    hooked: bool


# with an operator


class OperatorCommand(Message, frozen=True):
    """A command of the operator: its text, and the plan's `Action` as MessagePack; without an action, the run ends."""

    text: str
    action: bytes = b""


class OperatorAnswer(Message, frozen=True):
    """Answer to an operator's command: accepted, or the reason for the refusal.

    `t_ns`: time of the command; `at`: numbers of the order in the action list that conflicts with it."""

    text: str
    t_ns: int
    refused: str = ""
    at: tuple[int, ...] = ()


# on record


class Stage(Message, frozen=True):
    """Message that a stage of the action list begins."""

    name: str
    action: int


class Skipped(Message, frozen=True):
    """Message that an order was not begun because its `until` condition was already true."""

    action: int
    actor: str


class Finished(Message, frozen=True):
    """Message that the last action is done; the run ends at this logical time."""
