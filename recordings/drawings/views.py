"""Plan, elevation and rigging sketch at an instant, with their dimensions.

The elevation shows the plane of the jib or, for a crane that does not slew, the direction along the girder; the plan is
seen from above, with the same axis to the right.
"""

from collections.abc import Sequence
from itertools import combinations, count, pairwise
from math import atan2, cos, degrees, pi, sin

import numpy as np
from numpy.typing import NDArray

from .ink import ROW, TEXT, WIDE, Path, Text, View, clipped, fitting, hull, parts, points_of, within
from .instants import DrawnInstant, DrawnLine

Floats = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
STRETCH = 2.5  # [m] of hook ropes that are drawn in a rigging sketch
FROM_ABOVE = ("world", "crane", "block", "deck", "frame", "hook")  # what is drawn above what, and
LAST = ("world", "crane", "frame", "hook", "block", "deck")  # from aside
CLOSE = 2.5  # [mm] hooks on paper that have one dimension
SAME = 0.05  # [m] dimensions that differ by less are one
LINE = 3.4  # [mm] between labels
SHORTER = 1e-9  # [mm] of two leader lines, that is no rounding
SHOWN = 0.3  # of a clearance: what is shorter in a view is not drawn there
PIECE = "~"  # in names of the pieces of a rope with mass; the last one, at the hook, has the name of the rope
LEVEL = 0.02  # [m] below which a height is no dimension


def main_axis(x: DrawnInstant) -> Floats:
    """Return the horizontal direction (3,) that points to the right in every view."""
    hook = next((hook for hook in x.hooks if hook.axis is not None), None)
    if hook is not None and hook.axis is not None:
        distance = (hook.eye - hook.axis) * [1.0, 1.0, 0.0]
        size = float(np.linalg.norm(distance))
        if size > SAME:
            return distance / size
    size_x, size_y, _ = np.ptp(x.of("crane", "block"), axis=0)
    return np.array([1.0, 0.0, 0.0] if size_x >= size_y else [0.0, 1.0, 0.0])


def general(x: DrawnInstant, room: tuple[float, float]) -> tuple[View, View]:
    """Return the plan and the elevation below each other, with dimensions, at one scale that fits `room` [mm]."""
    h = main_axis(x)
    v = np.cross(UP, h)
    seen = x.of("crane", "block", "hook", "frame")
    wide, high, deep = (float(np.ptp(seen @ axis)) for axis in (h, UP, v))
    deep = max(deep, 2.2 * abs(float((x.hooks[0].eye - x.hooks[0].axis) @ v))) if x.hooks[0].axis is not None else deep
    rows = ROW * (5 + len({round(float(hook.eye @ h), 1) for hook in x.hooks}))
    scale = fitting(wide, high + deep, (room[0] - 7 * ROW, room[1] - rows - 12.0))
    return _plan(x, View(f"Plan 1 : {scale:g}", scale), h, v), _elevation(x, View(f"Elevation 1 : {scale:g}", scale), h)


def three(x: DrawnInstant, room: tuple[float, float]) -> tuple[View, View, View]:
    """Return the plan, the front elevation and the elevation from the right, each at a scale that fits `room` [mm]."""
    h = main_axis(x)
    v = np.cross(UP, h)
    seen = x.of("crane", "block", "hook", "frame")
    wide, deep, high = (float(np.ptp(seen @ axis)) for axis in (h, v, UP))
    inner = room[0] - 5 * ROW, room[1] - 3 * ROW
    plan, side = fitting(wide, deep, inner), fitting(deep, high, inner)
    front = fitting(wide, high, (inner[0], inner[1] - ROW))
    aside = x._replace(hooks=[hook._replace(axis=None) for hook in x.hooks])  # a radius is not seen in true size
    return (
        _plan(x, View(f"Plan, {_named_axis(h)} to the right", plan), h, v),
        _elevation(x, View(f"Elevation, {_named_axis(h)} to the right", front), h),
        _elevation(aside, View(f"Elevation, {_named_axis(v)} to the right", side), v, places=False),
    )


def _named_axis(way: Floats) -> str:
    """Return a horizontal direction in words."""
    for name, axis in (("x", way[0]), ("y", way[1])):
        if abs(abs(axis) - 1.0) < LEVEL:
            return f"{'+' if axis > 0 else '-'}{name}"
    return _bearing(way)


def _bearing(way: Floats) -> str:
    """Return a horizontal direction as an angle of 0.0 to 359.9 degrees."""
    return f"{round(degrees(atan2(way[1], way[0])), 1) % 360.0:.1f} deg from x"


