"""Stretches of samples of two shapes each, with bounds of what they are apart in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from .coarse import LONGEST, Coarse
from .distance import bounds
from .together import Together

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
SIZES = (LONGEST, 16, 4, 1)  # samples in a stretch, from the first cut to the last
PIECE = 1 << 10  # stretches that are looked at together: so few that their numbers stay in the cache
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


def whole(coarse: Coarse, pairs: Sequence[tuple[int, int]], groups: Sequence[int] | None = None) -> Stretches:
    """All pairs in the longest stretches, bounded by their boxes."""
    centre, reach, moved = coarse.centre.transpose(2, 0, 1), coarse.reach.transpose(2, 0, 1), coarse.moved
    a, b = (np.array(x, np.intp) for x in zip(*pairs, strict=True))
    group = np.zeros(len(a), np.intp) if groups is None else np.array(groups, np.intp)
    square = np.zeros((len(a), len(coarse.starts)))
    deep = np.full(square.shape, -np.inf)  # of boxes that overlap, along the axis where they do least
    for x, half in zip(centre, reach, strict=True):
        apart = np.abs(x[a] - x[b]) - (half[a] + half[b])
        np.maximum(deep, apart, out=deep)
        np.maximum(0.0, apart, out=apart)
        square += apart * apart
    way = moved[a] + moved[b]
    least = np.sqrt(square) + np.minimum(deep, 0.0) - way
    i, j = np.nonzero(coarse.there[a] & coarse.there[b])
    return Stretches(a[i], b[i], coarse.starts[j], coarse.ends[j], way[i, j], least[i, j], group[i])


def in_pieces(now: Stretches, look: Callable[[Stretches], Some]) -> Some:
    """What a look at all stretches gives, taken at so many at once that little memory is needed."""
    found = [look(now.of(np.arange(i, min(i + PIECE, len(now.a))))) for i in range(0, max(1, len(now.a)), PIECE)]
    return found[0] if len(found) == 1 else joined(found)


def joined(parts: Sequence[Some]) -> Some:
    """Arrays end to end, each component in one piece of memory, and tuples and classes of them."""
    one, all_ = cast("Any", parts[0]), cast("Any", parts)
    found: Any
    if isinstance(one, np.ndarray):
        found = np.concatenate([x.T for x in all_], axis=-1).T
    elif isinstance(one, tuple):
        columns = [joined(x) for x in zip(*all_, strict=True)]
        found = type(one)(*columns) if hasattr(one, "_fields") else tuple(columns)
    else:
        found = type(one)(*(joined([getattr(x, f.name) for x in all_]) for f in fields(one)))
    return cast("Some", found)


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
    one, two, middle = a[:, None], b[:, None], ((first + last) // 2)[:, None]
    way = all_.moved(one, two, k, middle) + all_.stray(one, two, k)
    return Stretches(a, b, first, last, way.max(axis=1, initial=0.0), np.full(len(a), -np.inf), now.group[of])
