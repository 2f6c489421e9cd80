"""Messages between models and the kernel: inputs that change a force law, a lock, a hooked rope or a threshold, and
state events."""

from collections.abc import Mapping
from typing import Any, ClassVar

import msgspec
from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.devs import Message

PLACE, SPEED, ACCELERATION = "m or rad", "m/s or rad/s", "m/s2 or rad/s2"  # along an actuator's coordinate


class KernelInput(Message, frozen=True):
    """An input that changes the mechanics by calling the method `command` of a `Simulation`."""

    command: ClassVar[str]

    def apply(self, simulation: Any) -> None:
        """Apply the input to a `Simulation`; raises KernelError if the input is impossible."""
        getattr(simulation, self.command)(*msgspec.structs.astuple(self))


class SetProfile(KernelInput, frozen=True):
    """Kernel input: ramp an actuator up to the signed `speed`, cruise, and ramp down after the displacement `distance`.
    If `distance` is None, the actuator keeps going."""

    command: ClassVar[str] = "set_profile"
    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION, "distance": PLACE}
    actuator: str
    start_ns: int
    speed: float
    accel: float
    distance: float | None = None

    def part(self, piece: str, share: float) -> "SetProfile":
        """Return the kernel input for one piece of a rope that is modelled in pieces.

        `share`: the piece's share of the rope's length."""
        distance = None if self.distance is None else self.distance * share
        return SetProfile(piece, self.start_ns, self.speed * share, self.accel * share, distance)


class SetFollow(KernelInput, frozen=True):
    """Kernel input: make an actuator follow a master; an empty `master` means hold the position.

    The reference changes by f(s) - f(present s), with f(s) = k1 s + kc cos s + ks sin s, where s is the value of the
    master and `law` holds (k1, kc, ks)."""

    command: ClassVar[str] = "set_follow"
    actuator: str
    master: str = ""
    law: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def part(self, piece: str, share: float) -> "SetFollow":
        """Return the kernel input for one piece of a rope that is modelled in pieces.

        `share`: the piece's share of the rope's length."""
        k1, kc, ks = self.law
        return SetFollow(piece, self.master, (k1 * share, kc * share, ks * share))


class SetSignal(KernelInput, frozen=True):
    """Kernel input: set the driven signal of a force, such as the wind speed, in the unit of the signal."""

    command: ClassVar[str] = "set_signal"
    force: str
    value: float


class SetBrake(KernelInput, frozen=True):
    """Kernel input: engage or release a brake."""

    command: ClassVar[str] = "set_brake"
    brake: str
    engaged: bool


class SetLock(KernelInput, frozen=True):
    """Kernel input: lock or release a joint; locking a moving joint stops it by an impulse."""

    command: ClassVar[str] = "set_lock"
    lock: str
    engaged: bool


class Hook(KernelInput, frozen=True):
    """Kernel input: hook a sling to two end points.

    `a` and `b` are in the frames of their bodies, `L0` is the unstretched length; None keeps the present value."""

    command: ClassVar[str] = "hook"
    units: ClassVar[Mapping[str, str]] = {"L0": "m"}
    rope: str
    a: Vector | None = None
    b: Vector | None = None
    L0: float | None = None


class Unhook(KernelInput, frozen=True):
    """Kernel input: unhook a sling."""

    command: ClassVar[str] = "unhook"
    rope: str


class Watch(KernelInput, frozen=True):
    """Kernel input: start watching a threshold; if it is exceeded already, its event occurs at the next microstep."""

    command: ClassVar[str] = "watch"
    threshold: str
    value: float
    rising: bool


class Unwatch(KernelInput, frozen=True):
    """Kernel input: stop watching a threshold."""

    command: ClassVar[str] = "unwatch"
    threshold: str


class StateEvent(Message, frozen=True):
    """A discrete change in the mechanics, such as a rope that becomes taut or a brake that slips.

    It concerns a rope (taut, slack), support or stop (closed, open), brake (stick, slip), threshold (reached) or joint
    (locked, with the energy lost [J], or freed)."""

    name: str
    what: str
    value: float
