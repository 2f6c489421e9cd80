"""What the equations of a lift need to hold in each stage of its action list, before it is run.

The list is followed statically.  Ropes that are not hooked and pads that the block is far from are not required, and
what nothing ties is an island; the kernel leaves out and cuts apart as that pays (`kernel.thrift`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.forces.force_law import BODY
from heavylift.kernel.islands.components import islands_of
from heavylift.kernel.methods.choice import choose, control_of
from heavylift.kernel.model.program import Program
from heavylift.kernel.simulation.native.inactive_laws import AWAY, leaner
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.nodes.models import system

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene
    from heavylift.nodes.statics.static_state import State

__all__ = ["Required", "page", "required"]

HEADS = ("islands", "ropes", "pads", "operations")


@dataclass(frozen=True)
class Required:
    """Of the end of a stage: islands, hooked ropes, pads that could be touched, operations of one evaluation."""

    stage: str
    islands: int
    ropes: int
    pads: int
    operations: int


def required(scene: LoadedScene) -> list[Required]:
    """The stages as far as the list can be followed without its dynamics; none where no block is lifted."""
    followed, plan = scene.followed, scene.plan
    if followed is None or plan.block is None:
        return []
    given = system(plan)
    program = Program(given)
    method = choose(plan.method, program)
    whole = Stepping(program, method, control_of(method, plan.step, program))
    slings, ropes = {s.name for s in plan.rig.slings}, {r.name for r in given.straight_ropes}
    pads = {u.name for u in given.supports}
    counts: dict[frozenset[str], int] = {}
    out = []
    for stage, steps in groupby(followed.steps, key=lambda step: step.stage):
        state = [*steps][-1].state
        loose = frozenset((slings & ropes) - state.lugs.keys())
        absent = loose | (pads if not state.grounded and _away(program, plan.block.name, state) else frozenset())
        absent = absent if plan.fidelity.unused_laws == "dropped" else frozenset()
        if absent not in counts:
            counts[absent] = (leaner(whole, absent) if absent else whole).f_rate.operations
        islands = len(islands_of(given, loose)) if plan.fidelity.islands == "apart" else 1
        left = (islands, len(ropes - absent), len(pads - absent))
        out.append(Required(stage, *left, counts[absent]))
    return out


def _away(program: Program, block: str, state: State) -> bool:
    """Whether the block at rest is too far from its pads to touch them soon."""
    if ("pads", block) not in program.parameters.at:
        return False
    c, s = cos(state.theta), sin(state.theta)
    body = np.zeros(BODY)
    body[:9], body[12:15] = (1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c), state.at
    p = program.parameters.initial[program.parameters.at["pads", block]]
    return bool(program.clearances.pads(p=p, body=body).time[0] > AWAY)


def page(rows: list[Required]) -> str:
    """A table; stages that change nothing are left out."""
    lines = [f"  {'required at the end of':<28}" + "".join(f" {head:>10}" for head in HEADS)]
    shown: tuple[int, ...] = ()
    for x in rows:
        cells = (x.islands, x.ropes, x.pads, x.operations)
        if cells != shown:
            lines.append(f"  {x.stage:<28}" + "".join(f" {cell:>10}" for cell in cells))
            shown = cells
    return "\n".join(lines)
