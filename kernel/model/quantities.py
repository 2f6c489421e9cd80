"""Formulas of the scalar signals, one for each quantity, traced for thresholds and computed from samples.

A formula takes positions of points, numbers, and named values of a scene: tensions and lengths of ropes, coordinates,
angles, wind speeds. `description.signals` defines the quantities.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.compiler.symbol import Scalar, Scalars, maximum, minimum, select, sqrt
from heavylift.kernel.description.mechanics import Line, Point, System
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.errors import KernelError

from .group_loads import (
    ABOUT_JOINTS,
    ON_BASES,
    TIPS,
    carried_group,
    corner_load,
    joint_moment,
    moved_point,
    starting_moment,
    tipping,
    track_pressure,
)

Places: TypeAlias = Sequence[Scalars]  # of points, each x, y, z
BEYOND = 1e-3  # of the last tension of a chart: what may hang beyond its last radius
PROJECTIONS = 10  # by which nearest points are found
TOUCH = 1e-9  # [m] between them where boxes touch


@dataclass(frozen=True)
class FormulaContext:
    """Arguments of a signal's formula: positions of points, numbers, and named values such as tensions."""

    places: Places
    numbers: Scalars
    values: Scalars
    lines: Sequence[int] = ()  # how many each of its ropes has


def _sum(x: FormulaContext) -> Any:
    return sum(x.values, 0.0)


def _one(x: FormulaContext) -> Any:
    return x.values[0]


def _radius(x: FormulaContext) -> Any:
    a, b = x.places
    dx, dy = a[0] - b[0], a[1] - b[1]
    return sqrt(dx * dx + dy * dy)


def _moment(x: FormulaContext) -> Any:
    tension, radius, chart = _sum(x), _radius(x), x.numbers[1:]
    allowed = chart[-1] * BEYOND
    for i in reversed(range(0, len(chart), 2)):
        allowed = select(radius <= chart[i], chart[i + 1], allowed)
    return select(tension > x.numbers[0], tension / allowed, 0.0)


def _use(x: FormulaContext) -> Any:
    found, *others = [tension * number for tension, number in zip(x.values, x.numbers, strict=True)]
    for other in others:
        found = maximum(found, other)
    return found


def _load(x: FormulaContext) -> Any:
    return _sum(x) * x.numbers[0] - x.numbers[1]


def _use_by_place(x: FormulaContext) -> Any:
    y, chart = x.places[0][1], x.numbers[2:]
    allowed = chart[-1]
    for i in reversed(range(2, len(chart), 2)):
        (a, low), (b, high) = chart[i - 2 : i], chart[i : i + 2]
        allowed = select(y <= b, low + (high - low) * ((y - a) / (b - a)), allowed)
    return _load(x) / select(y <= chart[0], chart[1], allowed)


def _aside(x: FormulaContext, axis: int) -> tuple[Scalar, Scalar]:
    """Return horizontal and vertical distance of a rope's lower end from its upper end, weighted over its lines."""
    out: Scalar = 0.0
    drop: Scalar = 0.0
    for i, share in enumerate(x.numbers):
        above, below = x.places[2 * i], x.places[2 * i + 1]
        out += share * (below[axis] - above[axis])
        drop += share * (above[2] - below[2])
    return out, drop


def _off_lead(x: FormulaContext) -> Any:
    (dx, drop), (dy, _) = _aside(x, 0), _aside(x, 1)
    return atan2(sqrt(dx * dx + dy * dy), drop)


def _boom_lead(x: FormulaContext, side: bool) -> Any:
    (dx, drop), (dy, _) = _aside(x, 0), _aside(x, 1)
    *ends, axis = x.places
    u, v = (sum((k * (p[i] - axis[i]) for k, p in zip(x.numbers, ends[::2], strict=True)), 0.0) for i in (0, 1))
    return atan2((u * dy - v * dx if side else u * dx + v * dy) / sqrt(u * u + v * v), drop)


def _slope(x: FormulaContext) -> Any:
    (dx, drop), (dy, _) = _aside(x, 0), _aside(x, 1)
    return atan2(sqrt(dx * dx + dy * dy), abs(drop))


def _vertical_load(x: FormulaContext) -> Any:
    line = FormulaContext(x.places, x.numbers[1:], ())
    return x.numbers[0] * _one(x) * (abs(_aside(line, 0)[1]) / _span(line))


