"""Discrete states at rest: which one-sided laws act, and how far dry friction has given way.

Ropes, pads and stops switch as at events.  Friction that is pulled beyond its limit slides and draws the anchor of its
spring after it, until the spring relaxes; then it holds from where it is (return mapping of perfect plasticity; Simo,
Hughes, Computational Inelasticity, 1998, 1.4).
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.forces.joint_laws import BrakeAt
from heavylift.kernel.forces.supports import SupportAt
from heavylift.kernel.model.switching import StateChange

from .poses import Poses

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

RUBS = ("rub", "brake")  # kinds of guards that watch dry friction
SETTLED = 20  # rounds of switching at one pose after which laws contradict each other
OPPOSITE = {"taut": "slack", "closed": "open", "stick": "slip", "locked": "freed"}


def switch(poses: Poses, q: np.ndarray, thresholds: bool = False) -> list[StateChange]:
    """Switch every law whose guard has fallen at pose q (nq,), until the active set stays; what has happened.

    `thresholds`: those that were armed, too.
    """
    simulation = poses.simulation
    guards = simulation.program.guards
    happened: list[StateChange] = []
    for _ in range(SETTLED):
        poses.accelerations(q)
        fallen = [int(i) for i in np.flatnonzero(poses.guards() < 0.0)]
        fallen = [i for i in fallen if guards[i][0] != "bending" and (thresholds or guards[i][0] != "threshold")]
        if not fallen:
            break
        others = [i for i in fallen if guards[i][0] not in RUBS]
        happened += [_rub(simulation, *guards[i]) for i in fallen if guards[i][0] in RUBS]
        happened += simulation.events.switch(others, simulation.epoch) if others else []
    return happened


def _rub(simulation: Simulation, kind: str, name: str) -> StateChange:
    """Friction that held slides from here on, in the direction in which it was pulled; what slid holds."""
    program, row = simulation.program, simulation.row()
    law = program.of_guard[kind, name]
    shown, p = program.shown(law, row), simulation.P[program.parameters.at[law.law.kind, name]]
    at: type[SupportAt] | type[BrakeAt]
    if kind == "rub":
        at, way, value = SupportAt, shown[1:3] - p[SupportAt.ANCHOR], float(shown[0])
        direction = way / max(_length(way), 1e-300)
    else:
        at, value, direction = BrakeAt, float(shown[0]), np.sign(shown[0] - p[BrakeAt.ANCHOR])
    slips = p[at.STICK] > 0.0
    p[at.STICK], p[at.DIRECTION] = float(not slips), direction
    return StateChange(name, "slip" if slips else "stick", 0.0 if slips and kind == "brake" else value)


def give_way(simulation: Simulation) -> float:
    """Draw the anchors of what slides after it, so that their springs hold what they can (radial return).

    Returns how far a pad has slid at most [m], whose direction is that of the end all the way.
    """
    slid = 0.0
    program, row = simulation.program, simulation.row()
    for kind, law in ((kind, x) for (kind, _), x in program.of_guard.items() if kind in RUBS):
        shown, p = program.shown(law, row), simulation.P[program.parameters.at[law.law.kind, law.name]]
        if kind == "rub" and p[SupportAt.CLOSED] > 0.0 and p[SupportAt.STICK] <= 0.0 and p[SupportAt.KT] > 0.0:
            place, limit = shown[1:3], p[SupportAt.MU] * shown[0]
            way = place - p[SupportAt.ANCHOR]
            anchor = place - limit / p[SupportAt.KT] / max(_length(way), 1e-300) * way
            slid = max(slid, _length(anchor - p[SupportAt.ANCHOR]))
            p[SupportAt.ANCHOR] = anchor
        if kind == "brake" and p[BrakeAt.ENGAGED] > 0.0 and p[BrakeAt.STICK] <= 0.0 and p[BrakeAt.K] > 0.0:
            q = shown[0]
            p[BrakeAt.ANCHOR] = q - p[BrakeAt.MOMENT] / p[BrakeAt.K] * np.sign(q - p[BrakeAt.ANCHOR])
    return slid


def net(events: list[StateChange]) -> list[StateChange]:
    """Events without those that were taken back: of each law and pair of states the last, if its state has changed."""
    last: dict[tuple[str, str], StateChange] = {}
    odd: dict[tuple[str, str], bool] = {}
    pairs = {two: one for one, two in OPPOSITE.items()}
    for e in events:
        key = e.name, pairs.get(e.what, e.what)
        last[key] = e
        odd[key] = not odd.get(key, False) or e.what not in {*OPPOSITE, *pairs}
    return [e for key, e in last.items() if odd[key]]


def _length(way: np.ndarray) -> float:
    return sqrt(float(way[0] * way[0] + way[1] * way[1]))
