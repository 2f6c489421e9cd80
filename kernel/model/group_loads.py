"""Loads on a base or joint by the bodies that it carries: their weights, and the pulls of ropes that lead to other
bodies.

Weights and pulls give one resultant force with its position on the base; inertia of the bodies and wind on them are not
included. That force V [N] at x, y [m] from the middle of the base is shared by

    two tracks    by the lever between them; below each along its length by the trapezoid of a rigid body on springs,
                  or by the triangle beyond the middle third
    four corners  V/4 (1 +- 2x/l +- 2y/w), as of a rigid base on equal springs; if one corner would be pulled, by the
                  other three, whose loads do not depend on stiffness

The moment about the axis of a joint is caused by the weights and rope pulls on all bodies that the joint carries; for
starting, the moment that accelerates their inertia is added.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from heavylift.kernel.algebra.dense import product
from heavylift.kernel.compiler.symbol import maximum, select, sqrt
from heavylift.kernel.description.mechanics import WORLD, Body, Line, Point, System
from heavylift.kernel.description.signals import ScalarSignal

ON_BASES = {"track pressure": 8, "corner load": 8, "tipping": 5}  # with their counts of numbers
ABOUT_JOINTS = {"joint moment": 0, "starting moment": 1}
NEAR = 1e-9  # [m] a shorter rope, or a shorter way to the edge of a track, counts as that
TIPS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # middle, and tips of the axes


@dataclass(frozen=True)
class CarriedGroup:
    """The bodies that a base or joint carries, with the ropes that pull at them."""

    frame: tuple[Point, ...]
    bodies: tuple[Body, ...]
    ropes: dict[str, tuple[Line, ...]]
    gravity: float
    turned: bool  # the attitudes of the bodies count, too

    @property
    def points(self) -> tuple[Point, ...]:
        """The points whose positions the load formulas need: of the frame, the bodies and the ropes."""
        tips = TIPS if self.turned else TIPS[:1]
        return (
            *self.frame,
            *(moved_point(Point(b.name, b.com), tip) for b in self.bodies for tip in tips),
            *(end for lines in self.ropes.values() for line in lines for end in (line.a, line.b)),
        )

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers that the load formulas need: weights of bodies [N], and the share of each rope line.

        For "starting moment", also mass and inertia of each body.
        """
        found = list[float]()
        for body in self.bodies:
            found.append(body.mass * self.gravity)
            found += [body.mass, *(x for row in body.inertia for x in row)] if self.turned else []
        return (*found, *(line.share for lines in self.ropes.values() for line in lines))


def carried_group(h: ScalarSignal, system: System) -> CarriedGroup:
    """Return the bodies carried by the base or joint of a load signal h, with the ropes that pull at them."""
    if h.quantity in ON_BASES:
        assert h.point is not None
        own, frame = _connected(system, h.point.body), tuple(moved_point(h.point, tip) for tip in TIPS[:3])
    else:
        joint = next(j for j in system.joints if j.name == h.of)
        own, middle = _above(system, joint.child), Point(joint.parent, joint.p_PJ)
        axis = product(joint.R_PJ, joint.axis)
        frame = middle, moved_point(middle, axis)
    ropes = dict[str, tuple[Line, ...]]()
    for rope in system.straight_ropes:
        outward = (line if line.a.body in own else Line(line.b, line.a, line.share) for line in rope.lines)
        if lines := tuple(x for x in outward if x.a.body in own and x.b.body not in own):
            ropes[rope.name] = lines
    bodies = tuple(b for b in system.bodies if b.name in own)
    return CarriedGroup(frame, bodies, ropes, system.gravity, h.quantity == "starting moment")


def moved_point(p: Point, d: Sequence[float]) -> Point:
    """Return the point at distance d (3,) [m] from another point, in the frame of the same body."""
    return Point(p.body, (p.p[0] + d[0], p.p[1] + d[1], p.p[2] + d[2]))


def _connected(system: System, base: str) -> set[str]:
    """Return the bodies that joints connect to a base, without those below it."""
    rigid = (j for j in system.joints if j.kind != "free" and j.child != base)
    pairs = [{j.parent, j.child} for j in rigid if WORLD not in (j.parent, j.child)]
    return _reached(base, lambda found: (pair for pair in pairs if pair & found))


def _above(system: System, child: str) -> set[str]:
    """Return a body and the bodies that joints carry on it; a body counts as carried by the first of its joints."""
    carried = {j.child: j.parent for j in reversed(system.joints)}
    return _reached(child, lambda found: ({body} for body, parent in carried.items() if parent in found))


def _reached(start: str, more: Any) -> set[str]:
    found, before = {start}, 0
    while len(found) > before:
        before = len(found)
        found = found.union(*more(found))
    return found


