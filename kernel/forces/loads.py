"""External forces: given loads, and wind drag (EN 13001-2, 4.2.3.1).

Laws given as data: a piecewise linear effort over the coordinate or the speed of a joint, such as a motor's
torque-speed curve or a buffer's force-travel curve, or over the depth of a body in water. P holds the active piece; its
ends are guards, so that no step crosses a kink and the integrators keep their order.
"""

from bisect import bisect_right
from collections.abc import Hashable
from itertools import pairwise
from typing import TypeVar

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, sqrt
from heavylift.kernel.description.forces import Characteristic, Immersion, Load, Wind

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench

UNIT = 1e-6  # how far a direction may be off by rounding


class LoadLaw(ForceLaw[Load]):
    """Force law of a given force and moment, multiplied by the load's signal; their power counts as external work."""

    works = True

    def shape(self, f: Load) -> Hashable:
        return f.axes, any(f.force), any(f.moment)

    def numbers(self, f: Load, poses: Poses) -> list[float]:
        return [*f.at.p, *f.force, *f.moment]

    def answer(self, f: Load, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        body = ends[0]
        x, _, v = attachment(body, p[:3], "a")
        force: Array = signal[0] * p[3:6] if any(f.force) else np.zeros(3)
        moment: Array = signal[0] * p[6:9] if any(f.moment) else np.zeros(3)
        if f.axes == "body":
            R = np.reshape(body[:9], (3, 3))
            force, moment = R @ force, R @ moment
        work = force @ v + moment @ body[15:18]
        return LawOutput([wrench(x, force, moment)], work=work, shown=[signal[0]])

    def shows(self, f: Load) -> list[SampledQuantity]:
        return [SampledQuantity("load/signal", f.name, "1")]


class WindLaw(ForceLaw[Wind]):
    """Force law of wind drag at a point, which may move."""

    works = True

    def check(self, f: Wind) -> None:
        size = norm(f.direction)
        self.demand(f, "direction", abs(size - 1.0) < UNIT, f"has length {size:g}; it must be a unit vector")

    def numbers(self, f: Wind, poses: Poses) -> list[float]:
        half = 0.5 * f.density * f.drag
        return [*f.at.p, half * f.area, *f.direction, *(half * side for side in f.sides)]

    def shape(self, f: Wind) -> Hashable:
        return any(f.sides)

    def answer(self, f: Wind, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        x, _, v = attachment(ends[0], p[:3], "a")
        u = signal[0] * p[4:7] - v
        size = p[3] * sqrt(u @ u)
        if any(f.sides):
            size += p[7:] @ abs(np.reshape(ends[0][:9], (3, 3)).T @ u)
        force = size * u
        return LawOutput([wrench(x, force)], work=force @ v, shown=[signal[0], sqrt(force @ force)])

    def shows(self, f: Wind) -> list[SampledQuantity]:
        return [SampledQuantity("wind/speed", f.name, "m/s"), SampledQuantity("wind/force", f.name, "N")]


FAR = 1e300  # beyond any coordinate


Curve = TypeVar("Curve", Characteristic, Immersion)


class PiecewiseLaw(ForceLaw[Curve]):
    """Force law of an effort f(x) that is piecewise linear through given points; its power counts as external work.

    Its parameters begin with those of the active piece.
    """

    works = True

    def check(self, f: Curve) -> None:
        n, m = len(f.x), len(f.effort)
        self.demand(f, "effort", n == m > 0, f"has {m} values at {n} places; give one for each place, at least one")
        low = next((b for a, b in pairwise(f.x) if b <= a), None)
        self.demand(f, "x", low is None, f"does not rise at {low}; its places must rise")

    def guards(self, f: Curve) -> tuple[str, ...]:
        return "lower end", "upper end"

    def switch(self, f: Curve, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        x = float(shown[1])
        piece = _piece(f, bisect_right(f.x, x))
        p[: len(piece)] = piece
        return "piece", x


class CharacteristicLaw(PiecewiseLaw[Characteristic]):
    """Force law of an actuator: an effort signal * f(x) along a joint."""

    def shape(self, f: Characteristic) -> Hashable:
        return f.of

    def numbers(self, f: Characteristic, poses: Poses) -> list[float]:
        return _piece(f, 0)

    def answer(
        self, f: Characteristic, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        lower, upper, x0, effort, slope = p
        x = joint[0 if f.of == "position" else 1]
        force = signal[0] * (effort + slope * (x - x0))
        return LawOutput(effort=force, work=force * joint[1], guards=[x - lower, upper - x], shown=[force, x])

    def shows(self, f: Characteristic) -> list[SampledQuantity]:
        return [
            SampledQuantity("characteristic/effort", f.name, "N or N m"),
            SampledQuantity("characteristic/place", f.name, "SI"),
        ]


class ImmersionLaw(PiecewiseLaw[Immersion]):
    """Force law of immersion: an upward force that depends on the depth of a body."""

    def numbers(self, f: Immersion, poses: Poses) -> list[float]:
        return [*_piece(f, 0), *f.at.p, f.level + f.below]

    def answer(
        self, f: Immersion, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        lower, upper, x0, effort, slope = p[:5]
        at, place, v = attachment(ends[0], p[5:8], "a")
        depth = p[8] - place[2]
        force = effort + slope * (depth - x0)
        lift = np.array([0.0, 0.0, force], dtype=object)
        return LawOutput(
            [wrench(at, lift)], work=force * v[2], guards=[depth - lower, upper - depth], shown=[force, depth]
        )

    def shows(self, f: Immersion) -> list[SampledQuantity]:
        return [SampledQuantity("immersion/force", f.name, "N"), SampledQuantity("immersion/depth", f.name, "m")]


def _piece(f: Characteristic | Immersion, i: int) -> list[float]:
    """Return both ends, a point and the slope of the piece that ends at point i; the end values hold outside."""
    if i == 0:
        return [-FAR, f.x[0], f.x[0], f.effort[0], 0.0]
    if i == len(f.x):
        return [f.x[-1], FAR, f.x[-1], f.effort[-1], 0.0]
    slope = (f.effort[i] - f.effort[i - 1]) / (f.x[i] - f.x[i - 1])
    return [f.x[i - 1], f.x[i], f.x[i - 1], f.effort[i - 1], slope]