def _drawn(x: DrawnInstant, view: View, right: Floats, up: Floats, last: Sequence[str] = LAST) -> tuple[Floats, Floats]:
    """Draw solids from far to near, then ropes; return the lower and upper corner of the drawing on paper [mm]."""
    axes, ahead = np.column_stack([right, up]), np.cross(right, up)
    seen = view.paper(x.of("crane", "block", "hook", "frame") @ axes)
    low, high = seen.min(axis=0), seen.max(axis=0)
    for solid in sorted(x.solids, key=lambda s: (last.index(s.kind), float((s.corners @ ahead).max()))):
        outline = clipped(hull(view.paper(solid.corners @ axes)), low - ROW, high + ROW)
        if len(outline) > 2:
            view.items.append(Path(outline, solid.kind, True))
    for line in x.lines:
        ends = clipped(view.paper(np.array([line.a, line.b]) @ axes), low - ROW, high + ROW)[
            :2
        ]  # mooring lines end far
        if len(ends):
            view.items.append(Path(ends, "rope"))
    return low, high


def _elevation(x: DrawnInstant, view: View, h: Floats, places: bool = True) -> View:
    """Draw an elevation with its dimensions, and return it; `places`: also the distances of the hooks from the
    left-hand edge."""
    low, high = _drawn(x, view, h, UP)
    low[1] = min(low[1], 0.0)
    view.items.append(Path(np.array([[low[0] - 4.0, 0.0], [high[0] + 4.0, 0.0]]), "frame line"))
    level = "water +-0.00" if x.afloat else "ground +-0.00"
    view.items.append(Text((low[0] - 4.0, -TEXT - 0.6), level))
    below = (low[1] - 4.0 - ROW * k for k in count(1))
    eyes = [view.paper(np.array([hook.eye @ h, hook.eye[2]])) for hook in x.hooks]
    for hook in x.hooks:
        if hook.axis is None:
            continue
        foot = view.paper(np.array([hook.axis @ h, max(0.0, hook.axis[2])]))
        view.items.append(Path(np.array([[foot[0], low[1] - 2.0], [foot[0], high[1] + 2.0]]), "axis"))
        view.across(foot, view.paper(np.array([hook.eye @ h, hook.eye[2]])), next(below), "R ")
    if places and all(hook.axis is None for hook in x.hooks):
        for eye in _spread(eyes, 0):
            view.across(np.array([low[0], 0.0]), eye, next(below))
    view.across(np.array([low[0], 0.0]), np.array([high[0], 0.0]), next(below))
    _heights(x, view, h, eyes, low, high)
    _near(x, view, h, UP)
    return view


def _heights(x: DrawnInstant, view: View, h: Floats, eyes: list[Floats], low: Floats, high: Floats) -> None:
    """Draw the heights of block, hooks and crane above ground: hooks on one side of the view, the crane on the
    other."""
    right = sum(p[0] for p in eyes) / len(eyes) > (low[0] + high[0]) / 2
    side, other = (high[0], low[0]) if right else (low[0], high[0])
    out = 1.0 if right else -1.0
    places = (side + out * (ROW + ROW * k) for k in count())
    foot = np.array([side, 0.0])
    block = x.of("block")
    if len(block) and (lowest := float(block[:, 2].min())) > LEVEL:
        corner = block[int(block[:, 2].argmin())]
        view.upright(foot, view.paper(np.array([corner @ h, lowest])), next(places))
    for eye in _spread(eyes, 1):
        view.upright(foot, eye, next(places))
    crane = x.of("crane")
    if len(crane):
        top = crane[int(crane[:, 2].argmax())]
        view.upright(np.array([other, 0.0]), view.paper(np.array([top @ h, top[2]])), other - out * ROW)


def _plan(x: DrawnInstant, view: View, h: Floats, v: Floats) -> View:
    low, high = _drawn(x, view, h, v, FROM_ABOVE)
    out = (low[1] - ROW - ROW * k for k in count())
    for hook in x.hooks:
        eye = view.paper(np.array([hook.eye @ h, hook.eye @ v]))
        _cross(view, eye)
        if hook.axis is not None:
            axis = view.paper(np.array([hook.axis @ h, hook.axis @ v]))
            _cross(view, axis, 3.0)
            angles = np.linspace(-pi / 6, pi / 6, 41)
            radius = float(np.hypot(*(eye - axis)))
            arc = axis + radius * np.column_stack([np.cos(angles), np.sin(angles)])
            view.items.append(Path(clipped_line(arc, low - 3.0, high + 3.0), "axis"))
            view.items.append(Text((axis[0], high[1] + 2.0), f"jib at {_bearing(h)}", "middle"))
            view.across(axis, eye, next(out), "R ")
    places = (high[0] + ROW + ROW * k for k in count())
    for one, other in pairwise(_spread([view.paper(np.array([k.eye @ h, k.eye @ v])) for k in x.hooks], 1)):
        view.upright(one, other, next(places))
    block = view.paper(x.of("block") @ np.column_stack([h, v]))
    if len(block):
        one, other = block.min(axis=0), block.max(axis=0)
        view.across(one, np.array([other[0], one[1]]), next(out))
        view.upright(np.array([other[0], one[1]]), other, next(places))
    _near(x, view, h, v)
    return view


