"""The columns of a sample row: what a simulation publishes of one instant.

State, accounts, laws, poses (origin and rotation, 12 numbers a body), energies, loops, rigid ropes, contacts, the
peaks of the tensions since the last row with their times, and the steps so far.  `kernel.samples` gives what is to be
published names and units.
"""

from __future__ import annotations

from typing import Any

from heavylift.kernel.compiler.layout import Layout
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.model.program import Program

__all__ = ["columns", "row_layout"]


def row_layout(program: Program) -> Layout:
    """Names and sizes of the columns, in their order."""
    laws = {group: len(columns) for group, columns in program.columns.items()}
    sizes: dict[str, int | None] = {"q": program.nq, "v": program.nv, "accounts": len(program.accounts)}
    sizes["turned"] = len(program.angles)
    sizes |= dict.fromkeys(("length", "length_rate"), len(program.system.ropes))
    sizes |= {**laws, "stored": len(program.stores)}
    sizes |= {"poses": 12 * len(program.graph.links), "kinetic": None, "potential": None}
    sizes |= {"loop": 6 * len(program.graph.loops)} | dict.fromkeys(
        ("pull", "slack", "span"), len(program.system.rigid_ropes)
    )
    sizes |= {"pressing": len(program.system.contacts), "axial": len(program.axial)}
    sizes |= dict.fromkeys(("peak", "peak_time"), len(program.system.straight_ropes))
    return Layout(sizes | {"steps": None})


def columns(x: Evaluation) -> list[Any]:
    """The values of all columns but the peaks and the steps."""
    program = x.program
    poses, kinetic, potential = x.poses_and_energies()
    turned = [x.turned[label] for label in program.angles]
    lengths = [[x.signals[r.name][i] for r in program.system.ropes] for i in (0, 1)]
    laws = (x.column(group) for group in program.columns)
    flat = [e for part in (x.q, x.v, x.accounts, turned, *lengths, *laws) for e in part]
    return [
        *flat,
        *(x.stored[label] for label in program.stores),
        *poses,
        kinetic,
        potential,
        *x.loads(),
        *x.pressing,
        *x.axial,
    ]
