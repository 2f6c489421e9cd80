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
    """Kernel input: ramp up to the signed `speed`, cruise, and ramp down so that the displacement is `distance` (None:
    keep going)."""

    command: ClassVar[str] = "set_profile"
    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION, "distance": PLACE}
    actuator: str
    start_ns: int
    speed: float
    accel: float
    distance: float | None = None

    def part(self, piece: str, share: float) -> "SetProfile":
        """Return the input for one piece of a rope; `share`: the piece's share of the rope's length."""
        distance = None if self.distance is None else self.distance * share
        return SetProfile(piece, self.start_ns, self.speed * share, self.accel * share, distance)


class SetFollow(KernelInput, frozen=True):
    """Follow a master: the reference changes by f(s) - f(present s), with f(s) = k1 s + kc cos s + ks sin s, where s is
    the value of the master and `law` holds (k1, kc, ks). An empty `master` means hold the position."""

    command: ClassVar[str] = "set_follow"
    actuator: str
    master: str = ""
    law: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def part(self, piece: str, share: float) -> "SetFollow":
        """Return the input for one piece of a rope; `share`: the piece's share of the rope's length."""
        k1, kc, ks = self.law
        return SetFollow(piece, self.master, (k1 * share, kc * share, ks * share))


class SetSignal(KernelInput, frozen=True):
    """Kernel input: set the driven signal of a force, such as the wind speed, in the unit of the signal."""

    command: ClassVar[str] = "set_signal"
    force: str
    value: float


class SetBrake(KernelInput, frozen=True):
    """Engage or release a brake."""

    command: ClassVar[str] = "set_brake"
    brake: str
    engaged: bool


class SetLock(KernelInput, frozen=True):
    """Lock or release a joint; locking a moving joint stops it by an impulse."""

    command: ClassVar[str] = "set_lock"
    lock: str
    engaged: bool


class Hook(KernelInput, frozen=True):
    """Hook a sling to end points `a` and `b` (in the frames of their bodies) with the unstretched length `L0`; None
    keeps the present value."""

    command: ClassVar[str] = "hook"
    units: ClassVar[Mapping[str, str]] = {"L0": "m"}
    rope: str
    a: Vector | None = None
    b: Vector | None = None
    L0: float | None = None


class Unhook(KernelInput, frozen=True):
    """Unhook a sling."""

    command: ClassVar[str] = "unhook"
    rope: str


class Watch(KernelInput, frozen=True):
    """Start watching a threshold; if the threshold is exceeded already, its event occurs at the next microstep."""

    command: ClassVar[str] = "watch"
    threshold: str
    value: float
    rising: bool


class Unwatch(KernelInput, frozen=True):
    """Stop watching a threshold."""

    command: ClassVar[str] = "unwatch"
    threshold: str


class StateEvent(Message, frozen=True):
    """A discrete change in the mechanics of a rope (taut, slack), support or stop (closed, open), brake (stick, slip),
    threshold (reached) or joint (locked, with the energy lost [J], or freed)."""

    name: str
    what: str
    value: float