def clipped_line(points: Floats, low: Floats, high: Floats) -> Floats:
    """Return the points of a line that lie inside a box."""
    inside: Floats = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside


def _cross(view: View, p: Floats, size: float = 1.6) -> None:
    for distance in (np.array([size, 0.0]), np.array([0.0, size])):
        view.items.append(Path(np.array([p - distance, p + distance]), "axis"))


def _near(x: DrawnInstant, view: View, right: Floats, up: Floats) -> None:
    """Draw the smallest clearance between its nearest points, in views in which it is long enough to be seen."""
    if x.near is None:
        return
    a, b = (view.paper(np.array([np.dot(p, right), np.dot(p, up)])) for p in (x.near.p_WA, x.near.p_WB))
    if np.hypot(*(a - b)) < SHOWN * float(view.paper(np.array(x.near.distance))):
        return
    middle, ring = (a + b) / 2, np.array([[cos(k), sin(k)] for k in np.linspace(0.0, 2.0 * pi, 25)])
    outlines = [item.points for item in view.items if isinstance(item, Path) and item.closed]
    distances = [
        length * np.array([i, j]) for length in (5.0, 9.0, 14.0) for i, j in ((1, 1), (-1, 1), (1, -1), (-1, -1))
    ]
    texts = [points_of(x) for item in view.items for x in parts(item) if isinstance(x, Text)]
    message = f"{x.near.distance:.2f}"
    made = [_beside(middle + w, float(np.sign(w[0])), message) for w in distances]
    free = (k for k, text in enumerate(made) if not _covered(points_of(text), outlines, texts))
    k = next(free, 0)
    distance = distances[k]
    view.items += [Path(np.array([a, b]), "near"), Path(middle + 2.2 * ring, "near")]
    view.items.append(Path(np.array([middle + distance / np.hypot(*distance) * 2.2, middle + distance]), "near"))
    view.items.append(made[k])


def _beside(p: Floats, side: float, message: str) -> Text:
    """Return a text to the right (side 1) or to the left (side -1) of a point."""
    return Text((float(p[0] + side * 0.6), float(p[1] - 0.8)), message, "start" if side > 0 else "end", bold=True)


def _covered(box: Floats, outlines: list[Floats], texts: list[Floats]) -> bool:
    """Return whether a text box overlaps an outline or another text."""
    low, high = box.min(axis=0), box.max(axis=0)
    over = any((low < o.max(axis=0)).all() and (high > o.min(axis=0)).all() for o in texts)
    return over or any(within(o, (low + high) / 2) for o in outlines)


def _spread(points: list[Floats], axis: int) -> list[Floats]:
    """Return points on paper sorted along an axis, without points too close to the one before."""
    found = list[Floats]()
    for p in sorted(points, key=lambda p: float(p[axis])):
        if not found or p[axis] - found[-1][axis] > CLOSE:
            found.append(p)
    return found


