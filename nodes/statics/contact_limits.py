"""Contacts of rigid shapes on the equilibrium path, which ends there because static contact forces are not computed.

Between two points of the path, bodies are assumed to move along straight lines.
"""

from dataclasses import replace
from math import ceil, inf

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.dense import norm, product
from heavylift.kernel.constraints.contact.pairs import Pose, gap
from heavylift.kernel.description.contacts import Ball, Box, Contact, Shape
from heavylift.kernel.description.mechanics import WORLD
from numpy.typing import NDArray

from .state import StaticState

STEP = 0.1  # [m] of a way from look to look
DEEP = 1e-3  # [m] by which shapes may lie in each other by rounding, or since they begin in touch
Poses = list[Pose]


def apart(contact: Contact, a: Pose, b: Pose) -> bool:
    """Return whether the two shapes of a contact are farther apart than the tolerance at these poses."""
    return gap(contact, a, b) > DEEP


def there(before: StaticState, after: StaticState, part: float) -> StaticState:
    """Return the state interpolated between two points of the equilibrium path.

    `part`: fraction of the way from the first to the second point."""
    poses = {
        body: (tuple(a + part * (b - a) for a, b in zip(p, q, strict=True)), R if part > 0.5 else Q)
        for (body, (p, Q)), (q, R) in zip(before.poses.items(), after.poses.values(), strict=True)
    }
    return replace(after, t=before.t + part * (after.t - before.t), poses=poses)  # type: ignore[arg-type]


def meets(contact: Contact, before: StaticState, after: StaticState) -> float | None:
    """Return the fraction (0 to 1) between two path points at which two shapes begin to penetrate, or None."""
    ends = _poses(contact, before), _poses(contact, after)
    distance = max(norm((a - b).tolist()) for (a, _), (b, _) in zip(*ends, strict=True))
    steps = max(1, ceil(distance / STEP))

    def deep(part: float) -> bool:
        here = [(a + part * (b - a), R if part > 0.5 else Q) for (a, Q), (b, R) in zip(*ends, strict=True)]
        return gap(contact, *here) < -DEEP

    parts = np.arange(0 if before is after else 1, steps + 1) / steps
    examined: list[float] = parts[_near(contact, ends, parts)].tolist()
    for high in examined:
        if deep(high):
            low = max(0.0, high - 1.0 / steps)
            while distance * (high - low) > DEEP:
                middle = (low + high) / 2
                low, high = (low, middle) if deep(middle) else (middle, high)
            return high
    return None


def _near(contact: Contact, ends: tuple[Poses, Poses], parts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of the fractions at which the axis-aligned bounding boxes of the two shapes overlap."""
    late = parts[:, None] > 0.5
    middles, reach = [], np.zeros((1, 3))
    for shape, (a, Q), (b, R) in zip((contact.a, contact.b), *ends, strict=True):
        turned = (np.array(product(frame.tolist(), shape.p)) for frame in (R, Q))
        middles.append(a + parts[:, None] * (b - a) + np.where(late, *turned))
        reach = reach + np.where(late, _reach(shape, R), _reach(shape, Q))
    found: NDArray[np.bool_] = (np.abs(middles[0] - middles[1]) <= reach).all(axis=1)
    return found


def _reach(shape: Shape, R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the half-extents (3,) [m] of the axis-aligned box around a shape on a body with the rotation R."""
    if isinstance(shape, Box):
        found: NDArray[np.float64] = np.array(product(np.abs(times(R, np.array(shape.R))).tolist(), shape.size)) / 2
        return found
    return np.full(3, shape.radius if isinstance(shape, Ball) else inf)


def _poses(contact: Contact, x: StaticState) -> Poses:
    """Return the positions and rotations of the two bodies of a contact."""
    found: Poses = []
    for body in (contact.a.body, contact.b.body):
        p, R = x.poses[body] if body != WORLD else ((0.0, 0.0, 0.0), np.eye(3))
        found.append((np.array(p), np.array(R)))
    return found
