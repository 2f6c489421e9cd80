"""Boxes that enclose the geoms of a MuJoCo model, for drawings and clearances."""

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)
SLICES = 6  # boxes along the longest edge of a mesh
THIN = 1e-3  # [m] of a box
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def boxes_of(
    model: Any, bodies: list[str], missing: list[str], matrix: Callable[[np.ndarray], np.ndarray]
) -> dict[str, list[Box]]:
    """Return, by body, the boxes (centre and edges [m], parallel to the body's axes) that enclose its geoms.

    These are the colliding geoms, or all if none collides. Geoms without a size are added to `missing`; `matrix`
    converts a quaternion into a rotation matrix."""
    found: dict[str, list[Box]] = {}
    of_body: dict[int, list[int]] = {}
    for g in range(model.ngeom):
        of_body.setdefault(int(model.geom_bodyid[g]), []).append(g)
    for body, geoms in sorted(of_body.items()):
        solid = [g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]] or geoms
        for g in solid:
            if int(model.geom_type[g]) in (PLANE, HFIELD) or int(model.geom_type[g]) > MESH:
                missing.append(f"shape of geom {g} of body '{bodies[body]}': planes, height fields and distance fields")
            else:
                found.setdefault(bodies[body], []).extend(_boxes(model, g, matrix(model.geom_quat[g])))
    return found


def _boxes(m: Any, g: int, R: np.ndarray) -> Iterator[Box]:
    """Yield the boxes of one geom; a mesh has several, in slices along its longest edge."""
    p, size, kind = m.geom_pos[g], m.geom_size[g], int(m.geom_type[g])
    if kind == MESH:
        k = int(m.geom_dataid[g])
        first = m.mesh_vertadr[k]
        yield from _sliced(m.mesh_vert[first : first + m.mesh_vertnum[k]] @ R.T + p, _faces(m, k))
        return
    along = np.abs(R[:, 2])
    across = np.sqrt(np.maximum(0.0, 1.0 - along * along))
    half = {
        SPHERE: np.full(3, size[0]),
        CAPSULE: size[0] + size[1] * along,
        ELLIPSOID: np.sqrt((R * R) @ (size * size)),
        CYLINDER: size[1] * along + size[0] * across,
        BOX: np.abs(R) @ size,
    }[kind]
    yield _box(p - half, p + half)


def _faces(m: Any, k: int) -> np.ndarray:
    first = m.mesh_faceadr[k]
    return np.array(m.mesh_face[first : first + m.mesh_facenum[k]])


def _sliced(corners: np.ndarray, faces: np.ndarray) -> Iterator[Box]:
    """Yield boxes that enclose a surface in slices along its longest edge."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    axis = int(np.argmax(high - low))
    edges = np.linspace(low[axis], high[axis], SLICES + 1)
    sides = corners[np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])]
    a, b = sides[:, 0], sides[:, 1]
    for lower, upper in pairwise(edges):
        inside = [corners[(corners[:, axis] >= lower) & (corners[:, axis] <= upper)]]
        for plane in (lower, upper):
            cut = (a[:, axis] - plane) * (b[:, axis] - plane) < 0.0
            p, q = a[cut], b[cut]
            inside.append(p + ((plane - p[:, axis]) / (q[:, axis] - p[:, axis]))[:, None] * (q - p))
        points = np.concatenate(inside)
        if len(points):
            least, most = points.min(axis=0), points.max(axis=0)
            least[axis], most[axis] = lower, upper
            yield _box(least, most)


def _box(low: np.ndarray, high: np.ndarray) -> Box:
    centre, size = 0.5 * (low + high), np.maximum(high - low, THIN)
    return tuple(float(x) for x in centre), tuple(float(x) for x in size)  # type: ignore[return-value]
