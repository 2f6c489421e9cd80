"""How near the parts of a lift came to one another: the smallest clearances with time and place, and what is too near.

Things are what a planner names: the block, a loader, a portal, a rope.  Two of them are kept apart by the scene's limit
or must only not go through each other (`nodes.limits.shapes.relation`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from heavylift.nodes.limits.findings import Finding
from heavylift.nodes.limits.shapes import GROUND, Kind, Solid, Strand, relation
from heavylift.nodes.scene.plan import Plan
from heavylift.recordings.verdict import Clearance
from numpy.typing import NDArray

from .ground import TOUCH, Low, Spans, over_ground
from .history import History
from .moving import Moving, matrices, moving
from .nearest import nearest_of_each
from .steps import Minimum
from .stretches import whole

__all__ = ["LIMIT", "clearances", "findings"]

Floats = NDArray[np.float64]
SMALLEST = 10  # clearances that are told
LIMIT = 0.5  # clearance of a scene that says nothing [m]
ORDER: tuple[Kind, ...] = (
    "rope", "sling", "loader", "mechanism", "block", "trolley", "portal", "stools",
)  # fmt: skip
THINNEST = 1e-3  # time between samples that are looked at, at least [s]


def clearances(plan: Plan, history: History, limit: float = LIMIT, landing: Spans = ()) -> list[Clearance]:
    """All that are below their limit and, if those are fewer, the smallest ten; smallest first.

    `landing`: from when to when [s] orders to land are carried out.
    """
    history = thinned(history)
    if not len(history.t):
        return []
    shapes = moving(plan, history)
    told = [_lowest(x) for x in over_ground(plan, shapes, history, limit, landing)]
    pairs, groups, limits = _pairs(plan, shapes, limit)
    if pairs:
        start = whole(shapes, pairs, _common(plan, history), groups)
        most = np.where(np.array(limits) > 0.0, np.inf, -TOUCH)  # what need not keep apart is told if it goes through
        found = nearest_of_each(shapes, start, most, SMALLEST, limit)
        told += [_told(limits[i], m) for i, m in enumerate(found) if m is not None]
    told.sort(key=lambda c: (c.distance, c.a, c.b))
    return [c for i, c in enumerate(told) if i < SMALLEST or _red(c)]


def findings(found: Sequence[Clearance]) -> list[Finding]:
    """What is too near, as findings."""
    return [_finding(c) for c in found if _red(c)]


def _red(c: Clearance) -> bool:
    return c.distance < (c.limit if c.limit > 0.0 else -TOUCH)


def _the(thing: str) -> str:
    """A thing with its article, unless it has a name of its own."""
    common = thing in ("block", GROUND, "stools") or thing.partition(" ")[0] in ("rope", "portal", "upper", "lower")
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
    kept = np.flatnonzero(np.diff(history.t, prepend=-np.inf) >= THINNEST)
    if len(kept) == len(history.t):
        return history

    def of(columns: Mapping[str, Floats]) -> dict[str, Floats]:
        return {name: np.take(x.T, kept, axis=-1).T for name, x in columns.items()}

    return History(history.t[kept], of(history.poses), of(history.tensions), of(history.lengths), history.rigs)


def _common(plan: Plan, history: History) -> Floats:
    """(n, 3) the motion that most shapes share: that of the cranes along their rails."""
    mains = [history.poses[f"{c.name}.main"][:, :3] for c in plan.cranes if f"{c.name}.main" in history.poses]
    return np.mean(mains, axis=0) if mains else np.zeros((len(history.t), 3))


def _pairs(plan: Plan, shapes: list[Moving], limit: float) -> tuple[list[tuple[int, int]], list[int], list[float]]:
    """Which shapes can meet, the number of the things that they are of, and the limit of each two things [m]."""
    pairs: list[tuple[int, int]] = []
    groups: list[int] = []
    numbers: dict[tuple[str, str], int] = {}
    limits: dict[int, float] = {}
    known: dict[tuple[int, int], int | None] = {}  # of shapes that are alike

    def number(a: Moving, b: Moving) -> int | None:
        """The number of two things; None of shapes that mean nothing to each other."""
        if a.shape.thing == b.shape.thing or not (_moves(a) or _moves(b)):
            return None
        means = relation(plan, a.shape, b.shape)
        if means == "joined":
            return None
        found = numbers.setdefault(_names(a, b), len(numbers))
        limits[found] = limit if means == "apart" else 0.0
        return found

    kinds: dict[object, int] = {}
    alike = [kinds.setdefault(_alike(s), len(kinds)) for s in shapes]
    for i, a in enumerate(shapes):
        for j in range(i + 1, len(shapes)):
            key = alike[i], alike[j]
            if key not in known:
                known[key] = number(a, shapes[j])
            group = known[key]
            if group is not None:
                pairs.append((i, j))
                groups.append(group)
    return pairs, groups, [limits[i] for i in range(len(limits))]


def _alike(s: Moving) -> object:
    """What shapes share that mean the same to others: all of a strand, of a solid all but its size and place."""
    return s.shape if isinstance(s.shape, Strand) else (s.shape.thing, s.shape.kind, s.shape.body)


def _moves(s: Moving) -> bool:
    return isinstance(s.shape, Strand) or s.shape.body != "world"


def _names(a: Moving, b: Moving) -> tuple[str, str]:
    """Both things, first the one that is told to have come to the other."""
    one, two = sorted((a, b), key=lambda s: (ORDER.index(s.shape.kind), s.shape.thing))
    return one.shape.thing, two.shape.thing


def _told(limit: float, m: Minimum) -> Clearance:
    a, b, p, q = m.a, m.b, m.near.a, m.near.b
    if (a.shape.thing, b.shape.thing) != _names(a, b):
        a, b, p, q = b, a, q, p
    parts = [x for x in (_part(a, p, m.t), _part(b, q, m.t)) if x]
    return _clearance(a.shape.thing, b.shape.thing, m.least, m.t, limit, p, q, parts)


def _lowest(x: Low) -> Clearance:
    part = _part(x.shape, x.p, x.t)
    below = x.p * (1.0, 1.0, 0.0)
    return _clearance(x.shape.shape.thing, GROUND, x.distance, x.t, x.limit, x.p, below, [part] if part else [])


def _clearance(
    a: str, b: str, least: float, t: float, limit: float, p: Floats, q: Floats, parts: Sequence[str]
) -> Clearance:
    place = f"at x, y, z = {p[0]:.1f}, {p[1]:.1f}, {p[2] + 0.0:.1f} m"
    return Clearance(
        a=a,
        b=b,
        distance=round(least, 4) + 0.0,
        t=t,
        limit=limit,
        p_WA=_rounded(p),
        p_WB=_rounded(q),
        place=", ".join([*parts, place]),
    )


def _part(s: Moving, p: Floats, t: float) -> str:
    """Which point of a shape is meant, in words."""
    if isinstance(s.shape, Solid) and s.shape.kind == "block":
        k = int(np.argmin(np.abs(s.t - t)))
        turn = s.turn[min(k, len(s.turn) - 1)]
        u, v, w = np.array(s.shape.centre) + matrices(turn[None])[0].T @ (p - s.centre[k])
        return f"{s.shape.thing} at u, v, w = {u:.1f}, {v:.1f}, {w:.1f} m"
    part = s.shape.part if isinstance(s.shape, Solid) else ""
    return f"{part} of {s.shape.thing}" if part and s.shape.kind != "stools" else ""


def _rounded(p: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(v), 3) + 0.0 for v in p)
    return x, y, z
