"""Smallest clearances between the parts of a lift, with time and place, and those below their limit.

Things are what a planner names: the block, a beam, a portal, a rope. A pair of things has the scene's clearance limit,
or must only not penetrate (`nodes.plan.shapes`); a contact that the scene orders is allowed while the order lasts, and
at other times must only not be touched.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from heavylift.kernel.description.findings import Check, finding
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.models import system
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import GROUND, Kind, Shapes, Solid, Strand
from heavylift.recordings.read.verdict import Clearance
from numpy.typing import NDArray

from .conduct import Meant
from .ground import TOUCH, GroundClearance, GroundSurvey, Spans
from .history import BLOCK, History, RunHistory
from .intervals import Coarse, Minimum, whole
from .moving import Moving, moving
from .nearest import NearestSoFar, search
from .rotating import matrices, turned

Floats = NDArray[np.float64]
SMALLEST = 10  # clearances that are reported
LIMIT = 0.5  # clearance of a scene that says nothing [m]
Kept = Callable[..., float]
ORDER: tuple[Kind, ...] = ("rope", "sling", "hanging", "block", "mechanism", "machine", "supports")
MISSED = ": the corners that their contact takes missed it, write 'meets: boxes'"
THINNEST = 1e-3  # time between samples that are looked at, at least [s]


def clearances(
    plan: Plan,
    history: RunHistory,
    landing: Spans = (),
    smallest: int = SMALLEST,
    mechanics: System | None = None,
    meant: Meant = (),
) -> list[Clearance]:
    """Return the clearances of a run, smallest first: all that are below their limits, and at least the first
    `smallest` ones.

    `landing`: intervals [s] in which an order to land is carried out; `mechanics`: those of the plan, if known;
    `meant`: allowed contacts with their times.
    """
    keep, known_shapes = limit_between(plan), Shapes(plan)
    known, nearest = NearestSoFar(smallest, keep()), dict[int, Clearance]()
    things, ground = _Things(known_shapes, keep, meant), GroundSurvey(known_shapes, keep)
    lowest: dict[tuple[str, bool], Clearance] = {}
    joints = (mechanics or system(plan)).joints if known_shapes.lifts else ()
    for part, between in thinned(history):
        ground.survey(part, between)
    ground.settle(landing, meant)
    for part, between in thinned(history):
        shapes = moving(known_shapes, part, joints)
        if not shapes:
            continue
        common = _common(known_shapes, part)
        for inside, now in _split(part.t, between, meant):
            coarse = Coarse(shapes, common, inside)
            pairs, groups = things.pairs(shapes, now)
            # what need not keep apart is reported if it goes through
            limits = np.array(things.limits)
            most = np.where(limits > 0.0, np.inf, limits - TOUCH)
            known.groups(most)
            if pairs:
                search(shapes, whole(coarse, pairs, groups), known)
            for i, m in enumerate(known.take()):
                if m is not None and (m.seen if things.fastened[i] else m.least) < most[i]:
                    nearest[i] = _described(things, i, m)
            for x, sunk in ground.look(shapes, coarse, part, known.message):
                lowest[x.shape.shape.thing, sunk] = _lowest(x)
    kept = [c for (thing, sunk), c in lowest.items() if sunk or (thing, True) not in lowest]
    kept = sorted([*kept, *nearest.values()], key=lambda c: (c.distance, c.a, c.b))
    return [c for i, c in enumerate(kept) if i < smallest or _red(c)]


def lift_of(plan: Plan, thing: str) -> str:
    """Return the name of the lift to which a part belongs, if the plan has several lifts; otherwise ""."""
    name = thing.rpartition(" ")[2]
    return max((x.name for x in plan.lists if name.startswith(f"{x.name}-")), key=len, default="")


def limit_between(plan: Plan) -> Kept:
    """Return a function that gives the required clearance [m] between named parts: the largest limit of their lifts."""
    limits = {x.subject: x.value for x in reversed(plan.limits) if x.quantity == "clearance" and x.value is not None}
    own = {x.name: limits[x.name] for x in plan.lists if x.name in limits}
    most = max(own.values(), default=next(reversed(limits.values()), LIMIT))

    def keep(*things: str) -> float:
        return max((own.get(lift_of(plan, x), 0.0) for x in things), default=most) or most

    return keep if own else lambda *_: most


def findings(found: Sequence[Clearance], plan: Plan | None = None) -> list[Check]:
    """Return clearances below their limits as findings; the message says what to write if the contact is intended."""
    shapes = Shapes(plan) if plan is not None else None
    missed = [shapes is not None and c.distance < -TOUCH and shapes.by_corners(c.a, c.b) for c in found]
    return [_finding(c, MISSED if m else "") for c, m in zip(found, missed, strict=True) if _red(c)]


def _red(c: Clearance) -> bool:
    return c.distance < (c.limit if c.limit > 0.0 else c.limit - TOUCH)


def _the(thing: str) -> str:
    """Return the name of a thing, with an article if the name is that of a kind."""
    common = thing in ("block", GROUND, "supports") or thing.partition(" ")[0] in ("rope", "portal", "upper", "lower")
    return f"the {thing}" if common else thing


def _finding(c: Clearance, more: str) -> Check:
    a, b = _the(c.a), _the(c.b)
    if c.distance < -TOUCH:
        message = f"{a} went {-c.distance:.2f} m into {b}"
    elif c.distance < TOUCH:
        message = f"{a} touched {b}, which nothing orders; where that is meant, write 'may touch: [[{c.a}, {c.b}]]'"
    else:
        message = f"{a} came within {c.distance:.2f} m of {b}, {c.limit:g} m are to be kept"
    subject, numbers = f"{c.a} and {c.b}", {"t": c.t, "value": c.distance, "limit": c.limit, "unit": "m"}
    return finding("red", "clearance", subject, f"{message} ({c.place}){more}", **numbers)


def thinned(past: RunHistory) -> Iterator[tuple[History, tuple[int, int]]]:
    """Yield consecutive parts of a run without repeated samples, each with the indices of the first and last sample
    to search.

    Up to two more samples at either end serve to compute accelerations.
    """
    kept = np.flatnonzero(np.diff(past.t, prepend=-np.inf) >= THINNEST)
    n = len(kept)
    for first in range(0, max(min(n, 1), n - 1), BLOCK):
        last = min(first + BLOCK, n - 1)
        begin, end = max(0, first - 2), min(n, last + 3)
        part = past.part(int(kept[begin]), int(kept[end - 1]) + 1)
        yield part.of(kept[begin:end] - kept[begin]), (first - begin, last - begin)


def _split(t: Floats, between: tuple[int, int], meant: Meant) -> Iterator[tuple[tuple[int, int], frozenset[int]]]:
    """Yield ranges of samples with a constant set of allowed contacts, one sample longer at both ends."""
    first, last = between
    spans = [
        (int(np.searchsorted(t, a, "right")) - 1, int(np.searchsorted(t, b, "left")) if b < np.inf else last)
        for _, a, b in meant
    ]
    cuts = sorted({first, last, *(k for span in spans for k in span if first < k < last)})
    for i, j in pairwise(cuts) if len(cuts) > 1 else [(first, last)]:
        yield (i, j), frozenset(n for n, (a, b) in enumerate(spans) if a <= i and j <= b)


def _common(shapes: Shapes, history: History) -> Floats:
    """Return the horizontal motion (n, 2) that most shapes share: that of the cranes along their rails."""
    mains = [history.poses[body][:, :2] for body in shapes.roots if body in history.poses]
    return np.mean(mains, axis=0) if mains else np.zeros((len(history.t), 2))


class _Things:
    """Numbered pairs of things, with the clearance limit [m] of each pair. `fastened`: whether a pair is a sling and
    its attachment, which deviate together between samples; `rigid`: whether a contact keeps the pair apart."""

    def __init__(self, shapes: Shapes, keep: Kept, meant: Meant) -> None:
        self._shapes, self._keep, self._meant = shapes, keep, meant
        self._numbers: dict[tuple[tuple[str, str], bool], int] = {}
        self._kinds: dict[object, int] = {}
        self._known: dict[tuple[int, int, frozenset[int]], int | None] = {}  # of shapes that are alike
        self._last: tuple[object, list[tuple[int, int]], list[int]] = None, [], []
        self.limits: list[float] = []
        self.fastened: list[bool] = []
        self.rigid: list[bool] = []

    def pairs(self, shapes: list[Moving], now: frozenset[int]) -> tuple[list[tuple[int, int]], list[int]]:
        """Return the pairs of shapes to search, as pairs of indices, and the group number of each pair of shapes.

        `now`: numbers of the contacts allowed at this time.
        """
        pairs: list[tuple[int, int]] = []
        groups: list[int] = []
        alike = [self._kinds.setdefault(_alike(s), len(self._kinds)) for s in shapes]
        if (alike, now) == self._last[0]:
            return self._last[1], self._last[2]
        for i, a in enumerate(shapes):
            for j in range(i + 1, len(shapes)):
                key = alike[i], alike[j], now
                if key not in self._known:
                    self._known[key] = self._number(a, shapes[j], now)
                group = self._known[key]
                if group is not None:
                    pairs.append((i, j))
                    groups.append(group)
        self._last = (alike, now), pairs, groups
        return pairs, groups

    def _number(self, a: Moving, b: Moving, now: frozenset[int]) -> int | None:
        """Return the number of a pair of things; None for shapes that are not checked against each other."""
        if a.shape.thing == b.shape.thing or not (_moves(a) or _moves(b)):
            return None
        means = self._shapes.relation(a.shape, b.shape)
        if means == "joined":
            return None
        one, other = self._shapes.called(a.shape), self._shapes.called(b.shape)
        named = {frozenset((x, y)) for x in one for y in other}
        pairs = {n for n, (names, _, _) in enumerate(self._meant) if names in named}
        rigid, begins = self._shapes.meeting(a.shape, b.shape)
        means = "through" if begins or pairs & now else means
        found = self._numbers.setdefault((self.names(a, b), begins or bool(pairs & now)), len(self._numbers))
        keep = TOUCH if pairs else self._keep(a.shape.thing, b.shape.thing)
        limit = 0.0 - self._shapes.overlap(a.shape, b.shape) if means == "through" else keep
        self.limits[found : found + 1] = [limit]
        strands, bodies = ([s.shape for s in (a, b) if isinstance(s.shape, kind)] for kind in (Strand, Solid))
        fastened = any(isinstance(x, Strand) and getattr(y, "body", "") in x.ends for x in strands for y in bodies)
        self.fastened[found : found + 1] = [fastened]
        self.rigid[found : found + 1] = [rigid]
        return found

    def names(self, a: Moving, b: Moving) -> tuple[str, str]:
        """Return the names of the parts to which two shapes belong, the more mobile part first."""
        one, two = sorted((a, b), key=self._order)
        return one.shape.thing, two.shape.thing

    def _order(self, s: Moving) -> tuple[int, int, str]:
        machine = isinstance(s.shape, Solid) and s.shape.kind == "machine"
        depth = self._shapes.depth(s.shape.body) if machine and isinstance(s.shape, Solid) else 0
        return ORDER.index(s.shape.kind), -depth, s.shape.thing


def _alike(s: Moving) -> object:
    """Return a key that is equal for shapes treated alike: the strand itself, or the thing, kind and body of a
    solid."""
    return s.shape if isinstance(s.shape, Strand) else (s.shape.thing, s.shape.kind, s.shape.body)


def _moves(s: Moving) -> bool:
    return isinstance(s.shape, Strand) or s.shape.body != "world"


def _described(things: _Things, number: int, m: Minimum) -> Clearance:
    a, b, p, q = m.a, m.b, *m.near
    if (a.shape.thing, b.shape.thing) != things.names(a, b):
        a, b, p, q = b, a, q, p
    parts = [x for x in (_part(a, p, m.t), _part(b, q, m.t)) if x]
    least = max(m.least, min(m.seen, 0.0)) if things.rigid[number] else m.least
    return _clearance(a.shape.thing, b.shape.thing, least, m.t, things.limits[number], p, q, parts)


def _lowest(x: GroundClearance) -> Clearance:
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
    """Describe the point `p` of a shape at time `t` [s] in words."""
    if isinstance(s.shape, Solid) and s.shape.kind == "block":
        k = int(np.argmin(np.abs(s.t - t)))
        turn = s.turn[min(k, len(s.turn) - 1)]
        u, v, w = np.array(s.shape.centre) + turned(matrices(turn[None])[0].T, p - s.centre[k])
        return f"{s.shape.thing} at u, v, w = {u:.1f}, {v:.1f}, {w:.1f} m"
    part = s.shape.part if isinstance(s.shape, Solid) else ""
    return f"{part} of {s.shape.thing}" if part and s.shape.kind != "supports" else ""


def _rounded(p: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(v), 3) + 0.0 for v in p)
    return x, y, z
