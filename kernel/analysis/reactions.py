"""Joint reactions: the six components of force and moment that every joint transmits at one instant.

The accelerations are those of the forward dynamics, whatever solved it; the balance of the outer bodies then gives the
joint forces, the paper's Fig. 6 (c), (d): f_c,i = f_B,i - f_e,i + sum of f_c,j over the children j.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics import composites
from ..spatial import cross
from .inverse import accelerated

if TYPE_CHECKING:
    from ..stepper import Stepper

__all__ = ["Reaction", "reactions"]


@dataclass(frozen=True)
class Reaction:
    """What a joint does to its child: `force` (3,) [N] and `moment` (3,) [N m] about the joint's place on the child.

    Both in the axes of the joint's frame on the parent, R_WJ; along free axes they are the forces of the joint's laws.
    """

    force: np.ndarray
    moment: np.ndarray


def reactions(simulation: Stepper) -> dict[str, Reaction]:
    """Reaction of every joint by name, at the present instant of a simulation; those that close loops come last."""
    program, x = simulation.program, simulation.instant()
    dv = x.dy[program.nq : program.nq + program.nv]
    found: dict[str, Reaction] = {}
    R_W = {-1: np.eye(3)}
    for tree in program.trees:
        q, v = np.array(x.q[tree.q]), np.array(x.v[tree.v])
        W = x.wrenches[tree.first : tree.first + len(tree.bodies)]
        K = accelerated(tree, q, v, dv[tree.v], x.gravity)
        _, F = composites(tree, K, W)
        for n, b in enumerate(tree.bodies):
            R_WJ = (K.R[b.parent] if b.parent >= 0 else np.eye(3)) @ b.R_PJ
            R_W[tree.first + n] = K.R[n]
            moment, force = F[n][:3] - cross(K.r[n] + K.R[n] @ b.p_CJ, F[n][3:]), F[n][3:]
            joint = program.graph.links[tree.first + n].joint.name
            found[joint] = Reaction(*(np.array(R_WJ.T @ f, dtype=float) for f in (force, moment)))
    loads = np.reshape(np.array(x.loads(), dtype=float), (-1, 2, 3))
    for j, load in zip(program.graph.loops, loads, strict=True):
        R_WJ = R_W[program.graph.number(j.parent)] @ np.array(j.R_PJ)
        found[j.name] = Reaction(*(np.array(R_WJ.T @ f, dtype=float) for f in load))
    return found
