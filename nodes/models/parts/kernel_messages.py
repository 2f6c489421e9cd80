"""What passes between models and the kernel: inputs, that change a law, a mask or a guard, and its state events."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import msgspec
from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.devs import Message

PLACE, SPEED, ACCELERATION = "m or rad", "m/s or rad/s", "m/s2 or rad/s2"  # along an actuator's coordinate


class KernelInput(Message, frozen=True):
    """Anything that changes a law, a mask or a guard of the kernel, by a `command` of a `Simulation`."""

    command: ClassVar[str]

    def apply(self, simulation: Any) -> None:
        """Apply to the commands of a `Simulation`; raises KernelError if it is impossible."""
        getattr(simulation, self.command)(*msgspec.structs.astuple(self))


class SetProfile(KernelInput, frozen=True):
    """Ramp to signed `speed`, cruise, and ramp down for a displacement of `distance` (None: continue)."""

    command: ClassVar[str] = "set_profile"
    units: ClassVar[Mapping[str, str]] = {"speed": SPEED, "accel": ACCELERATION, "distance": PLACE}
    actuator: str
    start_ns: int
    speed: float
    accel: float
    distance: float | None = None

    def part(self, piece: str, share: float) -> SetProfile:
        """The share of a piece of a rope."""
        distance = None if self.distance is None else self.distance * share
        return SetProfile(piece, self.start_ns, self.speed * share, self.accel * share, distance)


class SetFollow(KernelInput, frozen=True):
    """ref = ref now + f(s) - f(s now), f(s) = k1 s + kc cos s + ks sin s of `law`; master "": hold your place."""

    command: ClassVar[str] = "set_follow"
    actuator: str
    master: str = ""
    law: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def part(self, piece: str, share: float) -> SetFollow:
        """The share of a piece of a rope."""
        k1, kc, ks = self.law
        return SetFollow(piece, self.master, (k1 * share, kc * share, ks * share))


class SetBrake(KernelInput, frozen=True):
    """Engage or release a brake."""

    command: ClassVar[str] = "set_brake"
    brake: str
    engaged: bool


class SetLock(KernelInput, frozen=True):
    """Lock or free a joint; one that moves is stopped by an impulse."""

    command: ClassVar[str] = "set_lock"
    lock: str
    engaged: bool


class Hook(KernelInput, frozen=True):
    """Hook a sling; None keeps an end point (in its body's frame) or the unstretched length."""

    command: ClassVar[str] = "hook"
    units: ClassVar[Mapping[str, str]] = {"L0": "m"}
    rope: str
    a: Vector | None = None
    b: Vector | None = None
    L0: float | None = None


class Unhook(KernelInput, frozen=True):
    """Take a sling off."""

    command: ClassVar[str] = "unhook"
    rope: str


class Watch(KernelInput, frozen=True):
    """Arm a threshold; if it is already exceeded it fires at the next microstep."""

    command: ClassVar[str] = "watch"
    threshold: str
    value: float
    rising: bool


class Unwatch(KernelInput, frozen=True):
    """Disarm a threshold."""

    command: ClassVar[str] = "unwatch"
    threshold: str


class StateEvent(Message, frozen=True):
    """State of a rope (taut, slack), support or stop (closed, open), brake (sticks, slips), threshold, or joint (locked
    with lost energy [J], freed)."""

    name: str
    what: str
    value: float
