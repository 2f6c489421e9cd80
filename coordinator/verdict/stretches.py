"""Stretches of samples of two shapes each, with bounds of what they are apart in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, cast

import numpy as np
from heavylift.nodes.plan.shapes import Solid
from numpy.typing import NDArray

from .distance import bounds
from .moving import Moving
from .rotating import lengths
from .together import Together

__all__ = ["SIZES", "Stretches", "bounded", "cut", "in_pieces", "whole"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
SIZES = (64, 16, 4, 1)  # samples in a stretch, from the first cut to the last
PIECE = 1 << 14  # stretches that are looked at together
Some = TypeVar("Some")


@dataclass(frozen=True)
class Stretches:
    """Pairs of shapes (indices) over the samples from `first` to `last`, both included: by how much they move against
    each other, seen from the sample in the middle, and what they are apart at least [m]; the number of the two things
    that they are of."""

    a: Indices
    b: Indices
    first: Indices
    last: Indices
    moved: Floats
    least: Floats
    group: Indices

    @property
    def middle(self) -> Indices:
        """The samples in the middle."""
        found: Indices = (self.first + self.last) // 2
        return found

    def of(self, kept: NDArray[np.bool_] | Indices) -> Stretches:
        """Some of them."""
        a, b, first, last = self.a[kept], self.b[kept], self.first[kept], self.last[kept]
        return Stretches(a, b, first, last, self.moved[kept], self.least[kept], self.group[kept])


def whole(
    shapes: list[Moving],
    pairs: Sequence[tuple[int, int]],
    common: Floats,
    groups: Sequence[int] | None = None,
    between: tuple[int, int] | None = None,
) -> Stretches:
    """All pairs over all samples, or those from one to another, in the longest stretches, bounded by boxes along the
    world's axes; motion is taken against a common motion (n, 3)."""
    size, (first, last) = SIZES[0], between or (0, len(shapes[0].t) - 1)
    starts = np.arange(first, max(first + 1, last), size)
    ends = np.minimum(starts + size, last)
    middles = (starts + ends) // 2
    known: dict[str, Floats] = {}  # of bodies that never turn, whose shapes move alike
    moved = np.array([_excursions(s, starts, ends, middles, common, known) for s in shapes])
    centre = np.array([s.centre[middles] for s in shapes]).transpose(2, 0, 1)
    reach = np.array([_reach(s, middles) for s in shapes]).transpose(2, 0, 1)
    there = np.array([_there(s, starts, ends) for s in shapes])
    a, b = (np.array(x, np.intp) for x in zip(*pairs, strict=True))
    group = np.zeros(len(a), np.intp) if groups is None else np.array(groups, np.intp)
    square = np.zeros((len(a), len(starts)))
    for x, half in zip(centre, reach, strict=True):
        apart = np.maximum(0.0, np.abs(x[a] - x[b]) - (half[a] + half[b]))
        square += apart * apart
    way = moved[a] + moved[b]
    least = np.sqrt(square) - way
    i, j = np.nonzero(there[a] & there[b])
    return Stretches(a[i], b[i], starts[j], ends[j], way[i, j], least[i, j], group[i])


def in_pieces(now: Stretches, look: Callable[[Stretches], Some]) -> Some:
    """What a look at all stretches gives, taken at so many at once that little memory is needed."""
    found = [look(now.of(np.arange(i, min(i + PIECE, len(now.a))))) for i in range(0, max(1, len(now.a)), PIECE)]
    return found[0] if len(found) == 1 else joined(found)


def joined(parts: Sequence[Some]) -> Some:
    """Arrays end to end, and tuples and classes of them."""
    one, all_ = cast("Any", parts[0]), cast("Any", parts)
    found: Any
    if isinstance(one, np.ndarray):
        found = np.concatenate(all_)
    elif isinstance(one, tuple):
        columns = [joined(x) for x in zip(*all_, strict=True)]
        found = type(one)(*columns) if hasattr(one, "_fields") else tuple(columns)
    else:
        found = type(one)(*(joined([getattr(x, f.name) for x in all_]) for f in fields(one)))
    return cast("Some", found)


def _reach(s: Moving, k: Indices) -> Floats:
    """(m, 3) half edges of the box along the world's axes around a shape."""
    if not isinstance(s.shape, Solid):
        along: Floats = np.abs(s.turn[np.minimum(k, len(s.turn) - 1)]) / 2 + s.radius
        return along
    R, half = s.axes(k)
    found: Floats = (np.abs(R) * half[:, None, :]).sum(axis=2) + s.radius
    return found


def _there(s: Moving, starts: Indices, ends: Indices) -> NDArray[np.bool_]:
    if s.there is None:
        return np.ones(len(starts), bool)
    found: NDArray[np.bool_] = np.logical_or.reduceat(s.there, starts) | s.there[ends]
    return found


def _excursions(
    s: Moving, starts: Indices, ends: Indices, middles: Indices, common: Floats, known: dict[str, Floats]
) -> Floats:
    """(m,) by how much points of a shape leave their places at the middle of each stretch, against a common motion."""
    straight = s.shape.body if isinstance(s.shape, Solid) and len(s.turn) == 1 else ""
    if straight in known:
        return known[straight]
    inside, counts = slice(starts[0], ends[-1] + 1), np.diff(starts, append=ends[-1] + 1)
    path = s.centre - common
    moved = lengths(path[inside] - _repeated(path[middles], counts))
    last = lengths(path[ends] - path[middles])  # the first of the next
    if len(s.turn) > 1:
        moved += s.spun(s.turn[inside], _repeated(s.turn[middles], counts))
        last += s.spun(s.turn[ends], s.turn[middles])
    if len(s.stray):
        stray = np.zeros(len(path))
        stray[:-1] = s.stray
        np.maximum(stray[1:], s.stray, out=stray[1:])
        moved += stray[inside]
    found: Floats = np.maximum(np.maximum.reduceat(moved, starts - starts[0]), last)
    if straight:
        known[straight] = found
    return found


def _repeated(x: Floats, counts: Indices) -> Floats:
    """Rows of x (m, k), each as often as said; each column in one piece of memory."""
    found: Floats = np.repeat(np.ascontiguousarray(x.T), counts, axis=1).T
    return found


def bounded(all_: Together, now: Stretches) -> Stretches:
    """Stretches with the bound of the gap at their middles."""
    if not len(now.a):
        return now
    gap = bounds(all_.placed(now.a, now.middle), all_.placed(now.b, now.middle))
    return replace(now, least=np.maximum(now.least, gap - now.moved))


def cut(all_: Together, now: Stretches, size: int) -> Stretches:
    """The stretches in pieces of so many samples, each bounded by itself."""
    pieces = np.maximum(-(-(now.last - now.first) // size), 1)
    of = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(of)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = now.first[of] + number * size
    last = np.minimum(first + size, now.last[of])
    a, b = now.a[of], now.b[of]
    kept = all_.there(a, first, last) & all_.there(b, first, last)
    first, last, a, b, of = first[kept], last[kept], a[kept], b[kept], of[kept]
    k = np.minimum(first[:, None] + np.arange(size + 1), last[:, None])
    one, two, middle = a[:, None], b[:, None], np.broadcast_to(((first + last) // 2)[:, None], k.shape)
    way = all_.moved(one, two, k, middle) + all_.stray(one, two, k)
    return Stretches(a, b, first, last, way.max(axis=1, initial=0.0), np.full(len(a), -np.inf), now.group[of])
