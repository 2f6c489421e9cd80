"""The messages between models: orders, reports, inputs of the kernel and its state events.

    commander --Order--> model --KernelInput--> kernel --StateEvent--> model --Report--> commander
An order names one actor by its mechanical element (drive, winch rope, sling, brake, threshold, Master) and
carries an id of its own; an actor that has carried it out answers Done with that id.  Coordinates are the
actuator's own: joint coordinate of a drive, UNSTRETCHED LENGTH of a winch rope (hoisting is negative),
value of a Master.  SI units.
"""

from collections.abc import Mapping
from typing import ClassVar

from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.devs import Message

from .kernel_messages import ACCELERATION, PLACE, SPEED
from .kernel_messages import Hook as Hook
from .kernel_messages import KernelInput as KernelInput
from .kernel_messages import SetBrake as SetBrake
from .kernel_messages import SetFollow as SetFollow
from .kernel_messages import SetLock as SetLock
from .kernel_messages import SetProfile as SetProfile
from .kernel_messages import StateEvent as StateEvent
from .kernel_messages import Unhook as Unhook
from .kernel_messages import Unwatch as Unwatch
from .kernel_messages import Watch as Watch

# with models beside the kernel, by ports of their own


class Sample(Message, frozen=True):
    """The value of a signal at this time [SI]."""

    value: float


class SetPoint(Message, frozen=True):
    """The speed that an actuator shall be led to, signed along its coordinate."""

    units: ClassVar[Mapping[str, str]] = {"value": SPEED}
    value: float


# from the commander


class Order(Message, frozen=True):
    """To one actor; `at` is where it comes from: the numbers of an action and of one of its orders, from 0.

    The action of an operator's command is -2, of a set-point of a model -3.  An order to watch gives (action, order,
    term): the term of a condition of that order's `until`, or, as order -1, of the action's `when`.  The plan has the
    line (`places`).
    """

    actor: str
    id: int
    at: tuple[int, ...]


class Run(Order, frozen=True):
    """Move by a signed distance, to a coordinate, or (both None) with signed speed until Halt."""

    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION, "by": PLACE, "to": PLACE}
    speed: float
    accel: float
    by: float | None = None
    to: float | None = None


class Aim(Order, frozen=True):
    """Lead the present speed to a signed one with ramps of `accel`, and go on so; 0 stands still."""

    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION}
    speed: float
    accel: float


class RunInPulses(Run, frozen=True):
    """The same, without swing: ramps of so many pulses for these periods [s] of what swings, at the start and at the
    stop; `accel` is that of pulses whose length is not the period.
    """

    pulses: int = 0
    periods: tuple[float, float] = (0.0, 0.0)


class Halt(Order, frozen=True):
    """Ramp down the move of that id; its Done comes when it stands."""


class StopMotion(Order, frozen=True):
    """Stop whatever it does, with its emergency deceleration, or with `accel`; Done when it stands."""

    units: ClassVar[Mapping[str, str]] = {"accel": ACCELERATION}
    accel: float | None = None


class Follow(Order, frozen=True):
    """Follow `master`, whose value is `s` now, with f(s) = kc cos s + ks sin s; master "": stand still."""

    master: str
    s: float
    kc: float = 0.0
    ks: float = 0.0

    def value(self, s: float) -> float:
        """f(s)."""
        return float(self.kc * cos(s) + self.ks * sin(s))


class FollowAngle(Follow, frozen=True):
    """Follow an angle with f(s) = k1 s + kc cos s + ks sin s."""

    k1: float = 0.0

    def value(self, s: float) -> float:
        """f(s)."""
        return self.k1 * s + super().value(s)


class HookOrder(Order, frozen=True):
    """Hook the sling to the lug at `p` (frame of the block; None: where it hung before)."""

    lug: str
    p: Vector | None


class UnhookOrder(Order, frozen=True):
    """Take the sling off."""


class BrakeOrder(Order, frozen=True):
    """Engage or release the brake; an interlock: restore or bypass it."""

    engaged: bool


class WatchOrder(Order, frozen=True):
    """Report when the threshold reaches `value`, once."""

    value: float
    rising: bool


class UnwatchOrder(Order, frozen=True):
    """Stop watching the threshold."""


# to the commander


class Report(Message, frozen=True):
    """From the actor of this mechanical element."""

    actor: str


class Done(Report, frozen=True):
    """The order is carried out; the actuator stands at `position` (0 where there is none)."""

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
    """The sling hangs on this lug."""

    lug: str


class Unhooked(Report, frozen=True):
    """The sling is off."""


class BrakeState(Report, frozen=True):
    """The brake or hinge lock is engaged or released."""

    engaged: bool


class Overload(Report, frozen=True):
    """The tension [N] passed its rated value upwards (over) or is back below it."""

    units: ClassVar[Mapping[str, str]] = {"tension": "N", "rated": "N"}
    tension: float
    rated: float
    over: bool


class Tripped(Report, frozen=True):
    """An interlock has tripped (over) or is reset; `bypassed`: nothing is stopped."""

    over: bool
    bypassed: bool = False


class Reached(Report, frozen=True):
    """The threshold that was watched is reached at this value."""

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
    """Inside a machine: an interlock bars what it stops, or frees it."""

    interlock: str
    bars: bool


class Latch(Message, frozen=True):
    """Inside a lifting beam: a sling was hooked or taken off."""

    sling: str
    hooked: bool


# with an operator


class OperatorCommand(Message, frozen=True):
    """An operator's command during a run, and its orders: an Action of the plan as MessagePack; none: the run ends."""

    text: str
    action: bytes = b""


class OperatorAnswer(Message, frozen=True):
    """To the command of `t_ns`: its orders are given, or why not; `at`: the conflicting order of the action list."""

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
    """An order of this action to this actor was not begun: what it would go on until held already."""

    action: int
    actor: str


class Finished(Message, frozen=True):
    """The last action is done; the run ends at this tag."""
