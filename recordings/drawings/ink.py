"""Elements of a drawn view: lines, fills, texts and dimensions, in paper coordinates [mm] with y upwards; each view has
its own scale."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Style = Literal["crane", "block", "deck", "hook", "frame", "world", "rope", "thin", "axis", "near", "frame line"]
TEXT = 2.2  # height of letters [mm]
WIDE = 0.62  # of it: a letter
TICK, GAP, OVER = 0.8, 0.8, 1.2  # [mm] half a slash; from a point to its extension line; of that beyond the dimension
ROW = 6.5  # between dimension lines [mm]
SCALES = [a * 10.0**k for k in range(1, 5) for a in (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.5)]


class Path(NamedTuple):
    """A polyline through points (n, 2) or, if filled, the outline of an area."""

    points: Floats
    style: Style
    closed: bool = False


class Text(NamedTuple):
    """A text placed at a point on paper; `angle` of its baseline [deg]."""

    at: tuple[float, float]
    words: str
    anchor: Literal["start", "middle", "end"] = "start"
    angle: float = 0.0
    size: float = TEXT
    bold: bool = False


class DimensionLine(NamedTuple):
    """A horizontal (h) or vertical (v) dimension between two points; its dimension line is at y or x = `at`."""

    a: tuple[float, float]
    b: tuple[float, float]
    at: float
    way: Literal["h", "v"]
    words: str


Item = Path | Text | DimensionLine


@dataclass
class View:
    """A view drawn at scale 1 : `scale`: its items in their own coordinates, and the place of their origin."""

    title: str
    scale: float
    items: list[Item] = field(default_factory=list)
    place: tuple[float, float] = (0.0, 0.0)
    centre: tuple[float, float] = (0.0, 0.0)  # of its items, where it keeps its place at another scale

    def paper(self, points: Floats) -> Floats:
        """Convert points (..., 2) [m] to positions on paper [mm]."""
        out: Floats = points * 1e3 / self.scale
        return out

    def length(self, mm: float) -> str:
        """Return the true length of a distance on paper [mm], as text in metres."""
        return f"{abs(mm) * self.scale / 1e3:.2f}"

    def across(self, a: Floats, b: Floats, at: float, words: str = "") -> None:
        """Add a horizontal dimension between two points on paper, with its dimension line at y = `at`."""
        self.items.append(DimensionLine(_pair(a), _pair(b), at, "h", words + self.length(b[0] - a[0])))

    def upright(self, a: Floats, b: Floats, at: float, words: str = "") -> None:
        """Add a vertical dimension between two points on paper, with its dimension line at x = `at`."""
        self.items.append(DimensionLine(_pair(a), _pair(b), at, "v", words + self.length(b[1] - a[1])))


def _pair(p: Floats) -> tuple[float, float]:
    return float(p[0]), float(p[1])


def fitting(width: float, height: float, room: tuple[float, float]) -> float:
    """Return the largest standard scale at which an area of width x height [m] fits into `room` [mm] on paper."""
    fits = (s for s in SCALES if width * 1e3 / s <= room[0] and height * 1e3 / s <= room[1])
    return next(fits, SCALES[-1])


def hull(points: Floats) -> Floats:
    """Return the convex hull (n, 2) of points, by Andrew's monotone chain."""
    found = sorted(set(map(tuple, np.round(points, 6).tolist())))
    sides = []
    for row in (found, found[::-1]):
        side: list[tuple[float, ...]] = []
        for p in row:
            while len(side) > 1 and _turn(side[-2], side[-1], p) <= 0.0:
                side.pop()
            side.append(p)
        sides += side[:-1]
    return np.array(sides or found)


def within(outline: Floats, p: Floats) -> bool:
    """Return whether the point p is inside a convex counterclockwise outline."""
    along, to = np.roll(outline, -1, axis=0) - outline, p - outline
    return bool((along[:, 0] * to[:, 1] >= along[:, 1] * to[:, 0]).all())


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def clipped(outline: Floats, low: Floats, high: Floats) -> Floats:
    """Return the part of a convex outline inside a box (Sutherland and Hodgman); empty if it is outside the box."""
    for axis in (0, 1):
        for sign, bound in ((1.0, high[axis]), (-1.0, -low[axis])):
            kept = list[Floats]()
            for p, q in zip(outline, np.roll(outline, -1, axis=0), strict=True):
                a, b = bound - sign * p[axis], bound - sign * q[axis]
                kept += [p] if a >= 0.0 else []
                kept += [p + (q - p) * a / (a - b)] if a * b < 0.0 else []
            outline = np.array(kept).reshape(-1, 2)
    return outline


def points_of(item: Item) -> Floats:
    if isinstance(item, Path):
        return item.points
    if isinstance(item, DimensionLine):
        return np.concatenate([points_of(part) for part in parts(item)])
    width = WIDE * item.size * len(item.words)
    start = {"start": 0.0, "middle": -width / 2, "end": -width}[item.anchor]
    x, y = item.at
    if item.angle:
        return np.array([[x - item.size, y + start], [x, y + start + width]])
    return np.array([[x + start, y], [x + start + width, y + item.size]])


def parts(item: Item) -> Sequence[Path | Text]:
    """Return the lines and texts of which an item of a drawing consists."""
    return _dimension(item) if isinstance(item, DimensionLine) else (item,)


def _dimension(d: DimensionLine) -> list[Path | Text]:
    """Return a dimension as lines with slashes, and its number, which is placed beside the line if there is no room on
    it."""
    flip = d.way == "v"  # drawn as if it were horizontal, then mirrored at the diagonal
    a, b = sorted((d.a[::-1], d.b[::-1])) if flip else sorted((d.a, d.b))
    ends = [(a[0], d.at), (b[0], d.at)]
    lines = [[p, (p[0], d.at + (OVER if d.at > p[1] else -OVER))] for p in (_off(a, d.at), _off(b, d.at))]
    wide = WIDE * TEXT * len(d.words)
    inside = b[0] - a[0] > wide + 1.0
    lines.append([ends[0], ends[1] if inside else (b[0] + wide + 2.5, d.at)])
    lines += [[(x - TICK, y - TICK), (x + TICK, y + TICK)] for x, y in ends]
    middle = (a[0] + b[0]) / 2 if inside else b[0] + 1.6 + wide / 2
    if flip:
        words = Text((d.at - 0.7, middle), d.words, "middle", 90.0)
        return [*(Path(np.array(line)[:, ::-1], "thin") for line in lines), words]
    return [*(Path(np.array(line), "thin") for line in lines), Text((middle, d.at + 0.7), d.words, "middle")]


def _off(p: tuple[float, ...], at: float) -> tuple[float, float]:
    step = min(GAP, abs(at - p[1]))
    return p[0], p[1] + (step if at > p[1] else -step)
