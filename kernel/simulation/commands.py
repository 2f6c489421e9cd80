"""Commands to a simulation that has stopped at an instant, and their effect on the force laws.

They are given after `interrupt` or `fire` and before `settle` (see `simulation`), at the time of the epoch. Energy that
a law loses by a command becomes its heat, so that the balance stays closed.

The receiver is a simulation, or islands, which pass each command on to the island concerned.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import fsum, isfinite
from types import SimpleNamespace
from typing import Protocol

import numpy as np
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.forces import Reeving
from heavylift.kernel.description.mechanics import Line, Point, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingAt, ReevingLaw
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.forces.table import steered
from heavylift.kernel.model.instant import poses_of
from heavylift.kernel.model.parameters import PROFILE
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.references import References
from heavylift.kernel.model.switching import StateChange, Switches
from heavylift.kernel.multibody.joint_locking import lock_of
from heavylift.kernel.simulation.native.native_state import NativeState
from msgspec import structs

from .call_protocol import CallProtocol
from .events import Events
from .held_rows import HeldRows
from .native.native_functions import Stepping


class CommandSwitches:
    """Executes commands on the force laws of a run, as `CommandTarget` specifies them."""

    def __init__(
        self,
        native: NativeState,
        order: CallProtocol,
        references: References,
        switches: Switches,
        held: HeldRows,
        events: Events,
    ) -> None:
        self._native, self._order, self._held, self._events = native, order, held, events
        self.references, self.switches = references, switches
        references.admit = switches.admit = self.admit

    def admit(self, what: str) -> None:
        """Register a command to the simulation, after which `settle` checks the guards again.

        Raises KernelError if commands are not allowed now (see `call_protocol`).
        """
        self._order.command(what, self._native.epoch)
        self._events.forget()

    def set_follow(self, actuator: str, master: str, f: tuple[float, float, float]) -> None:
        """Make an actuator follow k1 s + kc cos s + ks sin s from now on; s: value of a master signal ("": none)."""
        self._standing("set_follow")
        self.references.set_follow(actuator, self._native.epoch, master, f, self.masters_now())

    def set_brake(self, brake: str, engaged: bool) -> None:
        """Close a brake at the present position of its joint, or release it."""
        self._standing("set_brake")
        row = self._native.row()
        self.switches.set_brake(brake, engaged, row)
        self._events.heat(row)

    def _standing(self, what: str) -> None:
        self._order.check_standing(what, self._native.epoch)

    def set_lock(self, lock: str, engaged: bool) -> StateChange | None:
        """Lock a joint in its position or release it; return the event with the energy lost [J], or None if nothing
        changed.

        An impulse stops a moving joint; a released joint continues without a jump.
        """
        self._standing("set_lock")
        lock_of(self._native.program.system, lock)
        if engaged == (lock in self._native.program.locked):
            return None
        native, before, at_lock = self._native, self._native.row(), self._native.account("heat", lock)
        heat = native.state[at_lock]
        if engaged and len(native.program.constraints) and (moving := _moving_drive(native.program, before.v)):
            raise KernelError(
                f"lock '{lock}' at {native.epoch * 1e-9:.3f} s: drive '{moving}' is moving; stop "
                "it before locking a joint of a scene with closed loops"
            )
        self.admit("set_lock")
        native.use(native.program.locked ^ {lock})
        if engaged:
            native.call("halt")
            if len(native.program.constraints):
                changed = self._held.resolve([], native.epoch)
                self._events.log += [(native.epoch, e) for e in changed]
                native.state[at_lock] += self._kept(before) - self._kept(native.row())  # what the loops' impulses took
        event = StateChange(lock, "locked" if engaged else "freed", float(native.state[at_lock] - heat))
        self._events.log.append((native.epoch, event))
        return event

    def _kept(self, row: SimpleNamespace) -> float:
        """Return kinetic energy plus heat minus work, which impulses do not change."""
        signs = [1.0 if what == "heat" else -1.0 for what, _ in self._native.program.accounts]
        return fsum([float(row.kinetic), *(s * float(x) for s, x in zip(signs, row.accounts, strict=True))])

    def unhook(self, rope: str) -> None:
        """Unhook a rope; its elastic energy becomes heat."""
        self._standing("unhook")
        row = self._native.row()
        self.switches.unhook(rope)
        self.admit("unhook")
        self._events.heat(row)

    def set_signal(self, name: str, value: float) -> None:
        """Set the driven signal of a force to a value; raises KernelError for a signal that only profiles change."""
        self._standing("set_signal")
        if name not in steered(self._native.program.system):
            raise KernelError(f"'{name}' is not a force signal that can be set at once; use set_profile()")
        if not isfinite(value):
            raise KernelError(f"'{name}': {value!r} is not a valid value of a signal; give a finite number")
        self.references.set_value(name, self._native.epoch, value)

    def hook(self, rope: str, a: Vector | None = None, b: Vector | None = None, L0: float | None = None) -> None:
        """Hook a slack rope, at new points (in the bodies' frames) of the same bodies if given.

        Raises KernelError if the rope is too short, or for a new station on a flexible body.
        """
        self._standing("hook")
        a, b = self._ends(rope, a, b)
        if (reeving := self.switches.reeving(rope)) is not None:
            self._hook_over(reeving, a, b, L0)
            return
        native, P, where = self._native, self._native.P, self._where(rope)
        at = native.program.parameters.at
        rigid = self.switches.rigid_numbers(rope)
        p, places = (self.switches.rope_numbers(rope), RopeAt) if rigid is None else (rigid, RigidAt)
        if p[places.HOOKED] > 0.0:
            raise KernelError(f"{where}: it is already hooked; unhook it first")
        if L0 is not None and not 0.0 < L0 < np.inf:
            raise KernelError(f"{where}: length {L0:g} m; it must be positive")
        before = P.copy()
        for end, place in ((a, places.A), (b, places.B)):
            if end is not None:
                p[place] = end
        if L0 is not None:
            P[at["reference", rope]], P[at["follow", rope]] = [0.0, L0] + [0.0] * (PROFILE - 2), 0.0
        gap = self._too_short(rope)
        if not gap <= 0.0:
            P[:] = before
            raise KernelError(f"{where}: it is {gap * 1e3:.0f} mm too short to be hooked there; bring the hook closer")
        self.admit("hook")
        if L0 is not None:
            self.references.set_value(rope, native.epoch, L0)
        p[places.HOOKED], p[places.TAUT] = 1.0, 0.0
        if rope in native.calm:
            p[RopeAt.DAMPING] = native.program.parameters.initial[at["rope", rope]][RopeAt.DAMPING]
            native.calm -= {rope}
            native.use(native.program.locked)

    def _hook_over(self, rope: Reeving, a: Vector | None, b: Vector | None, L0: float | None) -> None:
        """Hook a rope over sheaves or edges, with the contacts that it has at this time."""
        native, where, p = self._native, self._where(rope.name), self.switches.reeving_numbers(rope.name)
        if p[ReevingAt.TAUT] >= 0.0:
            raise KernelError(f"{where}: it is already hooked; unhook it first")
        if L0 is not None:
            raise KernelError(f"{where}: length {L0:g} m; the length of a rope over sheaves cannot be changed")
        moved = {k: Point(getattr(rope, k).body, p) for k, p in (("a", a), ("b", b)) if p is not None}
        rope = structs.replace(rope, **moved)
        long = self.references.value(rope.name, native.epoch) if rope.winch else rope.L0
        before = p.copy()
        gap = ReevingLaw().put_on(rope, p, long, poses_of(native.program, native.row()))
        if not gap <= 0.0:
            p[:] = before
            raise KernelError(f"{where}: it is {gap * 1e3:.0f} mm too short to be hooked there; bring the hook closer")
        self.admit("hook")
        angles, row = native.program.angles, native.row()
        counted = native.state[len(native.state) - len(angles) :]
        for i, label in enumerate(angles):
            if label[:2] == ("force", rope.name):
                counted[i] = row.turned[i]  # what it turned while it was off is no turn

    def _ends(self, rope: str, a: Vector | None, b: Vector | None) -> list[Vector | None]:
        """Return new ends a and b of a rope's first line as stored in P: on a flexible body relative to the station."""
        system, graph = self._native.program.system, self._native.program.graph
        lines = {r.name: r.lines[0] for r in system.straight_ropes}
        lines |= {r.name: Line(r.a, r.b) for r in system.reevings}
        if rope not in lines:
            return [a, b]
        line, where = lines[rope], self._where(rope)
        for end in (a, b):
            if end is not None and not _is_place(end):
                raise KernelError(f"{where}: end {end}; it must be 3 finite numbers")
        return [None if p is None else graph.in_frame(where, x.body, p) for x, p in ((line.a, a), (line.b, b))]

    def _where(self, rope: str) -> str:
        return f"rope '{rope}' at {self._native.epoch * 1e-9:.3f} s"

    def _too_short(self, rope: str) -> float:
        """Return by how much a rope is shorter than the distance of its ends [m]."""
        row, system = self._native.row(), self._native.program.system
        elastic, rigid = ([r.name for r in ropes] for ropes in (system.ropes, system.rigid_ropes))
        return float(row.elongation[elastic.index(rope)] if rope in elastic else -row.slack[rigid.index(rope)])

    def masters_now(self) -> list[float]:
        """Return the present values of all master signals, commanded and measured, that actuators can follow."""
        native, program = self._native, self._native.program
        values = [self.references.own(m.name, native.epoch)[0] for m in program.system.masters]
        row = native.row()
        for m in program.system.measured:
            if m.kind == "joint":
                values.append(float(row.q[program.graph.coordinate(m.name, m.of, m.coordinate)[0]]))
            else:
                values.append(float(row.turned[program.angles.index(("body", m.of, m.axis))]))
        return values


def _is_place(p: object) -> bool:
    """Whether p consists of three finite numbers."""
    return (
        isinstance(p, tuple | list | np.ndarray)
        and len(p) == 3
        and all(isinstance(x, float | int | np.number) and np.isfinite(x) for x in p)
    )


def _moving_drive(program: Program, v: np.ndarray) -> str:
    """Return the first prescribed drive that moves, "" if there is none."""
    drives = (d for d in program.system.drives if d.kind == "prescribed")
    return next((d.name for d in drives if v[program.driven(d)[1]] != 0.0), "")


class LiftRowsView(Protocol):
    """Interface of the sample rows recorded after the events of one lift, with times [ns] and layout (`method`)."""

    name: str
    method: Stepping
    rows: list[tuple[int, np.ndarray]]


class CommandTarget(ABC):
    """Interface of a simulation that receives commands.

    Each command raises KernelError for an unknown name and when called out of order.
    """

    @property
    def alone(self) -> Sequence[LiftRowsView]:
        """Sample rows recorded at the events of each single lift; empty if the scene has only one lift."""
        return ()

    @abstractmethod
    def _addressed(self, what: str, kind: str, name: str) -> CommandSwitches:
        """Return the command receiver of the simulation that contains the law of this name."""

    def set_profile(self, name: str, start_ns: int, speed: float, accel: float, distance: float | None) -> None:
        """Start a trapezoid speed profile of an actuator from its present value and speed (see `References`)."""
        commands = self._addressed("set_profile", "reference", name)
        commands.references.set_profile(name, start_ns, speed, accel, distance)

    def set_signal(self, name: str, value: float) -> None:
        """Set the driven signal of a force to a constant value at once."""
        self._addressed("set_signal", "reference", name).set_signal(name, value)

    def set_follow(self, actuator: str, master: str, f: tuple[float, float, float]) -> None:
        """Make an actuator follow k1 s + kc cos s + ks sin s from now on; s: value of a master signal ("": none)."""
        self._addressed("set_follow", "reference", actuator).set_follow(actuator, master, f)

    def set_brake(self, brake: str, engaged: bool) -> None:
        """Close a brake at the present position of its joint, or release it."""
        self._addressed("set_brake", "brake", brake).set_brake(brake, engaged)

    def set_lock(self, lock: str, engaged: bool) -> StateChange | None:
        """Lock a joint in its position or release it; return the event with the energy lost [J], or None if nothing
        changed.

        An impulse stops a moving joint; a released joint continues without a jump.
        """
        return self._addressed("set_lock", "lock", lock).set_lock(lock, engaged)

    def hook(self, rope: str, a: Vector | None = None, b: Vector | None = None, L0: float | None = None) -> None:
        """Hook a slack rope, at new points (in the bodies' frames) of the same bodies and with a new length if given.

        Raises KernelError if the rope is too short, or for a new station on a flexible body.
        """
        self._addressed("hook", "rope", rope).hook(rope, a, b, L0)

    def unhook(self, rope: str) -> None:
        """Unhook a rope; its elastic energy becomes heat."""
        self._addressed("unhook", "rope", rope).unhook(rope)

    def watch(self, threshold: str, value: float, rising: bool) -> None:
        """Report from now on when the signal of a threshold crosses `value`."""
        self._addressed("watch", "threshold", threshold).switches.watch(threshold, value, rising)

    def unwatch(self, threshold: str) -> None:
        """Stop reporting a threshold."""
        self._addressed("unwatch", "threshold", threshold).switches.unwatch(threshold)
