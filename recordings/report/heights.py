"""How high the lowest point of the block is over time, from its drawn shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.viewer_messages import Box, boxes_of
from heavylift.recordings.read.reader import Recording
from numpy.typing import NDArray

__all__ = ["lowest"]

Floats = NDArray[np.float64]
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def lowest(rec: Recording, plan: dict[str, Any]) -> tuple[Floats, Floats]:
    """Times [s] and height of the block's lowest point [m]; both empty without a block."""
    body = plan["block"].get("name", "block") if plan.get("block") else ""
    if POSE + body not in rec.signals():
        return np.zeros(0), np.zeros(0)
    drawn = [box for raw in rec.messages("/scene") for box in boxes_of(raw.data) if box.body == body]
    if not drawn:
        return np.zeros(0), np.zeros(0)
    found = [
        (times, np.min([_heights(box, pose) for box in drawn], axis=0)) for times, (pose,) in rec.blocks([POSE + body])
    ]
    return np.concatenate([t for t, _ in found]) / 1e9, np.concatenate([z for _, z in found])


def _heights(box: Box, pose: Floats) -> Floats:
    """(n,) height of the lowest corner of a box at each pose."""
    corners = np.array(box.centre) + _turned(np.array(box.turn)[None, :], CORNERS * np.array(box.size))[0]
    found: Floats = (pose[:, None, :3] + _turned(pose[:, 3:], corners))[:, :, 2].min(axis=1)
    return found


def _turned(q: Floats, points: Floats) -> Floats:
    """(n, m, 3) points (m, 3) turned by each of n quaternions x y z w."""
    u, w, x = q[:, None, :3], q[:, None, 3:], points[None, :, :]
    turned: Floats = x + 2.0 * np.cross(u, np.cross(u, x) + w * x)
    return turned