def _height_over(x: FormulaContext) -> Any:
    p, o, tip = x.places
    return _dot([a - b for a, b in zip(p, o, strict=True)], [a - b for a, b in zip(tip, o, strict=True)])


def _overhang(x: FormulaContext) -> Any:
    p, o, *tips = x.places
    u, v, w = (
        _dot([a - b for a, b in zip(p, o, strict=True)], [a - b for a, b in zip(t, o, strict=True)]) for t in tips
    )
    return maximum(minimum(-w, maximum(abs(u) - x.numbers[0], abs(v) - x.numbers[1])), 0.0)


def _span(x: FormulaContext) -> Any:
    """Return the length of the vector sum of a rope's lines, weighted by their shares."""
    (dx, drop), (dy, _) = _aside(x, 0), _aside(x, 1)
    return sqrt(dx * dx + dy * dy + drop * drop)


def _pull(x: FormulaContext, own: int = 2) -> Any:
    line = FormulaContext(x.places, x.numbers[own:], ())
    return x.numbers[0] * _one(x) + x.numbers[1] * (_span(line) / sum(line.numbers, 0.0))


def _side(x: FormulaContext, axis: int) -> Any:
    total: Scalar = 0.0
    at = 0
    for tension, count in zip(x.values, x.lines, strict=True):
        line = FormulaContext(x.places[2 * at : 2 * (at + count)], x.numbers[at : at + count], ())
        total += tension * _aside(line, axis)[0] / _span(line)
        at += count
    return total


def _gap(x: FormulaContext) -> Any:
    """Return the largest separation along face normals or the line of nearest points, a lower bound of the distance
    (separating axis theorem; Gottschalk, Lin, Manocha, OBBTree, 1996). Nearest points by alternating projections (von
    Neumann 1950; Bauschke, Borwein 1993)."""
    boxes = [_box(x.places[4 * i : 4 * i + 4], x.numbers[3 * i : 3 * i + 3]) for i in (0, 1)]
    gap = _apart(boxes, boxes[0].axes[0])
    for n in (*boxes[0].axes[1:], *boxes[1].axes):
        gap = maximum(gap, _apart(boxes, n))
    p = boxes[1].middle
    q = boxes[0].nearest(p)
    for _ in range(PROJECTIONS):
        p = boxes[1].nearest(q)
        q = boxes[0].nearest(p)
    distance = [b - a for a, b in zip(q, p, strict=True)]
    length = sqrt(_dot(distance, distance))
    some = 1.0 / maximum(length, TOUCH)
    return select(length > TOUCH, maximum(gap, _apart(boxes, [some * w for w in distance])), gap)


@dataclass(frozen=True)
class _Box:
    middle: Scalars
    axes: Sequence[Scalars]
    halves: Scalars

    def nearest(self, p: Scalars) -> Scalars:
        """Return the point inside or on this box that is nearest to the point p."""
        found, away = list(self.middle), [a - b for a, b in zip(p, self.middle, strict=True)]
        for axis, half in zip(self.axes, self.halves, strict=True):
            far = minimum(maximum(_dot(away, axis), -half), half)
            found = [a + far * b for a, b in zip(found, axis, strict=True)]
        return found


def _box(places: Places, halves: Scalars) -> _Box:
    o = places[0]
    return _Box(o, [[tip[i] - o[i] for i in range(3)] for tip in places[1:]], halves)


def _apart(boxes: list[_Box], n: Scalars) -> Any:
    """Return the separation of two boxes along the direction n; negative if they overlap along it."""
    gap = abs(_dot([b - a for a, b in zip(boxes[0].middle, boxes[1].middle, strict=True)], n))
    for box in boxes:
        for axis, half in zip(box.axes, box.halves, strict=True):
            gap = gap - half * abs(_dot(axis, n))
    return gap


def _dot(a: Scalars, b: Scalars) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@dataclass(frozen=True)
class QuantityFormula:
    """An entry of the table of signal quantities: the formula, and the fields that a signal must have for it."""

    formula: Callable[[FormulaContext], Scalar]
    needs: tuple[str, ...] = ()


