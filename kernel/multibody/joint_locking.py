"""Joints locked during a run, and bodies merged over fixed joints.

Joints locked during a run: a locked joint is a prescribed one at rest: its velocities leave the free degrees of freedom
of a *variant* of the scene's code, while layouts of state and parameters stay. If it is locked in motion, an impulse L
on the prescribed degrees of freedom changes the velocities of the whole tree at once, H dv = G^T L with dv = -v on the
locked ones and 0 on the driven ones (Featherstone 2008, section 11.7). L produces the heat -v L / 2 in a lock, and does
the work v L in a drive. Closed loops and rigid ropes add their impulses by a projection in the same metric, so that
both act as one impulse.

Fixed joints: the mass of a body behind a fixed joint is added to the rigid body that carries it, before anything is
traced. The body keeps its pose, also for laws that act on it, but has no mass or inertia, so that the code contains
neither its inertia nor its equations. Sums of rigid-body inertias about the common centre of mass (Featherstone 2008,
section 2.14).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.description.mechanics import JOINTS, Lock, System
from heavylift.kernel.errors import KernelError

from .dynamics import composites, joint_space_inertia, ltdl
from .graph import Graph
from .kinematics import kinematics
from .trees import Tree, TreeBody, with_numbers


def lock_of(system: System, name: str) -> Lock:
    """Return the lock of this name; raises KernelError for an unknown name."""
    for lock in system.locks:
        if lock.name == name:
            return lock
    raise KernelError(
        f"'{name}': there is no lock with this name; there are {', '.join(x.name for x in system.locks) or 'none'}"
    )


def check_locks(system: System, graph: Graph) -> None:
    """Raise KernelError for a lock on a fixed, driven or locked joint, or on one that starts moving."""
    taken: dict[str, str] = {}
    placed = {d.joint: d.name for d in system.drives if d.kind == "prescribed"}
    for lock in system.locks:
        joint = graph.joint(lock.joint).joint
        where = f"lock '{lock.name}': joint '{joint.name}'"
        if not JOINTS[joint.kind].n_v:
            raise KernelError(f"{where} is {joint.kind}; there is nothing to lock")
        if joint.name in placed:
            raise KernelError(
                f"{where} is moved by the prescribed drive '{placed[joint.name]}'; stop the drive instead"
            )
        if joint.name in taken:
            raise KernelError(f"{where} already has the lock '{taken[joint.name]}'; remove one of them")
        # a joint cannot be locked and moving at once
        if lock.engaged and any(joint.v0):
            raise KernelError(f"{where} is locked at the start; its initial velocity must be zero")
        taken[joint.name] = lock.name


def halt_function(k: int, tree: Tree) -> Function:
    """Return the traced function that stops a tree's locked joints: new velocities, impulses in prescribed joints."""
    nv, fixed = tree.v.stop - tree.v.start, len(tree.prescribed_dofs)

    def halt(q: Array, v: Array, P: Array) -> Outputs:
        t = with_numbers(tree, P)
        K = kinematics(t, q, v, 0.0, [0.0] * fixed)
        I, _ = composites(t, K, [np.zeros(6)] * len(t.bodies))
        H = joint_space_inertia(t, K, I)

        def row(i: int, jump: dict[int, Scalar]) -> Scalar:
            pairs = {j: (max(i, j), min(i, j)) for j in jump}
            return sum((H[pair] * jump[j] for j, pair in pairs.items() if pair in H), 0.0)

        # locked degrees of freedom stop; prescribed drives keep their speed (jump 0)
        jump = {i: -v[i] for i in t.locked_dofs}
        free = t.free_dofs
        # free ones respond by H_ff dv_f = -H_fl dv_l: no impulse acts along them
        jump |= dict(zip(free, ltdl(t, dict(H)).solve([-row(i, jump) for i in free]), strict=True))
        after = [v[i] + jump.get(i, 0.0) for i in range(nv)]
        return {"after": after, "impulse": [row(i, jump) for i in t.prescribed_dofs]}

    return Function(f"halt{k}", halt, {"q": tree.q.stop - tree.q.start, "v": nv, "P": len(tree.numbers)})


def merged(tree: Tree) -> Tree:
    """Return a tree, in floats, with the mass of each body behind a fixed joint added to the body that carries it."""
    bodies = list(tree.bodies)
    for i in reversed(range(len(bodies))):
        b = bodies[i]
        # only what changes nothing else may be merged: rigid, without added mass, with something to add
        if (
            b.kind == "fixed"
            and b.parent >= 0
            and b.place is None
            and b.elastic is None
            and b.added is None
            and (b.mass or np.any(b.inertia))
        ):
            bodies[b.parent] = _with(bodies[b.parent], b)
            bodies[i] = replace(b, mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    return replace(tree, bodies=tuple(bodies))


def _with(parent: TreeBody, child: TreeBody) -> TreeBody:
    """Return the parent with the mass of its child added, in the parent's frame."""
    R_PB = exact(child.R_PJ) @ exact(child.R_CJ).T
    com = exact(child.p_PJ) - R_PB @ exact(child.p_CJ) + R_PB @ exact(child.com)
    inertia = exact(parent.inertia) + R_PB @ exact(child.inertia) @ R_PB.T
    mass, middle, inertia = gathered(inertia, [(parent.mass, parent.com), (child.mass, com)])
    # rounding must not make an inertia unsymmetric
    symmetric = (inertia + inertia.T) / 2.0
    return replace(parent, mass=mass, com=np.asarray(middle, float), inertia=symmetric.astype(float))


def gathered(inertia: Array, parts: Sequence[tuple[Any, Array]]) -> tuple[float, Array, Array]:
    """Return the total mass, the common centre of mass, and the inertia about this centre, of several joined bodies.

    `parts`: mass and centre of mass of each body; `inertia` (3, 3): sum of the parts' own inertias.
    """
    mass = sum(m for m, _ in parts)
    com = sum((m * x for m, x in parts), np.zeros(3)) / mass if mass else np.zeros(3)
    # Steiner's theorem about the common centre of mass
    for m, x in parts:
        d = exact(x - com)
        inertia = inertia + m * ((d @ d) * np.eye(3) - np.outer(d, d))
    return mass, com, inertia
