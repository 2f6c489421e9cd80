"""Where the bodies of a mechanism are at the start, to see which of its ropes and supports carry then.

Walks the joints from the world outwards; the same joint conventions as `heavylift.kernel.describe`.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.describe import WORLD, Joint, Point, Rope, System
from numpy.typing import NDArray

Array = NDArray[np.float64]
Poses = dict[str, tuple[Array, Array]]  # body -> position [m], rotation matrix


def poses(system: System) -> Poses:
    """Position and rotation of every body that hangs together with the world."""
    found: Poses = {WORLD: (np.zeros(3), np.eye(3))}
    waiting = list(system.joints)
    while waiting:
        ready = [joint for joint in waiting if joint.parent in found]
        if not ready:
            break
        for joint in ready:
            p, R = found[joint.parent]
            d, Q = _motion(joint)
            frame = R @ np.array(joint.R_PJ)
            found[joint.child] = (p + R @ np.array(joint.p_PJ) + frame @ d, frame @ Q)
            waiting.remove(joint)
    return found


def length(rope: Rope, at: Poses) -> float:
    """Geometric length of a rope: the sum over its lines, each with its share [m]."""
    return sum(line.share * float(np.linalg.norm(place(line.a, at) - place(line.b, at))) for line in rope.lines)


def place(point: Point, at: Poses) -> Array:
    """World position of a point [m]."""
    p, R = at[point.body]
    return np.asarray(p + R @ np.array(point.p))


def _motion(joint: Joint) -> tuple[Array, Array]:
    """Displacement and rotation of the child in the joint frame."""
    q, axis = joint.q0, np.array(joint.axis)
    match joint.kind:
        case "prismatic":
            return q[0] * axis, np.eye(3)
        case "revolute":
            return np.zeros(3), _turned(axis * np.sin(q[0] / 2), float(np.cos(q[0] / 2)))
        case "spherical":
            return np.zeros(3), _turned(np.array(q[:3]), q[3])
        case "free":
            return np.array(q[:3]), _turned(np.array(q[3:6]), q[6])
        case "fixed":
            return np.zeros(3), np.eye(3)


def _turned(v: Array, w: float) -> Array:
    """Rotation matrix of the quaternion (v, w)."""
    x = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + 2 * w * x + 2 * x @ x)
