"""Masses that a fixed joint holds: they belong to the rigid body that carries them, before anything is traced.

The body that is held stays where it is, for the laws that act on it and for its pose, but without mass or inertia: of
its own inertia and of what moves it nothing is left in the code.  Sums of rigid-body inertias about the common centre
of mass (Featherstone 2008, section 2.14).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.compiler.symbol import Array

from .trees import Tree, TreeBody


def merged(tree: Tree) -> Tree:
    """The tree with the masses of fixed bodies given to the rigid bodies that carry them; numbers are floats."""
    bodies = list(tree.bodies)
    for i in reversed(range(len(bodies))):
        b = bodies[i]
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
    """The parent with the mass of its child, in the parent's frame."""
    R_PB = exact(child.R_PJ) @ exact(child.R_CJ).T
    com = exact(child.p_PJ) - R_PB @ exact(child.p_CJ) + R_PB @ exact(child.com)
    inertia = exact(parent.inertia) + R_PB @ exact(child.inertia) @ R_PB.T
    mass, middle, inertia = gathered(inertia, [(parent.mass, parent.com), (child.mass, com)])
    symmetric = (inertia + inertia.T) / 2.0
    return replace(parent, mass=mass, com=np.asarray(middle, float), inertia=symmetric.astype(float))


def gathered(inertia: Array, parts: Sequence[tuple[Any, Array]]) -> tuple[float, Array, Array]:
    """Mass, its centre and inertia about that of masses at points; `inertia` (3, 3): the sum of their own."""
    mass = sum(m for m, _ in parts)
    com = sum((m * x for m, x in parts), np.zeros(3)) / mass if mass else np.zeros(3)
    for m, x in parts:
        d = exact(x - com)
        inertia = inertia + m * ((d @ d) * np.eye(3) - np.outer(d, d))
    return mass, com, inertia
