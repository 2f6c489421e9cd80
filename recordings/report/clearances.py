"""How close what moves comes to what stands: gaps between the drawn shapes of block, portals and ground.

The gap between two bodies is that of the boxes along the world's axes around their shapes, so a body that is turned is
taken larger than it is: the true distance is at least the one that is told.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..drawing import Box, boxes_of
from ..reader import Recording
from ..samples import POSE

__all__ = ["Clearance", "clearances", "lowest"]

Floats = NDArray[np.float64]
Extent = tuple[Floats, Floats]  # (n, 3) lowest and highest corner of a box at each sample [m]
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


class Clearance(NamedTuple):
    """Least distance between two things [m], and when [s]."""

    between: str
    distance: float
    when: float


def clearances(rec: Recording, plan: dict[str, Any]) -> list[Clearance]:
    """Block against portals, portals against each other; nothing where there are none."""
    parts = _extents(rec)
    cranes = {c["name"]: parts.get(f"{c['name']}.main", []) for c in plan.get("cranes", [])}
    block = plan["block"].get("name", "block") if plan.get("block") else ""
    pairs = [(f"{block} and portal of {name}", parts.get(block, []), portal) for name, portal in cranes.items()]
    pairs += [(f"portals of {a} and {b}", cranes[a], cranes[b]) for a, b in combinations(cranes, 2)]
    found = []
    for between, some, others in pairs:
        gaps = [_gap(a, b) for a in some for b in others]
        if gaps:
            least = np.min(gaps, axis=0)
            k = int(np.argmin(least))
            found.append(Clearance(between, float(least[k]), float(_times(rec)[k])))
    return found


def lowest(rec: Recording, plan: dict[str, Any]) -> tuple[Floats, Floats]:
    """Times [s] and height of the block's lowest point [m]; both empty without a block."""
    block = _extents(rec).get(plan["block"].get("name", "block"), []) if plan.get("block") else []
    if not block:
        return np.zeros(0), np.zeros(0)
    heights: Floats = np.min([low[:, 2] for low, _ in block], axis=0)
    return _times(rec), heights


def _times(rec: Recording) -> Floats:
    return next((rec.signal(name).t for name in rec.signals() if name.startswith(POSE)), np.zeros(0))


def _extents(rec: Recording) -> dict[str, list[Extent]]:
    """The boxes of each body over time."""
    found: dict[str, list[Extent]] = {}
    bodies = {name.removeprefix(POSE) for name in rec.signals() if name.startswith(POSE)}
    for box in (box for raw in rec.messages("/scene") for box in boxes_of(raw.data)):
        if box.body in bodies:
            found.setdefault(box.body, []).append(_extent(box, rec.signal(POSE + box.body).values))
    return found


def _extent(box: Box, pose: Floats) -> Extent:
    corners = np.array(box.centre) + _turned(np.array(box.turn)[None, :], CORNERS * np.array(box.size))[0]
    places = pose[:, None, :3] + _turned(pose[:, 3:], corners)
    return places.min(axis=1), places.max(axis=1)


def _turned(q: Floats, points: Floats) -> Floats:
    """(n, m, 3) points (m, 3) turned by each of n quaternions x y z w."""
    u, w, x = q[:, None, :3], q[:, None, 3:], points[None, :, :]
    turned: Floats = x + 2.0 * np.cross(u, np.cross(u, x) + w * x)
    return turned


def _gap(a: Extent, b: Extent) -> Floats:
    apart = np.maximum(0.0, np.maximum(a[0] - b[1], b[0] - a[1]))
    gap: Floats = np.linalg.norm(apart, axis=1)
    return gap
