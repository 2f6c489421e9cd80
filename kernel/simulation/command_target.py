"""What may be told to a run, by whom it is told: a simulation, or islands that pass it on to the one that it is for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from heavylift.kernel.description.mechanics import Vector
from heavylift.kernel.model.switching import StateChange

from .commands import CommandSwitches
from .native.native_functions import Stepping


class OwnRows(Protocol):
    """Times [ns] and rows of one of several lifts, which `method` shows: what events have changed in it alone."""

    name: str
    method: Stepping
    rows: list[tuple[int, np.ndarray]]


class CommandTarget(ABC):
    """Whoever takes commands; each raises KernelError for a name that nobody bears, and out of turn."""

    @property
    def alone(self) -> Sequence[OwnRows]:
        """Lifts whose events leave rows of their own; without any all rows are of all."""
        return ()

    @abstractmethod
    def _addressed(self, what: str, kind: str, name: str) -> CommandSwitches:
        """Those of the simulation that has a law, ready for a command."""

    def set_profile(self, name: str, start_ns: int, speed: float, accel: float, distance: float | None) -> None:
        """Lead an actuator by a trapezoid from its present value and speed (see `References.set_profile`)."""
        commands = self._addressed("set_profile", "reference", name)
        commands.references.set_profile(name, start_ns, speed, accel, distance)

    def set_follow(self, actuator: str, master: str, f: tuple[float, float, float]) -> None:
        """Let an actuator follow k1 s + kc cos s + ks sin s of a master from here on; "" releases it."""
        self._addressed("set_follow", "reference", actuator).set_follow(actuator, master, f)

    def set_brake(self, brake: str, engaged: bool) -> None:
        """Close a brake where its joint stands, or open it."""
        self._addressed("set_brake", "brake", brake).set_brake(brake, engaged)

    def set_lock(self, lock: str, engaged: bool) -> StateChange | None:
        """Lock a joint where it stands, or free it; the event tells the energy that stopping it has taken [J].

        In a joint that moves, a lock stops it by an impulse; freed, it goes on without a jump.  None: nothing changed.
        """
        return self._addressed("set_lock", "lock", lock).set_lock(lock, engaged)

    def hook(self, rope: str, a: Vector | None = None, b: Vector | None = None, L0: float | None = None) -> None:
        """Hook a slack rope, at new points (in the frames) of the same bodies and with a new length if given.

        Raises KernelError if it is too short, or for a new station on a flexible body.
        """
        self._addressed("hook", "rope", rope).hook(rope, a, b, L0)

    def unhook(self, rope: str) -> None:
        """Take a rope off; the energy that it held is lost."""
        self._addressed("unhook", "rope", rope).unhook(rope)

    def watch(self, threshold: str, value: float, rising: bool) -> None:
        """Report when a threshold's scalar crosses a value."""
        self._addressed("watch", "threshold", threshold).switches.watch(threshold, value, rising)

    def unwatch(self, threshold: str) -> None:
        """Stop reporting it."""
        self._addressed("unwatch", "threshold", threshold).switches.unwatch(threshold)
