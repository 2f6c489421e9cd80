"""The distance of two shapes: bounds for many poses at once by separating axes, and exactly by Coal for one pose.

Shapes are rounded boxes, so along a unit vector n they are apart by |n d| - sum h_i |n a_i| - r of both (Gottschalk et
al. 1996, OBBTree); the largest over any directions bounds the distance, penetrations too, which are negative.  Coal
(Pan et al. 2012, FCL; Montaut et al. 2022) gives the distance itself with the nearest points.  Where shapes touch to
its tolerance its penetration algorithm may fail; the bound, which is exact for boxes, then stands for it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotating import cross

Floats = NDArray[np.float64]
TINY = 1e-9
TOLERANCE = 1e-6  # of Coal [m]


class Placed(NamedTuple):
    """A shape at m poses: centre (m, 3), R (m, 3, 3), half edges (m, 3), radius [m]."""

    centre: Floats
    R: Floats
    half: Floats
    radius: float | Floats


class Near(NamedTuple):
    """Distance [m], negative in a penetration; the nearest or deepest points in the world; direction from a to b."""

    distance: float
    a: Floats
    b: Floats
    normal: Floats


def bounds(a: Placed, b: Placed) -> Floats:
    """(m,) what the distances are at least."""
    d = b.centre - a.centre
    found: Floats = _gaps(_directions(a, b, d), a, b, d).max(axis=1)
    return found


def bounds_between(a: tuple[Placed, Placed], b: tuple[Placed, Placed]) -> Floats:
    """(m,) what the gaps are at least at the first poses and at the second, along directions that turn with the shapes.

    Seen from a shape that does not turn the gap along a fixed direction is concave in time while the other goes
    straight, so it is least at an end; what turning adds is the caller's.
    """
    d = b[0].centre - a[0].centre
    first = _directions(a[0], b[0], d)
    second = np.concatenate([a[1].R.transpose(0, 2, 1), b[1].R.transpose(0, 2, 1), first[:, 6:]], axis=1)
    second[:, :6] *= np.where(
        (first[:, :6] * np.concatenate([a[0].R, b[0].R], 2).transpose(0, 2, 1)).sum(2) < 0, -1, 1
    )[:, :, None]
    return _at_both(first, second, a, b)


def bounds_along(a: tuple[Placed, Placed], b: tuple[Placed, Placed], n: Floats, n_A: Floats, n_B: Floats) -> Floats:
    """(m,) the same along one direction from a to b alone: as it is in the world, in the first or the second shape."""
    first, second = (
        np.stack([np.broadcast_to(n, (len(x.centre), 3)), x.R @ n_A, y.R @ n_B], axis=1)
        for x, y in zip(a, b, strict=True)
    )
    return _at_both(first, second, a, b)


def _at_both(first: Floats, second: Floats, a: tuple[Placed, Placed], b: tuple[Placed, Placed]) -> Floats:
    gaps = [_gaps(n, x, y, y.centre - x.centre) for n, x, y in zip((first, second), a, b, strict=True)]
    found: Floats = np.minimum(*gaps).max(axis=1)
    return found


def _directions(a: Placed, b: Placed, d: Floats) -> Floats:
    """(m, directions, 3) that are tried."""
    n = np.concatenate([a.R, b.R, _candidates(d, a.R[:, :, 2], b.R[:, :, 2])], axis=2).transpose(0, 2, 1)
    found: Floats = n * np.where((n @ d[:, :, None]) < 0.0, -1.0, 1.0)
    return found


def _gaps(n: Floats, a: Placed, b: Placed, d: Floats) -> Floats:
    """(m, directions) gaps along unit vectors n (m, directions, 3); along 0 there is none to speak of."""
    mine, theirs = a.R * a.half[:, None, :], b.R * b.half[:, None, :]  # half edges as columns
    gap = (n @ d[:, :, None])[:, :, 0] - np.abs(n @ mine).sum(axis=2) - np.abs(n @ theirs).sum(axis=2)
    round_ = np.broadcast_to(np.asarray(a.radius) + np.asarray(b.radius), len(d))[:, None]
    found: Floats = np.where(np.abs(n).sum(axis=2) > 0.5, gap - round_, -np.inf)
    return found


def _candidates(d: Floats, u: Floats, v: Floats) -> Floats:
    """(m, 3, 4) unit columns: between the middles, also square to each third axis, and square to both of them."""
    across = cross(u, v)
    rows = [d, d - (d * u).sum(axis=1)[:, None] * u, d - (d * v).sum(axis=1)[:, None] * v, across]
    n = np.stack(rows, axis=2)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    unit: Floats = np.where(length > TINY, n / np.maximum(length, TINY), 0.0)
    return unit


def separation(a: Placed, b: Placed) -> tuple[float, Floats]:
    """Largest gap of two shapes along the normals of all faces and across all pairs of edges, and its direction: the
    distance itself of two boxes that overlap."""
    d = b.centre[0] - a.centre[0]
    A, B = a.R[0], b.R[0]
    crosses = np.cross(A.T[:, None, :], B.T[None, :, :]).reshape(9, 3)
    length = np.linalg.norm(crosses, axis=1)
    n = np.concatenate([A.T, B.T, crosses[length > 1e-6] / length[length > 1e-6, None]])
    reach = np.abs(n @ A) @ a.half[0] + np.abs(n @ B) @ b.half[0] + a.radius + b.radius
    gap = np.abs(n @ d) - reach
    k = int(np.argmax(gap))
    return float(gap[k]), n[k] * (1.0 if n[k] @ d >= 0.0 else -1.0)


def exactly(a: Placed, b: Placed) -> Near:
    """The distance of two shapes at one pose each (m = 1)."""
    import coal

    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    distance = coal.distance(*_made(coal, a), *_made(coal, b), request, result)
    p, q = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
    if distance > TOLERANCE:
        return Near(distance, p, q, (q - p) / max(distance, TINY))
    gap, normal = separation(a, b)
    if gap <= distance:
        return Near(distance, p, q, np.array(result.normal))
    middle = _support(a, normal)
    return Near(gap, middle, middle + gap * normal, normal)


def _support(a: Placed, n: Floats) -> Floats:
    """The middle of what of a shape is farthest along n."""
    along = a.R[0].T @ n
    point: Floats = a.centre[0] + a.R[0] @ (np.where(np.abs(along) > 1e-6, np.sign(along), 0.0) * a.half[0])
    return point + float(a.radius) * n


def _made(coal: Any, s: Placed) -> tuple[Any, Any]:
    """Coal's shape and pose of a rounded box: a box, a capsule along the third axis, or a ball."""
    x, y, z = s.half[0].tolist()
    radius = float(s.radius)
    if radius == 0.0:
        shape = coal.Box(2 * x, 2 * y, 2 * z)
    elif z > 0.0:
        shape = coal.Capsule(radius, 2 * z)
    else:
        shape = coal.Sphere(radius)
    return shape, coal.Transform3s(s.R[0], s.centre[0])
