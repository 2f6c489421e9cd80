"""The distance of two shapes: bounds for many poses at once along a few directions, and the distance itself.

Shapes are rounded boxes, so along a unit vector n they are apart by |n d| - sum h_i |n a_i| - r of both (Gottschalk et
al. 1996, OBBTree); the largest over any directions bounds the distance, penetrations too, which are negative.  Where
boxes are apart, a pair of their nearest points has one on an edge, and the square of an edge's distance from a box is
convex along it, with a slope that is piecewise linear.  Where they overlap, one of the normals of faces and across
pairs of edges is the direction of the shortest way out.  All sums run in a stated order, so no bit depends on a
processor.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotating import cross, dots, lengths, product, turned

Floats = NDArray[np.float64]
TINY = 1e-9
PARALLEL = 1e-12  # sine of the angle between lines
EQUAL = 1e-12  # distances [m]
STEEPEST = 1e300
EDGES = np.array([np.roll([0, y, z], i) for i in range(3) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])  # their middles
ALONG = np.repeat(np.arange(3), 4)  # the axis of each


class Placed(NamedTuple):
    """A shape at m poses: centre (m, 3), R (m, 3, 3), half edges (m, 3), radius [m]."""

    centre: Floats
    R: Floats
    half: Floats
    radius: float | Floats


class Near(NamedTuple):
    """Distances (m,) [m], negative in a penetration; nearest or deepest points in the world and directions from a to b
    (m, 3)."""

    distance: Floats
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
        np.stack([np.broadcast_to(n, (len(x.centre), 3)), turned(x.R, n_A), turned(y.R, n_B)], axis=1)
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
    found: Floats = n * np.where(dots(n, d[:, None]) < 0.0, -1.0, 1.0)[:, :, None]
    return found


def _gaps(n: Floats, a: Placed, b: Placed, d: Floats) -> Floats:
    """(m, directions) gaps along unit vectors n (m, directions, 3); along 0 there is none to speak of."""
    gap = dots(n, d[:, None])
    for x in (a, b):
        for i in range(3):
            gap -= x.half[:, i, None] * np.abs(dots(n, x.R[:, None, :, i]))
    round_ = np.broadcast_to(np.asarray(a.radius) + np.asarray(b.radius), len(d))[:, None]
    found: Floats = np.where(np.abs(n).sum(axis=2) > 0.5, gap - round_, -np.inf)
    return found


def _candidates(d: Floats, u: Floats, v: Floats) -> Floats:
    """(m, 3, 4) unit columns: between the middles, also square to each third axis, and square to both of them."""
    across = cross(u, v)
    rows = [d, d - (d * u).sum(axis=1)[:, None] * u, d - (d * v).sum(axis=1)[:, None] * v, across]
    n = np.stack(rows, axis=2)
    length = lengths(n.transpose(0, 2, 1))[:, None]
    unit: Floats = np.where(length > TINY, n / np.maximum(length, TINY), 0.0)
    return unit


def separation(a: Placed, b: Placed) -> tuple[Floats, Floats]:
    """(m,) largest gaps along the normals of all faces and across all pairs of edges, and (m, 3) their directions: the
    distances themselves where boxes overlap."""
    crosses = np.stack([cross(a.R[:, :, i], b.R[:, :, j]) for i in range(3) for j in range(3)], axis=1)
    length = lengths(crosses)[:, :, None]
    unit = np.where(length > PARALLEL, crosses / np.maximum(length, PARALLEL), 0.0)
    d = b.centre - a.centre
    n = np.concatenate([a.R.transpose(0, 2, 1), b.R.transpose(0, 2, 1), unit], axis=1)
    n *= np.where(dots(n, d[:, None]) < 0.0, -1.0, 1.0)[:, :, None]
    gaps = _gaps(n, a, b, d)
    k = np.arange(len(d)), gaps.argmax(axis=1)
    return gaps[k], n[k]


def exactly(a: Placed, b: Placed) -> Near:
    """The distances of shapes at m poses; the deepest points are those that still touch once the shapes are apart."""
    p, q = _nearest(a, b)
    gap = lengths(q - p)
    n = (q - p) / np.maximum(gap, TINY)[:, None]
    deep = np.flatnonzero(gap < TINY)
    if len(deep):
        one, two = (Placed(x.centre[deep], x.R[deep], x.half[deep], 0.0) for x in (a, b))
        gap[deep], n[deep] = separation(one, two)
        out = gap[deep, None] * n[deep]
        p[deep] = _nearest(one._replace(centre=one.centre + out), two)[0]
        q[deep] = p[deep] + out
    r, s = (np.broadcast_to(x.radius, gap.shape) for x in (a, b))
    return Near(gap - r - s, a.centre + p + r[:, None] * n, a.centre + q - s[:, None] * n, n)


def _nearest(a: Placed, b: Placed) -> tuple[Floats, Floats]:
    """(m, 3) nearest points of a and of b without their radii, seen from the middle of a: of edges of either from the
    other; of several pairs that are as near, their middle."""
    m, d = len(a.centre), b.centre - a.centre
    R, S = np.concatenate([a.R, b.R]), np.concatenate([b.R, a.R])  # of boxes, and of those whose edges are tried
    h, k = np.concatenate([a.half, b.half])[:, None], np.concatenate([b.half, a.half])
    back = R.transpose(0, 2, 1)
    C, middle = product(back, S), turned(back, np.concatenate([d, -d]))
    edges = middle[:, None] + turned(C[:, None], EDGES * k[:, None])
    x = _along(edges, C.transpose(0, 2, 1)[:, ALONG], k[:, ALONG, None], h)
    y = np.clip(x, -h, h)
    apart = lengths(x - y)
    x, y = turned(R[:, None], x), turned(R[:, None], y)
    x[m:] += d[:, None]
    y[m:] += d[:, None]
    apart = np.concatenate([apart[:m], apart[m:]], axis=1)
    weight = (apart <= apart.min(axis=1, keepdims=True) + EQUAL) * 1.0
    weight /= weight.sum(axis=1, keepdims=True)
    pairs = ([y[:m], x[m:]], [x[:m], y[m:]])
    p, q = ((weight[:, :, None] * np.concatenate(z, axis=1)).sum(axis=1) for z in pairs)
    return p, q


def _along(p: Floats, c: Floats, k: Floats, h: Floats) -> Floats:
    """(m, n, 3) points nearest to a box of half edges h (m, 1, 3) on lines p + t c (m, n, 3) with |t| <= k (m, n, 1):
    where the slope of the squared distance, linear between the planes of the faces, is zero."""
    steep = np.where(np.abs(c) > PARALLEL, c, np.inf)
    t = np.clip(np.concatenate([(-h - p) / steep, (h - p) / steep, -k, k], axis=2), -k, k)
    x, sides = p[:, :, None] + t[..., None] * c[:, :, None], h[:, None]
    slope = dots(x - np.clip(x, -sides, sides), c[:, :, None])
    low, high = slope <= 0.0, slope >= 0.0
    before, after = np.where(low, t, -k).max(axis=2), np.where(high, t, k).min(axis=2)
    falls, rises = np.where(low, slope, -STEEPEST).max(axis=2), np.where(high, slope, STEEPEST).min(axis=2)
    part = np.where(rises > falls, -falls / np.maximum(rises - falls, 1e-300), 0.5)
    found: Floats = p + (before + part * (after - before))[:, :, None] * c
    return found
