"""Discrete states at rest: which one-sided laws act, and how far dry friction has given way.

Ropes, pads and stops switch as at events.  Friction that is pulled beyond its limit slides: at rest it is a constant
force along the way of the slide, until that way turns back; then it holds from where it is (return mapping of perfect
plasticity; Simo, Hughes, Computational Inelasticity, 1998, 1.4).
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from ..parameters import BrakeAt, SupportAt
from ..switching import StateEvent
from .poses import Poses

if TYPE_CHECKING:
    from ..simulation import Simulation

__all__ = ["RUBS", "Sliding", "net", "switch"]

RUBS = ("rub", "brake")  # kinds of guards that watch dry friction
SETTLED = 20  # rounds of switching at one pose after which laws contradict each other
OPPOSITE = {"taut": "slack", "closed": "open", "stick": "slip", "locked": "freed"}
STILL = 1e-9  # [m, rad] of sliding that is none


def switch(poses: Poses, q: np.ndarray, thresholds: bool = False) -> list[StateEvent]:
    """Switch every law whose guard has fallen at pose q (nq,), until the active set stays; what has happened.

    `thresholds`: those that were armed, too.
    """
    simulation = poses.simulation
    guards = simulation.program.guards
    happened: list[StateEvent] = []
    for _ in range(SETTLED):
        poses.accelerations(q)
        fallen = [int(i) for i in np.flatnonzero(poses.guards() < 0.0)]
        fallen = [i for i in fallen if guards[i][0] != "bending" and (thresholds or guards[i][0] != "threshold")]
        if not fallen:
            break
        others = [i for i in fallen if guards[i][0] not in RUBS]
        happened += [_slip(simulation, *guards[i]) for i in fallen if guards[i][0] in RUBS]
        happened += simulation._switch(others, simulation.epoch) if others else []
    return happened


def _slip(simulation: Simulation, kind: str, name: str) -> StateEvent:
    """Friction slides from here on, in the direction in which it was pulled."""
    switches, row = simulation.switches, simulation.row()
    if kind == "rub":
        i, p = switches._supports[name], simulation.P[simulation.program.parameters.at["support", name]]
        way = row.place[2 * i : 2 * i + 2] - p[SupportAt.ANCHOR]
        p[SupportAt.STICK], p[SupportAt.DIRECTION] = 0.0, way / max(_length(way), 1e-300)
        return StateEvent(name, "slip", float(row.normal[i]))
    j, p = switches._brakes[name][0], simulation.P[simulation.program.parameters.at["brake", name]]
    p[BrakeAt.STICK], p[BrakeAt.DIRECTION] = 0.0, np.sign(row.q[j] - p[BrakeAt.ANCHOR])
    return StateEvent(name, "slip", 0.0)


class Sliding:
    """Friction that slides, between two poses of rest: which of it has turned back, and where to it goes now."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        at, system = simulation.program.parameters.at, simulation.program.system
        self._pads = [(u.name, simulation.P[at["support", u.name]]) for u in system.supports if u.mu > 0.0]
        self._brakes = [(b.name, simulation.P[at["brake", b.name]]) for b in system.brakes]
        self._before = self.places() if self.any else {}

    @property
    def any(self) -> bool:
        """Whether anything slides."""
        return any(p[SupportAt.CLOSED] > 0.0 and p[SupportAt.STICK] <= 0.0 for _, p in self._pads) or any(
            p[BrakeAt.ENGAGED] > 0.0 and p[BrakeAt.STICK] <= 0.0 for _, p in self._brakes
        )

    def places(self) -> dict[str, np.ndarray]:
        """Where what slides is now: (2,) [m] of a pad, (1,) [m or rad] of a brake."""
        row, switches = self._simulation.row(), self._simulation.switches
        found = {}
        for name, p in self._pads:
            if p[SupportAt.CLOSED] > 0.0 and p[SupportAt.STICK] <= 0.0:
                i = switches._supports[name]
                found[name] = row.place[2 * i : 2 * i + 2].copy()
        for name, p in self._brakes:
            if p[BrakeAt.ENGAGED] > 0.0 and p[BrakeAt.STICK] <= 0.0:
                found[name] = row.q[switches._brakes[name][0] :][:1].copy()
        return found

    def turned(self) -> list[StateEvent]:
        """Let what would slide back hold, where it was before; what goes on takes the direction of its way."""
        if not self._before:
            return []
        events, now = [], self.places()
        row = self._simulation.row()
        for name, p in self._pads:
            if name in self._before and name in now:
                way = now[name] - self._before[name]
                if way[0] * p[SupportAt.DIRECTION][0] + way[1] * p[SupportAt.DIRECTION][1] < -STILL:
                    i = self._simulation.switches._supports[name]
                    held = p[SupportAt.MU] * row.normal[i] / p[SupportAt.KT] * p[SupportAt.DIRECTION]
                    p[SupportAt.STICK], p[SupportAt.ANCHOR] = 1.0, self._before[name] - held
                    events.append(StateEvent(name, "stick", float(row.normal[i])))
                elif _length(way) > STILL:
                    p[SupportAt.DIRECTION] = way / _length(way)
        for name, p in self._brakes:
            if name in self._before and name in now:
                way = float((now[name] - self._before[name])[0])
                if way * p[BrakeAt.DIRECTION] < -STILL:
                    held = p[BrakeAt.MOMENT] / p[BrakeAt.K] * p[BrakeAt.DIRECTION]
                    p[BrakeAt.STICK], p[BrakeAt.ANCHOR] = 1.0, self._before[name][0] - held
                    events.append(StateEvent(name, "stick", float(now[name][0])))
        return events


def net(events: list[StateEvent]) -> list[StateEvent]:
    """Events without those that were taken back: of each law and pair of states the last, if its state has changed."""
    last: dict[tuple[str, str], StateEvent] = {}
    odd: dict[tuple[str, str], bool] = {}
    pairs = {two: one for one, two in OPPOSITE.items()}
    for e in events:
        key = e.name, pairs.get(e.what, e.what)
        last[key] = e
        odd[key] = not odd.get(key, False) or e.what not in {*OPPOSITE, *pairs}
    return [e for key, e in last.items() if odd[key]]


def _length(way: np.ndarray) -> float:
    return sqrt(float(way[0] * way[0] + way[1] * way[1]))
