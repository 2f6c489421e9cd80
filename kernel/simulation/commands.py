"""Commands: what may be told to a simulation that stands between two stretches, and what that does to the laws.

They are given after `interrupt` or `fire` and before `settle` (see `simulation`), at the time of the epoch.  Energy
that a law gives up by a command becomes its heat, so that the balance stays closed.
"""

from __future__ import annotations

from math import fsum
from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.description.mechanics import Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.model.parameters import PROFILE
from heavylift.kernel.model.switching import StateEvent, Switches
from heavylift.kernel.multibody.joint_locking import lock_of
from heavylift.kernel.simulation.impacts.active_sets import Act, ContactSets
from heavylift.kernel.simulation.impacts.halting import moving_drive

from .call_order import CallOrder
from .stepper import Stepper

__all__ = ["Commanded"]


class Commanded(Stepper):
    """A stepper whose laws can be switched, hooked, locked and led; `log`: what happened, and when [ns].

    Arguments as those of `Stepper`.
    """

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.order = CallOrder()
        self.switches = Switches(self.program, self.P)
        self.references.admit = self.switches.admit = self._admit
        self._contacts = ContactSets(self.program, self.P)
        self.log: list[tuple[int, StateEvent]] = []

    def _resolve_rows(self, fallen: list[int], t_ns: int) -> list[StateEvent]:
        """The next set of rigid ropes and contacts, all together."""
        if not self.program.contacts.sites:
            return self._resolve()
        act = Act(self._survey, lambda: self.row().slack, self._kick, self._onto_rows)
        after = self._contacts.resolve(fallen, t_ns * 1e-9, self["t"], self.state, act)
        self._onto_rows()
        first = self.program.nq + self.program.nv
        for account, energy in after.accounts.items():
            if account in self.program.accounts:
                self.state[first + self.program.accounts.index(account)] += energy
        return after.events

    def _onto_rows(self) -> None:
        """Places and speeds that the rows allow."""
        self.X[self._at["y"]] = self._close(self.state.copy())[0]
        self.X[self._at["gap"]] = 0.0

    def _admit(self, what: str) -> None:
        """A command is given; raises KernelError where the simulation does not stand (see `call_order`)."""
        self.order.command(what, self.epoch)

    def set_profile(self, name: str, start_ns: int, speed: float, accel: float, distance: float | None) -> None:
        """Lead an actuator by a trapezoid from its present value and speed (see `References.set_profile`)."""
        self.references.set_profile(name, start_ns, speed, accel, distance)

    def watch(self, threshold: str, value: float, rising: bool) -> None:
        """Report when a threshold's scalar crosses a value."""
        self.switches.watch(threshold, value, rising)

    def unwatch(self, threshold: str) -> None:
        """Report it no more."""
        self.switches.unwatch(threshold)

    def set_follow(self, actuator: str, master: str, f: tuple[float, float, float]) -> None:
        """Let an actuator follow k1 s + kc cos s + ks sin s of a master from here on; "" releases it."""
        self.order.check_standing("set_follow", self.epoch)
        self.references.set_follow(actuator, self.epoch, master, f, self.masters_now())

    def set_brake(self, brake: str, engaged: bool) -> None:
        """Close a brake where its joint stands, or open it."""
        self.order.check_standing("set_brake", self.epoch)
        row = self.row()
        self.switches.set_brake(brake, engaged, row)
        self._heat(row)

    def set_lock(self, lock: str, engaged: bool) -> StateEvent | None:
        """Lock a joint where it stands, or free it; the event tells the energy that stopping it has taken [J].

        In a joint that moves, a lock stops it by an impulse; freed, it goes on without a jump.  None: nothing changed.
        """
        self.order.check_standing("set_lock", self.epoch)
        lock_of(self.program.system, lock)
        if engaged == (lock in self.program.locked):
            return None
        before, at_lock = self.row(), self.program.nq + self.program.nv + self.program.accounts.index(("heat", lock))
        heat = self.state[at_lock]
        if engaged and len(self.program.constraints) and (moving := moving_drive(self.program, before.v)):
            raise KernelError(
                f"lock '{lock}' at {self.epoch * 1e-9:.3f} s: drive '{moving}' moves; stop it before a joint of a "
                "scene with closed loops is locked"
            )
        self._admit("set_lock")
        self._use(self.program.locked ^ {lock})
        if engaged:
            self._call("halt")
            if len(self.program.constraints):
                changed = self._resolve_rows([], self.epoch)
                self.log += [(self.epoch, e) for e in changed]
                self.state[at_lock] += self._kept(before) - self._kept(self.row())  # what the loops' impulses took
        event = StateEvent(lock, "locked" if engaged else "freed", float(self.state[at_lock] - heat))
        self.log.append((self.epoch, event))
        return event

    def _kept(self, row: SimpleNamespace) -> float:
        """Kinetic energy with what went into heat and without what came from work: no impulse changes it."""
        signs = [1.0 if what == "heat" else -1.0 for what, _ in self.program.accounts]
        return fsum([float(row.kinetic), *(s * float(x) for s, x in zip(signs, row.accounts, strict=True))])

    def unhook(self, rope: str) -> None:
        """Take a rope off; the energy that it held is lost."""
        self.order.check_standing("unhook", self.epoch)
        row = self.row()
        self.switches.unhook(rope)
        self._admit("unhook")
        self._heat(row)

    def hook(self, rope: str, a: Vector | None = None, b: Vector | None = None, L0: float | None = None) -> None:
        """Hook a slack rope, at new points (in the frames) of the same bodies if given.

        Raises KernelError if it is too short, or for a new station on a flexible body.
        """
        self.order.check_standing("hook", self.epoch)
        a, b = self._ends(rope, a, b)
        where, at = f"rope '{rope}' at {self.epoch * 1e-9:.3f} s", self.program.parameters.at
        rigid = self.switches.rigid_numbers(rope)
        p, places = (self.switches.rope_numbers(rope), RopeAt) if rigid is None else (rigid, RigidAt)
        if p[places.HOOKED] > 0.0:
            raise KernelError(f"{where}: it is hooked already; unhook it first")
        if L0 is not None and not 0.0 < L0 < np.inf:
            raise KernelError(f"{where}: length {L0:g} m; it must be positive")
        before = self.P.copy()
        for end, place in ((a, places.A), (b, places.B)):
            if end is not None:
                p[place] = end
        if L0 is not None:
            self.P[at["reference", rope]], self.P[at["follow", rope]] = [0.0, L0] + [0.0] * (PROFILE - 2), 0.0
        gap = self._too_short(rope)
        if not gap <= 0.0:
            self.P[:] = before
            raise KernelError(f"{where}: {gap * 1e3:.0f} mm too short to be hooked there; bring the hook closer")
        self._admit("hook")
        if L0 is not None:
            self.references.set_value(rope, self.epoch, L0)
        p[places.HOOKED], p[places.TAUT] = 1.0, 0.0
        if rope in self._calm:
            p[RopeAt.DAMPING] = self.program.parameters.initial[at["rope", rope]][RopeAt.DAMPING]
            self._calm -= {rope}
            self._use(self.program.locked)

    def _ends(self, rope: str, a: Vector | None, b: Vector | None) -> list[Vector | None]:
        """New ends of a rope's first line where the rope's numbers want them: on a flexible body from their station."""
        system, graph = self.program.system, self.program.graph
        lines = {r.name: r.lines[0] for r in system.ropes} | {r.name: r.lines[0] for r in system.rigid_ropes}
        if rope not in lines:
            return [a, b]
        line, where = lines[rope], f"rope '{rope}' at {self.epoch * 1e-9:.3f} s"
        for end in (a, b):
            if end is not None and not _is_place(end):
                raise KernelError(f"{where}: end {end}; it must be 3 finite numbers")
        return [None if p is None else graph.in_frame(where, x.body, p) for x, p in ((line.a, a), (line.b, b))]

    def _too_short(self, rope: str) -> float:
        """By how much a rope is shorter than the way between its ends [m]."""
        row, system = self.row(), self.program.system
        elastic, rigid = ([r.name for r in ropes] for ropes in (system.ropes, system.rigid_ropes))
        return float(row.elongation[elastic.index(rope)] if rope in elastic else -row.slack[rigid.index(rope)])

    def masters_now(self) -> list[float]:
        """Values of masters and measured scalars at the epoch."""
        s = self.program.system
        values = [self.references.own(m.name, self.epoch)[0] for m in s.masters]
        row = self.row()
        for m in s.measured:
            if m.kind == "joint":
                values.append(float(row.q[self.program.graph.coordinate(m.name, m.of, m.coordinate)[0]]))
            else:
                values.append(float(row.turned[self.program.angles.index(("body", m.of, m.axis))]))
        return values

    def _heat(self, before: SimpleNamespace) -> None:
        """What the laws hold less than before a switch has become their heat; what they hold more comes from it."""
        first = self.program.nq + self.program.nv
        self.state[first : first + len(before.stored)] += before.stored - self.row().stored


def _is_place(p: Any) -> bool:
    """Whether p is three finite numbers."""
    return (
        isinstance(p, tuple | list | np.ndarray)
        and len(p) == 3
        and all(isinstance(x, float | int | np.number) and np.isfinite(x) for x in p)
    )
