"""Where rigid shapes would meet on the equilibrium path, which knows nothing of what they press: it holds up to there.

Between two points of the path bodies are looked at on straight ways.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.constraints.contact.pairs import gap
from heavylift.kernel.description.contacts import Contact
from heavylift.kernel.description.mechanics import WORLD
from numpy.typing import NDArray

from .state import StaticState

STEP = 0.1  # [m] of a way from look to look
DEEP = 1e-3  # [m] by which shapes may lie in each other by rounding, or since they begin in touch
Poses = list[tuple[NDArray[np.float64], NDArray[np.float64]]]


def meets(contact: Contact, before: StaticState | None, after: StaticState) -> bool:
    """Whether the shapes of a contact go through each other from one point of the path to the next."""
    ends = _poses(contact, before or after), _poses(contact, after)
    way = max(norm((a - b).tolist()) for (a, _), (b, _) in zip(*ends, strict=True))
    looks = max(1, ceil(way / STEP))
    for i in range(0 if before is None else 1, looks + 1):
        part = i / looks
        here = [(a + part * (b - a), R if part > 0.5 else Q) for (a, Q), (b, R) in zip(*ends, strict=True)]
        if gap(contact, *here) < -DEEP:
            return True
    return False


def _poses(contact: Contact, x: StaticState) -> Poses:
    """Place and rotation of the two bodies of a contact."""
    found: Poses = []
    for body in (contact.a.body, contact.b.body):
        p, R = x.poses[body] if body != WORLD else ((0.0, 0.0, 0.0), np.eye(3))
        found.append((np.array(p), np.array(R)))
    return found