ROWS: dict[str, QuantityFormula] = {
    "height": QuantityFormula(lambda x: x.places[0][2], ("point",)),
    "height difference": QuantityFormula(lambda x: x.places[0][2] - x.places[1][2], ("point", "origin")),
    "height over": QuantityFormula(_height_over, ("point", "origin")),
    "overhang": QuantityFormula(_overhang, ("point", "origin")),
    "radius": QuantityFormula(_radius, ("point", "origin")),
    "gap": QuantityFormula(_gap, ("point", "origin")),
    "tension": QuantityFormula(_sum, ("rope",)),
    "length": QuantityFormula(_one, ("rope",)),
    "load": QuantityFormula(_load, ("rope",)),
    "use": QuantityFormula(_use, ("rope",)),
    "use by place": QuantityFormula(_use_by_place, ("rope", "point")),
    "moment": QuantityFormula(_moment, ("rope", "point", "origin")),
    "swing along": QuantityFormula(lambda x: atan2(*_aside(x, 0)), ("rope",)),
    "swing across": QuantityFormula(lambda x: atan2(*_aside(x, 1)), ("rope",)),
    "boom lead": QuantityFormula(lambda x: _boom_lead(x, side=False), ("rope", "origin")),
    "side lead": QuantityFormula(lambda x: _boom_lead(x, side=True), ("rope", "origin")),
    "off-lead": QuantityFormula(_off_lead, ("rope",)),
    "slope": QuantityFormula(_slope, ("rope",)),
    "vertical load": QuantityFormula(_vertical_load, ("rope",)),
    "pull": QuantityFormula(_pull, ("rope",)),
    "reserve": QuantityFormula(lambda x: x.numbers[2] / _pull(x, 3), ("rope",)),
    "side along": QuantityFormula(lambda x: _side(x, 0), ("rope",)),
    "side across": QuantityFormula(lambda x: _side(x, 1), ("rope",)),
    "place along": QuantityFormula(lambda x: x.places[0][0] - x.numbers[0], ("point",)),
    "place across": QuantityFormula(lambda x: x.places[0][1] - x.numbers[0], ("point",)),
    "track pressure": QuantityFormula(track_pressure, ("point",)),
    "corner load": QuantityFormula(corner_load, ("point",)),
    "tipping": QuantityFormula(tipping, ("point",)),
    "joint moment": QuantityFormula(joint_moment, ("joint",)),
    "starting moment": QuantityFormula(starting_moment, ("joint",)),
    "angle": QuantityFormula(_one),
    "joint": QuantityFormula(_one),
    "speed": QuantityFormula(_one),
    "wind": QuantityFormula(_one),
}
SIDES = ("side along", "side across")
LEADS = ("boom lead", "side lead")
LINED = (  # quantities of the lines of ropes
    "swing along", "swing across", *LEADS, "off-lead", "slope", "vertical load", "pull", "reserve", *SIDES,
)  # fmt: skip
OF_GROUPS = {**ON_BASES, **ABOUT_JOINTS}  # of all bodies that a base or joint carries
COUNTS = {"gap": 6, "overhang": 2, "load": 2, "vertical load": 1, "pull": 2, "reserve": 3}  # numbers it has
COUNTS |= {"place along": 1, "place across": 1, **OF_GROUPS}


def scalar(h: ScalarSignal, places: Places, numbers: Scalars, values: Scalars, lines: Sequence[int] = ()) -> Scalar:
    """Return the value of a scalar signal by its formula, from positions of points, numbers and named values."""
    return ROWS[h.quantity].formula(FormulaContext(places, numbers, values, lines))


def points(h: ScalarSignal, system: System) -> tuple[Point, ...]:
    """Return the points whose positions enter the formula of a signal."""
    if h.quantity in LINED:
        more = (h.origin,) if h.quantity in LEADS and h.origin else ()
        return (*(p for rope in _lines(h, system) for line in rope for p in (line.a, line.b)), *more)
    if h.quantity in OF_GROUPS:
        return carried_group(h, system).points
    given = [p for p in (h.point, h.origin)[: _places(h)] if p is not None]
    if h.quantity == "gap":
        return tuple(moved_point(p, d) for p in given for d in TIPS)
    tips = {"height over": TIPS[3:], "overhang": TIPS[1:]}.get(h.quantity, ())
    given += [moved_point(given[1], tip) for tip in tips]
    return tuple(given)