def base_force(x: Any, own: int) -> tuple[Any, Any, Any]:
    """Return the resultant vertical force [N] on a base and its position [m] along and across the base.

    All bodies above are slewed by an angle, whose cosine and sine are the first two numbers; `own`: count of the
    signal's numbers.
    """
    middle, *tips = x.places[:3]
    V: Any = 0.0
    Mx: Any = 0.0
    My: Any = 0.0
    for p, F in _forces(x, own, 3, 1):
        d = _less(p, middle)
        V, Mx, My = V - F[2], Mx + (d[1] * F[2] - d[2] * F[1]), My + (d[2] * F[0] - d[0] * F[2])
    ex, ey = My / V, -Mx / V
    along, across = (ex * (tip[0] - middle[0]) + ey * (tip[1] - middle[1]) for tip in tips)
    c, s = x.numbers[:2]
    return V, along * c + across * s, across * c - along * s


def _forces(x: Any, own: int, frame: int, each: int) -> Iterator[tuple[Any, Any]]:
    """Yield the position and force of each weight and of each line's pull; `each`: number of points of a body; they
    follow those of the frame."""
    n = sum(x.lines)
    ends, shares = x.places[len(x.places) - 2 * n :], x.numbers[len(x.numbers) - n :]
    bodies, width = x.places[frame : len(x.places) - 2 * n : each], 1 if each == 1 else 11
    for i, com in enumerate(bodies):
        yield com, (0.0, 0.0, -x.numbers[own + width * i])
    k = 0
    for tension, count in zip(x.values, x.lines, strict=True):
        for _ in range(count):
            a, d = ends[2 * k], _less(ends[2 * k + 1], ends[2 * k])
            pull = shares[k] * tension / maximum(sqrt(_dot(d, d)), NEAR)
            yield a, tuple(pull * w for w in d)
            k += 1


def track_pressure(x: Any) -> Any:
    """Return the largest pressure below a crawler track [N/m2], scaled by the signal's numbers[6:8]; inf on tipping."""
    V, along, across = base_force(x, ON_BASES["track pressure"])
    length, apart, breadth, side, times, plus = x.numbers[2:8]
    own = _between(0.0, V / 2.0 * (1.0 + 2.0 * side * across / apart), V)
    e = abs(along)
    edge = length / 2.0 - e
    triangle = select(edge > 0.0, 2.0 * own / (3.0 * breadth * maximum(edge, NEAR)), inf)
    trapezoid = own / (breadth * length) * (1.0 + 6.0 * e / length)
    return select(e <= length / 6.0, trapezoid, triangle) * times + plus


def corner_load(x: Any) -> Any:
    """Return the load on one corner of a base [N], scaled by factor and offset in numbers[6:8] of the signal."""
    V, along, across = base_force(x, ON_BASES["corner load"])
    length, width, ahead, left, times, plus = x.numbers[2:8]
    u, v = 2.0 * along / length, 2.0 * across / width
    a, b = ahead * u, left * v
    two = select(a >= 0.0, 1.0 - abs(v), select(b >= 0.0, 1.0 - abs(u), 0.0))
    three = V / 2.0 * select(a >= 0.0, select(b >= 0.0, a + b, two), two)
    found = select(abs(u) + abs(v) <= 1.0, V / 4.0 * (1.0 + a + b), _between(0.0, three, V))
    return found * times + plus


def tipping(x: Any) -> Any:
    """Return how far the base force is off centre, as a fraction of the distance at which the machine tips.

    If the last number is above zero, of the distance at which one corner loses contact.
    """
    _, along, across = base_force(x, ON_BASES["tipping"])
    length, width, lifts = x.numbers[2:5]
    u, v = abs(2.0 * along / length), abs(2.0 * across / width)
    return select(lifts > 0.0, u + v, maximum(u, v))


def joint_moment(x: Any, own: int = 0, each: int = 1) -> Any:
    """Return the moment [N m] of weights and rope pulls about the axis of a joint."""
    middle, tip = x.places[:2]
    axis, found = _less(tip, middle), 0.0
    for p, F in _forces(x, own, 2, each):
        found = found + _dot(_cross(_less(p, middle), F), axis)
    return abs(found)


def starting_moment(x: Any) -> Any:
    """Return the moment [N m] about a joint's axis that starts a rotation with the acceleration numbers[0] [rad/s2]."""
    middle, tip = x.places[:2]
    axis, inertia = _less(tip, middle), 0.0
    bodies = x.places[2 : len(x.places) - 2 * sum(x.lines)]
    for i in range(len(bodies) // 4):
        com, *tips = bodies[4 * i : 4 * i + 4]
        _, mass, *own = x.numbers[1 + 11 * i : 12 + 11 * i]
        d, e = _cross(_less(com, middle), axis), [_dot(_less(tip, com), axis) for tip in tips]
        turned = [_dot(e, own[3 * k : 3 * k + 3]) for k in range(3)]
        inertia = inertia + mass * _dot(d, d) + _dot(e, turned)
    return joint_moment(x, 1, 4) + x.numbers[0] * inertia


def _between(low: Any, x: Any, high: Any) -> Any:
    return select(x < low, low, select(x > high, high, x))


def _less(a: Any, b: Any) -> tuple[Any, Any, Any]:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Any, b: Any) -> tuple[Any, Any, Any]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
