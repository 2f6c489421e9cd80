"""Whether something resists every motion: a mass or an inertia that is missing where it matters is named at the start.

What is zero by structure is seen when the equations are traced.  A joint-space inertia can also be singular by its
numbers, such as that of a point mass in the middle of a ball joint; its factors on floats, in the initial pose, tell.
Trees in which every body has mass and full inertia need no look.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.dense import eigenvalues
from heavylift.kernel.errors import KernelError
from heavylift.kernel.multibody.dynamics import composites, joint_space_inertia
from heavylift.kernel.multibody.kinematics import kinematics
from heavylift.kernel.multibody.ltdl import ltdl
from heavylift.kernel.multibody.trees import Tree

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

ROUND_OFF = 1e-14  # of a pivot, relative to the products whose sum it is
FULL = 1e-12  # least principal moment of a full inertia, relative to the largest


def check_resistance(program: Program, y: np.ndarray) -> None:
    """Raises KernelError naming the body and the joint in which it moves without any resistance; y: initial state."""
    for tree, _ in program.instances:
        if not all(map(_full, tree.bodies)):
            _check(program, tree, y[tree.q])


def _full(body: object) -> bool:
    moments = eigenvalues(body.inertia.tolist())  # type: ignore[attr-defined]
    return body.mass > 0.0 and moments[0] > FULL * moments[2]  # type: ignore[attr-defined]


def _check(program: Program, tree: Tree, q: np.ndarray) -> None:
    still = [0.0] * len(tree.prescribed_dofs)
    K = kinematics(tree, q, np.zeros(tree.v.stop - tree.v.start), 0.0, still)
    I, _ = composites(tree, K, [np.zeros(6)] * len(tree.bodies))
    H = joint_space_inertia(tree, K, I)
    with np.errstate(all="ignore"):
        factors = ltdl(tree, {k: np.float64(h) for k, h in H.items()})
    columns = [s for S in K.S for s in S]
    for k in reversed(tree.free_dofs):  # in the order of elimination
        i, s = tree.body_of_dof[k], np.abs(columns[k])
        if not 1.0 / factors.D_inverse[k] > ROUND_OFF * (s @ np.abs(I[i]) @ s):
            name, joint = tree.bodies[i].name, program.graph.links[tree.first + i].joint
            raise KernelError(
                f"body '{name}': nothing resists its motion in joint '{joint.name}'; give it, or what it carries, mass "
                "or inertia"
            )