def numbers(h: ScalarSignal, system: System) -> tuple[float, ...]:
    """Return the numbers in the formula of a signal, such as its chart, weights of bodies, factors of rope lines."""
    if h.quantity in OF_GROUPS:
        return (*h.numbers, *carried_group(h, system).numbers)
    shares = (line.share for rope in _lines(h, system) for line in rope) if h.quantity in LINED else ()
    return (*h.numbers, *shares)


def lines(h: ScalarSignal, system: System) -> tuple[int, ...]:
    """Return how many straight lines each rope of a load signal has."""
    if h.quantity in OF_GROUPS:
        return tuple(map(len, carried_group(h, system).ropes.values()))
    return tuple(map(len, _lines(h, system))) if h.quantity in SIDES else ()


def names(h: ScalarSignal, system: System) -> tuple[str, ...]:
    """Return the names of the ropes, joints or other elements whose values enter the formula of a signal."""
    if h.quantity in OF_GROUPS:
        return (*carried_group(h, system).ropes,)
    if h.quantity in ("tension", "load", "moment", "use", "use by place", *SIDES):
        return h.ropes
    if h.quantity in ("length", "vertical load", "pull", "reserve"):
        return h.ropes[:1]
    return (h.of,) if h.quantity in ("angle", "joint", "speed", "wind") else ()


def check_signal(h: ScalarSignal, system: System, label: str) -> None:
    """Raise KernelError for a signal without the fields that its quantity needs."""
    a = f"an {h.quantity}" if h.quantity[0] in "aeiou" else f"a {h.quantity}"
    line = h.quantity in LINED and h.point and h.origin
    given = {"rope": h.ropes or line, "joint": h.of, "point": h.point, "origin": h.origin}
    for need in (need for need in ROWS[h.quantity].needs if not given[need]):
        raise KernelError(f"{label}: {a} needs {'an' if need == 'origin' else 'a'} {need}; give one")
    for rope in h.ropes:
        if rope not in {x.name for x in system.all_ropes}:
            raise KernelError(f"{label}: there is no rope '{rope}'")
    if len(h.numbers) != COUNTS.get(h.quantity, len(h.numbers)):
        raise KernelError(f"{label}: {a} needs {COUNTS[h.quantity]} values in `numbers`, not {len(h.numbers)}")
    if h.quantity == "moment" and (len(h.numbers) < 3 or len(h.numbers) % 2 == 0 or min(h.numbers[2::2]) <= 0.0):
        raise KernelError(
            f"{label}: `numbers` must be the tension of the empty hook, then a chart: pairs (radius, tension > 0)"
        )
    if h.quantity == "use" and len(h.numbers) != len(h.ropes):
        raise KernelError(
            f"{label}: a utilisation needs a limit for each of {len(h.ropes)} ropes, not {len(h.numbers)}"
        )
    rising = all(a < b for a, b in pairwise(h.numbers[2::2]))
    if h.quantity == "use by place" and (
        len(h.numbers) < 4 or len(h.numbers) % 2 or min(h.numbers[3::2]) <= 0.0 or not rising
    ):
        raise KernelError(
            f"{label}: `numbers` must be factor and offset of the load, then pairs (place, load > 0) by place"
        )
    if h.quantity == "wind" and h.of not in {x.name for x in system.forces}:
        raise KernelError(f"{label}: there is no wind '{h.of}'")
    if h.quantity in LINED:
        _lines(h, system)


def _places(h: ScalarSignal) -> int:
    return sum(need in ("point", "origin") for need in ROWS[h.quantity].needs)


def _lines(h: ScalarSignal, system: System) -> tuple[tuple[Line, ...], ...]:
    """Return the lines of the signal's ropes that count, or the line from origin to point."""
    if h.point and h.origin and h.quantity not in LEADS:
        return ((Line(h.origin, h.point),),)
    known = {rope.name: rope.lines for rope in system.straight_ropes}
    asked = h.ropes if h.quantity in SIDES else h.ropes[:1]
    for rope in asked or ("",):
        if rope not in known:
            raise KernelError(
                f"signal '{h.quantity}': there is no rope '{rope}' over straight lines; name one that has no sheaves"
            )
    on = h.point and h.point.body
    return tuple(tuple(x for x in known[rope] if on is None or on in (x.a.body, x.b.body)) for rope in asked)
