"""Speeds of bodies at samples, from the speeds of their joints, and the possible deviation from straight motion.

A point with velocities v0 and v1 at two samples and mean velocity s between them deviates by about h / 4 (|v0 - s| +
|v1 - s|): for a constant acceleration this is twice h^2 / 8 times it; for vibration faster than the samples it exceeds
the amplitude, unless the vibration happens to reverse at both samples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from heavylift.kernel.description.mechanics import WORLD, Joint
from numpy.typing import NDArray

from .rotating import cross, dots, lengths

Floats = NDArray[np.float64]
Twist = tuple[Floats, Floats]  # (n, 3) of a body's origin [m/s] and (n, 3) angular [rad/s], both in the world
SINGLE = {"prismatic": "speed", "revolute": "rate"}
FREE = ("vx", "vy", "vz"), ("wx", "wy", "wz")


class BodyPoses(Protocol):
    """Interface of the poses of a body: positions `p` and rotations `R`."""

    p: Floats  # (n, 3) its origin [m]

    @property
    def R(self) -> Floats:
        """Rotations (n, 3, 3), or (1, 3, 3) without rotation."""


def twists(joints: Sequence[Joint], frames: Mapping[str, BodyPoses], speeds: Mapping[str, Floats]) -> dict[str, Twist]:
    """Return velocities of all bodies whose joints up to the world are free, sliding, hinged or fixed; locked joints
    are at rest."""
    if not speeds:
        return {}
    still = np.zeros_like(next(iter(frames.values())).p)
    found: dict[str, Twist] = {WORLD: (still, still)}
    for joint in joints:  # from the world on
        known, frame = found.get(joint.parent), frames.get(joint.child)
        if known is None or frame is None:
            continue
        parent = frames[joint.parent]
        v, w = known
        v = v + cross(w, frame.p - parent.p)
        if joint.kind == "free" and joint.parent == WORLD:
            rates = [[speeds.get(f"{joint.name}.{x}", still[:, 0]) for x in names] for names in FREE]
            v, w = (sum((frame.R[:, :, i] * x[:, None] for i, x in enumerate(one)), still) for one in rates)
            v = v - cross(w, _turned(frame.R, joint.p_CJ))
        elif joint.kind in SINGLE:
            axis = _turned(parent.R, (np.array(joint.R_PJ) @ joint.axis).tolist())
            along = axis * speeds.get(f"{joint.name}.{SINGLE[joint.kind]}", still[:, 0])[:, None]
            if joint.kind == "prismatic":
                v = v + along
            else:
                v, w = v - cross(along, _turned(frame.R, joint.p_CJ)), w + along
        elif joint.kind != "fixed":
            continue
        found[joint.child] = v, w
    return found


def strays(t: Floats, pose: Floats, twist: Twist) -> tuple[Floats, Floats]:
    """Return bounds (n - 1,) of the deviation of a body's origin from its chords [m], and per metre from it."""
    v, w = twist
    h = np.maximum(np.diff(t), 1e-9)[:, None]
    return _strays(h, v, np.diff(pose[:, :3], axis=0) / h), _strays(h, w, _turns(pose[:, 3:]) / h)


def _strays(h: Floats, v: Floats, mean: Floats) -> Floats:
    found: Floats = h[:, 0] / 4 * (lengths(v[:-1] - mean) + lengths(v[1:] - mean))
    return found


def _turns(q: Floats) -> Floats:
    """Return rotation vectors (n - 1, 3) from each quaternion (x y z w) to the next [rad]."""
    a, b = q[:-1], q[1:]
    sine = a[:, 3:] * b[:, :3] - b[:, 3:] * a[:, :3] - cross(b[:, :3], a[:, :3])
    sine *= np.where(dots(a, b) < 0.0, -1.0, 1.0)[:, None]
    size = lengths(sine)
    found: Floats = sine * (2.0 * np.arcsin(np.minimum(1.0, size)) / np.maximum(size, 1e-300))[:, None]
    return found


def _turned(R: Floats, x: Sequence[float]) -> Floats:
    """Return a vector of a body in world axes (n, 3)."""
    return sum((R[:, :, i] * xi for i, xi in enumerate(x) if xi), np.zeros((1, 3)))
