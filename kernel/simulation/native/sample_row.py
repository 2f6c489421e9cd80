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
    ropes, supports = len(program.system.ropes), len(program.system.supports)
    sizes: dict[str, int | None] = {"q": program.nq, "v": program.nv, "accounts": len(program.accounts)}
    sizes["turned"] = len(program.angles)
    sizes |= dict.fromkeys(("tension", "length", "length_rate", "elongation"), ropes)
    sizes |= {
        "normal": supports,
        "place": 2 * supports,
        "velocity": 2 * supports,
        "stored": len(program.stored),
        "shown": sum(len(x.law.shows(x.force)) for x in program.forces),
    }
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
    parts = (x.q, x.v, x.accounts, turned, x.tensions, x.lengths, x.length_rates, x.elongations, x.normals)
    flat = [e for part in parts for e in part]
    return [
        *flat,
        *x.places,
        *x.velocities,
        *x.stored,
        *x.shown,
        *poses,
        kinetic,
        potential,
        *x.loads(),
        *x.pressing,
        *x.axial,
    ]
