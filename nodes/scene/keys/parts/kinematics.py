"""Poses of the bodies of a mechanism at the start, which determine the ropes and supports that carry a load then.

The joints are followed from the world outwards, with the kernel's table of joints.
"""

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Point, RigidRope, Rope, System
from heavylift.kernel.multibody.motion import axes_of, placement
from heavylift.kernel.multibody.spanning_tree import spanning_tree
from numpy.typing import NDArray

Array = NDArray[np.float64]
Poses = dict[str, tuple[Array, Array]]  # body -> position [m], rotation matrix


def poses(system: System) -> Poses:
    """Return the position (3,) [m] and rotation (3, 3) of each body connected to the world, found along the spanning
    tree; raises KernelError if that is impossible."""
    found: dict[str, tuple[Array, Array]] = {WORLD: (exact(np.zeros(3)), exact(np.eye(3)))}
    waiting = list(spanning_tree(system, {joint.name: joint for joint in system.joints})[0].values())
    while ready := [joint for joint in waiting if joint.parent in found]:
        for joint in ready:
            p, R = found[joint.parent]
            q = joint.q0 or JOINTS[joint.kind].rest
            Q, d = map(exact, placement(joint.kind, exact(axes_of(joint)), joint.pitch, q))
            if joint.kind == "slider" and joint.q0:
                d = exact([joint.q0[0], 0.0, 0.0])  # along the straight beam
            frame = R @ exact(joint.R_PJ)
            turned = frame @ Q
            own = turned @ exact(joint.p_CJ)
            found[joint.child] = (p + R @ exact(joint.p_PJ) + frame @ d - own, turned)
            waiting.remove(joint)
    return {body: (p.astype(float), R.astype(float)) for body, (p, R) in found.items()}


def length(rope: Rope | RigidRope, at: Poses) -> float:
    """Return the geometric length of a rope [m]: the weighted sum of the lengths of its straight parts."""
    return sum(line.share * norm((place(line.a, at) - place(line.b, at)).tolist()) for line in rope.lines)


def place(point: Point, at: Poses) -> Array:
    """Return the world position (3,) [m] of a point."""
    p, R = at[point.body]
    return np.asarray(exact(p) + exact(R) @ exact(point.p), dtype=float)
