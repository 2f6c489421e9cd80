"""How near the parts of a lift came to one another: the smallest clearances with time and place, and what is too near.

Things are what a planner names: the block, a loader, a portal, a rope.  Two of them are kept apart by the scene's limit
or must only not go through each other (`nodes.limits.shapes.relation`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from heavylift.nodes.limits.findings import Finding
from heavylift.nodes.limits.shapes import Kind, Solid, Strand, relation
from heavylift.nodes.scene.plan import Plan
from heavylift.recordings.verdict import Clearance
from numpy.typing import NDArray

from .history import History
from .moving import Moving, matrices, moving
from .nearest import Minimum, Stretches, nearest, together, whole

__all__ = ["LIMIT", "clearances", "findings"]

SMALLEST = 10  # clearances that are told
LIMIT = 0.5  # clearance of a scene that says nothing [m]
TOUCH = 0.01  # depth of a penetration that is only numbers, such as of a pad that yields [m]
ORDER: tuple[Kind, ...] = (
    "rope", "sling", "loader", "mechanism", "block", "trolley", "portal", "stools", "ground",
)  # fmt: skip
TOGETHER = 3  # times that what is left is looked at in one go
THINNEST = 1e-3  # time between samples that are looked at, at least [s]


def clearances(plan: Plan, history: History, limit: float = LIMIT) -> list[Clearance]:
    """All that are below their limit and, if those are fewer, the smallest ten; smallest first."""
    history = thinned(history)
    if not len(history.t):
        return []
    shapes = moving(plan, history)
    pairs, limits = _pairs(plan, shapes, limit)
    if not pairs:
        return []
    start = whole(shapes, pairs, _common(plan, history))
    groups = list(_groups(shapes, pairs, start))
    found = _through(shapes, [g for names, g in groups if not limits[names]])
    found += _smallest(shapes, [(names, g) for names, g in groups if limits[names]], limit)
    told = sorted((_told(bar, m) for bar, m in found), key=lambda c: (c.distance, c.a, c.b))
    return [c for i, c in enumerate(told) if i < SMALLEST or _red(c)]


def _through(shapes: list[Moving], groups: list[Stretches]) -> list[tuple[float, Minimum]]:
    """Things that went through each other, of those that may come near."""
    if not groups or nearest(shapes, together(groups), -TOUCH) is None:
        return []
    each = (nearest(shapes, group, -TOUCH) for group in groups)
    return [(0.0, minimum) for minimum in each if minimum is not None]


def _smallest(
    shapes: list[Moving], groups: list[tuple[tuple[str, str], Stretches]], limit: float
) -> list[tuple[float, Minimum]]:
    """The smallest clearances of things that keep apart, and all below the limit."""
    found: list[tuple[float, Minimum]] = []
    rest, alike = list(groups), 0
    while rest:
        smallest = sorted(m.least for _, m in found)
        most = max(smallest[SMALLEST - 1], limit) if len(found) >= SMALLEST else np.inf
        rest = [(names, group) for names, group in rest if float(group.least.min()) < most]
        if not rest:
            break
        if len(found) < SMALLEST or alike == TOGETHER:
            _, group = rest.pop(0)
            minimum = nearest(shapes, group, most)
        else:  # of what is left there is mostly none as near: all of it in one go
            alike += 1
            minimum = nearest(shapes, together([group for _, group in rest]), most)
            if minimum is None:
                break
            done = _names(minimum.a, minimum.b)
            rest = [(names, group) for names, group in rest if names != done]
        if minimum is not None:
            found.append((limit, minimum))
    return found


def findings(found: Sequence[Clearance]) -> list[Finding]:
    """What is too near, as findings."""
    return [_finding(c) for c in found if _red(c)]


def _red(c: Clearance) -> bool:
    return c.distance < (c.limit if c.limit > 0.0 else -TOUCH)


def _the(thing: str) -> str:
    """A thing with its article, unless it has a name of its own."""
    common = thing in ("block", "ground", "stools") or thing.partition(" ")[0] in ("rope", "portal", "upper", "lower")
    return f"the {thing}" if common else thing


def _finding(c: Clearance) -> Finding:
    a, b = _the(c.a), _the(c.b)
    if c.distance < -TOUCH:
        told = f"{a} went {-c.distance:.2f} m into {b}"
    elif c.distance < TOUCH:
        told = f"{a} touched {b}"
    else:
        told = f"{a} came within {c.distance:.2f} m of {b}, {c.limit:g} m are to be kept"
    return Finding(
        severity="red",
        kind="clearance",
        subject=f"{c.a} and {c.b}",
        sentence=f"{told} ({c.place})",
        t=c.t,
        value=c.distance,
        limit=c.limit,
        unit="m",
    )


def thinned(history: History) -> History:
    """Without samples of the same instant, as events leave them."""
    kept = np.concatenate([[True], np.diff(history.t) >= THINNEST]) if len(history.t) else np.zeros(0, bool)
    if kept.all():
        return history
    return History(
        history.t[kept],
        {name: x[kept] for name, x in history.poses.items()},
        {name: x[kept] for name, x in history.tensions.items()},
        {name: x[kept] for name, x in history.lengths.items()},
        history.rigs,
    )


def _common(plan: Plan, history: History) -> NDArray[np.float64]:
    """(n, 3) the motion that most shapes share: that of the cranes along their rails."""
    mains = [history.poses[f"{c.name}.main"][:, :3] for c in plan.cranes if f"{c.name}.main" in history.poses]
    return np.mean(mains, axis=0) if mains else np.zeros((len(history.t), 3))


def _pairs(
    plan: Plan, shapes: list[Moving], limit: float
) -> tuple[list[tuple[int, int]], dict[tuple[str, str], float]]:
    """Which shapes can meet, and the limit of their things [m]."""
    pairs, limits = [], {}
    for i, a in enumerate(shapes):
        for j in range(i + 1, len(shapes)):
            b = shapes[j]
            if a.shape.thing == b.shape.thing or not (_moves(a) or _moves(b)):
                continue
            means = relation(plan, a.shape, b.shape)
            if means != "joined":
                pairs.append((i, j))
                limits[_names(a, b)] = limit if means == "apart" else 0.0
    return pairs, limits


def _moves(s: Moving) -> bool:
    return isinstance(s.shape, Strand) or s.shape.body != "world"


def _names(a: Moving, b: Moving) -> tuple[str, str]:
    """Both things, first the one that is told to have come to the other."""
    one, two = sorted((a, b), key=lambda s: (ORDER.index(s.shape.kind), s.shape.thing))
    return one.shape.thing, two.shape.thing


def _groups(
    shapes: list[Moving], pairs: list[tuple[int, int]], start: Stretches
) -> Iterator[tuple[tuple[str, str], Stretches]]:
    """Stretches by the two things that they are of, the nearest first."""
    if not len(start.a):
        return
    numbers: dict[tuple[str, str], int] = {}
    table = np.zeros((len(shapes), len(shapes)), np.intp)
    for a, b in pairs:
        table[a, b] = numbers.setdefault(_names(shapes[a], shapes[b]), len(numbers))
    group = table[start.a, start.b]
    least = np.full(len(numbers), np.inf)
    np.minimum.at(least, group, start.least)
    order = np.argsort(group, kind="stable")
    begins = np.searchsorted(group[order], np.arange(len(numbers) + 1))
    for bound, names, number in sorted((float(least[i]), names, i) for names, i in numbers.items()):
        if np.isfinite(bound):
            yield names, start.of(order[begins[number] : begins[number + 1]])


def _told(limit: float, m: Minimum) -> Clearance:
    a, b, p, q = m.a, m.b, m.near.a, m.near.b
    if (a.shape.thing, b.shape.thing) != _names(a, b):
        a, b, p, q = b, a, q, p
    place = f"at x, y, z = {p[0]:.1f}, {p[1]:.1f}, {p[2]:.1f} m"
    parts = [x for x in (_part(a, p, m.t), _part(b, q, m.t)) if x]
    return Clearance(
        a=a.shape.thing,
        b=b.shape.thing,
        distance=round(m.least, 4) + 0.0,
        t=m.t,
        limit=limit,
        p_WA=_rounded(p),
        p_WB=_rounded(q),
        place=", ".join([*parts, place]),
    )


def _part(s: Moving, p: NDArray[np.float64], t: float) -> str:
    """Which point of a shape is meant, in words."""
    if isinstance(s.shape, Solid) and s.shape.kind == "block":
        k = int(np.argmin(np.abs(s.t - t)))
        turn = s.turn[min(k, len(s.turn) - 1)]
        u, v, w = np.array(s.shape.centre) + matrices(turn[None])[0].T @ (p - s.centre[k])
        return f"{s.shape.thing} at u, v, w = {u:.1f}, {v:.1f}, {w:.1f} m"
    part = s.shape.part if isinstance(s.shape, Solid) else ""
    return f"{part} of {s.shape.thing}" if part and s.shape.kind != "stools" else ""


def _rounded(p: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (round(float(v), 3) + 0.0 for v in p)
    return x, y, z
