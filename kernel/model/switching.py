"""Discrete states of laws: what changes when a guard has fallen or a command says so.

Coordinates and velocities are never touched.  Elastic energy that a law still holds when it lets go (a rope that
slackens under damping, a sling unhooked, a pad that opens) counts as heat of that law; the simulation books it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.laws import SLIP_BLEND

from .parameters import BrakeAt, RopeAt, StopAt, SupportAt
from .program import Program

__all__ = ["StateEvent", "Switches"]

JUST_BELOW = 1.0 - 1e-9  # part of the limit that a spring holds which begins to stick, so that it does not slip at once
GIVEN_WAY = 0.5  # part that it holds after the limit has fallen below it


def _deflection(force: Any, velocity: Any, k: float, d: float) -> Any:
    """How far a friction spring is from its anchor to hold a force; without a spring nothing is held."""
    return (force - d * velocity) / k if k > 0.0 else 0.0 * force


@dataclass(frozen=True)
class StateEvent:
    """A change of state: `what` is taut, slack, closed, open, stick, slip, bent or reached, of a lock locked or freed;
    `value` is the law's own."""

    name: str
    what: str
    value: float


class Switches:
    """Reads and writes the discrete states in P; `row` is the present sample row (see `sample_row`).

    `admit(command)` is called before a command takes effect.
    """

    def __init__(self, program: Program, P: np.ndarray) -> None:
        self._program, self._P, self._at = program, P, program.parameters.at
        s = program.system
        self._ropes = {r.name: i for i, r in enumerate(s.ropes)}
        self._supports = {u.name: i for i, u in enumerate(s.supports)}
        self._brakes = {b.name: program.graph.coordinate(b.name, b.joint, b.coordinate) for b in s.brakes}
        self._thresholds = {h.name: h for h in s.thresholds}
        self.watched: dict[str, float] = {}
        self.admit: Callable[[str], None] = lambda command: None

    def fire(self, guard: int, row: SimpleNamespace) -> StateEvent:
        """Switch the law behind a fallen guard."""
        kind, name = self._program.guards[guard]
        if kind == "force":
            return self._force(guard, name, row)
        return getattr(self, f"_{kind}")(name, row)  # type: ignore[no-any-return]

    def _rope(self, name: str, row: SimpleNamespace) -> StateEvent:
        p = self._P[self._at["rope", name]]
        p[RopeAt.TAUT] = 1.0 - p[RopeAt.TAUT]
        return StateEvent(name, "taut" if p[RopeAt.TAUT] else "slack", float(row.elongation[self._ropes[name]]))

    def _support(self, name: str, row: SimpleNamespace) -> StateEvent:
        p, i, at = self._P[self._at["support", name]], self._supports[name], SupportAt
        p[at.CLOSED] = 1.0 - p[at.CLOSED]
        p[at.STICK], p[at.ANCHOR], p[at.DIRECTION] = 1.0, row.place[2 * i : 2 * i + 2], 0.0
        return StateEvent(name, "closed" if p[at.CLOSED] else "open", float(row.normal[i]))

    def _rub(self, name: str, row: SimpleNamespace) -> StateEvent:
        p, i, at = self._P[self._at["support", name]], self._supports[name], SupportAt
        place, velocity = row.place[2 * i : 2 * i + 2], row.velocity[2 * i : 2 * i + 2]
        if p[at.STICK] > 0.0:
            s = place - p[at.ANCHOR]
            held = p[at.KT] * s + p[at.DT] * velocity
            if float(held[0] * velocity[0] + held[1] * velocity[1]) > 0.0 or p[at.KT] == 0.0:
                p[at.STICK], p[at.DIRECTION] = 0.0, held / max(norm(held.tolist()), 1e-300)
            else:  # the limit has fallen faster than the spring relaxes: it gives way and holds on
                p[at.ANCHOR] = place - _deflection(GIVEN_WAY * held, velocity, p[at.KT], p[at.DT])
            return StateEvent(name, "slip", float(row.normal[i]))
        direction = velocity + SLIP_BLEND * p[at.DIRECTION]
        force = JUST_BELOW * p[at.MU] * row.normal[i] * direction / max(norm(direction.tolist()), 1e-300)
        p[at.STICK], p[at.ANCHOR] = (
            1.0,
            place - _deflection(force, velocity, p[at.KT], p[at.DT]),
        )
        return StateEvent(name, "stick", float(row.normal[i]))

    def _lower(self, name: str, row: SimpleNamespace) -> StateEvent:
        return self._stop(name, StopAt.AT_LOWER, StopAt.LOWER)

    def _upper(self, name: str, row: SimpleNamespace) -> StateEvent:
        return self._stop(name, StopAt.AT_UPPER, StopAt.UPPER)

    def _stop(self, name: str, side: int, limit: int) -> StateEvent:
        p = self._P[self._at["stop", name]]
        p[side] = 1.0 - p[side]
        return StateEvent(name, "closed" if p[side] else "open", float(p[limit]))

    def _brake(self, name: str, row: SimpleNamespace) -> StateEvent:
        p, (i, k), at = self._P[self._at["brake", name]], self._brakes[name], BrakeAt
        q, v = float(row.q[i]), float(row.v[k])
        if p[at.STICK] > 0.0:
            held = p[at.K] * (q - p[at.ANCHOR]) + p[at.D] * v
            p[at.STICK], p[at.DIRECTION] = 0.0, np.sign(held)
            return StateEvent(name, "slip", v)
        force = JUST_BELOW * p[at.MOMENT] * p[at.DIRECTION]
        p[at.STICK], p[at.ANCHOR] = 1.0, q - _deflection(force, v, p[at.K], p[at.D])
        return StateEvent(name, "stick", q)

    def _force(self, guard: int, name: str, row: SimpleNamespace) -> StateEvent:
        """Switch an entry of the force table; its guards and what it shows lie one after the other."""
        first = 0
        for x in self._program.forces:
            n = len(x.law.shows(x.force))
            if x.name == name:
                local = guard - self._program.guards.index(("force", name))
                p = self._P[self._at["force", name]]
                return StateEvent(name, *x.law.switch(x.force, p, local, row.shown[first : first + n]))
            first += n
        raise KernelError(f"'{name}': no force of this name")

    def _threshold(self, name: str, row: SimpleNamespace) -> StateEvent:
        self._disarm(name)
        return StateEvent(name, "reached", self.watched[name])

    # ---- commands --------------------------------------------------------------------------------------

    def watch(self, name: str, value: float, rising: bool) -> None:
        """Arm a threshold; raises KernelError if there is none of this name."""
        p = self._threshold_numbers(name)
        if not isfinite(value):
            raise KernelError(f"threshold '{name}': {value} is no value to wait for; it must be a finite number")
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
            raise KernelError(f"'{name}': no threshold of this name; there are {', '.join(self._thresholds) or 'none'}")
        return self._P[self._at["threshold", name]]

    def set_brake(self, name: str, engaged: bool, row: SimpleNamespace) -> None:
        """Close a brake where the joint stands, or open it; one that is closed already keeps its place."""
        if name not in self._brakes:
            raise KernelError(f"'{name}': no brake of this name; there are {', '.join(self._brakes) or 'none'}")
        self.admit("set_brake")
        p = self._P[self._at["brake", name]]
        if bool(p[BrakeAt.ENGAGED]) != engaged:
            p[BrakeAt.ENGAGED :] = [float(engaged), 1.0, row.q[self._brakes[name][0]], 0.0]

    def rope_numbers(self, name: str) -> np.ndarray:
        """EA, damping, hooked, taut and lines of a rope; raises KernelError if there is none of this name."""
        if name not in self._ropes:
            raise KernelError(f"'{name}': no rope of this name; there are {', '.join(self._ropes) or 'none'}")
        return self._P[self._at["rope", name]]

    def rigid_numbers(self, name: str) -> np.ndarray | None:
        """hooked, taut and lines of a rigid rope, if this is one."""
        return self._P[self._at["rigid", name]] if ("rigid", name) in self._at else None

    def unhook(self, name: str) -> None:
        """Let a rope go."""
        rigid = self.rigid_numbers(name)
        if rigid is not None:
            rigid[RigidAt.HOOKED] = rigid[RigidAt.TAUT] = 0.0
            return
        p = self.rope_numbers(name)
        p[RopeAt.HOOKED] = p[RopeAt.TAUT] = 0.0
