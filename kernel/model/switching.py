"""Discrete states of force laws, and their changes when a guard becomes negative or by command.

Coordinates and velocities do not change. Elastic energy that a law still stores when it releases (a rope that slackens
under damping, a sling unhooked, a pad that opens) counts as heat of that law; the simulation adds it to the energy
accounts.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.forces import Reeving, RopeForce
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import ForceLaw
from heavylift.kernel.forces.joint_laws import BrakeAt
from heavylift.kernel.forces.mooring import LineAt
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.kernel.forces.ropes import RopeAt

from .program import Program

ROPES = ("rope", "rigid", ReevingLaw.kind)  # kinds of numbers that ropes have


@dataclass(frozen=True)
class StateChange:
    """A change of the discrete state of a force law or lock, such as a rope that becomes taut."""

    name: str
    what: str  # taut, slack, closed, open, stick, slip, bent, reached; of a lock locked, freed
    value: float  # its meaning depends on the law


class Switches:
    """Reads and writes the discrete states of laws in the parameter block P; `row` is the present sample row (see
    `sample_row`).

    `admit(command)` is called before a command takes effect.
    """

    def __init__(self, program: Program, P: np.ndarray) -> None:
        self._program, self._P, self._at = program, P, program.parameters.at
        s = program.system
        self._ropes = [r.name for r in s.ropes]
        self._brakes = {b.name: program.graph.coordinate(b.name, b.joint, b.coordinate) for b in s.brakes}
        self._thresholds = {h.name: h for h in s.thresholds}
        self.watched: dict[str, float] = {}
        self.admit: Callable[[str], None] = lambda command: None

    def fire(self, guard: int, row: SimpleNamespace) -> StateChange:
        """Switch the law whose guard has become negative, and return the change of state."""
        what, name = label = self._program.guards[guard]
        if what == "threshold":
            self._disarm(name)
            return StateChange(name, "reached", self.watched[name])
        law = self._program.of_guard[label]
        shown = self._program.shown(law, row)
        return StateChange(name, *law.law.switch(law.force, self._P[self._at[law.law.kind, name]], what, shown))

    def watch(self, name: str, value: float, rising: bool) -> None:
        """Arm a threshold: an event when its signal crosses `value`; raises KernelError for an unknown threshold."""
        p = self._threshold_numbers(name)
        if not isfinite(value):
            raise KernelError(f"threshold '{name}': {value} is not a valid threshold; it must be a finite number")
        self.admit("watch")
        sign = -1.0 if rising else 1.0
        p[:2] = [sign, -sign * value]
        self.watched[name] = value

    def unwatch(self, name: str) -> None:
        self._threshold_numbers(name)
        self.admit("unwatch")
        self._disarm(name)

    def _disarm(self, name: str) -> None:
        self._threshold_numbers(name)[:2] = [0.0, 1.0]

    def _threshold_numbers(self, name: str) -> np.ndarray:
        if name not in self._thresholds:
            raise KernelError(
                f"'{name}': there is no threshold with this name; there are {', '.join(self._thresholds) or 'none'}"
            )
        return self._P[self._at["threshold", name]]

    def set_brake(self, name: str, engaged: bool, row: SimpleNamespace) -> None:
        """Close a brake at the joint's present position, or release it; a closed brake keeps its position."""
        if name not in self._brakes:
            raise KernelError(
                f"'{name}': there is no brake with this name; there are {', '.join(self._brakes) or 'none'}"
            )
        self.admit("set_brake")
        p = self._P[self._at["brake", name]]
        if bool(p[BrakeAt.ENGAGED]) != engaged:
            p[BrakeAt.ENGAGED :] = [float(engaged), 1.0, row.q[self._brakes[name][0]], 0.0]

    def rope_numbers(self, name: str) -> np.ndarray:
        """Return the present parameters of an elastic rope (see `RopeAt`); raises KernelError for an unknown name."""
        if name not in self._ropes:
            raise KernelError(
                f"'{name}': there is no rope with this name; there are {', '.join(self._ropes) or 'none'}"
            )
        return self._P[self._at["rope", name]]

    def rigid_numbers(self, name: str) -> np.ndarray | None:
        """Return the present parameters of a rigid rope (see `RigidAt`); None for any other rope."""
        return self._P[self._at["rigid", name]] if ("rigid", name) in self._at else None

    def reeving(self, name: str) -> Reeving | None:
        """Return the rope over sheaves of this name; None if the rope is of another kind."""
        return next((r for r in self._program.system.reevings if r.name == name), None)

    def reeving_numbers(self, name: str) -> np.ndarray:
        """Return the present parameters of a rope over sheaves (see `ReevingAt`)."""
        return self._P[self._at[ReevingLaw.kind, name]]

    def unhook(self, name: str) -> None:
        """Unhook a rope of any kind, without accounting for its energy."""
        if (reeving := self.reeving(name)) is not None:
            ReevingLaw().take_off(reeving, self.reeving_numbers(name))
            return
        system = self._program.system
        lines: tuple[RopeForce, ...] = (*system.mooring_lines, *system.tugger_lines)
        if any(x.name == name for x in lines):
            self._P[self._at[ForceLaw.kind, name]][LineAt.HOOKED] = 0.0
            return
        rigid = self.rigid_numbers(name)
        if rigid is not None:
            rigid[RigidAt.HOOKED] = rigid[RigidAt.TAUT] = 0.0
            return
        p = self.rope_numbers(name)
        p[RopeAt.HOOKED] = p[RopeAt.TAUT] = 0.0
