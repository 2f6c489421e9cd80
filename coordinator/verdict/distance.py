"""Distance of two shapes: lower bounds for many poses at once along a few directions, and the exact distance.

Shapes are rounded boxes; their gap along a unit vector n is |n d| - sum h_i |n a_i| - r of both (Gottschalk et al.
1996, OBBTree). The largest gap over any directions is a lower bound of the distance, also of penetrations, which are
negative. If boxes are apart, a pair of their nearest points has one on an edge, and the square of an edge's distance
from a box is convex along it, with a slope that is piecewise linear. If they overlap, the direction of the shortest
separation is a normal of a face or across a pair of edges. All sums run in a stated order, so no bit depends on a
processor.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotating import cross, dots, lengths, product, turned

Floats = NDArray[np.float64]
TINY = 1e-9
PARALLEL = 1e-12  # sine of the angle between lines
EQUAL = 1e-12  # distances [m]
STEEPEST = 1e300  # beyond all slopes
EDGES = np.array([np.roll([0, y, z], i) for i in range(3) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])  # their middles
ALONG = np.repeat(np.arange(3), 4)  # the axis of each


class Placed(NamedTuple):
    """A shape at m poses: centre (m, 3), rotation R (m, 3, 3), half edges (m, 3), radius [m]."""

    centre: Floats
    R: Floats
    half: Floats
    radius: float | Floats


class Near(NamedTuple):
    """Distances of shapes a and b at m poses (m,) [m], negative for penetration; nearest points; unit vectors from a to
    b (m, 3)."""

    distance: Floats
    a: Floats
    b: Floats
    normal: Floats


def bounds(a: Placed, b: Placed) -> Floats:
    """Return a lower bound of the distance between two shapes at each of m poses (m,) [m]."""
    found: Floats = _gaps(_directions(a, b), a, b).max(axis=0)
    return found


def bounds_between(a: tuple[Placed, Placed], b: tuple[Placed, Placed]) -> Floats:
    """Return lower bounds (m,) [m] of the distance of two shapes that translate between two poses, ignoring their
    rotation.

    Seen from a shape that does not turn, the gap along a fixed direction is concave in time while the other shape moves
    straight, so it is least at an end; the caller adds the effect of turning.
    """
    first = _directions(a[0], b[0])
    faces = [np.concatenate([_columns(x.R), _columns(y.R)], axis=1) for x, y in zip(a, b, strict=True)]
    turned_round = _along(first[:, :6], faces[0]) < 0.0
    second = np.concatenate([np.where(turned_round, -faces[1], faces[1]), first[:, 6:]], axis=1)
    return _at_both(first, second, a, b)


def bounds_along(a: tuple[Placed, Placed], b: tuple[Placed, Placed], n: Floats, n_A: Floats, n_B: Floats) -> Floats:
    """Return lower bounds (m,) [m] of the distance between two moving shapes from their gaps along given directions.

    Directions from a to b: `n` fixed in the world, `n_A` in a, `n_B` in b.
    """
    first, second = (
        np.stack([np.broadcast_to(n, x.centre.shape).T, turned(x.R, n_A).T, turned(y.R, n_B).T], axis=1)
        for x, y in zip(a, b, strict=True)
    )
    return _at_both(first, second, a, b)


def _at_both(first: Floats, second: Floats, a: tuple[Placed, Placed], b: tuple[Placed, Placed]) -> Floats:
    gaps = [_gaps(n, x, y) for n, x, y in zip((first, second), a, b, strict=True)]
    found: Floats = np.minimum(*gaps).max(axis=0)
    return found


def _columns(R: Floats) -> Floats:
    """Return rotation components (3, 3, m) in contiguous memory."""
    return R.transpose(1, 2, 0)


def _along(a: Floats, b: Floats) -> Floats:
    """Return the scalar products of vectors (3, ..., m)."""
    found: Floats = a[0] * b[0]
    found += a[1] * b[1]
    found += a[2] * b[2]
    return found


def _middles(a: Placed, b: Placed) -> Floats:
    """Return the vectors (3, m) from the centres of a to those of b."""
    return np.subtract(b.centre.T, a.centre.T, order="C")


def _directions(a: Placed, b: Placed) -> Floats:
    """Return candidate unit vectors (3, directions, m): face normals, centre line, cross products; 0 if degenerate."""
    A, B, d = _columns(a.R), _columns(b.R), _middles(a, b)
    u, v = A[:, 2], B[:, 2]
    rows = [d, d - _along(d, u) * u, d - _along(d, v) * v, cross(u.T, v.T).T]
    return _towards(d, np.concatenate([A, B, _units(np.stack(rows, axis=1), TINY)], axis=1))


def _units(n: Floats, least: float) -> Floats:
    length = np.sqrt(_along(n, n))
    found: Floats = np.where(length > least, n / np.maximum(length, least), 0.0)
    return found


def _towards(d: Floats, n: Floats) -> Floats:
    found: Floats = np.where(_along(n, d[:, None]) < 0.0, -n, n)
    return found


def _gaps(n: Floats, a: Placed, b: Placed) -> Floats:
    """Return the gaps (directions, m) along unit vectors n (3, directions, m); none along a vector 0."""
    edges = np.concatenate([_columns(x.R) * x.half.T for x in (a, b)], axis=1)
    reach = _along(n[:, :, None], edges[:, None])
    np.abs(reach, out=reach)
    gap = _along(n, _middles(a, b)[:, None]) - reach.sum(axis=1) - (np.asarray(a.radius) + b.radius)
    found: Floats = np.where(np.abs(n).sum(axis=0) > 0.5, gap, -np.inf)
    return found


def separation(a: Placed, b: Placed) -> tuple[Floats, Floats]:
    """Return the largest gap (m,) [m] between two boxes along the normals of their faces and of pairs of their edges,
    with its direction (m, 3).

    For overlapping boxes this is the negative depth of penetration.
    """
    A, B = _columns(a.R), _columns(b.R)
    crosses = np.stack([cross(A[:, i].T, B[:, j].T).T for i in range(3) for j in range(3)], axis=1)
    n = _towards(_middles(a, b), np.concatenate([A, B, _units(crosses, PARALLEL)], axis=1))
    gaps = _gaps(n, a, b)
    best = gaps.argmax(axis=0), np.arange(len(a.centre))
    return gaps[best], n.transpose(1, 2, 0)[best]


def exactly(a: Placed, b: Placed) -> Near:
    """Return distances [m], nearest points and directions of two shapes at m poses, exact to rounding.

    Of overlapping shapes, the points are those that touch last when the shapes are moved apart.
    """
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
    """Return the nearest points (m, 3) of a and b without radii, relative to the centre of a, over edges of both; the
    mean of equally near ones."""
    m, d = len(a.centre), b.centre - a.centre
    R, S = np.concatenate([a.R, b.R]), np.concatenate([b.R, a.R])  # of boxes, and of those whose edges are tried
    h, k = np.concatenate([a.half, b.half])[:, None], np.concatenate([b.half, a.half])
    back = R.transpose(0, 2, 1)
    C, middle = product(back, S), turned(back, np.concatenate([d, -d]))
    edges = middle[:, None] + turned(C[:, None], EDGES * k[:, None])
    x = _nearest_along(edges, C.transpose(0, 2, 1)[:, ALONG], k[:, ALONG, None], h)
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


def _nearest_along(p: Floats, c: Floats, k: Floats, h: Floats) -> Floats:
    """Return the points (m, n, 3) nearest to a box of half edges h (m, 1, 3) on lines p + t c (m, n, 3) with
    |t| <= k (m, n, 1): where the slope of the squared distance, linear between the planes of the faces,
    is zero.
    """
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