def rigging(x: DrawnInstant, room: tuple[float, float]) -> View:
    """Return the rigging sketch: block, slings and hooks in detail, with the tension and angle of each rope."""
    h = main_axis(x)
    axes = np.column_stack([h, UP])
    seen = np.concatenate(
        [x.of("block", "hook", "frame"), *(np.array([line.a, line.b]) for line in x.lines if line.sling)]
    )
    top = float(seen[:, 2].max()) + STRETCH
    wide, high = float(np.ptp(seen @ h)), top - float(seen[:, 2].min())
    notes = _named(x)
    labels = WIDE * TEXT * max((len(message) for _, message in notes), default=0) + ROW
    scale = fitting(wide, high, (room[0] - labels - 3 * ROW, room[1] - 4 * ROW))
    view = View(f"Rigging 1 : {scale:g}", scale)
    for solid in sorted(x.solids, key=lambda s: LAST.index(s.kind)):
        if solid.kind not in ("crane", "world"):
            view.items.append(Path(hull(view.paper(solid.corners @ axes)), solid.kind, True))
    for line in x.lines:
        if (ends := _close(x, line)) is not None:
            view.items.append(Path(view.paper(np.array(ends) @ axes), "rope"))
    if x.com is not None:
        _gravity(view, view.paper(x.com @ axes))
    low, right = view.paper(np.array([(seen @ h).min(), seen[:, 2].min()])), float(view.paper((seen @ h).max()))
    _labels(
        view, [(view.paper(p @ axes), message) for p, message in notes], right + ROW, float(view.paper(np.array(top)))
    )
    block = view.paper(x.of("block") @ axes)
    if len(block):
        one, other = block.min(axis=0), block.max(axis=0)
        view.upright(one, np.array([one[0], other[1]]), low[0] - ROW)
        highest = max(x.hooks, key=lambda hook: float(hook.eye[2]))
        view.upright(np.array([one[0], other[1]]), view.paper(highest.eye @ axes), low[0] - ROW)
        beside = x.com is not None and len(x.hooks) == 1 and abs(float((highest.eye - x.com) @ h)) > SAME
        if x.com is not None and beside:  # above the longer dimension, whose text its lines would cross
            view.across(view.paper(x.com @ axes), view.paper(highest.eye @ axes), low[1] - ROW)
        view.across(one, np.array([other[0], one[1]]), low[1] - (2 if beside else 1) * ROW)
    return view


def _close(x: DrawnInstant, line: DrawnLine) -> tuple[Floats, Floats] | None:
    """Return the ends of the part of a rope that a rigging sketch shows (of hook ropes only the part near the hook);
    None if it shows none."""
    if line.sling:
        return line.a, line.b
    if all(np.linalg.norm(line.b - hook.eye) > STRETCH for hook in x.hooks):
        return None
    return line.b + (line.a - line.b) * min(1.0, STRETCH / max(float(np.linalg.norm(line.a - line.b)), 1e-9)), line.b


def _named(x: DrawnInstant) -> list[tuple[Floats, str]]:
    """Return the labels of a rigging sketch with their positions (3,): ropes with lug, tension and angle, and the
    centre of gravity."""
    found: dict[str, tuple[Floats, str]] = {}
    for line in x.lines:
        if line.rope not in found and PIECE not in line.rope and (ends := _close(x, line)) is not None:
            distance = line.a - line.b
            lean = degrees(np.arccos(min(1.0, abs(distance[2]) / max(float(np.linalg.norm(distance)), 1e-9))))
            lug = next((f" ({name})" for name, p in x.lugs.items() if np.linalg.norm(p - line.b) < SAME), "")
            message = f"{line.rope}{lug} {line.tension / 1e3:.0f} kN" + (f", {lean:.1f} deg" if line.sling else "")
            found[line.rope] = ((ends[0] + ends[1]) / 2 if line.sling else ends[0], message)
    return [*found.values(), *([(x.com, f"centre of gravity, {x.mass / 1e3:g} t")] if x.com is not None else [])]


def _gravity(view: View, p: Floats) -> None:
    ring = np.array([[cos(k), sin(k)] for k in np.linspace(0.0, 2.0 * pi, 25)])
    view.items.append(Path(p + 1.2 * ring, "frame line"))
    _cross(view, p, 1.8)


def _labels(view: View, notes: list[tuple[Floats, str]], x: float, top: float) -> None:
    """Draw labels in a column, sorted so that exchanging two labels would not shorten their leader lines; so no two
    leader lines cross."""
    if not notes:
        return
    middle = (max(p[1] for p, _ in notes) + min(p[1] for p, _ in notes)) / 2
    first = min(top, middle + LINE * (len(notes) - 1) / 2)
    ends = [np.array([x - 1.0, first - LINE * k + 0.7]) for k in range(len(notes))]
    lengths = np.array([[float(np.hypot(*(p - end))) for end in ends] for p, _ in notes])
    at = np.argsort([-p[1] for p, _ in notes], kind="stable").argsort()
    better = True
    while better:
        better = False
        for i, j in combinations(range(len(notes)), 2):
            if lengths[i, at[j]] + lengths[j, at[i]] < lengths[i, at[i]] + lengths[j, at[j]] - SHORTER:
                at[[i, j]], better = at[[j, i]], True
    for (p, message), k in zip(notes, at, strict=True):
        view.items.append(Path(np.array([p, ends[k], ends[k] + [1.0, 0.0]]), "thin"))
        view.items.append(Text((x + 0.6, float(ends[k][1]) - 0.7), message))
